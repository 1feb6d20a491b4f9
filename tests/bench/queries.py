"""Programs that ask for everything over OSCQuery, again and again: how long do others wait for an answer by OSC?

`python -m tests.bench.queries` starts a server with a crowd of objects of its own, and fails where an answer took more
than 20 ms, but for the time that the server's threads waited for a processor: that is other programs' doing. The
clients of HTTP run in a process of their own.
"""

import argparse
import http.client
import re
import sys
import tempfile
import time
from contextlib import suppress
from multiprocessing import Event, Process
from multiprocessing.synchronize import Event as Flag
from pathlib import Path
from threading import Thread

from carom.clients.client import Client
from tests.bench.crowd import crowd
from tests.support import Running, serving

LATE = 0.02
"""s: an answer that takes longer is late."""
CLIENTS = 8


def _ask(port: int, stopped: Flag) -> None:
    while not stopped.is_set():
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=600.0)
        connection.request("GET", "/")
        assert connection.getresponse().read().startswith(b'{"FULL_PATH": "/"')
        connection.close()


def _ask_together(port: int, stopped: Flag) -> None:
    threads = [Thread(target=_ask, args=(port, stopped)) for _ in range(CLIENTS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def _waited(pid: int) -> float:
    """Return the s that the threads of a process have waited for a processor; 0 where the system does not tell."""
    with suppress(OSError):
        tasks = Path(f"/proc/{pid}/task").iterdir()
        return 1e-9 * sum(int((task / "schedstat").read_text().split()[1]) for task in tasks)
    return 0.0


def answers(server: Running, seconds: float) -> list[tuple[float, float]]:
    """Measure how long (s) each answer to /version took in so many seconds, while CLIENTS ask for everything over HTTP,
    and how long without the time in which the server waited for a processor."""
    assert server.process.stdout
    told = re.search(r"http://127.0.0.1:(\d+)/", server.process.stdout.readline())
    assert told
    stopped = Event()
    clients = Process(target=_ask_together, args=(int(told[1]), stopped))
    clients.start()
    taken = []
    try:
        with Client(port=server.port) as client:
            time.sleep(1.0)
            end = time.monotonic() + seconds
            while (asked := time.monotonic()) < end:
                before = _waited(server.process.pid)
                client.ask("/version", timeout=30.0)
                answered = time.monotonic() - asked
                taken.append((answered, max(0.0, answered - _waited(server.process.pid) + before)))
                time.sleep(0.005)
    finally:
        stopped.set()
        clients.join()
    return taken


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=30.0, help="(%(default)g)")
    seconds = parser.parse_args().seconds
    with (
        tempfile.TemporaryDirectory() as folder,
        serving(Path(folder), "--device", "none", "--oscquery", "0") as server,
    ):
        with Client(port=server.port, tcp=True) as client:
            crowd(client)
        taken = answers(server, seconds)
        _, said = server.quit()
    for what, times in zip(("answered", "without waiting for a processor"), zip(*taken, strict=True), strict=True):
        ordered = sorted(times)
        print(
            f"{what}: median {1e3 * ordered[len(ordered) // 2]:.2f} ms, "
            f"99 % {1e3 * ordered[len(ordered) * 99 // 100]:.1f} ms, worst {1e3 * ordered[-1]:.1f} ms"
        )
    print(f"{len(taken)} answers, {sum(own > LATE for _, own in taken)} late {said}")
    return any(own > LATE for _, own in taken) or bool(said)


if __name__ == "__main__":
    sys.exit(main())
