"""A server whose engine is compiled first: it says how far it is, and loses nothing that comes meanwhile."""

import threading
import time

import pytest

from carom import Client
from carom.server import compiling
from carom.server.options import Options
from carom.server.start import serving

pytestmark = pytest.mark.slow


@pytest.fixture
def server(monkeypatch):
    """A server that has been started, with an engine that is ready when the event is set; yields its port, and it."""
    ready, opened = threading.Event(), threading.Event()
    ports = []
    monkeypatch.setattr(compiling, "prepare", lambda: ready.wait(20.0))
    monkeypatch.setattr(compiling, "progress", lambda: (0.25, 12.0))
    monkeypatch.setattr(compiling, "_PERIOD", 0.1)
    wait = compiling.wait_for_code

    def waits(network):
        ports.append(network.address[1])
        opened.set()
        return wait(network)

    monkeypatch.setattr("carom.server.start.wait_for_code", waits)

    def run() -> None:
        with serving(Options(port=0, device="none")) as made:
            made.run()

    thread = threading.Thread(target=run)
    thread.start()
    assert opened.wait(10.0)
    yield ports[0], ready
    ready.set()
    with Client(port=ports[0], tcp=True) as client:
        client.ask("/quit")
    thread.join()


@pytest.mark.parametrize("tcp", [False, True])
def test_messages_during_compilation_are_carried_out_after_it(server, tcp):
    port, ready = server
    with Client(port=port, tcp=tcp) as client:
        told = []
        client.tell_compiling(lambda share, seconds: told.append((share, seconds)))
        threading.Timer(1.0, ready.set).start()
        asked = time.monotonic()
        client.ask("/object/new", "bell", "church-bell", timeout=0.5)
        assert time.monotonic() - asked > 0.7
        assert len(told) > 3 and set(told) == {(0.25, 12.0)}
        client.impact("bell", 1.0)
        assert client.ask("/sync", 1).args == (1,)
        assert client.errors() == []


def test_a_fault_of_the_compiler_ends_the_start(monkeypatch):
    def fails() -> None:
        time.sleep(0.5)
        raise TypeError("no code")

    monkeypatch.setattr(compiling, "prepare", fails)
    with pytest.raises(TypeError, match="no code"), serving(Options(port=0, device="none")):
        pass
