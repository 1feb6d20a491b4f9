"""A tune in parallel fifths on bars of one preset, soft and loud: notes by name or number. Usage: notes.py [PORT]"""

import sys
import time

from carom import Client
from carom.server.osc.wire import DEFAULT_PORT

BEAT = 0.3  # s
TUNE = ["A3", "C4", "E4", "D4", "B3", "A3", "G3", "E3", "A3"]
VELOCITIES = (100, 60, 80, 60)  # of MIDI

port = int(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT_PORT
with Client(port=port) as carom:
    carom.new("tuned-bar", "marimba-bar")  # each note is a copy of it, made when it is first played
    for note in TUNE:
        carom.note("tuned-bar", note, 0)  # velocity 0 plays nothing
    start = time.time() + 0.5  # ahead of the first note: the time tags and not the network set the rhythm
    for beat, note in enumerate(TUNE):
        with carom.bundle(at=start + BEAT * beat):
            carom.note("tuned-bar", note, VELOCITIES[beat % len(VELOCITIES)])
    time.sleep(0.5 + BEAT * len(TUNE) + 2.0)
    carom.free("tuned-bar")
