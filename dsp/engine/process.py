"""The engine's page: from commands to sound, in the order in which it happens.

Sound is computed in quanta of QUANTUM frames. Device blocks of any size are served from finished quanta, so a block
size can't change a bit of it. Nothing here allocates, locks or needs Python.
"""

from ..native.atomics import load_acquire, store_release
from ..native.jit import kernel
from ..native.typed import View2D
from .bank.spectral import recall_objects, ring_bank
from .bodies.sensing import finish_sensing
from .events.events import carry_out, take_commands, take_due
from .events.ramps import run_ramps
from .memory.filling import fill_unused
from .memory.state import QUANTUM, TAP, State
from .output.headroom import keep_headroom
from .output.limiter import limit
from .output.meter import measure
from .render import forget_quiet, mix_objects, retune_objects, update_objects


@kernel
def process(state: State, out: View2D[float], frames: int) -> None:
    """Write `frames` frames of sound to out, float32 (frames, channels): those of the mix, then those of sensors."""
    output = state.output
    channels = output.channels + output.sensors
    done = 0
    while done < frames:
        if output.consumed == QUANTUM:
            render_quantum(state)
            output.consumed = 0
        count = min(frames - done, QUANTUM - output.consumed)
        # Write `count` frames, of those that are ready from `first` on, to `out` from `begin` on.
        first = output.consumed
        if channels == 1:  # one row after another, which is copied several frames at a time
            for n in range(count):
                out[done + n, 0] = output.ready[0, first + n]
        else:
            for n in range(count):
                for channel in range(channels):
                    out[done + n, channel] = output.ready[channel, first + n]
        done += count
        output.consumed += count


@kernel
def render_quantum(state: State) -> None:
    """Compute the next quantum: the way of the sound."""
    fill_unused(state)
    # Commands that Python has sent join the queue; events whose time falls into this quantum are carried out.
    take_commands(state)
    while True:
        index = take_due(state)
        if index < 0:
            break
        carry_out(state, state.queue.events[index])
    run_ramps(state)
    # Gestures glide and bodies roll on; modes that were retuned get their coefficients.
    update_objects(state)
    recall_objects(state)
    retune_objects(state)
    # Modes that ring freely do so in the spectral bank, a block ahead.
    ring_bank(state)
    # Contacts drive the modes, the modes ring, and each object adds its sound to the mix.
    mix_objects(state)
    # What goes on being too loud is turned down slowly. The limiter has the last word, and a quantum's delay; what
    # leaves is measured, and kept for a recorder.
    keep_headroom(state)
    limit(state)
    finish_sensing(state)
    measure(state)
    forget_quiet(state)
    # Hand the mix over to whoever asks for frames, and move on in time.
    output = state.output
    for channel in range(output.channels):
        for n in range(QUANTUM):
            output.ready[channel, n] = output.mix[channel, n]
    for k in range(output.sensors):
        for n in range(QUANTUM):
            output.ready[output.channels + k, n] = state.sensors[k].sensed[n]
    state.position += QUANTUM
    state.steps_taken = 0
    if state.stats.sounding > 0:
        state.stats.sounded = state.position
    _tap(state)


@kernel
def _tap(state: State) -> None:
    """Keep the quantum for a recorder, if it keeps up; not the silence that a limiter begins with."""
    tap = state.tap
    if tap.on == 0 or state.position <= state.output.delay:
        return
    written = tap.written[0]
    if written + QUANTUM - load_acquire(tap.read, 0) > TAP:
        state.stats.tap_lost += QUANTUM
        return
    channels = state.output.channels + state.output.sensors
    for n in range(QUANTUM):
        for channel in range(channels):
            tap.frames[(written % TAP + n) * channels + channel] = state.output.ready[channel, n]
    tap.first[written % TAP // QUANTUM] = state.position - QUANTUM - state.output.delay
    store_release(tap.written, 0, written + QUANTUM)
