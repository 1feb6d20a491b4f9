"""The answers of points to the forces of contacts that are solved in blocks: within a sample, and after it."""

from ..native.jit import kernel, noinline_kernel
from ..native.typed import Items, View
from ..numerics.legendre import AHEAD, FINE
from ..numerics.sums import AT_ONCE, DELAYED, add_delayed, add_few, add_tables, line_of
from .block_nodes import AT, RATES, SHARES, TO_NODES, TRAVELS
from .block_records import Block, Net, Tables, forces_of, moments_of, motion_of, rows_of
from .block_sizes import FORCES, MOMENTS_AHEAD, MOTIONS, NODES_PER_PART

_BEHIND = 1.0 / 2160.0
"""Two Gauss nodes make an oscillation slower: one of s rad in a part falls s^5/4320 behind in each. A spring in series
that gives s^2/2160 less than the part itself takes that off, and leaves s^7/54000, the other way."""

_OF_ONE = 4  # rows of a block of one part: half a line of the cache
AT_BEGIN, AT_END = 1024, 2048
"""Places in `later` of tables for a quarter of AHEAD samples at a quantum's ends."""


@kernel
def settle_tables(tables: Tables, answer: View[float], parts: int, stiffness: float) -> None:
    """Set what the forces do within a sample of so many parts, by an answer.

    A contact of that stiffness (N/m) gives a trifle less at each node, which keeps it in step.
    """
    for j in range(FORCES * MOTIONS):
        tables.give[j] = 0.0
    for i in range(MOTIONS):
        tables.give_all[i] = 0.0
    for j in range(NODES_PER_PART * parts):
        for moment in range(MOMENTS_AHEAD):
            travel = 0.0
            for n in range(FINE):
                travel += answer[n] * TRAVELS[parts, moment, n, j]
            tables.travel[moment * FORCES + j] = travel
        for i in range(NODES_PER_PART * parts):
            x = v = 0.0
            for n in range(1, FINE):
                x += answer[n] * TO_NODES[parts, i, n, j]
                v += answer[n] * RATES[parts, i, n, j]
            tables.give[j * MOTIONS + i] = x
            tables.give[j * MOTIONS + FORCES + i] = v
            tables.give_all[i] += x
            tables.give_all[FORCES + i] += v
    _keep_in_step(tables, parts, stiffness)


@kernel
def _keep_in_step(tables: Tables, parts: int, stiffness: float) -> None:
    """Take that trifle off."""
    given = 0.0  # m/N: by a part's forces at its nodes: a third of h^2/m for a mass
    for j in range(NODES_PER_PART):
        for i in range(NODES_PER_PART):
            given += tables.give[j * MOTIONS + i]
    square = 3.0 * stiffness * given  # of the swing in a part
    less = _BEHIND * square * 3.0 * given
    for j in range(NODES_PER_PART * parts):
        tables.give[j * MOTIONS + j] -= less
        tables.give_all[j] -= less


@kernel
def take_missed(block: Block, tables: Tables, laid: View[float], place: float, own: float) -> None:
    """Find what the tables miss of a force that lasts, where 1 N bends the modes by `place` (m): by the rows of their
    motion if they are let go. own: the striker's answer in the tables, m/(N sample^2); 0 if there is none."""
    forces, parts, end = forces_of(block), block.parts, (rows_of(block) - 1) * AHEAD
    for moment in range(MOMENTS_AHEAD):
        tables.missed_travel[moment] = 0.0
    for k in range(forces):
        at, part = AT[parts, k], k // NODES_PER_PART
        before = laid[(3 * parts + part - 1) * AHEAD] if part > 0 else place
        after = laid[(3 * parts + part) * AHEAD] if part < parts - 1 else laid[end]
        tilt = laid[(forces + part) * AHEAD]
        rate = parts * (after - before) + (tilt if k % NODES_PER_PART == 1 else -tilt)
        tables.missed[k] = laid[k * AHEAD] + tables.give_all[k] - 0.5 * own * at * at - place
        tables.missed[FORCES + k] = rate + tables.give_all[FORCES + k] - own * at
        tables.missed_travel[0] += SHARES[parts, k] * tables.missed[FORCES + k]
        tables.missed_travel[1] += SHARES[parts, k] * (2.0 * at - 1.0) * tables.missed[FORCES + k]
    for moment in range(2, parts + 1):
        tables.missed_travel[moment] = laid[(4 * parts + moment - 3) * AHEAD]
        for k in range(forces):
            tables.missed_travel[moment] += tables.travel[moment * FORCES + k]


@kernel
def take_rows(block: Block, laid: View[float], scale: float, samples: int) -> None:
    """Take rows of the point's motion over so many samples that were laid one after the other, times `scale`."""
    count, rows = rows_of(block), motion_of(block)
    if count == _OF_ONE:  # by registers
        for n in range(samples):
            first = _OF_ONE * (n + 1)
            rows[first], rows[first + 1] = scale * laid[n], scale * laid[AHEAD + n]
            rows[first + 2], rows[first + 3] = scale * laid[2 * AHEAD + n], scale * laid[3 * AHEAD + n]
        return
    for r in range(count):
        for n in range(samples):
            rows[(n + 1) * count + r] = scale * laid[r * AHEAD + n]


