"""Lasting contacts with an object that rings freely but for them, a block of samples at a time: one implicit step a
sample, of Galerkin's method.

Compression x = path + body - point. Time runs over [0, 1] of a sample, u = 2 t - 1, and P_l are Legendre polynomials.

1. The force over a sample is f = sum f_l P_l(u), of four terms. Its moments h f_l/(2 l + 1) are all that body
   and modes get of it: both take them exactly.
2. Of the compression's rate only as many moments are seen, v_l = (2 l + 1) int P_l x' dt. By superposition
   v_l = free_l - sum_k W_lk f_k: W is the answer within a sample, what forces did before is in rows of the point's
   motion (resonator/rows.py) to which each sample's moments add by a table, and the moments of the path's slope are
   exact: so a kink gives the right impulse. x(t) = x_0 + sum v_l int_0^t P_l, and x_1 = x_0 + v_0 holds exactly.
3. The law holds by projection: f_l = (2 l + 1) int P_l k x^a (1 + mu x'), by Gauss's quadrature. Newton's method finds
   the terms of all contacts that share objects together: with K the slopes of the law's terms over the rates,
   (1 + K W) f = law(v) + K (free - v). It begins with the rates of the last sample, so that a stiff contact takes no
   more turns, or with forces on a line through the last two, after which a soft one mostly takes one.
4. The work sum f_l v_l/(2 l + 1) is just what body and modes get, and just int f x' of the polynomials: what the
   contact stores and loses, but for the error of the quadrature. Where V = k x^(a+1)/(a+1) would grow beyond that work
   by more than a small share of its greatest value, a viscous force, in proportion to v_l, takes the excess. Where that
   is not enough, or Newton's method ends nowhere, one force is held over the sample, by the discrete gradient of V:
   there always is one. So a step can't fail.

The method's order is twice its terms: Brugnano, Iavernaro, "Line Integral Methods for Conservative Problems" (2016);
Hairer, "Energy-preserving variant of collocation methods", JNAIAM 5 (2010). With one term it is the discrete gradient.

Here F = f - f_0 is what modes get, with f_0 the force of a body at rest: gravity is gone from all else, and at rest
nothing moves. A striker that is pressed on has no such force: modes bend under all of it, and series are mended by what
they miss of a force that lasts. Its block ends where it leaves.
"""

import math

from ..native.jit import kernel, noinline_kernel, simd_kernel
from ..native.typed import Items
from .block_choice import HARDER, LANDS, swing_of
from .block_records import TERMS, Block, Net, Newton, motion_of
from .collocation import discrete_gradient, factor, substitute
from .coupled_records import Coupled, Member
from .law import compression_of_stiffness, elastic
from .step_record import NODES
from .terms import NEAR, NONE, change_of, dot, plus, project_law, put, solve_terms, take, times, work_of

ALLOWED = 1e-6  # share of the greatest V by which it may grow beyond the force's work
ROUNDS = 6  # of changes for that
LEAST = 1e-300  # keeps a quotient finite
_SOFT = 0.7  # rad of a swing up to which forces are foretold better than rates
_FIRST = 0.25  # of a sample: the first step to try after a block
AS_HARD = 2.0  # times the greatest V so far, up to which a body that lands does so no harder: it hops on a rough path
_BEGINS, _ENDS = (1.0, -1.0, 1.0, -1.0), (1.0, 1.0, 1.0, 1.0)  # P_l at the sample's ends
_NOTHING = 1e-12  # share of a held force below which a change is none
_NEWTON_STEPS = 14
_KNOWN_STEPS = 3  # of them by slopes that are known
_SWEEPS = 50  # over held forces that feel each other


@kernel
def renew_block(block: Block) -> None:
    """Begin with a contact anew."""
    block.settled = 0
    put(block.rate, NONE)
    forget_energy(block)


@kernel
def forget_energy(block: Block) -> None:
    """Begin the account of energy anew, as with another touch, which may be much softer."""
    block.gained = block.scale = 0.0


