"""The channels of the output, and where on them an object is placed: by its pan, or by gains of its own.

Two channels are left and right, and an object's two sides are heard on them. Any other number is a ring around the
listener: channel 1 and 2 are in front, to the left and to the right, and the others follow clockwise. There an object
is a point between two channels.
"""

import math

from ...native.jit import kernel
from ...native.typed import View
from .state import Object, State


@kernel
def ask_gains(state: State, obj: Object) -> None:
    """Find the gains that an object's settings and its place ask for; everything's gain comes on top of them."""
    place, settings, channels = obj.place, obj.settings, state.output.channels
    gain = settings.gain / settings.distance
    place.loudest = gain * state.choices.gain
    if place.has_own == 0:
        pan_gains(place.asked, channels, settings.pan, gain)
        return
    largest = 0.0
    for channel in range(channels):
        place.asked[channel] = gain * place.own[channel]
        largest = max(largest, abs(place.own[channel]))
    place.loudest *= largest


@kernel
def pan_gains(gains: View[float], channels: int, pan: float, gain: float) -> None:
    """Set the gain of each channel for an object at a pan of -1 to 1; powers add up to the same wherever it is.

    Of two: from left to right, and `gain` on both in the middle. Of a ring: pan times half a turn to the right, and
    `gain` on a channel at which the object stands.
    """
    for channel in range(channels):
        gains[channel] = gain
    if channels == 2:
        angle = 0.25 * math.pi * (pan + 1.0)
        gain *= math.sqrt(2.0)
        gains[0], gains[1] = gain * math.cos(angle), gain * math.sin(angle)
    elif channels > 2:
        place = 0.5 * (pan * channels + 1.0)  # in channels from the first
        nearest = math.floor(place)
        angle = 0.5 * math.pi * (place - nearest)
        for channel in range(channels):
            gains[channel] = 0.0
        gains[int(nearest) % channels] = gain * math.cos(angle)
        gains[(int(nearest) + 1) % channels] = gain * math.sin(angle)
