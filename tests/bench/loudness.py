"""How loud presets are, and the levels that make them alike: integrated loudness by ITU-R BS.1770 (pyloudnorm).

`make levels` measures every object at its defaults and writes `level`, `roll_level` and `bounce_level` into its preset:
strikes within 5 LU of each other, none with a peak above an eighth of full scale, so that eight at once do not limit;
rolls and bounces no further from the strike than GESTURES. `--dry` only prints.
"""

import argparse
import re
from pathlib import Path

import numpy as np

import carom
from carom.clients.loudness import PEAK, Heard, heard
from carom.presets import BUILT_IN

RATE = 48_000
SPREAD = 5.0  # LU between the loudest strike and the softest
GESTURES = 9.0  # LU between a strike and a roll or a bounce on the same object, at most


def strike(name: str) -> Heard:
    """An object's own strike."""
    return _played(name, lambda body, preset: body.impact(preset.velocity), 1.0)


def roll(name: str) -> Heard:
    """Its own striker, or a marble where that is not round, rolling at 0.5 m/s over the surface `wood`."""
    presets = carom.Presets()
    own = presets.object(name).striker
    striker = "glass-marble" if presets.striker(own).radius is None else own
    return _played(name, lambda body, preset: body.roll(0.5, surface="wood", striker=striker), 1.0)


def bounce(name: str) -> Heard:
    """Its own striker, dropped from 0.3 m."""
    return _played(name, lambda body, preset: body.bounce(0.3), 1.5)


def _played(name, gesture, seconds: float) -> Heard:
    with carom.Scene(RATE, limiter=False) as scene:
        gesture(scene.new("a", name), carom.Presets().object(name))
        return heard(scene.render(seconds).samples, RATE)


def levels(strikes: dict[str, Heard]) -> dict[str, float]:
    """What is to be added to each object's level (dB): all as loud as they can be without one being SPREAD louder."""
    headroom = {name: 20 * np.log10(PEAK) - each.peak for name, each in strikes.items()}
    softest = min(each.loudness + headroom[name] for name, each in strikes.items())
    return {name: min(headroom[name], softest + SPREAD - each.loudness) for name, each in strikes.items()}


def gesture_level(strike: Heard, other: Heard) -> float:
    """What is to be added to a gesture (dB) so that it lies no further than GESTURES from the strike."""
    apart = other.loudness - strike.loudness
    return float(np.clip(apart, -GESTURES, GESTURES) - apart)


def write(path: Path, **values: float) -> None:
    """Write levels (dB) into a preset's file, above its sections: in place where there are some, else after `level`."""
    head, section, rest = path.read_text(encoding="utf-8").partition("\n[")
    for key, value in values.items():
        line = f"{key} = {round(value, 1) + 0.0:.1f}  # dB"
        head, found = re.subn(rf"^{key} = .*$", line, head, flags=re.M)
        if not found:
            head = re.sub(r"^(level = .*)$", rf"\1\n{line}", head, flags=re.M)
    path.write_text(head + section + rest, encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--dry", action="store_true", help="print the levels, write none")
    options = parser.parse_args()
    presets = carom.Presets()
    strikes = {name: strike(name) for name in presets.names("objects")}
    added = levels(strikes)
    print(f"{'object':22} {'LUFS':>6} {'peak':>6} {'roll':>6} {'bounce':>6}")
    for name, struck in strikes.items():
        preset = presets.object(name)
        others = {"roll": roll(name), "bounce": bounce(name)}
        apart = [other.loudness - struck.loudness for other in others.values()]
        print(
            f"{name:22} {struck.loudness + added[name]:6.1f} {struck.peak + added[name]:6.1f} "
            f"{apart[0]:6.1f} {apart[1]:6.1f}"
        )
        if not options.dry:
            raised = {
                f"{gesture}_level": preset.gesture_levels.get(gesture, 0.0) + gesture_level(struck, other)
                for gesture, other in others.items()
            }
            write(BUILT_IN / "objects" / f"{name}.toml", level=preset.level + added[name], **raised)


if __name__ == "__main__":
    main()
