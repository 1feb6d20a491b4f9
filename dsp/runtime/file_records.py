"""Records that a file lays out: whether their numbers fit each other."""

from ..engine.memory.state import State
from ..engine.memory.striker_state import STRIKERS
from ..karman.layout import LEVELS, SHEETS, SPACE, TABLE_VALUES, Grid, Sheet
from ..karman.simd import LANES as SINGLES
from ..karman.simd import ROWS
from ..native.jit import noinline_kernel
from ..resonator.simd import LANES
from ..swarm.grid import STEPS as WIDTHS_OF_OCTAVE
from ..swarm.record import (
    MOST_TURNS,
    OCTAVES,
    PULSES,
    PulseTable,
)


@noinline_kernel
def _is_grid(grid: Grid, functions: int) -> bool:
    """True if the tables of a plate's grid, and what is computed with them, have room."""
    points, orders, stresses, angles = grid.points, grid.orders, grid.stresses, grid.angles
    width = 3 * points
    if points < 1 or points % SINGLES or orders < 1 or stresses < 1 or angles < 1:
        return False
    if max(2 * orders * width, 4 * angles * width, 2 * stresses * points) > SPACE:
        return False
    room = TABLE_VALUES - ROWS * width  # rows are read some together
    for order in range(orders):
        last = grid.row[order] + grid.count[order]
        if grid.first[order] + grid.count[order] > functions or grid.shapes + last * width > room:
            return False
    for order in range(stresses):
        count = grid.stress[order + 1] - grid.stress[order]
        if count < 0:
            return False
        if grid.domed == 1 and order < orders and grid.bent + grid.strain[order] + count * grid.count[order] > room:
            return False
    if grid.stretch + grid.stress[stresses] * points > room:
        return False
    for odd in range(2):
        if max(grid.cosine[odd], grid.sine[odd]) + angles * orders > room:
            return False
        if max(grid.stress_cosine[odd], grid.stress_sine[odd]) + angles * stresses > room:
            return False
    return True


@noinline_kernel
def is_sheet(sheet: Sheet) -> bool:
    """True if a plate's numbers fit each other."""
    if sheet.functions < 1 or sheet.plain > sheet.functions or 2 * sheet.functions - sheet.plain > sheet.modes:
        return False
    if sheet.rungs > sheet.modes or sheet.every < 1 or sheet.mixes < 1 or sheet.below < 1.0 or sheet.span <= 0.0:
        return False
    for n in range(sheet.rungs):
        if sheet.ladder[n] >= sheet.modes:
            return False
    for level in range(LEVELS):
        if sheet.start[level] > sheet.rungs or sheet.free[level] > sheet.rungs:
            return False
        if not _is_grid(sheet.grids[level], sheet.functions):
            return False
    return sheet.scale > 0.0 and sheet.tension > 0.0 and sheet.follows > 0.0 and sheet.highest > 0.0


@noinline_kernel
def is_pulse_table(table: PulseTable, values: int) -> bool:
    """True if the numbers of a table of pulses fit each other, and its values lie in so many."""
    if table.dissipations < 2 or table.nodes < 1 or table.points < 3 or table.first[0] + table.size > values:
        return False
    for octave in range(OCTAVES):
        length, phases, block = table.length[octave], table.phases[octave], table.block[octave]
        if length < LANES or length % LANES or phases < 1 or length * phases > MOST_TURNS:
            return False
        if table.lead[octave] >= length or table.orders[octave] < 1:
            return False
        if block != (WIDTHS_OF_OCTAVE + 1) * (phases + 1) * length or table.first[octave] < table.first[0]:
            return False
        if table.first[octave] + table.dissipations * block > table.first[0] + table.size:
            return False
    return True


@noinline_kernel
def wrong_record(state: State, values: int, plates: int) -> int:
    """Return the number of a record that a file has laid out and that does not fit itself, -1 if there is none: of
    plates, then of strikers, then of tables of pulses.

    values: of pulses, that there is memory for; plates: 1 if there is memory for the tables of plates.
    """
    for n in range(SHEETS):
        if state.sheets[n].functions > 0 and (plates == 0 or not is_sheet(state.sheets[n])):
            return n
    for n in range(STRIKERS):
        if state.strikers[n].size % LANES or state.strikers[n].clicks > state.strikers[n].size:
            return SHEETS + n
    for n in range(PULSES if values > 0 else 0):
        if state.pulses.tables[n].size > 0 and not is_pulse_table(state.pulses.tables[n], values):
            return SHEETS + STRIKERS + n
    return -1