@kernel
def take_answers(block: Block, tables: Tables, moment: int, laid: View[float], samples: int, begin: int) -> None:
    """Take the rows of the motion over so many samples that follow on a moment of a force that is 1; begin: 0, or
    AT_BEGIN or AT_END."""
    count, moments, first = rows_of(block), moments_of(block), line_of(tables.later) + begin
    for r in range(count):
        for n in range(samples):
            i = n * count + r
            within = i % AT_ONCE
            tables.later[first + (i - within) * moments + moment * AT_ONCE + within] = laid[r * AHEAD + n]


@kernel
def answer_after(tables: Tables, lag: int, moment: int, r: int) -> float:
    """Return what a moment of a force adds to row r so many samples later, where a sample has one part."""
    i = (lag - 1) * _OF_ONE + r
    within = i % AT_ONCE
    return tables.later[line_of(tables.later) + 2 * (i - within) + moment * AT_ONCE + within]


@kernel
def mix_tables(block: Block, tables: Tables, share: float, samples: int, answer: View[float], stiffness: float) -> None:
    """Set tables to those on a line between a quantum's ends, a share of it from the beginning: as far as so many
    samples need them. `answer` (FINE) gets the answer there."""
    ends, later, first = tables.ends, tables.later, line_of(tables.later)
    for n in range(FINE):
        answer[n] = ends[n] + share * (ends[FINE + n] - ends[n])
    settle_tables(tables, answer, block.parts, stiffness)
    for i in range(samples * rows_of(block) * moments_of(block)):
        early = later[first + AT_BEGIN + i]
        later[first + i] = early + share * (later[first + AT_END + i] - early)


@kernel
def go_on_from_end(block: Block, tables: Tables, samples: int) -> None:
    """Take tables at a quantum's end, as far as so many samples need them, as those at the next one's beginning."""
    later, first = tables.later, line_of(tables.later)
    for n in range(FINE):
        tables.ends[n] = tables.ends[FINE + n]
    for i in range(samples * rows_of(block) * moments_of(block)):
        later[first + AT_BEGIN + i] = later[first + AT_END + i]


@kernel
def feel(blocks: Items[Block], net: Net, size: int, n: int) -> None:
    """Add what the forces of sample n do to the rows of the samples after it in the block, of all contacts of a net of
    a size.

    Of one part, only the next samples feel it at once: what DELAYED samples do to all that come after them is added
    together.
    """
    for j in range(size):
        block, k = blocks[net.block[j]], 2 * (n & (DELAYED - 1))
        block.recent[k], block.recent[k + 1] = block.moments[0], block.moments[1]
    for i in range(size):
        for j in range(size):
            ratio = net.gain[j] / net.gain[i] if i != j else 1.0
            left = net.stop - net.begin - 1 - n
            block, other = blocks[net.block[i]], blocks[net.block[j]]
            if block.parts > 1:
                _feel(block, block.tables[j], other.moments, n, left, ratio)
            elif n & (DELAYED - 1) == DELAYED - 1:
                feel_delayed(block, block.tables[j], other.recent, n, left, ratio)
            else:
                near = min(left, DELAYED - 1 - (n & (DELAYED - 1)))
                _feel_next(block, block.tables[j], other.moments, n, near, ratio)


@kernel
def _feel(block: Block, tables: Tables, moments: View[float], n: int, left: int, share: float) -> None:
    """Add what a share of one force does to the rows of one contact, of which so many samples are left."""
    count, first, later, rows = rows_of(block), line_of(tables.later), tables.later, motion_of(block)
    begin, values = (n + 2) * count, left * count
    m0, m1, m2 = share * moments[0], share * moments[1], share * moments[2]
    if block.parts == 2:
        add_tables(rows, begin, later, first, (m0, m1, m2), values)
    else:
        add_tables(rows, begin, later, first, (m0, m1, m2, share * moments[3]), values)


@kernel
def _feel_next(block: Block, tables: Tables, moments: View[float], n: int, near: int, share: float) -> None:
    """Add it to the rows of so many samples of one part."""
    first, begin, factors = line_of(tables.later), (n + 2) * _OF_ONE, (share * moments[0], share * moments[1])
    add_few(motion_of(block), begin, tables.later, first, factors, near * _OF_ONE)


@noinline_kernel
def feel_delayed(block: Block, tables: Tables, recent: View[float], n: int, left: int, share: float) -> None:
    """Add what a share of the last forces up to sample n, of as many samples as go together, does to those that are
    left."""
    first, begin = line_of(tables.later), (n + 2) * _OF_ONE
    add_delayed(motion_of(block), begin, tables.later, first, recent, share, left * _OF_ONE)
