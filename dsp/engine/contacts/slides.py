"""Bodies that slide: a roll's normal motion, and friction along the surface.

Rolling and sliding are one state of contact: a speed at which the contact moves over the object (sweep) and one at
which the surfaces slip. Asperities pass at the faster of the two. The normal force is the roll's, whose weight is the
force that presses. It feels the modes where a roll's does (coupled_rolls.py), with what friction does to them. Friction
feels the SLID longest ringing ones, sample by sample (friction/stick_slip.py). Its bound follows the normal force, or
that of a press on the same object, which feels the modes, too.

With a sweep of 0 modes move along the slip, as under a bow. The contact stays, or goes along its travel at the slip's
speed, as a finger goes round a glass. The modes' pattern follows it where they grow faster than it passes them.
"""

import math

from ...contact.law import elastic
from ...friction.elastic import step_elastic, stiffen
from ...friction.located import step_located
from ...friction.stick_slip import begin_friction, move_beside, respond_along, step_whole
from ...native.jit import kernel, noinline_kernel
from ...numerics.legendre import FINE
from ...resonator.bank import inject_fine, inject_line
from ...resonator.velocity import observe_velocity, sense, set_rows, set_shapes, velocity_response
from ...rolling.body import begin_roll, share_of
from ...rolling.path import place_of
from ...schema import SPEED
from ..bodies.bends import find_static
from ..bodies.objects import modes_of, point_of, shapes_at
from ..bodies.sensing import push_sensed
from ..bodies.surface import direct, has_moved, keep_spot, put
from ..memory.records import SLID, Contact
from ..memory.state import COUPLING, COVERING, LEAD, QUANTUM, ROLLING, State
from .contact_list import give_room_back
from .coupled_rolls import LEAST, LEAVING, NEVER, couple_roll, may_feel, position_of
from .presses import add_static
from .rolls import feed_of
from .trace import trace_friction

_LAID = 0.02  # s: time constant with which a striker is laid on
_MEAN = 0.05  # s: and of the mean of its friction, which bends the object without a sound
_GLIDE = SPEED.glide


@kernel
def begin_slide(state: State, contact: Contact) -> None:
    """Begin to slide: to be called before the roll begins."""
    slide = state.slides[contact.roll]
    begin_friction(slide.friction, state.rate)
    slide.friction.drive[1] = slide.slip = contact.target.speed
    slide.sweep = _sweep_of(contact)
    slide.position = -1.0
    slide.pressed = -1
    slide.stale = 1
    _lead_roll(state, contact)


@noinline_kernel
def choose_again(state: State, contact: Contact) -> None:
    """Begin a slide's normal motion anew, at rest where it is, if its friction or force was steered so that it is to
    feel the modes, or is not to: so it sounds as one that begins with these."""
    slide, roll = state.slides[contact.roll], state.rolls[contact.roll]
    may, begun = may_feel(state, contact), roll.t > 0.0
    if slide.feels == NEVER or roll.fade < 1.0 or slide.feels == int(may):
        return
    if contact.solver != COUPLING and slide.feels != LEAVING and begun:
        slide.feels = LEAVING if slide.feels == 0 else 0  # 0: there was no room
        return
    place = place_of(roll.path, roll.piece, roll.along) if begun else roll.path.begin
    if contact.solver == COUPLING:
        give_room_back(state, contact)
    contact.solver, contact.aside = ROLLING, 0
    contact.origin = max(contact.origin, state.position - 1.0)
    if begun:
        state.contact_count += 1
        contact.number = state.contact_count  # its force drives modes in another way: it is another contact
        if not may:  # a beginning is in one number a frame from LEAD frames before
            contact.start, contact.fraction = state.position - 1 + LEAD, 0.0
            contact.origin = float(contact.start)
    contact.led = contact.ahead = 0
    slide.friction.beside[0] = slide.friction.beside[1] = 0.0
    slide.stale = 1
    begin_roll(roll, place, contact.k, contact.mu, contact.a, roll.path.corners, roll.path.coarseness)
    couple_roll(state, contact)


@kernel
def _sweep_of(contact: Contact) -> float:
    """Return the sweep (m/s) that is requested."""
    return contact.target.sweep if contact.target.sweep >= 0.0 else contact.target.speed


