"""Names of files that are made of names that somebody has chosen: such as every system takes, in no other folder."""

import hashlib
import re
import unicodedata
from collections.abc import Iterable

_UNSAFE = re.compile(r"""[\x00-\x1f\x7f"*/:<>?\\|%]|^[.-]|[. ]$""")
_DEVICES = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|(com|lpt)[0-9¹²³])(\.|$)", re.IGNORECASE)
"""Names that are devices on Windows, whatever ends them."""
_LONGEST = 180  # bytes, of 255, as endings and the names of unfinished files come on top


def file_names(names: Iterable[str]) -> dict[str, str]:
    """Return a name of a file, without its ending, for each of some names that differ.

    A character that some system does not take, or gives a meaning to, becomes % and its number in hexadecimal: \\ is
    %5C. One that differs from another but in upper or lower case, or in the way in which accents are written, ends in
    %2, %3 ...; one that is too long is cut, and ends in % and a digest of the whole.
    """
    made: dict[str, str] = {}
    taken: set[str] = set()
    for name in names:
        safe = _UNSAFE.sub(_escaped, name) or "%"
        if _DEVICES.match(safe):
            safe = f"%{ord(safe[0]):02X}{safe[1:]}"
        if len(safe.encode()) > _LONGEST:
            safe = f"{_cut(safe)}%{hashlib.sha256(name.encode()).hexdigest()[:12]}"
        count, unique = 1, safe
        while (seen := unicodedata.normalize("NFC", unique).casefold()) in taken:
            count += 1
            unique = f"{safe}%{count}"
        taken.add(seen)
        made[name] = unique
    return made


def _escaped(found: re.Match[str]) -> str:
    return f"%{ord(found[0]):02X}"


def _cut(text: str) -> str:
    return text.encode()[: _LONGEST - 13].decode(errors="ignore")
