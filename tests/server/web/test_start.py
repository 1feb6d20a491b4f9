"""A page that is served elsewhere: with a token, over TLS, beside OSCQuery; and what is said where it can't be."""

import json
import os
import re
import ssl
import subprocess
import urllib.request
from pathlib import Path

import pytest

from tests.server.web.conftest import ask
from tests.support import CAROM, serving

pytestmark = pytest.mark.slow


def told(server) -> str:
    """Return the page's address, as the server prints it."""
    match = re.search(r"https?://\S+", server.process.stdout.readline())
    assert match
    return match[0]


def test_beyond_this_machine_the_address_has_a_token(tmp_path):
    with serving(tmp_path, "--device", "none", "--page", "0", "--bind", "0.0.0.0") as server:
        address = told(server)
        port = int(re.search(r":(\d+)/\?token=", address)[1])
        assert ask(port, "/panic")[0] == 403
        token = address.partition("token=")[2]
        assert len(token) >= 16 and ask(port, f"/panic?token={token}")[0] == 200


def test_a_page_over_tls(tmp_path):
    with serving(tmp_path, "--device", "none", "--page", "0", "--tls") as server:
        address = told(server)
        assert address.startswith("https://127.0.0.1:")
        anybody = ssl.create_default_context()
        anybody.check_hostname, anybody.verify_mode = False, ssl.CERT_NONE
        with urllib.request.urlopen(f"{address}?HOST_INFO", context=anybody, timeout=10) as answer:
            assert json.load(answer)["NAME"] == "Carom"


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("--page", "0", "--oscquery", "0"), "page, oscquery: expected one of the two"),
        (("--tls",), "tls, certificate: expected with --page"),
        (("--page", "0", "--certificate", "missing.pem"), "missing.pem: No such file or directory"),
        (("--page", "70000"), "page = 70000: expected 0 to 65535"),
    ],
)
def test_wrong_options_are_told_in_a_line(carom_here, options, said):
    run = carom_here("serve", "--port", "0", "--device", "none", *options)
    assert run.returncode == 1 and said in run.stderr and run.stderr.count("\n") == 1


@pytest.mark.parametrize("option", ["--page", "--oscquery"])
def test_a_port_that_is_taken_is_told_in_a_sentence(tmp_path: Path, option):
    with serving(tmp_path, "--device", "none", "--page", "0") as server:
        port = re.search(r":(\d+)/", told(server))[1]
        words = [*CAROM, "serve", "--port", "0", "--device", "none", option, port]
        run = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert run.returncode == 1
    assert run.stderr == (
        f"carom serve: port {port} on 127.0.0.1 is in use, perhaps by a Carom that runs already: "
        f"{option} 0 takes any free one\n"
    )


def test_without_aiohttp_it_says_what_to_install(tmp_path):
    (tmp_path / "aiohttp.py").write_text("raise ModuleNotFoundError('no', name='aiohttp')")
    run = subprocess.run(
        [*CAROM, "serve", "--port", "0", "--device", "none", "--page", "0"],
        cwd=tmp_path, env={"PYTHONPATH": str(tmp_path), **os.environ}, capture_output=True, text=True,
        timeout=60,
    )  # fmt: skip
    assert run.returncode == 1 and "page: aiohttp is missing: pip install 'carom[page]'" in run.stderr