@kernel
def _lead_roll(state: State, contact: Contact) -> None:
    """Set the normal motion to what the slide asks for."""
    asked, target = contact.target, state.rolls[contact.roll].target
    target.speed = max(asked.speed, _sweep_of(contact))
    target.mass = contact.m
    target.gravity = max(contact.now.force, LEAST) / contact.m
    target.radius, target.patch, target.roughness = asked.radius, asked.patch, asked.roughness
    target.friction = target.asymmetry = 0.0


@kernel
def lead_slide(state: State, contact: Contact, changed: bool) -> None:
    """Bring a slide to a new quantum; `changed`: it acts on other modes than before."""
    slide = state.slides[contact.roll]
    _lead_roll(state, contact)
    slide.sweep += (_sweep_of(contact) - slide.sweep) * -math.expm1(-QUANTUM / (_GLIDE * state.rate))
    contact.rolled += contact.rolls
    travels = slide.slip if contact.target.sweep == 0.0 else slide.sweep
    contact.rolls = travels * QUANTUM / state.rate
    slide.stale |= int(changed) | contact.unsettled
    if contact.solver != COUPLING:
        contact.unsettled = 0
    moves = contact.travel > 0.0 and contact.rolls > 0.0
    if (
        moves
        or slide.along != contact.target.along
        or slide.position != contact.now.position
        or has_moved(contact, slide.spot)
    ):
        slide.moved = 1
    slide.slip = slide.friction.drive[1]
    # The press that its friction feels, where there is one on the object.
    slide.pressed = -1
    index = state.objects[contact.point[0].slot].contact if slide.press > 0 else -1
    while index >= 0 and slide.pressed < 0:
        held = state.contacts[index].trait.held == 1 and state.contacts[index].solver != COVERING
        if held and state.contacts[index].gesture == slide.press:
            slide.pressed = index
        index = state.contacts[index].next
    friction, law = slide.friction, contact.target
    friction.dynamic, friction.stribeck = law.dynamic, law.stribeck
    friction.static = max(law.static, law.dynamic)
    stiffen(friction, law.tangential)
    add_static(state, contact, slide.along * slide.pull)


@kernel
def rubs(contact: Contact) -> bool:
    """True for a slide whose friction is heard."""
    return contact.target.along > 0.0 and max(contact.target.static, contact.target.dynamic) > 0.0


