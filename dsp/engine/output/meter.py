"""The level meter: what leaves the engine, by quanta: its peaks, and its power as ITU-R BS.1770 weighs it."""

from ...native.jit import kernel
from ...native.typed import View
from ..memory.meter_record import METERED
from ..memory.state import QUANTUM, State


@kernel
def measure(state: State) -> None:
    """Keep the peaks and the power of the quantum that leaves, where a meter is on."""
    meter, output = state.meter, state.output
    if meter.on == 0:
        return
    place = state.position // QUANTUM % METERED
    power = 0.0
    for channel in range(output.channels):
        memory, peak = meter.memory[channel], 0.0
        for n in range(QUANTUM):
            sample = output.mix[channel, n]
            peak = max(peak, abs(sample))
            weighted = _filter(meter.high_pass, memory, 2, _filter(meter.shelf, memory, 0, sample))
            power += weighted * weighted
        meter.peak[place, channel] = peak
    meter.power[place] = power / QUANTUM


@kernel
def _filter(c: View[float], memory: View[float], at: int, sample: float) -> float:
    """Filter a sample by a filter of second order, whose memory begins at a place."""
    out = c[0] * sample + memory[at]
    memory[at] = c[1] * sample - c[3] * out + memory[at + 1]
    memory[at + 1] = c[2] * sample - c[4] * out
    return out
