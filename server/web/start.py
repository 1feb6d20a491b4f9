"""The start of a server's web server."""

from dataclasses import dataclass
from pathlib import Path

from ..net.network import Network
from ..net.reply_budget import local
from .guard import Guard, new_token
from .listening import Listening
from .server import WebServer
from .site import Known, Site
from .tls import context


@dataclass(frozen=True)
class Web:
    """Settings of a web server: host and port (0: any that is free); with the page of a folder (None: OSCQuery alone);
    over TLS with the certificate of a file, or with one that is made for it (`self_made`)."""

    host: str
    port: int
    page: Path | None = None
    certificate: Path | None = None
    self_made: bool = False


def web_server(web: Web, known: Known, network: Network) -> tuple[WebServer, Listening]:
    """Make a web server for a server, to be started, and what notifies its clients. OSError where TLS can't be had."""
    # OSCQuery's other clients know no token: what describes the addresses alone reveals nothing that OSC would not.
    token = new_token() if web.page and not local(web.host) else ""
    site = Site(known, network, network.address[1], web.page, Guard(token, () if local(web.host) else (web.host,)))
    tls = context(web.certificate, web.host) if web.certificate or web.self_made else None
    return WebServer(site, web.host, web.port, tls), Listening(site.clients, known.value)
