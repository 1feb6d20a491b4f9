"""Plates whose modes are coupled while they swing far: when they are, and the kick in each sample.

A plate that swings by less than `least` rings as any other object. It is coupled in the quantum in which a blow may
bring it above, as far as there is room. Once it is below, the force of stretching fades, and it is uncoupled. Neither
makes energy: what stretching holds is taken from the modes first, and is lost in the end.
"""

import math

from ...karman.grid import stretch
from ...karman.layout import Sheet
from ...karman.scatter import scatter
from ...karman.step import (
    Heard,
    catch_up,
    displace,
    drawn_in,
    extrapolate,
    fade,
    give_back,
    is_behind,
    kick,
    prepare,
    set_constant,
    settle,
    take,
)
from ...native.jit import kernel, noinline_kernel
from ...native.typed import View, View2D
from ...resonator.mode import energy_of
from ...resonator.simd import LANES
from ..memory.quality import couples_half, couples_none, looks_every
from ..memory.state import COUPLED_SHEETS, QUANTUM, Object, State
from .glide import energy_without_gains
from .objects import modes_of

_AGAIN = 0.7  # of `least`: below, a plate is uncoupled
_MOST_STRETCHED = 0.25  # of the energy: more must not be taken from the modes at once
_LOWERED = 0.125  # of c0: it is only brought down if the energy wants so little
_GIVEN, _GIVEN_STRUCK = 0.9999, 0.999  # of what modes have lost: how much they may get back, and in a contact
_HELD = 0.1  # of the energy of a dome: one that a hand bends by more is held, and hardly swings
_DRIFTS = 0.05  # s in which psi follows the grid's under a hand, which holds a dome so still that modes can't pay
_LOOKS, _MOST_APART = 6.0, 4.0
"""Looks at the grid in each period of the highest coupled mode, at least, and the most samples from one to the next.
The gradient goes on between as a parabola: against 192 kHz all plates then sound as with a look in each sample, up to
4 m/s, or within what 2 % of the speed change."""
_FADES = 0.04  # s in which stretching fades as a plate falls asleep


@kernel
def is_coupled(state: State, obj: Object) -> bool:
    """True if an object is a plate whose modes are coupled now."""
    return obj.sheet >= 0 and state.sheets[obj.sheet].coupled == 1


@kernel
def is_bent(state: State, obj: Object) -> bool:
    """True if it is, or was a moment ago: what would be heard as slow forces bend it still fades."""
    if obj.sheet < 0:
        return False
    sheet = state.sheets[obj.sheet]
    return sheet.coupled == 1 or sheet.bent[0, 0] != 0.0 or sheet.bent[1, 0] != 0.0


@noinline_kernel
def follow_sheets(state: State) -> None:
    """Couple plates that may swing far in this quantum, go on with those that do, and uncouple the others."""
    for i in range(state.active):
        obj = state.objects[state.order[i]]
        if obj.sheet >= 0:
            # Couple or uncouple a plate, or go on.
            sheet = state.sheets[obj.sheet]
            if obj.spectral > 0 or (obj.live == 0 and obj.has_contact == 0) or couples_none(state):
                _repay(state, obj, sheet)
                uncouple(state, obj)
                sheet.waits = 0
            else:
                ringing = energy_without_gains(state, obj)
                # The energy (J) that strikers which touch it in this quantum, and the blows of swarms, may bring.
                energy = 0.0
                index = obj.contact
                while index >= 0:
                    contact = state.contacts[index]
                    if contact.trait.swarms > 0:
                        energy += state.swarms[contact.swarm].coming
                    elif contact.touching == 1 or contact.start < state.position + QUANTUM:
                        energy += 0.5 * contact.m * contact.v_in * contact.v_in
                    index = contact.next
                coming = energy
                sheet.given = _GIVEN if coming == 0.0 else _GIVEN_STRUCK
                if sheet.coupled == 0:
                    if ringing + coming <= sheet.least:
                        sheet.waits = 0
                    elif state.coupled_sheets < COUPLED_SHEETS:
                        _couple(state, obj, sheet, ringing + coming)
                    elif sheet.waits == 0:
                        sheet.waits = 1
                        state.stats.nonlinear_dropped += 1
                else:
                    stored = 0.5 * (sheet.psi * sheet.psi - sheet.c0)
                    sheet.energy = max(ringing + stored, 0.0)
                    if not _is_left(state, obj, sheet, sheet.energy + coming):
                        wanted = sheet.growth * (sheet.energy + coming)
                        if wanted > sheet.c0 or (
                            wanted < _LOWERED * sheet.c0 and sheet.psi * sheet.psi - sheet.c0 > -0.5 * wanted
                        ):
                            set_constant(sheet, wanted)
                        _renew(state, obj, sheet)
    state.stats.nonlinear_active = state.coupled_sheets


