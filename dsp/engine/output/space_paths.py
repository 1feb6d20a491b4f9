"""The ways of a line's sound to the listener, each with its own time, loss and direction.

What arrives at a time left when the way was as long as the time since: that is solved at the end of each quantum, and
goes as a cubic over it, so that delay and doppler are those of the motion, of object and listener. Gains and filters go
as lines over a quantum.
"""

import math

from ...native.jit import kernel, noinline_kernel
from ...native.typed import View, View2D
from ...resonator.pole import run_pole
from ...resonator.simd_pole import run_filter
from ...space.delay import AHEAD_OF, TAPS, read_moving, read_steady, read_stretch
from ...space.harmonics import harmonics
from ...space.head import ear_path, ear_shadow
from ..memory.capacity import STEMS
from ..memory.channels import pan_gains
from ..memory.space_record import FRAMES, KNOTS, Line, Path, Space
from ..memory.state import QUANTUM, State
from .fade import left_of

NEAREST = 0.1
"""m: what is nearer is as loud as there."""
_SOONEST = AHEAD_OF + 1.0  # samples: no way is shorter
_LONGEST = FRAMES - 4.0 * QUANTUM  # nor longer
_ROUNDS = 6
_EXACT = 1e-4  # samples: what a smaller step of Newton's leaves is none
_FASTEST = 0.1  # least derivative of the arrival by the departure: bodies are slower than sound
_FLEES, _JUMP = -0.5, 2.5  # quanta that may pass at a line's far end in one: fewer or more are a jump
_TURNS = 0.5 * QUANTUM  # samples by which the way to an ear may change in a quantum: more is a jump, too
_STEADY = 1e-7  # samples
_INAUDIBLE = 1e-3  # dB that the air takes
_SAME = 1e-5  # of the poles: less is left as it is
_EASY = 1.0  # dB up to which one filter takes it all


