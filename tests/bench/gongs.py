"""Plates whose modes are coupled: periods, forces, energies, rates, swells and courses of the treble.

    python -m tests.bench.gongs [PART ...] [--json FILE] [--plot FILE]

Parts are those of PARTS; without one all are measured. Each row has a bound, and says whether it holds. `--plot` draws
spectrograms of the struck presets.
"""

import argparse
import json
import math
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np

import carom
from carom.dsp import bodies
from carom.dsp.engine.memory.state import QUANTUM
from carom.dsp.runtime.engine import Engine
from tests.dsp.engine.bodies.test_sheets import (
    BEATER,
    BRONZE,
    STICK,
    is_coupled,
    lossless,
    plate,
    sheet_of,
    true_energy,
    whole,
)
from tests.dsp.engine.support import setting, strike
from tests.dsp.karman.test_grid import Reference, displacements, forced, laid_out
from tests.dsp.karman.test_grid import plate as heavy_plate
from tests.dsp.karman.test_step import swung

from .cymbals import apart, centroids, course, recordings, risen
from .soundfont import Recording

RATE = 48_000
RATIOS = (1.0, 2.0, 3.0, 4.0, 5.0)
"""Amplitudes over the thickness."""
CENTS = ((60.0, 1.0), (181.0, 1.0), (300.0, 1.0), (450.0, 2.0), (600.0, 2.0))
"""Linear frequencies of a supported plate (Hz), and bounds of its period's error."""
PLATES, BLOWS, BETWEEN = 20, 500, 0.03
"""Random plates, blows on each, and s between two."""
BLOWS_HEARD = 64
"""Blows whose mean levels are compared at several rates."""
BLOWS_FOLLOWED = 16
"""Blows whose swells are followed, and whose medians are held to bounds."""
BESIDE = np.linspace(-0.01, 0.01, 8)
"""Places of blows on a cymbal, of its path, beside the usual one."""
TOP = 20_000.0  # Hz: of modes
OCTAVES = tuple(62.5 * 2**k for k in range(8))
CYMBALS = ("crash-cymbal", "china-cymbal", "ride-cymbal", "splash-cymbal")
GONGS = ("tam-tam", "small-gong", "opera-gong", "thunder-sheet")
CRASHED = {"ride-cymbal": {"striker": "stick-shoulder", "position": 0.97, "velocity": 8.0}}
"""Strikes that make a cymbal crash that is not struck so by default."""


@dataclass(frozen=True)
class Row:
    """A measured figure, the bound that it is to keep, from `least` to `most`, and whether it does."""

    part: str
    what: str
    figure: float
    least: float
    most: float

    @property
    def holds(self) -> bool:
        return self.least <= self.figure <= self.most


def periods() -> Iterator[Row]:
    """Compare the period of a supported plate with the elliptic closed form, at 96 kHz."""
    for (frequency, cents), ratio in product(CENTS, RATIOS):
        period, exact, _ = swung(frequency, ratio, 96_000.0)
        error = abs(1200 * math.log2(period / exact))
        yield Row("periods", f"cents, {frequency:g} Hz, {ratio:g} h", error, 0.0, cents)


def forces() -> Iterator[Row]:
    """Compare the grid's energy and its gradient with sums over stress functions, of 60 modes."""
    engine = Engine(RATE)
    state = engine.state
    for dome in (0.0, 0.01):
        rng = np.random.default_rng(1)
        sheet = heavy_plate(dome)
        record, laid = laid_out(state, sheet)
        reference = Reference(sheet, laid)
        for ratio in (0.5, 5.0):
            q = displacements(sheet, laid, ratio, rng)
            energy, gradient = forced(state, record, q)
            error = abs(energy / reference.energy(q) - 1)
            yield Row("forces", f"energy, dome {dome:g} m, {ratio:g} h", error, 0.0, 2e-3)
            worst = 0.0
            for _ in range(5):
                way = displacements(sheet, laid, ratio, rng)
                ends = (reference.energy(q + side * 1e-4 * way) for side in (1, -1))
                exact = (next(ends) - next(ends)) / 2e-4
                worst = max(worst, abs((gradient * way).sum() - exact) / np.linalg.norm(gradient) / np.linalg.norm(way))
            yield Row("forces", f"gradient, dome {dome:g} m, {ratio:g} h", worst, 0.0, 2e-3)


def amplitude(engine: Engine, handle: object) -> float:
    """Return the greatest deflection of a plate's coupled modes over the thickness of 1 mm, from their energy: as if
    all were in the lowest."""
    sheet = sheet_of(engine, handle)
    return math.sqrt(max(whole(engine, handle), 0.0) / sheet["least"]) / 20.0


