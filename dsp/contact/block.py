"""Lasting contacts with an object that rings freely but for them, a block of samples at a time.

As in coupled.py the compression is x = D - int g f. Here D is laid out for a whole block (resonator/rows.py), and what
the force of a sample does to the samples after it is added by a table, so that modes are read once a block. The unknown
is F = f - f_0, with f_0 the force of a body at rest: gravity is gone from all else, and at rest nothing moves. A
striker that is pressed on has no such force: modes bend under all of it, and series are mended by what they miss of a
force that lasts. Its block ends where it leaves.

The force over a sample, or over each half or third of it, is a line by its values at two Gauss nodes, where the law
holds; one Legendre moment of it for each part, and one more, are all that later samples feel. The path under the body
is the line of least squares in each such part, and so is its rate: so a kink gives the right impulse, and the work of
the path is exact. The rate of the compression is its line of least squares, too: so the work of modes is exact, however
they swing in a sample. One part a sample is within -50 dB, two are within -60 dB. A rest hardly leaves its stiffness:
one part follows a soft one within -60 dB, as it does a long blow, and three one between two plates, which swings by
more than 2 rad a sample. With fewer moments that would gain energy. Gauss's nodes keep what is left of a rate where a
contact's loss should take all of it: so a part must not be long against the loss.

Several contacts are solved together (block_forces.py).

Energy: V = k x^(a+1)/(a+1) may grow by the work of the force that later samples feel, and by a small share of the
greatest V. Where it would grow by more, the force is changed by the least that takes the excess: in proportion to x' at
the nodes. A body that rolls is mended so, too, where it lands or leaves amid a sample: what touches after the last node
pushes there. Where the change is too much, the block ends: that sample is taken by steps as fine as they have to be
(coupled_group.py), and another block begins after it.
"""

import math

from ..native.jit import kernel
from ..native.typed import Items, View
from .block_forces import find_forces, find_rates
from .block_nodes import AT, FORCE_MOMENTS, SHARES, TIMES_OF_ONE, TIMES_OF_THREE, TIMES_OF_TWO
from .block_parts import LANDS, energy_at
from .block_records import Block, Net, forces_of, motion_of, rows_of, weigh_all
from .block_sizes import FORCES, MOMENTS_AHEAD, NODES_PER_PART
from .block_step import free_at, gone_on, is_gentle
from .collocation import raised
from .coupled_records import Coupled, Member
from .step_record import NODES

ALLOWED = 4e-6  # share of the greatest V by which it may grow beyond the force's work
_MENDED = 1e-3  # share of the force by which it may be changed for that
_EDGE = 0.03
"""The same of a roll's force at the sample's end or of its weight: it may land or leave amid a sample of one part."""

_ROUNDS = 6  # of such changes
_LEAST = 1e-300  # keeps a quotient finite
_FIRST = 0.25  # of a sample: the first step to try after a block


@kernel
def renew_block(block: Block) -> None:
    """Begin with a contact anew."""
    block.settled = block.parts = block.linear.settled = block.linear.calm = 0
    forget_energy(block)


@kernel
def forget_energy(block: Block) -> None:
    """Begin the account of energy anew, as with another touch, which may be much softer."""
    block.gained = block.scale = 0.0


@kernel
def begin_block(block: Block, contact: Coupled, place: float, rolls: bool) -> None:
    """Begin a block with a coupled contact as it is; place (m): of the object's point now, by its free motion."""
    block.edge = _EDGE if rolls and block.parts == 1 else 0.0
    contact.position = contact.motion[0] + place
    block.springs = contact.k / (contact.a + 1.0)
    block.landing = energy_at(contact, LANDS[block.parts])
    block.stored = _stored(contact, block, contact.motion[0])
    block.leaves = 1 if contact.rest_force == 0.0 else 0
    motion_of(block)[rows_of(block) - 1] = place
    for j in range(FORCES):
        known = contact.touching == 1 and j < forces_of(block)
        block.force[j] = block.before[j] = contact.force[0] if known else 0.0


@kernel
def add_beside(block: Block, contact: Coupled, first: float, second: float) -> None:
    """Add the moments (N s) of another force at the contact's point over the last sample, by whose end it has moved
    the point: it does what the contact's own does to the samples after it."""
    block.moments[0] += first
    block.moments[1] += second
    block.stored = _stored(contact, block, contact.motion[0])


@kernel
def end_block(block: Block, contact: Coupled) -> None:
    """Leave the contact so that it can go on by samples, after as many of the block as were taken."""
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = block.last[forces_of(block) - 1] if contact.touching == 1 else 0.0
    contact.last = contact.next = _FIRST


@kernel
def step_blocks(contacts: Items[Member], blocks: Items[Block], net: Net, size: int, n: int) -> bool:
    """Take all contacts of a net, of a size, through sample n of the block, with their paths laid by `project_path`;
    `moments` gets those of F.

    False, and nothing done, where the energy of one would grow: then the block ends before that sample.
    """
    if size > 1:
        weigh_all(net, size)
    if blocks[net.block[0]].parts == 1:
        return _step(contacts, blocks, net, size, n, TIMES_OF_ONE)
    if blocks[net.block[0]].parts == 2:
        return _step(contacts, blocks, net, size, n, TIMES_OF_TWO)
    return _step(contacts, blocks, net, size, n, TIMES_OF_THREE)


