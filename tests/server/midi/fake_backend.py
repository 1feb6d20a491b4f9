"""A backend of mido's without hardware: its input reads the bytes of a MIDI cable from the pipe that CAROM_CABLE names.

MIDO_BACKEND=tests.server.midi.fake_backend makes mido use it. While there is no such pipe, there is no device.
"""

import os
import threading

from mido.parser import Parser
from mido.ports import BaseInput

NAME = "Fake Keys MIDI 1"


def get_devices(**_):
    """Return the only device, if it is plugged in."""
    there = os.path.exists(os.environ["CAROM_CABLE"])
    return [{"name": f"{NAME} 20:0", "is_input": True, "is_output": False}] if there else []


class Input(BaseInput):
    """The end of the cable."""

    def _open(self, callback=None, **_):
        threading.Thread(target=self._read, args=[callback], daemon=True).start()

    def _read(self, callback):
        parser = Parser()
        with open(os.environ["CAROM_CABLE"], "rb", buffering=0) as cable:
            while data := cable.read(64):
                parser.feed(data)
                for message in parser:
                    callback(message)