@kernel
def begin_block(block: Block, contact: Coupled, place: float, terms: int) -> None:
    """Begin a block with a coupled contact as it is; place (m): of the object's point now, by its free motion; terms:
    of the forces."""
    contact.position = contact.motion[0] + place
    block.stored = elastic(contact.motion[0], contact.k, contact.a)
    swing, block.landing = swing_of(contact), math.inf
    if contact.a != 1.0:
        # The energy (J) that compresses the contact as far as a block follows what lands.
        rate = max(LANDS, HARDER * swing) / contact.period
        deepest = compression_of_stiffness(rate * rate * contact.mass, contact.k, contact.a)
        block.landing = elastic(deepest, contact.k, contact.a)
    block.leaves = 1 if contact.rest_force == 0.0 else 0
    motion_of(block)[terms - 1] = place
    block.pushes = contact.force[0] if contact.touching == 1 else 0.0
    block.soft = 1 if swing < _SOFT else 0
    put(block.force, (block.pushes, 0.0, 0.0, 0.0))
    put(block.before, (block.pushes, 0.0, 0.0, 0.0))


@kernel
def end_block(block: Block, contact: Coupled) -> None:
    """Leave the contact so that it can go on by samples, after as many of the block as were taken."""
    for j in range(NODES):
        contact.force[j] = contact.step.f[j] = block.pushes if contact.touching == 1 else 0.0
    contact.last = contact.next = _FIRST


@kernel
def step_blocks(contacts: Items[Member], blocks: Items[Block], net: Net, size: int, n: int) -> bool:
    """Take all contacts of a net, of a size, through sample n of the block, with their paths laid; `moments` gets those
    of F.

    False, and nothing done, where the block ends before that sample: one leaves whose block ends so, lands harder than
    a block follows, or moves by no number.
    """
    if size > 1:
        # Set the factors on what the forces of contacts of a net, of a size, do to each other's points.
        for i in range(size):
            for j in range(size):
                net.ratio[i, j] = net.gain[j] * net.share[j] / net.gain[i] if i != j else 1.0
    for i in range(size):
        _predict(contacts, blocks, net, size, i, n)
    for i in range(size):
        _guess(blocks[net.block[i]])
    for i in range(size):
        if blocks[net.block[i]].soft == 1:
            _find_rates(blocks, net, size, i)
    if size == 1:
        solved = _solve_alone(contacts[net.contact[0]].coupled, blocks[net.block[0]], net.newton)
    else:
        solved = _solve_together(contacts, blocks, net, size)
    if not (solved and _conserve(contacts, blocks, net, size)):
        # Hold one force of each contact over the sample, by the discrete gradient: each as the others' are, until
        # they hardly change.
        for j in range(size):
            put(blocks[net.block[j]].force, NONE)
        for _ in range(_SWEEPS if size > 1 else 1):
            changed = False
            for j in range(size):
                contact, block = contacts[net.contact[j]].coupled, blocks[net.block[j]]
                _find_rates(blocks, net, size, j)
                give, before = block.tables[j].within[0, 0], block.force[0]
                free, law = block.rate[0] + give * before, (contact.k, contact.mu, contact.a)
                _, block.force[0] = discrete_gradient(contact.motion[0], free, give, contact.period, *law)
                changed |= abs(block.force[0] - before) > _NOTHING * block.force[0]
            if not changed:
                break
        for j in range(size):
            _find_rates(blocks, net, size, j)
    for i in range(size):
        contact, block = contacts[net.contact[i]].coupled, blocks[net.block[i]]
        force, rate = take(block.force), take(block.rate)
        if not math.isfinite(dot(force, rate)):
            return False
        if block.leaves == 1 and not (contact.motion[0] + rate[0] > 0.0 and dot(force, _ENDS) > 0.0):
            return False
        speed = dot(rate, _BEGINS) / contact.period
        energy = block.stored + 0.5 * contact.mass * speed * speed
        if force[0] > 0.0 and energy > max(block.landing, AS_HARD * block.scale):
            return False
    for i in range(size):
        _move(contacts[net.contact[i]].coupled, blocks[net.block[i]])
    return True


