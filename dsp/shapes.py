"""Every shape that gives modes: the public face of the shape modules."""

from .bar import bar
from .body import Modes, listed
from .disc import disc, membrane
from .plate import plate
from .ring import glass, ring
from .strings import string

__all__ = ["Modes", "bar", "disc", "glass", "listed", "membrane", "plate", "ring", "string"]