@kernel
def rub(state: State, contact: Contact, frame: int) -> None:
    """Give the modes a slide's friction over the sample that ends at a frame."""
    if state.position + frame - contact.start - contact.fraction <= 0.0 or not rubs(contact):
        return
    slide, scratch = state.slides[contact.roll], state.scratch
    friction = slide.friction
    if slide.stale == 1 or slide.moved == 1:
        # Tell a slide's friction where it is, and how the objects give way there; their modes only if these are others.
        slide.along, slide.position = contact.target.along, contact.now.position
        keep_spot(contact, slide.spot)
        for n in range(FINE):
            scratch.receptance[n] = 0.0
        for side in range(2):
            point = contact.point[side]
            if point.slot < 0:
                continue
            obj = state.objects[point.slot]
            if side == 0:
                put(state, obj, contact, position_of(contact, 0.5 * QUANTUM))
                if point.on_surface == 1 and obj.faces > 0:
                    direct(state, obj, contact, 0)
                slide.directed = point.directed
            slide.modes[side] = min(point.modes, SLID)
            slide.row[side] = point.row
            for n in range(4):
                slide.weights[side, n] = point.weights[n]
            modes = modes_of(state, obj, 0, slide.modes[side])
            where = point_of(state, obj, point)
            if slide.stale == 1:
                set_rows(modes, state.bank.weight[obj.first : obj.first + obj.size], slide.rows[side], SLID)
            set_shapes(slide.modes[side], where, slide.along, slide.rows[side], SLID)
            velocity_response(modes, slide.rows[side], SLID, scratch.work, scratch.fine)
            for n in range(FINE):
                scratch.receptance[n] += scratch.fine[n]
            find_static(state, contact, side, obj, slide.modes[side])
        respond_along(slide.friction, scratch.receptance)
        slide.stale = slide.moved = 0
    if contact.solver == COUPLING:
        # Tell friction of the normal force over the sample that ends at a frame, beyond its weight: as a line.
        block = state.blocks[contact.roll]
        scale = state.rate / slide.along
        first, second = block.moments[0], block.moments[1]
        if contact.ahead <= frame:
            scale *= share_of(state.rolls[contact.roll])
            first, second = contact.moments[0], contact.moments[1]
        slide.friction.beside[0] = scale * (first - 3.0 * second)
        slide.friction.beside[1] = scale * 6.0 * second
    _drive(state, contact, frame)
    third = end = mean = moment = 0.0
    for side in range(2):
        if contact.point[side].slot >= 0:
            modes = modes_of(state, state.objects[contact.point[side].slot], 0, slide.modes[side])
            a, b, c, d = sense(modes, slide.rows[side], SLID)
            third, end, mean, moment = third + a, end + b, mean + c, moment + d
    gain = contact.now.gain
    third, end, mean, moment = third / gain, end / gain, mean / gain, moment / gain
    if contact.solver == COUPLING:
        third, end, mean, moment = move_beside(friction, third, end, mean, moment)
    whole = True
    if friction.tangential > 0.0:
        step_elastic(friction, mean)
    else:
        whole = step_whole(friction, third, end, mean, moment)
    if not whole:
        # Find the velocity of the points over the sample in full.
        for n in range(FINE):
            scratch.observed[n] = 0.0
        for side in range(2):
            if contact.point[side].slot >= 0:
                modes = modes_of(state, state.objects[contact.point[side].slot], 0, slide.modes[side])
                observe_velocity(modes, slide.rows[side], SLID, scratch.work, scratch.fine)
                for n in range(FINE):
                    scratch.observed[n] += scratch.fine[n] / contact.now.gain
        step_located(friction, scratch.observed, scratch.fine)
    force = friction.start + 0.5 * friction.slope if whole else scratch.fine[0] * state.rate
    slide.pull += (force - slide.pull) / (_MEAN * state.rate)
    # Inject friction's force over the sample into the modes.
    sample = state.position + frame - 1
    scale = contact.now.gain * slide.along
    first = (friction.start + 0.5 * friction.slope) / state.rate
    second = friction.slope / (6.0 * state.rate)
    if not whole:
        first, second = scratch.fine[0], scratch.fine[1]
    trace_friction(state, contact, sample, slide, first, second, whole)
    if contact.solver == COUPLING:
        contact.coupled.motion[0] -= first * friction.whole_mean / slide.along  # the point has moved meanwhile
        if contact.ahead > sample + 1 - state.position:
            # By the sample's end friction has moved the point, and does what the contact's own force does to the
            # samples after it.
            block, coupled = state.blocks[contact.roll], contact.coupled
            block.moments[0] += slide.along * first
            block.moments[1] += slide.along * second
            block.stored = elastic(coupled.motion[0], coupled.k, coupled.a)
    first *= scale
    second *= scale
    if not whole:
        for n in range(FINE):
            scratch.fine[n] *= scale
    for side in range(2):
        if contact.point[side].slot < 0:
            continue
        obj = state.objects[contact.point[side].slot]
        modes = modes_of(state, obj, 0, slide.modes[side])
        directed = slide.directed if side == 0 else 0
        where = shapes_at(state, obj, slide.row[side], slide.weights[side], directed)
        if obj.sensors > 0:
            push_sensed(state, obj, where, slide.modes[side], first)
        if whole:
            inject_line(modes, where, first, second)
        else:
            inject_fine(modes, where, scratch.fine)


@kernel
def _drive(state: State, contact: Contact, frame: int) -> None:
    """Give friction the slip and the normal force at the sample's end."""
    slide = state.slides[contact.roll]
    friction = slide.friction
    friction.drive[0], friction.normal[0] = friction.drive[1], friction.normal[1]
    friction.drive[1] = slide.slip + (contact.now.speed - slide.slip) * ((frame + 1) / QUANTUM)
    slide.laid += (1.0 - slide.laid) / (_LAID * state.rate)
    if slide.press > 0:
        # The force (N) of the press that it feels, over the last sample.
        there = slide.pressed >= 0 and state.contacts[slide.pressed].gesture == slide.press
        force = max(state.contacts[slide.pressed].forces[0], 0.0) if there else 0.0
        friction.normal[1] = slide.laid * share_of(state.rolls[contact.roll]) * force
        return
    # The slide's own force at the end of the sample.
    roll, beside = state.rolls[contact.roll], friction.beside
    weight = share_of(roll) * roll.m * roll.g
    if contact.solver == COUPLING:
        own = max((beside[0] + beside[1]) * slide.along + weight, 0.0)
    else:
        feed, after = feed_of(state, contact), min(frame + 1, QUANTUM - 1)
        first, last = feed[frame, 0] * state.rate + weight, feed[after, 0] * state.rate + weight
        own = 0.5 * (max(first, 0.0) + max(last, 0.0))
    friction.normal[1] = slide.laid * own