@simd_kernel
def _predict(contacts: Items[Member], blocks: Items[Block], net: Net, size: int, i: int, n: int) -> None:
    """Find a contact's v_l without a force."""
    contact, block = contacts[net.contact[i]].coupled, blocks[net.block[i]]
    h, row = contact.period, motion_of(block)[(n + 1) * TERMS :]
    pushed = 0.5 * h * h * (contact.push - contact.rest_force) / contact.m
    way = contact.position - contact.motion[0] - row[TERMS - 1]  # of the point, backwards
    free = h * contact.v + pushed + way, pushed - row[0], -row[1], -row[2]
    free = plus(free, 1.0, take(block.path[TERMS * block.at :]))
    for j in range(size):
        other, tables = blocks[net.block[j]], block.tables[j]
        ratio = net.ratio[i, j] if size > 1 else 1.0
        rest, w = ratio * contacts[net.contact[j]].coupled.rest_force, tables.within
        free = plus(free, rest, (w[0, 0], w[1, 0], w[2, 0], w[3, 0]))
        if net.lasts == 1 and other.leaves == 1:
            free = plus(free, ratio * other.pushes, take(tables.missed))
    put(block.free, free)


@simd_kernel
def _guess(block: Block) -> None:
    """Guess the forces of a contact that is soft: by the line through those of the last two samples."""
    force, before = take(block.force), take(block.before)
    put(block.before, force)
    if block.soft == 1:
        guess = plus(plus(force, 1.0, force), -1.0, before)
        put(block.force, guess if guess[0] > 0.0 else NONE)


@simd_kernel
def _find_rates(blocks: Items[Block], net: Net, size: int, i: int) -> None:
    """Find a contact's v_l under all forces as they are now."""
    block = blocks[net.block[i]]
    rate = take(block.free)
    for j in range(size):
        taken = times(block.tables[j].within, take(blocks[net.block[j]].force))
        rate = plus(rate, -net.ratio[i, j] if size > 1 else -1.0, taken)
    put(block.rate, rate)


@noinline_kernel
def _solve_alone(contact: Coupled, block: Block, newton: Newton) -> bool:
    """Find the force and the rates of one contact by Newton's method: from the last sample's rates, then from those
    without a force. False if it fails."""
    x, law, within = contact.motion[0], (contact.k, contact.mu, contact.a), block.tables[0].within
    free, rate, bend = take(block.free), take(block.rate), contact.mu / contact.period
    for _ in range(2):
        for _ in range(_NEWTON_STEPS):
            project_law(newton, x, rate, law, contact.period)
            force = solve_terms(newton, plus(free, -1.0, rate), within)
            before, rate = rate, plus(free, -1.0, times(within, force))
            if change_of(x, rate, before, bend) <= NEAR:
                put(block.force, force)
                put(block.rate, rate)
                return True
        rate = free
    return False


