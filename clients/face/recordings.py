"""Objects from recordings, and sounds beside each other."""

from collections.abc import Iterable, Sequence
from dataclasses import fields
from os import PathLike
from pathlib import Path
from typing import Any

from .clients.comparison import compare as _compare
from .clients.fitting import Made, Wanted, make
from .clients.performer import Folders
from .dsp.arguments import ArgumentError, explain_arguments, path_of, refuse_unknown
from .dsp.fitting.distance import Distance
from .presets import Presets

File = str | PathLike[str]


@explain_arguments
def fit(
    recordings: File | Iterable[File],
    out: File,
    name: str,
    *,
    presets: Folders = (),
    report: bool = False,
    **known: Any,
) -> Made:
    """Make an object of recordings of single strikes, as `carom fit` does.

        carom.fit(["left.wav", "middle.wav"], "mine", "bar", positions=(0.1, 0.5), licence="CC0")
        carom.Scene(presets="mine").new("a", "bar").impact(2.0, position=0.3)

    recordings: sound files, or a folder of such. out: the folder that gets the presets; it is made if missing. name:
    the object's. known: modes (how many at most), positions (0 to 1, one for each hit), strikers (a preset's name or a
    new one; one, or one for each hit), force (a hammer's recording), mass (kg), velocity (m/s), full_scale (Pa),
    distance (m), source, licence. report: whether to write the page NAME.html too.

    Return `fit` (frequency (n,) in Hz, decay (n,) in 1/s, residual in dB of each take), `files`, `notes`, and `sound`,
    the default strike. RecordingError, FitError, PresetError or OSError say what cannot be.
    """
    refuse_unknown("fit", known, (each.name for each in fields(Wanted) if each.name != "name"))
    if not isinstance(recordings, str | PathLike | Iterable):
        raise ArgumentError(f"recordings = {recordings!r}: expected sound files, or a folder of them")
    paths = [recordings] if isinstance(recordings, str | PathLike) else list(recordings)
    files = [path_of("recordings", each, "sound files, or a folder of them") for each in paths]
    for key in ("positions", "strikers"):
        if isinstance(known.get(key), Sequence) and not isinstance(known[key], str):
            known[key] = tuple(known[key])
    if "force" in known and known["force"] is not None:
        known["force"] = path_of("force", known["force"], "a sound file")
    library = presets if isinstance(presets, Presets) else Presets(presets)
    made = make(files, path_of("out", out, "a folder"), Wanted(name, **known), library)
    if report:
        from .clients.fit_report import write_report

        write_report(made, name, Path(out))
    return made


@explain_arguments
def compare(a: File, b: File) -> Distance:
    """Measure how far apart two sound files are, as `carom compare` does.

    Return the residual and the log-spectral distance (dB), third octaves (Hz, dB, dB), and decays by octave (Hz, s, s).
    RecordingError or OSError say what cannot be read.
    """
    wanted = "a sound file, such as Sound.save writes"
    return _compare(path_of("a", a, wanted), path_of("b", b, wanted))[0]