def energy() -> Iterator[Row]:
    """Follow the scheme's energy of plates without losses for 10 s, struck again after 5 s; and what one gains that
    comes awake and falls asleep."""
    for rate, dome, speed in product((44_100, 48_000, 96_000, 192_000), (0.0, 0.008), (0.4, 2.0)):
        engine = Engine(rate)
        handle = engine.add(lossless(plate(20, dome)))
        worst, most = 0.0, 0.0
        for _ in range(2):
            strike(engine, handle, BEATER, velocity=speed, position=0.8)
            engine.process(rate // 5)
            while engine.stats.contacts_active:
                engine.process(QUANTUM)
            first, most = whole(engine, handle), max(most, amplitude(engine, handle))
            for _ in range(48):
                engine.process(rate // 10)
                worst = max(worst, abs(whole(engine, handle) / first - 1))
            assert is_coupled(engine, handle)
        yield Row("energy", f"of itself, {rate} Hz, dome {dome:g} m, {most:.1f} h", worst, 0.0, 1e-9)
    for dome in (0.0, 0.008):
        gained, turns = _sleeps(dome)
        yield Row("energy", f"gained, awake and asleep {turns} times, dome {dome:g} m", gained, -1.0, 1e-9)


def _sleeps(dome: float) -> tuple[float, int]:
    """Return by which share the energy of a plate that is struck and damped by turns rises at most in a quantum
    without a contact, and how often it came awake or fell asleep."""
    engine = Engine(RATE)
    handle = engine.add(plate(40, dome))
    most, turns, before, awake = -1.0, 0, math.inf, False
    for blow in range(5):
        engine.send([setting(handle, "damp", 0.0)])
        strike(engine, handle, STICK, velocity=1.0 + blow, position=0.8)
        engine.process(2 * QUANTUM)
        while engine.stats.contacts_active:
            engine.process(QUANTUM)
        engine.send([setting(handle, "damp", 0.4, engine.position + 4_800.0)])
        before = whole(engine, handle)
        for _ in range(900):
            engine.process(QUANTUM)
            now = whole(engine, handle)
            if now > 0.0:
                most = max(most, now / before - 1)
            turns += is_coupled(engine, handle) != awake
            before, awake = now, is_coupled(engine, handle)
    return most, turns


def truth() -> Iterator[Row]:
    """Compare, while random blows fall on random plates, the energy of their modes and of what the grid says is
    stretched with the scheme's."""
    worst, mean = [], []
    for seed in range(PLATES):
        rng = np.random.default_rng(seed)
        radius = rng.uniform(0.1, 0.35)
        thickness, dome = rng.uniform(0.0008, 0.002), rng.choice([0.0, 0.02, 0.05]) * radius
        engine = Engine(RATE)
        handle = engine.add(plate(int(rng.integers(20, 80)), dome, radius, thickness, 8_000.0))
        errors = []
        for _ in range(BLOWS):
            mass, speed = 10 ** rng.uniform(-2.5, -0.5), 10 ** rng.uniform(-1.0, 0.7)
            strike(engine, handle, (mass, 3e7, 0.3, 2.3), velocity=speed, position=rng.uniform(0.05, 0.95))
            engine.process(int(BETWEEN * RATE) // QUANTUM * QUANTUM)
            if is_coupled(engine, handle):
                errors.append(abs(true_energy(engine, handle) / whole(engine, handle) - 1))
        worst.append(max(errors))
        mean.append(float(np.mean(errors)))
    yield Row("truth", f"worst of {PLATES} plates, {BLOWS} blows each", max(worst), 0.0, 2e-3)
    yield Row("truth", "mean of the worst plate", max(mean), 0.0, 2e-3)


def tam_tam(modes: int) -> bodies.Modes:
    """Return the tam-tam of 700 x 1.5 mm, with a rise of 10 mm."""
    return bodies.disc(
        BRONZE, radius=0.35, thickness=0.0015, dome=0.01, nonlinear_modes=modes, split=0.004, top=20_000.0
    )


def struck(body: bodies.Modes, velocity: float, seconds: float, rate: int = RATE, position: float = 0.81) -> np.ndarray:
    """Return the sound of a body that the beater strikes."""
    engine = Engine(rate)
    strike(engine, engine.add(body, 1e3), BEATER, velocity=velocity, position=position)
    return engine.process(int(seconds * rate))[:, 0].astype(float)


def octaves(sound: np.ndarray, rate: int, begin: float, end: float) -> np.ndarray:
    """Return the levels (dB) of octaves between two times (s), alike at any rate."""
    piece = sound[int(begin * rate) : int(end * rate)]
    power = np.abs(np.fft.rfft(piece * np.hanning(len(piece)))) ** 2 / len(piece) ** 2
    frequency = np.fft.rfftfreq(len(piece), 1 / rate)
    return np.array(
        [
            10 * math.log10(power[(frequency > low / math.sqrt(2)) & (frequency < low * math.sqrt(2))].sum())
            for low in OCTAVES
        ]
    )


def rates() -> Iterator[Row]:
    """Compare the octaves of a tam-tam at 96 and 192 kHz with those at 48 kHz, each the mean level of BLOWS_HEARD
    blows, and those of two soft ones.

    One blow by itself goes its own way from some tenths of a second on: then its lowest octave differs by 3.6 dB rms,
    the mean of 64 of these by 0.5 dB.
    """
    body = tam_tam(120)
    for velocity, blows in ((4.0, BLOWS_HEARD), (0.02, 2)):
        found = {}
        for rate in (48_000, 96_000, 192_000):
            places = 0.7 + 0.24 * np.arange(blows) / blows
            sounds = [struck(body, velocity, 1.2, rate, float(place)) for place in places]
            for begin, end in ((0.0, 0.3), (0.3, 1.2)):
                levels = [octaves(each, rate, begin, end) for each in sounds]
                found[rate, begin] = np.mean(levels, axis=0)
        for rate, (begin, most) in product((96_000, 192_000), ((0.0, 1.0), (0.3, 2.0))):
            off = float(np.abs(found[rate, begin] - found[48_000, begin]).max())
            what = f"dB in octaves, {rate} against 48000 Hz, from {begin:g} s, {velocity:g} m/s"
            yield Row("rates", what, off, 0.0, most)


def swells() -> Iterator[Row]:
    """Follow the energy above 1 kHz of a tam-tam after hard blows, and after a soft one.

    Such a level is flat at its top, so that chance decides when one blow is at its most: from 0.31 to 0.89 s for 16
    blows, each 3 mm beside the last. So figures are of all these: medians, the least rise, quarters of the times.
    """
    for modes, rise, first, last in ((500, 20.0, 0.1, 0.7), (250, 12.0, 0.0, 1.2)):
        body = tam_tam(modes)
        places = 0.78 + 0.06 * np.arange(BLOWS_FOLLOWED) / (BLOWS_FOLLOWED - 1)
        found = np.array([_swell(struck(body, 4.0, 2.5, RATE, float(place))) for place in places])
        yield Row("swells", f"dB from 20 ms on, {modes} modes", float(np.median(found[:, 0])), rise, 60.0)
        yield Row("swells", f"the same, the least of {BLOWS_FOLLOWED} blows", float(found[:, 0].min()), rise, 60.0)
        for name, share in (("first quarter", 0.25), ("median", 0.5), ("third quarter", 0.75)):
            time = float(np.quantile(found[:, 1], share))
            yield Row("swells", f"s to the most, {name} of blows, {modes} modes", time, first, last)
        yield Row("swells", f"dB at 2.4 s under the most, {modes} modes", float(np.median(found[:, 2])), 3.0, 60.0)
    _, soft = course(struck(body, 0.05, 0.5), 1000.0, RATE)
    _, linear = course(struck(replace(body, sheet=None), 0.05, 0.5), 1000.0, RATE)
    yield Row("swells", "dB over the linear plate, soft blow", float(soft.max() - linear.max()), -1.5, 1.5)


def _swell(sound: np.ndarray) -> tuple[float, float, float]:
    """Return how far the level above 1 kHz of a sound rises (dB), when it is at its most (s), and how far it then falls
    (dB)."""
    time, level = course(sound, 1000.0, RATE)
    most = int(level.argmax())
    return float(level[most] - level[0]), float(time[most]), float(level[most] - level[-1])


def played(preset: str, seconds: float, crashed: bool = False, beside: float = 0.0) -> np.ndarray:
    """Return the sound of a preset's default strike, or of one that makes it crash; beside: farther along its path."""
    usual = carom.Presets().object(preset)
    with carom.Scene(RATE, limiter=False) as scene:
        more = dict(CRASHED.get(preset, {})) if crashed else {}
        velocity = float(more.pop("velocity", usual.velocity))
        more["position"] = float(more.get("position", usual.position)) + beside
        scene.new("a", preset, stereo_width=0).impact(velocity, at=0.0, **more)
        return scene.render(seconds).samples[:, 0].astype(float)


def around(preset: str, seconds: float, crashed: bool = False) -> list[np.ndarray]:
    """Return the sounds of such strikes within some millimetres: one alone goes its own way."""
    return [played(preset, seconds, crashed, float(beside)) for beside in BESIDE]


def opens() -> Iterator[Row]:
    """Follow the centroids of cymbals that crash, of the mean power of several blows: when they have risen, and how
    far."""
    for preset in CYMBALS:
        time, rise = risen(*centroids(around(preset, 1.0, crashed=True), RATE))
        yield Row("opens", f"s in which the centroid rises, {preset}", time, 0.1, 0.4)
        yield Row("opens", f"octaves it rises, {preset}", rise, 0.2, 4.0)


def recorded() -> Iterator[Row]:
    """Compare default strikes with recordings of several cymbals: how much farther they are from these than these from
    each other, in third octaves and in the course of the treble, and how they open, medians of several blows. Nothing
    where fewer than two recordings are there."""
    for preset in CYMBALS:
        real = recordings(preset)
        if len(real) < 2:
            continue
        found = apart(real, [Recording(preset, sound, RATE) for sound in around(preset, 1.2)])
        of = f"{preset} and {found.recordings} recordings"
        for what, (ours, theirs) in (("third octaves", found.gap), ("treble's course", found.treble)):
            yield Row("recorded", f"dB, {what}, over theirs of {theirs:.1f}, {of}", ours - theirs, -10.0, 1.0)
        for what, (ours, each), more in (("s it opens", found.time, 0.1), ("octaves it rises", found.rise, 0.2)):
            yield Row("recorded", f"{what}, {of}", ours, min(each) - more, max(each) + more)


def walls() -> Iterator[Row]:
    """Find by how much more spectra fall where the coupled modes end, and where all modes end below 16 kHz, than just
    below: from one third octave to the next, from 0.3 to 1 s after a blow."""
    for preset in CYMBALS + GONGS:
        sheet = made(preset).sheet
        assert sheet is not None
        ends = {"coupled modes": sheet.laid_out(TOP).highest, "all modes": float(made(preset).frequency.max())}
        sound = played(preset, 1.0, crashed=True)[int(0.3 * RATE) :]
        power = np.abs(np.fft.rfft(sound * np.hanning(len(sound)))) ** 2
        frequency = np.fft.rfftfreq(len(sound), 1 / RATE)
        for name, end in ends.items():
            if end < 16_000.0:
                edges = end * 2 ** (np.arange(-2, 2) / 3)
                first, below, above = (
                    10 * math.log10(power[(frequency >= low) & (frequency < high)].mean())
                    for low, high in pairwise(edges)
                )
                fall = (below - above) - (first - below)
                yield Row("walls", f"dB where {name} end, {end:.0f} Hz, {preset}", fall, -20.0, 10.0)


def made(preset: str) -> bodies.Modes:
    """Return the modes of a preset."""
    return carom.Presets().object(preset).modes(TOP)


PARTS: dict[str, Callable[[], Iterator[Row]]] = {
    each.__name__: each for each in (periods, forces, energy, truth, rates, swells, opens, recorded, walls)
}


def draw(path: Path) -> None:
    """Draw spectrograms of all presets, each struck so that it swells or crashes."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(2, 4, figsize=(20, 9), sharey=True)
    for axis, preset in zip(axes.flat, CYMBALS + GONGS, strict=True):
        sound = played(preset, 2.0, crashed=True)
        axis.specgram(sound + 1e-12, NFFT=1024, Fs=RATE, noverlap=768, vmin=-150, vmax=-40, cmap="magma")
        axis.set_title(preset)
    figure.tight_layout()
    figure.savefig(path, dpi=60)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(PARTS))
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument("--plot", type=Path, help="file for spectrograms of the presets")
    options = parser.parse_args()
    unknown = [part for part in options.parts if part not in PARTS]
    if unknown:
        parser.error(f"part = {unknown[0]}: expected {', '.join(PARTS)}")
    rows = []
    for part in options.parts or PARTS:
        for row in PARTS[part]():
            rows.append(row)
            bound = f"{row.least:g} to {row.most:g}"
            print(
                f"{row.part:8} {row.what:58} {row.figure:10.3g}  {bound:14} {'' if row.holds else 'FAILS'}", flush=True
            )
    if options.json:
        options.json.write_text(json.dumps([{**asdict(row), "holds": row.holds} for row in rows], indent=1) + "\n")
    if options.plot:
        draw(options.plot)


if __name__ == "__main__":
    main()
