"""Many objects, struck at random for a while. Usage: random_scene.py [PORT [SECONDS [SEED]]]"""

import random
import sys
import time

from carom import Client
from carom.server.osc.wire import DEFAULT_PORT

PRESETS = ("glass-plate", "church-bell", "marimba-bar")
STRIKERS = ("steel", "rubber", "wood")
LATENCY = 0.1  # s: strikes are sent this long before they sound
RATE = 12.0  # strikes a second, on average

port = int(sys.argv[1]) if len(sys.argv) > 1 else DEFAULT_PORT
seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 10.0
chance = random.Random(int(sys.argv[3]) if len(sys.argv) > 3 else 1)

with Client(port=port) as carom:
    names = [f"{preset}-{copy}" for preset in PRESETS for copy in range(4)]
    for name in names:
        carom.new(name, name.rsplit("-", 1)[0])
        carom.send(f"/object/{name}/pan", chance.uniform(-1.0, 1.0))
    when = start = time.time() + LATENCY
    while when < start + seconds:
        time.sleep(max(0.0, when - LATENCY - time.time()))
        with carom.bundle(at=when):
            carom.impact(
                chance.choice(names),
                velocity=chance.lognormvariate(-0.5, 0.8),
                position=chance.random(),
                striker=chance.choice(STRIKERS),
            )
        when += chance.expovariate(RATE)  # a Poisson process: as rain falls
    with carom.bundle(at=when):
        for name in names:
            carom.free(name)