@noinline_kernel
def hear_path(state: State, line: Line, path: Path, wall: int, end: int) -> bool:
    """Hear a way of a line in this quantum; return True if there was, or may soon be, something to hear."""
    space, rate = state.surroundings, state.rate
    comes = wall > 0 and path.known == 0 and space.walls_change == 2
    if path.known == 1 and path.still == 1 and _stays(space, line) and not (wall > 0 and space.walls_change == 1):
        # Hear a way on which nothing has changed since the quantum before.
        begin = path.place
        path.place += QUANTUM
        if line.last <= begin - TAPS:
            return False
        for channel in range(state.output.channels):
            space.asked[channel] = path.gain[channel]
        for ear in range(2):
            space.aim[ear], space.aim[2 + ear] = path.longer[ear], path.shadow[ear]
        if space.fading == 1:
            _lay_places(space.places, begin, 1.0, path.place, 1.0)
        for ear in range(2 if space.layout == 1 else 1):
            place = min(begin - path.longer[ear], state.position - _SOONEST)
            whole = math.floor(place)
            _copy(space, line, whole - (TAPS // 2 - 1), QUANTUM + TAPS, state.position + QUANTUM)
            read_steady(space.window, place - whole, space.taps, space.heard[ear], QUANTUM)
        _filter(state, path, path.air[0], path.air[1])
        _mix_path(state, line, path)
        return True
    found = space.weights  # room for 7
    begin, slope = path.place, path.slope
    place = _departed(space, line, rate, wall, begin + slope * QUANTUM if path.known == 1 else 1e300, float(end), found)
    frames = rate / space.speed
    moves = along = 0.0
    for i in range(3):
        velocity = (space.listener.now[i] - space.listener.before[i]) / QUANTUM
        along += found[i] * velocity / found[6]
        moves += found[i] * found[3 + i] / found[6]
    later = min(max((1.0 + frames * along) / max(1.0 + frames * moves, _FASTEST), _FLEES), _JUMP)
    if path.known == 0:
        begin, slope = place - QUANTUM, 1.0
    first, second = _aim(state, path, wall, found)
    if comes:  # in this quantum: gains go as lines
        for channel in range(state.output.channels):
            path.gain[channel] = 0.0
    jumps = not _FLEES * QUANTUM < place - begin < _JUMP * QUANTUM
    for ear in range(2):
        jumps |= abs(space.aim[ear] - path.longer[ear]) > _TURNS
    path.place, path.slope, path.known = place, later, 1
    steady = abs(later - 1.0) + abs(slope - 1.0) + abs(place - begin - QUANTUM) < _STEADY
    path.still = int(steady and _stays(space, line))
    if line.last <= min(begin, place) - TAPS:
        _settle(state, path, first, second)
        return False
    if jumps:
        # Read a line whose object or listener has jumped: from the old way to the new one by a fade.
        _lay_places(space.places, begin, slope, begin + slope * QUANTUM, slope)
        _read(state, line, path.longer, path.longer, space.heard)
        for ear in range(2):
            for n in range(QUANTUM):
                space.other[ear, n] = space.heard[ear, n]
        _lay_places(space.places, place - later * QUANTUM, later, place, later)
        _read(state, line, space.aim, space.aim, space.heard)
        for ear in range(2):
            for n in range(QUANTUM):
                u = (n + 1) / QUANTUM
                share = u * u * (3.0 - 2.0 * u)
                space.heard[ear, n] = space.other[ear, n] + share * (space.heard[ear, n] - space.other[ear, n])
    else:
        _lay_places(space.places, begin, slope, place, later)
        _read(state, line, path.longer, space.aim, space.heard)
    _filter(state, path, first, second)
    _mix_path(state, line, path)
    return True


@kernel
def feed_late(state: State, line: Line, begin: float, end: float) -> None:
    """Add what arrives straight in this quantum, and left from `begin` to `end`, to what the room's late part is fed:
    nothing comes by walls before that. Where the way changes, by a fade from whole samples to whole samples."""
    space = state.surroundings
    fed, window = space.late.fed, space.window
    first, second = math.floor(begin + 0.5), math.floor(end + 0.5) - QUANTUM
    _copy(space, line, second, QUANTUM, state.position + QUANTUM)
    for n in range(QUANTUM):
        fed[n] += window[n] * ((n + 1) / QUANTUM if first != second else 1.0)
    if first != second:
        _copy(space, line, first, QUANTUM, state.position + QUANTUM)
        for n in range(QUANTUM):
            fed[n] += window[n] * (1.0 - (n + 1) / QUANTUM)


@kernel
def _stays(space: Space, line: Line) -> bool:
    """True if neither an object nor the listener has moved for as long as a line holds."""
    return space.stays == 1 and line.moved_at + FRAMES <= space.now


@kernel
def _departed(space: Space, line: Line, rate: float, wall: int, guess: float, end: float, out: View[float]) -> float:
    """Return when that left which arrives at a time `end` (samples), by Newton's method; `out` has room for 7: the way
    from listener to source, the source's velocity, and the distance (m)."""
    frames = rate / space.speed
    place = min(max(guess, end - _LONGEST), end - _SOONEST)
    for _ in range(_ROUNDS):
        # Find where an object, or its image behind a wall (0: itself), was at a time (samples), in out[:3], and its
        # velocity in m a sample, in out[3:6].
        knot = math.floor(place / QUANTUM)
        share = place / QUANTUM - knot
        here, there = int(knot) & (KNOTS - 1), (int(knot) + 1) & (KNOTS - 1)
        for i in range(3):
            a, b = space.knots[here, line.number, i], space.knots[there, line.number, i]
            out[i] = a + share * (b - a)
            out[3 + i] = (b - a) / QUANTUM
        if wall > 0:
            # Of a floor there is one wall, below; of a box those below and above along each axis.
            axis = 2 if space.walls == 1 else (wall - 1) // 2
            side = space.low[axis] if space.walls == 1 or (wall - 1) % 2 == 0 else space.high[axis]
            out[axis] = 2.0 * side - out[axis]
            out[3 + axis] = -out[3 + axis]
        square = along = 0.0
        for i in range(3):
            out[i] -= space.listener.now[i]
            square += out[i] * out[i]
            along += out[i] * out[3 + i]
        out[6] = max(math.sqrt(square), 1e-6)
        slope = max(1.0 + frames * along / out[6], _FASTEST)
        error = (place - end + frames * out[6]) / slope
        place = min(max(place - error, end - _LONGEST), end - _SOONEST)
        if abs(error) < _EXACT:
            break
    return place


@kernel
def _aim(state: State, path: Path, wall: int, found: View[float]) -> tuple[float, float]:
    """Find the gains to which a way goes in this quantum, in `asked`, and what its ears shall be, in `aim`; return the
    poles of the air's two filters."""
    space = state.surroundings
    far = found[6]
    share = (0.0 if space.walls_change == 1 else space.reflected) if wall > 0 else 1.0
    gain = share / max(far, NEAREST)
    # A direction in the axes of a pose: ahead, left and up.
    x = found[0] / far
    y = found[1] / far
    z = found[2] / far
    w, i, j, k = space.listener.now[3], -space.listener.now[4], -space.listener.now[5], -space.listener.now[6]
    a, b, c = 2.0 * (j * z - k * y), 2.0 * (k * x - i * z), 2.0 * (i * y - j * x)
    ahead, left, up = x + w * a + j * c - k * b, y + w * b + k * a - i * c, z + w * c + i * b - j * a
    channels = state.output.channels
    for channel in range(channels):
        space.asked[channel] = 0.0
    if space.layout == 2:
        harmonics(space.asked, space.order, ahead, left, up)
        for channel in range(channels):
            space.asked[channel] *= gain
    elif space.layout == 1:
        space.asked[0] = space.asked[1] = gain
    elif channels == 2:
        pan_gains(space.asked, 2, min(max(-left, -1.0), 1.0), gain)
    else:
        level = math.sqrt(max(1.0 - up * up, 0.0))
        pan_gains(space.asked, channels, -math.atan2(left, ahead) / math.pi if level > 1e-6 else 0.0, gain)
    if space.layout == 1:
        angle = math.acos(min(max(left, -1.0), 1.0))
        for ear in range(2):
            space.aim[ear] = ear_path(angle, space.head) / space.speed * state.rate
            space.aim[2 + ear] = ear_shadow(angle)
            angle = math.pi - angle
    else:
        space.aim[0] = space.aim[1] = 0.0
        space.aim[2] = space.aim[3] = 1.0
    lost = space.air * far
    first = _air_pole(space, min(lost, _EASY + 0.5 * max(lost - _EASY, 0.0)))
    second = _air_pole(space, 0.5 * max(lost - _EASY, 0.0))
    if path.known == 0:
        _settle(state, path, first, second)
    if abs(first - path.air[0]) + abs(second - path.air[1]) < _SAME:
        return path.air[0], path.air[1]
    return first, second


@kernel
def _air_pole(space: Space, lost: float) -> float:
    """Return the pole of a filter that takes so many dB at the frequency where the air's absorption is known."""
    if lost < _INAUDIBLE:
        return 0.0
    square = math.exp(-0.1 * math.log(10.0) * lost)
    half = (1.0 - square * space.turned) / (1.0 - square)
    return min(half - math.sqrt(max(half * half - 1.0, 0.0)), 0.999)


@kernel
def _settle(state: State, path: Path, first: float, second: float) -> None:
    """Bring a way's gains and filters at once to where they go: nobody hears it."""
    space = state.surroundings
    for channel in range(state.output.channels):
        path.gain[channel] = space.asked[channel]
    path.air[0], path.air[1] = first, second
    for ear in range(2):
        path.longer[ear], path.shadow[ear] = space.aim[ear], space.aim[2 + ear]
        for k in range(4):
            path.memory[ear, k] = 0.0


@kernel
def _lay_places(places: View[float], begin: float, slope: float, end: float, later: float) -> None:
    """Lay out a cubic from a place to another a quantum later, by its slopes there."""
    way = end - begin
    a, b = slope * QUANTUM - way, way - later * QUANTUM
    for n in range(QUANTUM):
        u = n / QUANTUM
        places[n] = begin + u * way + u * (1.0 - u) * ((1.0 - u) * a + u * b)


@kernel
def _read(state: State, line: Line, before: View[float], after: View[float], out: View2D[float]) -> None:
    """Read a line at `places`: for each ear, if there are two, the ways to which go from some samples longer to others
    over the quantum."""
    space = state.surroundings
    for ear in range(2 if space.layout == 1 else 1):
        longer, more = before[ear], (after[ear] - before[ear]) / QUANTUM
        soonest = state.position - _SOONEST
        for n in range(QUANTUM):
            # In samples from the quantum's begin, each less its number: of what is steady all are alike.
            space.weights[n] = min(space.places[n] - longer - n * more, soonest + n) - n
        low, high = _range_of(space.weights)
        least, greatest = math.floor(low), math.floor(high)
        first = least - (TAPS // 2 - 1)
        _copy(space, line, first, greatest - least + QUANTUM + TAPS, state.position + QUANTUM)
        if high - low < _STEADY:
            read_steady(space.window, low - least, space.taps, out[ear], QUANTUM)
        elif least == greatest:
            read_stretch(space.window, space.weights, least, out[ear])
        else:
            read_moving(space.window, least, space.weights, out[ear], QUANTUM)


@kernel
def _range_of(lags: View[float]) -> tuple[float, float]:
    """Return the least and the greatest of a quantum's lags."""
    low, high = lags[0], lags[0]
    for n in range(0, QUANTUM, 8):
        a, b, c, d = lags[n], lags[n + 1], lags[n + 2], lags[n + 3]
        p, q, r, s = lags[n + 4], lags[n + 5], lags[n + 6], lags[n + 7]
        low = min(low, min(min(min(a, b), min(c, d)), min(min(p, q), min(r, s))))
        high = max(high, max(max(max(a, b), max(c, d)), max(max(p, q), max(r, s))))
    return low, high


@kernel
def _copy(space: Space, line: Line, first: int, count: int, end: int) -> None:
    """Copy samples of a line from number `first` on to the window; before the line began, and from `end` on, they are
    silence."""
    window, done = space.window, 0
    while done < count:
        quantum = (first + done) // QUANTUM
        begin = first + done - quantum * QUANTUM
        size = min(QUANTUM - begin, count - done)
        sound = space.sounds[quantum & (KNOTS - 1), line.number, begin : begin + size]
        for n in range(size):
            window[done + n] = sound[n]
        done += size
    for n in range(min(line.since - first, count)):
        window[n] = 0.0
    for n in range(max(end - first, 0), count):
        window[n] = 0.0


@kernel
def _filter(state: State, path: Path, first: float, second: float) -> None:
    """Filter what was read as the air and the head do, and fade what left before a panic."""
    space = state.surroundings
    for ear in range(2 if space.layout == 1 else 1):
        heard, memory = space.heard[ear], path.memory[ear]
        if space.fading == 1:
            for n in range(QUANTUM):
                if space.places[n] < space.panicked:
                    heard[n] *= left_of(state.rate, space.faded + n + 1)
        if first > 0.0 or path.air[0] > 0.0:
            memory[0] = _lose(heard, path.air[0], first, memory[0])
        if second > 0.0 or path.air[1] > 0.0:
            memory[1] = _lose(heard, path.air[1], second, memory[1])
        else:
            memory[1] = heard[QUANTUM - 1]
        if space.layout == 1:
            # Filter what an ear heard as the head's shadow does, which goes from one to another over the quantum.
            heard = state.surroundings.heard[ear]
            two, corner = 2.0 * state.rate, 2.0 * space.speed / space.head
            scale = 1.0 / (corner + two)
            low, high = corner * scale, two * scale
            more = (space.aim[2 + ear] - path.shadow[ear]) / QUANTUM * high
            begin, previous = path.shadow[ear] * high + more, memory[2]
            memory[2] = heard[QUANTUM - 1]
            memory[3] = run_filter(heard, low + begin, low - begin, more, previous, high - low, memory[3])
            path.longer[ear], path.shadow[ear] = space.aim[ear], space.aim[2 + ear]
    path.air[0], path.air[1] = first, second


@kernel
def _lose(heard: View[float], before: float, pole: float, last: float) -> float:
    """Filter a quantum by one pole, which goes from one value to another; return the last sample."""
    if pole == before:
        return run_filter(heard, 1.0 - pole, 0.0, 0.0, 0.0, pole, last)
    more = (pole - before) / QUANTUM
    for n in range(QUANTUM):
        heard[n] *= 1.0 - (before + (n + 1) * more)
    return run_pole(heard, before, more, last)


@kernel
def _mix_path(state: State, line: Line, path: Path) -> None:
    """Add what was heard to each channel, and to the object's stem where stems are kept."""
    space, output = state.surroundings, state.output
    for channel in range(output.channels):
        before = path.gain[channel]
        step = (space.asked[channel] - before) / QUANTUM
        path.gain[channel] = space.asked[channel]
        if before == 0.0 and step == 0.0:
            continue
        heard = space.heard[channel if space.layout == 1 else 0]
        for n in range(QUANTUM):
            output.mix[channel, n] += heard[n] * (before + (n + 1) * step)
        if output.stems_on == 1 and line.slot < STEMS:
            output.stem_sounds[output.turn, line.slot] = 1
            for n in range(QUANTUM):
                output.stems[output.turn, line.slot, channel, n] += heard[n] * (before + (n + 1) * step)
