"""The hosts that attack: two addresses of this machine, or, where root asks for them, two namespaces with networks of
their own."""

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import NamedTuple


class Host(NamedTuple):
    """A host: the words that run a command there, its address, and that of the server as it sees it."""

    words: tuple[str, ...]
    address: str
    server: str


ON_LOOPBACK = Host((), "127.0.0.2", "127.0.0.1"), Host((), "127.0.0.3", "127.0.0.1")
attacking: Sequence[Host] = ON_LOOPBACK
"""The hosts in use."""


@contextmanager
def namespaces() -> Iterator[None]:
    """Have the attacks come from two namespaces: root alone may, on Linux."""
    global attacking
    with ExitStack() as stack:
        attacking = [stack.enter_context(_namespace(n)) for n in (1, 2)]
        try:
            yield
        finally:
            attacking = ON_LOOPBACK


@contextmanager
def _namespace(number: int) -> Iterator[Host]:
    """Make a namespace with a network of two: itself and this machine."""
    name, net = f"carom-attack{number}", f"10.83.{number}"
    here, there = f"carom{number}a", f"carom{number}b"
    _ip("netns", "add", name)
    try:
        _ip("link", "add", here, "type", "veth", "peer", "name", there, "netns", name)
        for words, link, end in (((), here, 1), (("-n", name), there, 2)):
            _ip(*words, "address", "add", f"{net}.{end}/24", "dev", link)
            _ip(*words, "link", "set", link, "up")
        yield Host(("ip", "netns", "exec", name), f"{net}.2", f"{net}.1")
    finally:
        _ip("netns", "delete", name)  # and its link


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True)


@contextmanager
def attackers(module: str, hosts: Sequence[Host], *args: object) -> Iterator[None]:
    """Run a module that attacks on each of some hosts, in processes of their own: `HOST SERVER` and what else it is
    given."""
    with ExitStack() as stack:
        for host in hosts:
            words = [*host.words, sys.executable, "-m", module, host.address, host.server, *map(str, args)]
            process = subprocess.Popen(words)
            stack.callback(process.wait)
            stack.callback(process.kill)
        yield
