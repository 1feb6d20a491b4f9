"""Two futures of one moment: a glass is about to be struck again; in one of them a hand holds it. Usage: futures.py

It needs no server, and writes struck.wav and held.wav. Both begin with the moment.
"""

import carom

with carom.Scene() as scene:
    glass = scene.new("glass", "wine-glass")
    glass.impact(0.3, at=0.0)
    glass.impact(1.0, at=1.0)  # waits for its time in both futures
    scene.render(seconds=0.5)
    with scene.fork() as other:
        other.damp("glass", 1.0, at=0.8)
        for future, name in ((scene, "struck.wav"), (other, "held.wav")):
            sound = future.render(seconds=2.0)
            sound.save(name)
            print(f"{name}: peak {abs(sound.samples[72_000:]).max():.4f} a second after the strike")
