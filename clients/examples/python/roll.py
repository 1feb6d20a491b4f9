"""A marble on a pane of ground glass, pushed to and fro and caught; balls dropped after it. Usage: roll.py [PORT]"""

import math
import sys
import time

from carom import Client
from carom.server.osc.wire import DEFAULT_PORT

port = int(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT_PORT
with Client(port=port) as carom:
    carom.new("ground-glass", "glass-plate")
    carom.roll("ground-glass", 0.2, 0.2, striker="glass-marble", surface="slate", travel=0.6, id="marble")
    start = time.monotonic()
    while (seconds := time.monotonic() - start) < 4.0:
        carom.gesture("marble", "speed", 0.8 - 0.6 * math.cos(math.pi * seconds))
        time.sleep(0.02)  # changes glide: fifty a second are smooth
    carom.gesture("marble", "speed", 0.0)
    for ball in range(3):
        carom.bounce("ground-glass", 0.05 + 0.02 * ball, 0.3 + 0.1 * ball, striker="ping-pong", id=f"ball{ball}")
    time.sleep(2.0)
    carom.gesture("ball*", "stop")
    carom.free("ground-glass")
    carom.ask("/sync", 1)  # all that was sent is carried out, or refused
    for error in carom.errors():
        print(error, file=sys.stderr)