@kernel
def _step(contacts: Items[Member], blocks: Items[Block], net: Net, size: int, n: int, times: tuple[float, ...]) -> bool:
    """Take a step of `step_blocks` with nodes at `times`, of which there is a fixed number for each compilation."""
    for i in range(size):
        _predict(contacts[net.contact[i]].coupled, blocks[net.block[i]], i, n, times)
    if net.lasts == 1:
        _keep_at_rest(blocks, net, size, times)
    find_forces(contacts, blocks, net, size, times)
    if not _conserve(contacts, blocks, net, size, times):
        for i in range(size):
            blocks[net.block[i]].gained = blocks[net.block[i]].kept
        return False
    for i in range(size):
        _move(contacts[net.contact[i]].coupled, blocks[net.block[i]], times)
    return True


@kernel
def _conserve(contacts: Items[Member], blocks: Items[Block], net: Net, size: int, times: tuple[float, ...]) -> bool:
    """Change the forces so that no contact's energy grows by too much; false if that takes too much.

    False, too, where a contact leaves that ends its block so.
    """
    for turn in range(_ROUNDS):
        grows = False
        for i in range(size):
            for first in range(0, len(times) if turn > 0 else 0, NODES_PER_PART):
                find_rates(contacts, blocks, net, i, size, first)
            excess = _account(contacts, blocks, net, size, i, times)
            block = blocks[net.block[i]]
            if block.solved == 0 or not math.isfinite(excess) or (block.leaves == 1 and not _pushes(block, times)):
                return False
            if not _is_gentle(contacts[net.contact[i]].coupled, block, times):
                return False
            if excess > 0.0:
                grows = True
                if not _mend(contacts[net.contact[i]].coupled, block, excess):
                    return False
        if not grows:
            return True
    return False


@kernel
def _is_gentle(contact: Coupled, block: Block, times: tuple[float, ...]) -> bool:
    """True if a contact pushes with no more energy than its parts of a sample follow."""
    most = 0.0
    for k in range(len(times)):
        most = max(most, block.force[k])
    speed = block.v[0] / contact.period
    return is_gentle(most, block.stored + 0.5 * contact.mass * speed * speed, block.landing, block.scale)


@kernel
def _pushes(block: Block, times: tuple[float, ...]) -> bool:
    """True if a contact pushes at all nodes of a sample, and touches at its end."""
    least = block.end
    for k in range(len(times)):
        least = min(least, block.force[k])
    return least > 0.0


@kernel
def _mend(contact: Coupled, block: Block, excess: float) -> bool:
    """Change the forces by the least that does so much more work (J), as the rates are; false if that is too much.

    What a body lands on after the last node pushes at that node.
    """
    last = forces_of(block) - 1
    begins = block.edge > 0.0 and block.end > 0.0 and block.v[last] > 0.0
    square = most = 0.0
    for k in range(last + 1):
        if block.force[k] > 0.0 or (begins and k == last):
            square += SHARES[block.parts, k] * block.v[k] * block.v[k]
            most = max(most, block.force[k])
    deep = (contact.a + 1.0) * block.left / block.end if block.end > 0.0 else 0.0  # N: without loss, at the end
    bound = max(_MENDED * most, block.edge * max(deep, contact.rest_force))
    for k in range(last + 1):
        if block.force[k] > 0.0 or (begins and k == last):
            change = excess / max(square, _LEAST) * block.v[k]
            if not (abs(change) <= bound and change >= -block.force[k]):
                return False
            block.force[k] += change
    return begins or most > 0.0


@kernel
def _predict(contact: Coupled, block: Block, i: int, n: int, times: tuple[float, ...]) -> None:
    """Find compression and rate at the nodes with no force but that at rest, and a first guess of the forces: by the
    line through those of the last two samples."""
    forces = len(times)
    h, rest, parts = contact.period, contact.rest_force, forces // NODES_PER_PART
    first = (n + 1) * (5 * parts - 1)
    rows, middles, end = motion_of(block), first + 3 * parts, first + 5 * parts - 2
    pushed = h * h * (contact.push - rest) / contact.m
    moved, held = h * contact.v, block.tables[i].give_all
    begin, tilted, laid = contact.position - contact.motion[0], 0.0, forces * block.at
    body = contact.position, moved, pushed
    for k in range(forces):
        at, part = AT[parts, k], k // NODES_PER_PART
        before = rows[middles + part - 1] if part > 0 else begin
        after = rows[middles + part] if part < parts - 1 else rows[end]
        path = block.height[laid + k] + rest * held[k], block.slope[laid + k]
        point = rows[first + k], parts * (after - before), rows[first + forces + part]
        x, v = free_at(at, 1.0 if k % NODES_PER_PART == 1 else -1.0, body, path, point)
        tilted += SHARES[parts, k] * (2.0 * at - 1.0) * v
        block.free[k], block.free[FORCES + k] = x, v + rest * held[FORCES + k]
        block.last[k] = block.force[k]
        block.force[k] = max(2.0 * block.force[k] - block.before[k], 0.0)
    block.travel[0] = moved + 0.5 * pushed + block.rise[block.at] + (begin - rows[end])
    block.travel[1] = tilted
    _bend(block, rows[middles + parts - 1 :], times)
    block.kept = block.gained


