"""carom doctor: check this machine for missing parts, and say how to get them."""

import argparse

from .options import no_options
from .parser import Command


def _run(_: argparse.Namespace) -> int:
    from ..doctor import examine

    broken = False
    for well, what, remedy in examine():
        broken |= well is False
        print({True: "ok   ", None: "lack ", False: "FAIL "}[well], what)
        if remedy:
            print("      ", remedy)
    return 1 if broken else 0


COMMAND = Command("doctor", "", "check this machine for missing parts, and say how to get them", no_options, _run)
