"""Writes the types of gestures' keys from the table of addresses: `python -m tests.documents.typed_keys`."""

from pathlib import Path

from carom.dsp.schema import GESTURES, Parameter
from carom.server.osc.addresses import VERBS

PATH = Path(__file__).parents[2] / "clients" / "gesture_keys.py"

_HEAD = '''"""The keys of gestures as types; tests/documents/typed_keys.py writes them from the table of addresses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol, SupportsFloat, TypedDict

if TYPE_CHECKING:
    from typing_extensions import Unpack
'''

_GESTURE = '''

class {title}Keys(TypedDict, total=False):
    """Keys of {name}."""

{keys}


class {title}OfNamed(Protocol):
    """The gesture {name} on an object of a name, at a position 0 to 1 on its strike path."""

    def __call__(
        self,
        name: str,
        {argument}: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[{title}Keys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""


class {title}OfObject(Protocol):
    """The gesture {name} on an object, the same way."""

    def __call__(
        self,
        {argument}: SupportsFloat | None = None,
        position: SupportsFloat | None = None,
        at: SupportsFloat | None = None,
        **keys: Unpack[{title}Keys],
    ) -> None:
        """Begin the gesture; the preset's own values stand for those that are None."""
'''


def written() -> str:
    """Return the module."""
    parts = [_HEAD]
    for name, gesture in GESTURES.items():
        keys = [
            f"    {key.name}: {'SupportsFloat' if isinstance(key, Parameter) else 'str'}"
            for key in VERBS[f"/object/NAME/{name}"].keys
        ]
        told = {"title": name.title(), "name": name, "argument": gesture.argument.name, "keys": "\n".join(keys)}
        parts.append(_GESTURE.format(**told))
    return "".join(parts)


if __name__ == "__main__":
    PATH.write_text(written(), encoding="utf-8")
