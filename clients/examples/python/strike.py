"""Makes a bell, strikes it softly and hard, and lets it ring. Usage: strike.py [PORT]"""

import sys
import time

from carom import Client
from carom.server.osc.wire import DEFAULT_PORT

port = int(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT_PORT
with Client(port=port) as carom:
    carom.new("tower", "church-bell")
    start = time.time() + 0.1  # a little ahead, so that the time tags and not the network set the rhythm
    for beat, velocity in enumerate((0.3, 1.0, 3.0)):
        with carom.bundle(at=start + beat):
            carom.impact("tower", velocity)
    time.sleep(5.0)
    carom.damp("tower", 1.0)
    carom.free("tower")
