"""Ways in which directions become channels."""

from enum import IntEnum


class Layout(IntEnum):
    """Way in which directions become channels."""

    PAN = 0
    BINAURAL = 1
    AMBISONICS = 2


# The same as plain numbers, which kernels compare with.
PAN, BINAURAL, AMBISONICS = (int(layout) for layout in Layout)
