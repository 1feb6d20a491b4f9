"""The forces over a sample of contacts that are solved in blocks (block.py), by Newton's method, part after part.

Later parts do nothing to earlier ones. Contacts that share objects are one system: the force of a heavy body errs by a
share of its own, which may be all of that of a light one.
"""

import math

import numpy as np

from ..native.jit import kernel
from ..native.typed import Items
from .block_records import Block, Net, Tables
from .block_sizes import FORCES, MOTIONS, NODES_PER_PART
from .block_step import correct, less
from .collocation import eliminate, law_with_slopes
from .coupled_records import Coupled, Member

# Relative change of the forces that ends Newton's method, by parts: below a third of its square is left.
CHANGED = np.array([0.0, 1e-2, 2e-3, 2e-3])
_CHANGED_TOGETHER = 2e-3  # the same of several
NEWTON_STEPS = 12


@kernel
def find_forces(contacts: Items[Member], blocks: Items[Block], net: Net, size: int, times: tuple[float, ...]) -> None:
    """Find the forces of all contacts of a net, of a size, and the rates at the nodes; `solved` says whether."""
    if size == 1:
        _solve_alone(contacts[net.contact[0]].coupled, blocks[net.block[0]], blocks[net.block[0]].tables[0], times)
        return
    solved = True
    for part in range(len(times) // NODES_PER_PART):
        first = NODES_PER_PART * part
        # Most are pairs: the loops for two are unrolled.
        if size == 2:
            solved = solved and _solve_together(contacts, blocks, net, 2, first)
        else:
            solved = solved and _solve_together(contacts, blocks, net, size, first)
    for i in range(size):
        blocks[net.block[i]].solved = 1 if solved else 0


@kernel
def _solve_together(contacts: Items[Member], blocks: Items[Block], net: Net, size: int, first: int) -> bool:
    """Find the two forces of each contact in a part of the sample, by its first node; false if Newton's method
    fails."""
    for i in range(size):
        _see(contacts, blocks, net, i, size, first, first)
        block = blocks[net.block[i]]
        if block.seen[first] <= 0.0 and block.seen[first + 1] <= 0.0:
            block.force[first] = block.force[first + 1] = 0.0  # open, and guessed to stay so
    for _ in range(NEWTON_STEPS):
        for i in range(size):
            _linearise(contacts[net.contact[i]].coupled, blocks, net, i, size, first)
        count = NODES_PER_PART * size
        eliminate(net.linear, count)
        solved = True
        for i in range(size):
            block, change, whole = blocks[net.block[i]], 0.0, 0.0
            for a in range(NODES_PER_PART):
                changed = net.linear[NODES_PER_PART * i + a, count]
                block.force[first + a] += changed
                change += abs(changed)
                whole += abs(block.force[first + a])
            solved &= change <= _CHANGED_TOGETHER * whole
        if solved:
            for i in range(size):
                for k in range(first, first + NODES_PER_PART):
                    blocks[net.block[i]].v[k] = _motion(blocks, net, i, size, first, k)[1]
            return True
    return False


@kernel
def _see(
    contacts: Items[Member], blocks: Items[Block], net: Net, i: int, size: int, first: int, known: int
) -> None:  # fmt: skip
    """Find a contact's compression and rate at the nodes of a part under so many forces of each contact, of those of
    others beyond their rest."""
    block = blocks[net.block[i]]
    for k in range(first, first + NODES_PER_PART):
        x, v = block.free[k], block.free[FORCES + k]
        for j in range(size):
            give, force = block.tables[j].give, blocks[net.block[j]].force
            ratio, rest = 1.0, 0.0
            if i != j:
                ratio, rest = net.ratio[i, j], contacts[net.contact[j]].coupled.rest_force
            for p in range(first + NODES_PER_PART):
                excess = ratio * ((force[p] if p < known else 0.0) - rest)
                x -= excess * give[p * MOTIONS + k]
                v -= excess * give[p * MOTIONS + FORCES + k]
        block.seen[k], block.seen[FORCES + k] = x, v


@kernel
def find_rates(contacts: Items[Member], blocks: Items[Block], net: Net, i: int, size: int, first: int) -> None:
    """Find a contact's rates at the nodes of a part by all forces as they are now."""
    _see(contacts, blocks, net, i, size, first, first + NODES_PER_PART)
    block = blocks[net.block[i]]
    for k in range(first, first + NODES_PER_PART):
        block.v[k] = block.seen[FORCES + k]


@kernel
def _motion(blocks: Items[Block], net: Net, i: int, size: int, first: int, k: int) -> tuple[float, float]:
    """Return a contact's compression and rate at a node of a part, with all its forces."""
    x, v = blocks[net.block[i]].seen[k], blocks[net.block[i]].seen[FORCES + k]
    for j in range(size):
        give, force = blocks[net.block[i]].tables[j].give, blocks[net.block[j]].force
        ratio = net.ratio[i, j] if i != j else 1.0
        for p in range(first, first + NODES_PER_PART):
            x -= ratio * force[p] * give[p * MOTIONS + k]
            v -= ratio * force[p] * give[p * MOTIONS + FORCES + k]
    return x, v


@kernel
def _linearise(contact: Coupled, blocks: Items[Block], net: Net, i: int, size: int, first: int) -> None:
    """Fill the rows of Newton's equations for a contact."""
    block, rate, right = blocks[net.block[i]], 1.0 / contact.period, NODES_PER_PART * size
    for a in range(NODES_PER_PART):
        k, row = first + a, NODES_PER_PART * i + a
        x, v = _motion(blocks, net, i, size, first, k)
        force, stiffness, damping = law_with_slopes(x, rate * v, (contact.k, contact.mu, contact.a))
        for j in range(size):
            give, ratio = block.tables[j].give, net.ratio[i, j] if i != j else 1.0
            for b in range(NODES_PER_PART):
                p = (first + b) * MOTIONS
                taken = stiffness * give[p + k] + rate * damping * give[p + FORCES + k]
                net.linear[row, NODES_PER_PART * j + b] = ratio * taken
        net.linear[row, row] += 1.0
        net.linear[row, right] = force - block.force[k]


@kernel
def _solve_alone(contact: Coupled, block: Block, own: Tables, times: tuple[float, ...]) -> None:
    """Find the forces of one contact, one part of the sample after the other, and the rates."""
    solved = True
    for part in range(len(times) // NODES_PER_PART):
        first = NODES_PER_PART * part
        second = first + 1
        x0, x1 = block.free[first], block.free[second]
        v0, v1 = block.free[FORCES + first], block.free[FORCES + second]
        for p in range(first):
            give = own.give[p * MOTIONS :]
            x0 -= give[first] * block.force[p]
            x1 -= give[second] * block.force[p]
            v0 -= give[FORCES + first] * block.force[p]
            v1 -= give[FORCES + second] * block.force[p]
        solved &= _solve_part(block, own, contact, first, (x0, x1, v0, v1))
    block.solved = 1 if solved else 0


@kernel
def _solve_part(block: Block, own: Tables, contact: Coupled, i: int, seen: tuple[float, float, float, float]) -> bool:
    """Find the two forces of a part of the sample; false if Newton's method fails."""
    j = i + 1
    x0, x1, v0, v1 = seen
    here, there = own.give[i * MOTIONS :], own.give[j * MOTIONS :]
    a = here[i], here[j], there[i], there[j]
    w = here[FORCES + i], here[FORCES + j], there[FORCES + i], there[FORCES + j]
    if x0 <= 0.0 and x1 <= 0.0:
        block.force[i] = block.force[j] = 0.0
        block.v[i], block.v[j] = v0, v1
        return True
    forces = block.force[i], block.force[j]
    law, rate, changed = (contact.k, contact.mu, contact.a), 1.0 / contact.period, CHANGED[block.parts]
    solved = False
    for _ in range(NEWTON_STEPS):
        f, s, d = law_with_slopes(less(x0, a[0], a[2], forces), rate * less(v0, w[0], w[2], forces), law)
        g, t, e = law_with_slopes(less(x1, a[1], a[3], forces), rate * less(v1, w[1], w[3], forces), law)
        c0, c1, left = correct(forces, (f, s, rate * d), (g, t, rate * e), a, w)
        forces = forces[0] + c0, forces[1] + c1
        if left <= changed * (abs(forces[0]) + abs(forces[1])):
            solved = True
            break
    block.force[i], block.force[j] = forces
    block.v[i], block.v[j] = less(v0, w[0], w[2], forces), less(v1, w[1], w[3], forces)
    return solved and math.isfinite(forces[0] + forces[1])
