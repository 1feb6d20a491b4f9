"""The wait while the engine is being compiled: clients hear how far it is, and what they send waits for the engine."""

import threading
import time
from typing import Any

from ..dsp.native.compile_notice import progress
from ..dsp.runtime.engine import prepare
from .net.network import Network, Source
from .osc.wire import Message

_AT_ONCE = 0.3  # s in which code that need not be compiled is loaded
_LOOK = 0.1  # s between looks whether it is done
_PERIOD = 1.0  # s between two words to a client
_MOST = 1 << 22  # bytes of packets that wait
_OVERHEAD = 256  # bytes that a packet takes besides its own


def wait_for_code(network: Network) -> list[tuple[bytes, Source]]:
    """Wait for the engine's code; return the packets that arrived meanwhile, to be carried out now.

    Whoever sends one gets `/compiling SHARE SECONDS` at once, and every second until the code is there. The newest
    packets are dropped where some 10,000 short ones, or a few MB of long ones, wait.
    """
    failed: list[BaseException] = []
    thread = threading.Thread(target=_prepare, args=(failed,), name="carom-compiling-engine", daemon=True)
    thread.start()
    thread.join(_AT_ONCE)
    arrived: list[tuple[bytes, Source]] = []
    size = 0
    told: dict[Any, float] = {}
    while thread.is_alive():
        packet = network.receive(_LOOK)
        if packet:
            told.setdefault(packet[1], 0.0)
            size += len(packet[0]) + _OVERHEAD
            if size <= _MOST:
                arrived.append(packet)
            else:
                network.drop(packet[1])
        _tell(network, told)
    if failed:
        raise failed[0]
    return arrived


def _prepare(failed: list[BaseException]) -> None:
    try:
        prepare()
    except BaseException as error:  # it is raised in the thread that waits
        failed.append(error)


def _tell(network: Network, told: dict[Any, float]) -> None:
    """Report the progress to clients, each once in a while; `told` holds the times of the last replies."""
    now = time.monotonic()
    for source, last in list(told.items()):
        if now - last >= _PERIOD or last == 0.0:
            try:
                network.send(Message("/compiling", progress()), source)
                told[source] = now
            except OSError:  # it can't be reached
                told[source] = float("inf")
