"""Every shape that gives modes: the public face of the shape modules."""

from .bar import bar
from .disc import disc, membrane
from .modes import Modes, listed
from .plate import plate
from .ring import glass, ring
from .string import string

__all__ = ["Modes", "bar", "disc", "glass", "listed", "membrane", "plate", "ring", "string"]
