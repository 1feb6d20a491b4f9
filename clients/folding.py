"""Text that fits a terminal: long lines are folded between words. Lines that go elsewhere are not folded."""

import os
from typing import TextIO

_NARROWEST = 40  # columns: a terminal that says that it has fewer is not believed


def columns_of(stream: TextIO | None) -> int | None:
    """Return the number of columns of the terminal that a stream goes to; None if it goes elsewhere."""
    if stream is None or not stream.isatty():
        return None
    try:
        return max(_NARROWEST, os.get_terminal_size(stream.fileno()).columns)
    except OSError:
        return _NARROWEST * 2


def folded(text: str, columns: int | None, indent: int = 4) -> str:
    """Fold a line into lines of at most so many columns, all but the first indented; leave it as it is where `columns`
    is None.

    Only words that are longer than a line stand out.
    """
    if columns is None or len(text) < columns:
        return text
    import textwrap  # slow to load

    return textwrap.fill(
        text, columns - 1, subsequent_indent=" " * indent, break_long_words=False, break_on_hyphens=False
    )
