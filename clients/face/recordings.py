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
    r"""Make an object of recordings of single strikes, as `carom fit` does.

    Parameters
    ----------
    recordings : path, list of paths or a folder
        Sound files.
    out : path
        Folder of presets that gets the object; it is made if missing.
    name : str
        Name of the object.
    presets : path, list of paths or Presets, optional
        Folders of your own presets.
    report : bool, default False
        Whether the page NAME.html is written.
    **known
        What is known, by these keys:

        - `modes`: largest number of modes.
        - `positions`: position of each strike, 0 to 1.
        - `strikers`: a preset's name or a new one; one, or one for each strike.
        - `force`: recording of the force, by an impact hammer.
        - `mass`, `velocity`: mass of the object, kg, and speed of the strikes, m/s.
        - `full_scale`, `distance`: pressure of full scale, Pa, and distance of the microphone, m.
        - `source`, `licence`: texts, kept in the preset.

    Returns
    -------
    Made
        `fit`: frequency (n,) in Hz, decay (n,) in 1/s, residual in dB of each take. `files`, `notes`, and `sound`,
        the default strike.

    Raises
    ------
    RecordingError, FitError, PresetError, OSError
        An argument is refused, or a file cannot be read or written; the text says why.

    Examples
    --------
    >>> import carom
    >>> score = "0 /object/new a marimba-bar\n0.1 /object/a/impact 1 striker wood"
    >>> path = carom.render(score, seconds=1.5, limiter=False).save("strike.wav")
    >>> made = carom.fit("strike.wav", "mine", "bar", modes=8, licence="CC0-1.0", source="an example")
    >>> len(made.fit.frequency) <= 8
    True
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
    r"""Measure how far apart two sound files are, as `carom compare` does.

    Parameters
    ----------
    a, b : path
        Sound files; b is shifted and levelled to agree with a.

    Returns
    -------
    Distance
        `residual` and `spectral` (log-spectral distance), float, dB; `thirds`, array (n, 3) of Hz, dB and dB;
        `decays` by octave, array (n, 3) of Hz, s and s.

    Raises
    ------
    RecordingError, OSError
        A file cannot be read; the text says why.

    Examples
    --------
    >>> import carom
    >>> for n, striker in enumerate(("wood", "yarn")):
    ...     score = f"0 /object/new a marimba-bar\n0.1 /object/a/impact 1 striker {striker}"
    ...     carom.render(score, seconds=1.5).save(f"{n}.wav")
    >>> carom.compare("0.wav", "1.wav").spectral > 0
    True
    """
    wanted = "a sound file, such as Sound.save writes"
    return _compare(path_of("a", a, wanted), path_of("b", b, wanted))[0]
