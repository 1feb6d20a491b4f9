"""The errors that a command prints in one line, and their wording."""

import sys
from pathlib import Path

from ..dsp.wording import near
from .folding import columns_of, folded

KINDS = (OSError, RuntimeError, ValueError)
"""Errors that may be Carom's own or the system's; `is_expected` separates these from bugs."""


def is_expected(error: Exception) -> bool:
    """True if an error is Carom's own or the system's. Others are bugs, and keep their traceback."""
    return isinstance(error, OSError) or type(error).__module__.startswith("carom.")


def plain(error: Exception) -> str:
    """Return an error as one line; for a file that is missing, with the near name in its folder."""
    if not isinstance(error, OSError) or error.filename is None:
        return str(error)
    text = f"{error.filename}: {error.strerror}"
    missing = Path(error.filename)
    if isinstance(error, FileNotFoundError) and missing.parent.is_dir():
        from difflib import SequenceMatcher  # slow to load

        # Without their endings, which make all names alike; of names that differ in it, that with the nearest ending.
        def likeness(path: Path) -> tuple[float, Path]:
            return SequenceMatcher(None, path.suffix, missing.suffix).ratio(), path

        paths = sorted(missing.parent.iterdir(), key=likeness)
        names = {path.stem: path.name for path in paths}
        if found := near(missing.stem, names):
            return f"{text}; did you mean {' or '.join(names[stem] for stem in found)}?"
    return text


def tell(command: str, text: str) -> None:
    """Print a line about a command on stderr, folded where that is a terminal."""
    print(folded(f"carom {command}: {text}", columns_of(sys.stderr)), file=sys.stderr)
