"""Texts that go out: what came in may be in them."""

_LONGEST = 1_000  # characters


def plain(text: str) -> str:
    """Return text that can be sent and shown anywhere: short, and without control characters."""
    short = text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."
    return short if short.isprintable() else "".join(c if c.isprintable() else "?" for c in short)
