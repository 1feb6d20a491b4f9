"""TLS: a certificate of one's own, or one that is made at the start and that nobody vouches for."""

import datetime
import errno
import os
import socket
import ssl
import tempfile
from asyncio.sslproto import SSLProtocol
from contextlib import suppress
from ipaddress import ip_address
from pathlib import Path

_DAYS = 30

# Bytes that asyncio takes for each connection's reading, from its handshake on: 256 kB are too much for those that say
# no more.
SSLProtocol.max_size = 1 << 14


def context(certificate: Path | None, host: str) -> ssl.SSLContext:
    """Return the server's side of TLS. certificate: a PEM file with the key in it; None: one is made.

    OSError (ssl.SSLError is one) where the file is wrong.
    """
    made = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    made.minimum_version = ssl.TLSVersion.TLSv1_2
    if certificate:
        if not certificate.is_file():
            raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(certificate))
        made.load_cert_chain(certificate)
        return made
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "carom.pem"
        path.touch(mode=0o600)
        path.write_bytes(_self_made(host))
        made.load_cert_chain(path)
    return made


def _self_made(host: str) -> bytes:
    """Make a certificate and its key, in PEM, for this machine's names."""
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec

    key = ec.generate_private_key(ec.SECP256R1())
    names: list[x509.GeneralName] = [x509.DNSName("localhost"), x509.DNSName(socket.gethostname())]
    for address in ("127.0.0.1", host):
        with suppress(ValueError):
            names.append(x509.IPAddress(ip_address(address)))
    subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, "Carom")])
    now = datetime.datetime.now(datetime.timezone.utc)
    certificate = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(subject)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=_DAYS))
        .add_extension(x509.SubjectAlternativeName(names), critical=False)
        .sign(key, hashes.SHA256())
    )
    pem = serialization.Encoding.PEM
    private = key.private_bytes(pem, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    return certificate.public_bytes(pem) + private
