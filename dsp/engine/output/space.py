"""Space: the sound of objects with a place travels in lines to a listener, by several ways."""

from ...native.jit import noinline_kernel
from ..memory.space_record import KNOTS, LINES, NO_CHANGE, WALLS_COME, WALLS_FADE
from ..memory.state import QUANTUM, State
from .fade import fade_length
from .late import hear_late, let_walls_come
from .space_lines import pose_at
from .space_paths import feed_late, hear_path


@noinline_kernel
def hear_space(state: State) -> None:
    """Add what arrives at the listener in this quantum to the mix."""
    space = state.surroundings
    if space.on == 0:
        return
    end = state.position + QUANTUM
    space.now = end
    for k in range(7):
        space.listener.before[k] = space.listener.now[k]
    pose_at(space.listener, float(end))
    space.stays = 1
    for k in range(7):
        if space.listener.now[k] != space.listener.before[k]:
            space.stays = 0
    for n in range(QUANTUM):
        space.late.fed[n] = 0.0
    for n in range(LINES):
        if space.lines[n].used == 1:
            # Hear a line in this quantum, and note where its object is at the end of it.
            line = space.lines[n]
            obj = state.objects[line.slot]
            if line.left == 0 and (obj.used == 0 or obj.serial != line.serial):
                line.left = 1
            sound = space.sounds[state.position // QUANTUM & (KNOTS - 1), line.number]
            if line.written == 0:
                for frame in range(QUANTUM):
                    sound[frame] = 0.0
            line.written = 0
            if line.left == 0:
                pose_at(line.pose, float(end))
            knot = end // QUANTUM & (KNOTS - 1)
            before = end // QUANTUM - 1 & (KNOTS - 1)
            for i in range(3):
                if space.knots[before, line.number, i] != line.pose.now[i]:
                    line.moved_at = end
                space.knots[knot, line.number, i] = line.pose.now[i]
            straight = line.paths[0]
            known, begin = straight.known, straight.place
            heard = False
            for p in range(1 + space.walls):
                heard |= hear_path(state, line, line.paths[p], p, end)
            if space.late.on == 1:
                feed_late(state, line, begin if known == 1 else straight.place - QUANTUM, straight.place)
            if heard:
                state.stats.sounding += 1
            elif line.left == 1:
                line.used = 0
    if space.walls_change == WALLS_COME:
        for n in range(QUANTUM):
            space.late.fed[n] *= (n + 1) / QUANTUM
    if space.late.on == 1:
        hear_late(state)
    if space.walls_change == WALLS_FADE:
        let_walls_come(state)
        space.walls_change = WALLS_COME
    else:
        space.walls_change = NO_CHANGE
    if space.fading == 1:
        space.faded += QUANTUM
        if space.faded >= fade_length(state.rate):
            # End a fade: what left before the panic is gone.
            space.fading = 0
            for n in range(LINES):
                space.lines[n].since = max(space.lines[n].since, space.panicked)
