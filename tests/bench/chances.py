"""Random combinations of objects, strikers, gestures and keys within their usual ranges: how many sound fine?

Each is played with make-up (`--physical`: without), and rendered without a limiter. `--macros 0`, `1` or `random` turns
one macro in two there. It is fine if its greatest momentary loudness is from -35 to -12 LUFS, its true peak over full
scale by 3 dB at most before the limiter and by none behind it, it takes at most a tenth of a processor (plates that
swell 0.4), and nothing is refused that a knob offers. Prints the shares, and the worst of each kind.
"""

import argparse
import math
import random
import time
from typing import NamedTuple

import numpy as np

import carom
from carom.dsp.macros import MACROS
from carom.dsp.runtime.loudness import Heard, heard
from carom.dsp.schema import GESTURES, SETTINGS, Parameter

RATE = 48_000
SECONDS = 2.0
SOFTEST, LOUDEST = -35.0, -12.0  # LUFS
SILENT = -50.0  # LUFS
BEFORE, BEHIND = 3.0, -1.0  # dB of full scale: true peak before and behind the limiter
USUAL_LOAD, LOAD_OF_PLATES = 0.1, 0.4
_GIVEN = 0.15  # chance that a key is given
_SETTINGS = ("tune", "decay", "damp")
_TRIED = 3  # times that CPU time is taken, of which the least counts
_NAMED = ("impact", "bounce", "roll", "slide", "spin", "rain", "shake", "crumple", "pour", "step", "shatter")
_SHOWN = 6

Value = float | str


class Chance(NamedTuple):
    """A combination, and what became of it."""

    said: str
    before: Heard | None
    behind: float
    load: float
    swells: bool
    refused: str

    @property
    def figures(self) -> str:
        """Its figures, or why it is refused."""
        if self.before is None:
            return self.refused
        level, peak = self.before.loudness, self.before.peak
        return f"{level:.1f} LUFS, {peak:.1f} dB before the limiter, {self.behind:.1f} behind, load {self.load:.2f}"

    @property
    def faults(self) -> list[str]:
        """What is not fine about it, in a word each."""
        if self.before is None:
            return ["refused"]
        most = LOAD_OF_PLATES if self.swells else USUAL_LOAD
        found = {
            "silent": self.before.loudness < SILENT,
            "soft": SILENT <= self.before.loudness < SOFTEST,
            "loud": self.before.loudness > LOUDEST,
            "over": self.before.peak > BEFORE,
            "true peak": self.behind > BEHIND + 0.05,
            "slow": self.load > most,
        }
        return [name for name, is_so in found.items() if is_so]


def value_of(parameter: Parameter, chance: random.Random) -> float:
    """Choose a value in a parameter's usual range, by ratios where it spans more than a decade."""
    low, high = parameter.useful or (parameter.low, parameter.high)
    if low > 0.0 and high / low > 10.0:
        return float(f"{math.exp(chance.uniform(math.log(low), math.log(high))):.4g}")
    return float(round(chance.uniform(low, high))) if parameter.whole else round(chance.uniform(low, high), 4)


def combination(chance: random.Random) -> tuple[str, str, dict[str, Value], dict[str, Value]]:
    """Choose an object, a gesture, its argument and keys, and the keys of the object."""
    presets = carom.Presets()
    name, kind = chance.choice(presets.names("objects")), chance.choice(_NAMED)
    gesture = GESTURES[kind]
    keys: dict[str, Value] = {gesture.argument.name: value_of(gesture.argument, chance), "seed": chance.randrange(1000)}
    if kind == "impact":
        del keys["seed"]
    if kind != "rain":
        keys["striker"] = chance.choice(presets.names("strikers"))
    for key in gesture.keys:
        if key.useful and key.name not in ("travel", gesture.instead) and chance.random() < _GIVEN:
            keys[key.name] = value_of(key, chance)
    if chance.random() < _GIVEN:
        keys["position"] = round(chance.random(), 3)
    made: dict[str, Value] = {each: value_of(SETTINGS[each], chance) for each in _SETTINGS if chance.random() < _GIVEN}
    return name, kind, keys, made


def rendered(
    name: str, kind: str, keys: dict[str, Value], made: dict[str, Value], macros: dict[str, float], limiter: bool
) -> tuple[carom.Sound, float, bool]:
    """Render a combination; return the sound, the share of a processor, and whether the object is a plate that
    swells."""
    with carom.Scene(RATE, limiter=limiter) as scene:
        body = scene.new("a", name, **made)
        if macros:
            body.macro(**macros)
        getattr(body, kind)(**keys)
        begun = time.thread_time()
        sound = scene.render(SECONDS)
        return sound, (time.thread_time() - begun) / SECONDS, body._placed.modes.sheet is not None


def turned(chance: random.Random, macros: str) -> dict[str, float]:
    """Choose macros, one in two, and turn them to a place, or each to another one at random; none without a place."""
    named = [name for name in MACROS if chance.random() < 0.5] if macros else []
    return {name: round(chance.random(), 3) if macros == "random" else float(macros) for name in named}


def tried(chance: random.Random, play: int, place: str) -> Chance:
    """Try a combination, with macros at a place."""
    name, kind, keys, made = combination(chance)
    macros = turned(chance, place)
    said = f"{name} {kind} {' '.join(f'{key} {value}' for key, value in (keys | made | macros).items())}"
    try:
        sound, load, swells = rendered(name, kind, keys | {"play": play}, made, macros, False)
        most = LOAD_OF_PLATES if swells else USUAL_LOAD
        for _ in range(_TRIED - 1):
            if load > most:
                load = min(load, rendered(name, kind, keys | {"play": play}, made, macros, False)[1])
        before = heard(sound.samples, RATE)
        behind = before.peak
        if before.peak > BEHIND - 0.5:
            behind = heard(rendered(name, kind, keys | {"play": play}, made, macros, True)[0].samples, RATE).peak
    except carom.CommandError as error:
        return Chance(said, None, 0.0, 0.0, False, str(error))
    return Chance(said, before, behind, load, swells, "")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000, help="combinations (%(default)s)")
    parser.add_argument("--seed", type=int, help="of the random numbers; another each time if not given")
    parser.add_argument("--physical", action="store_true", help="without make-up")
    parser.add_argument("--macros", choices=("0", "1", "random"), default="", help="where macros are turned to")
    options = parser.parse_args()
    seed = options.seed if options.seed is not None else int(np.random.SeedSequence().generate_state(1)[0])
    chance = random.Random(seed)
    found = [tried(chance, 0 if options.physical else 1, options.macros) for _ in range(options.count)]
    fine = sum(not each.faults for each in found)
    print(f"seed {seed}: {fine} of {len(found)} fine ({fine / len(found):.1%})")
    for fault in ("refused", "silent", "soft", "loud", "over", "true peak", "slow"):
        those = [each for each in found if fault in each.faults]
        print(f"{fault:10} {len(those):5} ({len(those) / len(found):.1%})")
        for each in those[:_SHOWN]:
            print(f"    {each.said}: {each.figures}")


if __name__ == "__main__":
    main()
