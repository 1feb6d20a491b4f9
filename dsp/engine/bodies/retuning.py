"""The coefficients of an object's modes, as it is tuned and as tense as it is now."""

from ...native.jit import noinline_kernel
from ...resonator.bank import MOBILITY, RESPONSES
from ...resonator.click import set_click
from ...resonator.coefficients import set_mode, yield_less
from ...resonator.simd import LANES
from ..memory.state import Object, State
from .objects import is_felt, modes_of, relief_of, ringing_of, share_of, weigh_anew
from .reshaping import reshape_mode


@noinline_kernel
def retune(state: State, obj: Object, count: int) -> None:
    """Bring the next `count` modes of an object to its tune, decay and damp."""
    modes = modes_of(state, obj, 0, obj.size)
    for _ in range(count):
        i = obj.retuning
        strength = state.bank.weight[obj.first + i]
        if obj.reshaped >= 0:
            reshape_mode(state, obj, i)
        if is_felt(obj, i):
            frequency, sigma, weight = ringing_of(state, obj, i)
            share = share_of(state, obj, i, frequency)
            weigh_anew(state, obj, i, weight)
            set_mode(modes, i, frequency, sigma, state.rate, complex(weight, 0.0))
            if share != 1.0:
                yield_less(modes, i, share)
        elif i < obj.bent:
            frequency, sigma, weight = relief_of(state, obj, i)
            # Give mode i coefficients as `set_mode` does, but no contact feels it.
            set_mode(modes, i, frequency, sigma, state.rate, complex(weight, 0.0))
            base = (i // LANES) * RESPONSES + i % LANES
            modes.response[base + MOBILITY] = modes.response[base + MOBILITY + LANES] = 0.0
        else:
            bank, j = state.bank, obj.first + i
            if modes.a2[i] == 0.0 and bank.frequency[j] > 0.0:  # not yet made: all of its modes are made at once
                set_click(modes, i, bank.frequency[j], bank.sigma[j], state.rate, strength)
            elif modes.a2[i] == 0.0:
                set_mode(modes, i, 0.0, 0.0, state.rate, 0.0j)
            if bank.weight[j] != strength:
                yield_less(modes, i, bank.weight[j] / strength)
        obj.retuning = (i + 1) % obj.size
    obj.stale_modes -= count
    obj.retuned += 1 if count > 0 else 0