@kernel
def _bend(block: Block, rows: View[float], times: tuple[float, ...]) -> None:
    """Set the means of higher P_l times the compression's rate, by the rows of it and by the path's slope."""
    parts = len(times) // NODES_PER_PART
    for moment in range(2, parts + 1):
        total = -rows[moment - 2]
        for k in range(len(times)):
            s = 2.0 * AT[parts, k] - 1.0
            value = 1.5 * s * s - 0.5 if moment == 2 else (2.5 * s * s - 1.5) * s
            total += SHARES[parts, k] * value * block.slope[len(times) * block.at + k]
        block.travel[moment] = total


@kernel
def _keep_at_rest(blocks: Items[Block], net: Net, size: int, times: tuple[float, ...]) -> None:
    """Add what series miss of forces that last, as they were at the end of the sample before."""
    for i in range(size):
        block = blocks[net.block[i]]
        for j in range(size):
            tables, other = block.tables[j], blocks[net.block[j]]
            if other.leaves == 1:
                force = (net.ratio[i, j] if i != j else 1.0) * other.last[len(times) - 1]
                for k in range(len(times)):
                    block.free[k] += force * tables.missed[k]
                    block.free[FORCES + k] += force * tables.missed[FORCES + k]
                for moment in range(len(times) // NODES_PER_PART + 1):
                    block.travel[moment] += force * tables.missed_travel[moment]


@kernel
def _account(
    contacts: Items[Member], blocks: Items[Block], net: Net, size: int, i: int, times: tuple[float, ...]
) -> float:
    """Find a contact's compression at the sample's end, and its energy's growth beyond its force's work.

    The work is sum_l (2 l + 1) J_l int P_l x' dt, with J_l the moments that later samples feel: body and modes get so
    much. Return by how much (J) the growth is above half of what it may be, where it is more than it may be; else 0.
    """
    contact, block = contacts[net.contact[i]].coupled, blocks[net.block[i]]
    forces = len(times)
    moved, work = block.travel[0], 0.0
    for moment in range(forces // NODES_PER_PART + 1):
        travel = block.travel[moment]
        for j in range(size):
            own, f, rest = block.tables[j], blocks[net.block[j]].force, contacts[net.contact[j]].coupled.rest_force
            ratio = net.ratio[i, j] if i != j else 1.0
            for p in range(forces):
                travel -= own.travel[moment * FORCES + p] * ratio * (f[p] - rest)
        if moment == 0:
            moved = travel
        work += (2 * moment + 1) * _moment(block, moment, 0.0, times) * travel
    block.end = contact.motion[0] + moved
    block.left = _stored(contact, block, block.end)
    block.most = max(block.scale, block.left)
    grown = block.kept + block.left - block.stored - work
    block.gained = max(grown, 0.0)
    return 0.0 if grown <= ALLOWED * block.most else grown - 0.5 * ALLOWED * block.most


@kernel
def _moment(block: Block, moment: int, rest: float, times: tuple[float, ...]) -> float:
    """Return a moment of the force beyond `rest`, in N, as later samples feel it: none above the number of parts."""
    parts = len(times) // NODES_PER_PART
    total = 0.0
    if moment <= parts:
        for k in range(len(times)):
            total += FORCE_MOMENTS[parts, moment, k] * (block.force[k] - rest)
    return total


@kernel
def _move(contact: Coupled, block: Block, times: tuple[float, ...]) -> None:
    """Go on to the sample's end."""
    h, rest, forces = contact.period, contact.rest_force, len(times)
    total = 0.0
    for moment in range(MOMENTS_AHEAD):
        block.moments[moment] = h * _moment(block, moment, rest, times)
    for j in range(forces):
        total += block.force[j]
        block.before[j] = block.last[j]
    lightness = 1.0 / contact.m
    push, moments = (h * (contact.push - rest) * lightness, lightness), (block.moments[0], block.moments[1])
    body = contact.position, contact.v
    contact.position, contact.v = gone_on(body, h, push, block.rise[block.at], moments)
    if total > 0.0 and contact.touching == 0:
        contact.contacts += 1
    block.scale, block.stored = block.most, block.left
    contact.motion[0] = block.end
    contact.touching = 1 if block.end > 0.0 else 0
    contact.steps += 1


@kernel
def _stored(contact: Coupled, block: Block, x: float) -> float:
    """Return the elastic energy V(x) in J."""
    return block.springs * raised(x, contact.a + 1.0) if x > 0.0 else 0.0