@kernel
def _solve_together(contacts: Items[Member], blocks: Items[Block], net: Net, size: int) -> bool:
    """Find the forces and the rates of several contacts so; at first by the slopes of an earlier sample, whose
    equations are factored: what hardly changes its stiffness needs no others."""
    count = TERMS * size
    for attempt in range(2):
        last = NEAR * NEAR
        for step in range(_NEWTON_STEPS):
            anew = net.factored == 0 or step >= _KNOWN_STEPS or attempt > 0
            for i in range(size):
                # Newton's equations for contact i: (1 + K W) f = found + K (free - rate), with its slopes as they are
                # `anew`; else only their right side.
                contact, block = contacts[net.contact[i]].coupled, blocks[net.block[i]]
                rate = take(block.rate)
                project_law(net.newton, contact.motion[0], rate, (contact.k, contact.mu, contact.a), contact.period)
                away = plus(take(block.free), -1.0, rate)
                for k in range(TERMS):
                    row = net.linear[TERMS * i + k]
                    if anew:
                        slopes = take(net.newton.slopes[TERMS * k :])
                        put(net.slopes[i, TERMS * k :], slopes)
                        for j in range(size):
                            within = block.tables[j].within
                            for p in range(TERMS):
                                taken = dot(slopes, (within[0, p], within[1, p], within[2, p], within[3, p]))
                                row[TERMS * j + p] = net.ratio[i, j] * taken
                        row[TERMS * i + k] += 1.0
                    row[count] = net.newton.found[k] + dot(take(net.slopes[i, TERMS * k :]), away)
            if anew:
                factor(net.linear, count)
                net.factored = 1
            substitute(net.linear, count)
            for i in range(size):
                put(blocks[net.block[i]].force, take(net.linear[TERMS * i : TERMS * i + TERMS, count]))
            moved = 0.0
            for i in range(size):
                contact, before = contacts[net.contact[i]].coupled, take(blocks[net.block[i]].rate)
                _find_rates(blocks, net, size, i)
                rate = take(blocks[net.block[i]].rate)
                moved = max(moved, change_of(contact.motion[0], rate, before, contact.mu / contact.period))
            # Newton's next step would be about as small as the square of this one; by known slopes, as this one
            # against the last.
            if moved <= NEAR and (anew or moved * moved <= NEAR * NEAR * last):
                return True
            last = moved
        for i in range(size):
            put(blocks[net.block[i]].rate, take(blocks[net.block[i]].free))
    return False


@kernel
def _conserve(contacts: Items[Member], blocks: Items[Block], net: Net, size: int) -> bool:
    """Slow the contacts whose energy grows by too much, by viscous forces; false if one's still does."""
    for _ in range(ROUNDS):
        grows = False
        for i in range(size):
            grows |= _mend(contacts[net.contact[i]].coupled, blocks[net.block[i]])
        if not grows:
            return True
        for i in range(size):
            _find_rates(blocks, net, size, i)
    return False


@simd_kernel
def _mend(contact: Coupled, block: Block) -> bool:
    """Slow a contact if its energy grows by more than it may: by so much that half of what it may be is left. True if
    it does, or if it is no number."""
    force, rate = take(block.force), take(block.rate)
    left = elastic(contact.motion[0] + rate[0], contact.k, contact.a)
    allowed = ALLOWED * max(block.scale, left)
    grown = block.gained + left - block.stored - work_of(force, rate)
    if grown <= allowed:
        return False
    put(block.force, plus(force, (grown - 0.5 * allowed) / (work_of(rate, rate) + LEAST), rate))
    return True


@simd_kernel
def _move(contact: Coupled, block: Block) -> None:
    """Go on to the sample's end."""
    h, rest, force, rate = contact.period, contact.rest_force, take(block.force), take(block.rate)
    if force[0] > 0.0 and contact.touching == 0:
        contact.contacts += 1
    x = contact.motion[0] + rate[0]
    left = elastic(x, contact.k, contact.a)
    block.gained = max(block.gained + left - block.stored - work_of(force, rate), 0.0)
    block.scale, block.stored = max(block.scale, left), left
    block.pushes = max(dot(force, _ENDS), 0.0)
    first, second = h * (force[0] - rest), h * (1.0 / 3.0) * force[1]
    put(block.moments, (first, second, h * 0.2 * force[2], h * (1.0 / 7.0) * force[3]))
    # A force at time t moves the body by 1 - t = (1 - P_1)/2 at the end.
    pushed, lightness = h * (contact.push - rest), 1.0 / contact.m
    moved = contact.v + 0.5 * lightness * (pushed - first + second)
    contact.position += h * moved + block.path[TERMS * block.at]
    contact.v += lightness * (pushed - first)
    contact.motion[0] = x
    contact.touching = 1 if x > 0.0 else 0
    contact.steps += 1