@kernel
def uncouple(state: State, obj: Object) -> None:
    """End the coupling of a plate's modes, if there is one: what stretching holds is lost."""
    if is_coupled(state, obj):
        state.sheets[obj.sheet].coupled = 0
        state.coupled_sheets -= 1


@kernel
def _is_left(state: State, obj: Object, sheet: Sheet, energy: float) -> bool:
    """Begin to fade the stretching of a plate of so much energy (J), or go on; return True if that is over: it was
    uncoupled, or woken, which couples it anew."""
    if sheet.leaves == 0:
        if energy < _AGAIN * sheet.least:
            sheet.leaves, sheet.left = 1, int(_FADES * state.rate)
        return False
    if sheet.left > 0 and energy <= sheet.least:
        return False
    _repay(state, obj, sheet)
    uncouple(state, obj)
    if energy > sheet.least:
        _couple(state, obj, sheet, energy)
    return True


@kernel
def _repay(state: State, obj: Object, sheet: Sheet) -> None:
    """Take from the modes of a dome that is to be uncoupled what they have got from its stretching beyond what that
    held."""
    stored = 0.5 * (sheet.psi * sheet.psi - sheet.c0)
    if sheet.coupled == 0 or stored >= 0.0:
        return
    ringing = energy_without_gains(state, obj)
    left = math.sqrt(max(1.0 + stored / ringing, 0.0)) if ringing > 0.0 else 0.0
    for i in range(obj.first, obj.first + obj.live):
        state.bank.y1[i] *= left
        state.bank.y2[i] *= left


@kernel
def rows_coupled(state: State, obj: Object) -> int:
    """Return the number of a plate's modes that are coupled or exchange energy with those, a multiple of LANES."""
    return (state.sheets[obj.sheet].modes + LANES - 1) // LANES * LANES


@kernel
def _renew(state: State, obj: Object, sheet: Sheet) -> None:
    """Bring a plate's coupling to its modes' coefficients, to its gain and tune, and to the quality requested."""
    level = 1 if couples_half(state) else 0
    if level != sheet.level:
        sheet.level, sheet.turn, sheet.looked = level, 0, 0
    scale = math.sqrt(obj.amplified)
    # A body whose strain is the same has the same share of its energy in it: the square of a frequency is that of a
    # factor on displacements, times one on the energy.
    sheet.strained = math.sqrt(obj.stiffened) / obj.lowered
    pitch = obj.settings.tune * obj.lowered / sheet.strained
    sheet.tension = pitch * pitch
    highest = sheet.highest * obj.settings.tune * obj.lowered
    sheet.every = int(min(max(state.rate / max(_LOOKS * highest, 1.0), 1.0), _MOST_APART))
    if sheet.retuned != obj.retuned or sheet.scale != scale:
        sheet.retuned, sheet.scale = obj.retuned, scale
        bank, first = state.bank, obj.first
        last = first + sheet.modes
        heard = Heard(bank.a1[first:last], bank.a2[first:last], bank.weight[first:last], bank.balance[first:last])
        prepare(sheet, heard, state.rate)


@kernel
def _couple(state: State, obj: Object, sheet: Sheet, energy: float) -> None:
    """Couple a plate's modes, unless they are far out already; energy (J): that they have or may get."""
    count = sheet.modes
    sheet.retuned = -1
    sheet.level = sheet.turn = sheet.looked = 0
    _renew(state, obj, sheet)
    bank, first, space = state.bank, obj.first, state.space
    displace(sheet, bank.y1[first : first + count], space.place)
    stored = sheet.tension * stretch(sheet.grids[sheet.level], state.curves, sheet.functions, space)
    whole = rows_coupled(state, obj)
    weights = bank.weight[first : first + whole]
    ringing = energy_of(modes_of(state, obj, 0, whole), weights, count) / obj.amplified
    if abs(stored) > _MOST_STRETCHED * ringing and ringing > 0.0:
        return
    left = math.sqrt(1.0 - stored / ringing) if ringing > 0.0 else 1.0
    for i in range(first, first + count):
        bank.y1[i] *= left
        bank.y2[i] *= left
    sheet.c0 = sheet.growth * (energy + abs(stored))
    sheet.psi = math.sqrt(max(sheet.c0 + 2.0 * stored, 0.0))
    sheet.energy, sheet.owed = energy, 0.0
    sheet.leaves, sheet.share = 0, 1.0
    for side in range(2):
        sheet.bent[side, 0] = sheet.bent[side, 1] = 0.0
    sheet.coupled = 1
    state.coupled_sheets += 1
    obj.live = max(obj.live, whole)


@noinline_kernel
def kick_modes(state: State, obj: Object) -> None:
    """Move a plate's modes by its stretching, between two samples."""
    sheet, bank, space, first = state.sheets[obj.sheet], state.bank, state.space, obj.first
    last = first + sheet.modes
    y1, y2 = bank.y1[first:last], bank.y2[first:last]
    # A hand bends it so far that it would roar on with fewer looks.
    every = looks_every(state, max(sheet.every // 2, 1) if obj.deflection > 0.0 else sheet.every)
    h = 1.0 / state.rate
    if sheet.leaves == 1:
        fade(sheet, int(_FADES * state.rate))
    if sheet.turn >= every:
        sheet.turn = 0
    if sheet.turn == 0:
        _look(state, sheet, y1)
    else:
        extrapolate(sheet, sheet.turn / every)
    domed = sheet.grids[sheet.level].domed == 1
    # A hand holds it that bends it by more than it swings, where psi lacks less than the bend has.
    lacks = 0.5 * (sheet.truth * sheet.truth - sheet.psi * sheet.psi)
    sheet.held = int(domed and obj.deflection > _HELD * sheet.energy and lacks < obj.deflection)
    behind = is_behind(sheet) and sheet.held == 0
    if not behind:
        drifts = sheet.turn == 0 and obj.deflection > 0.0 and domed
        give_back(sheet, y1, y2, h, every * h / _DRIFTS if drifts else 0.0)
    if sheet.turn == 0 and sheet.held == 0:
        if behind and sheet.given == _GIVEN:
            _draw_in(state, obj, sheet)
        if behind:
            catch_up(sheet, y1, y2, h)
        else:
            settle(sheet, y1, y2, min(every * h / sheet.follows, 1.0), h)
    kick(sheet, y1, y2, h)
    sheet.turn += 1
    sheet.mixed += 1
    if sheet.mixed >= sheet.mixes:
        sheet.mixed = 0
        if sheet.held == 0:
            scatter(sheet, space, y1, y2, sheet.mixes * h)


@kernel
def _look(state: State, sheet: Sheet, y1: View[float]) -> None:
    """Look at the grid: how much energy stretching holds, and which way it falls."""
    displace(sheet, y1, state.space.place)
    energy = stretch(sheet.grids[sheet.level], state.curves, sheet.functions, state.space)
    take(sheet, energy, state.space.answer)


@noinline_kernel
def _draw_in(state: State, obj: Object, sheet: Sheet) -> None:
    """Draw the coupled modes of a plate in, all alike, until what the grid says is stretched is what psi says.

    Sprung through, a thin dome moves faster than it is looked at, and ends so far out that its modes can't pay for it.
    """
    bank, first, count = state.bank, obj.first, 2 * sheet.functions - sheet.plain
    whole = (count + LANES - 1) // LANES * LANES
    weights = bank.weight[first : first + whole]
    ringing = energy_of(modes_of(state, obj, 0, whole), weights, count) / obj.amplified
    left = drawn_in(sheet, bank.y1[first : first + count], ringing)
    for i in range(first, first + count):
        bank.y1[i] *= left
        bank.y2[i] *= left
    sheet.looked = 0
    _look(state, sheet, bank.y1[first : first + count])


@kernel
def take_bending(state: State, obj: Object, voice: View2D[float], frame: int) -> None:
    """Take what would be heard of a plate's modes as slow forces bend them out of its voice."""
    bent = state.sheets[obj.sheet].bent
    for side in range(2):
        voice[side, frame] -= bent[side, 0]
