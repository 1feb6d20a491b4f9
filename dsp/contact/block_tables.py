"""The answers of points to the forces of contacts that are solved in blocks: within a sample, and after it."""

import numpy as np
from numpy.polynomial import legendre

from ..native.jit import kernel, noinline_kernel
from ..native.typed import Items, View
from ..numerics.checks import Array
from ..numerics.legendre import AHEAD, FINE
from ..numerics.settled import same_everywhere
from ..numerics.sums import AT_ONCE, add_tables, line_of
from .block_records import SOFT_TERMS, TERMS, TILE, Block, Lanes, Net, Tables, motion_of


def _within() -> Array:
    """Return (2 l + 1) int_0^1 P_l(2 t - 1) r'(t) dt, with r = int_0^t (t - s)^n P_k(2 s - 1) ds: (l, n, k)."""
    x, w = legendre.leggauss(FINE)
    t, n, order = 0.5 * (x + 1.0), np.arange(1, FINE), 2.0 * np.arange(TERMS) + 1.0
    values = legendre.legvander(x, TERMS - 1)
    rates = np.zeros((FINE, FINE, TERMS))  # [t, n, k]
    rates[:, 0] = values
    s = t[:, None] * t
    powers = 0.5 * w * t[:, None] * n[:, None, None] * (t[:, None] - s) ** (n[:, None, None] - 1)
    rates[:, 1:] = np.einsum("nts,tsk->tnk", powers, legendre.legvander(2.0 * s - 1.0, TERMS - 1))
    found: Array = np.einsum("l,tl,t,tnk->lnk", order, values, 0.5 * w, rates)
    return found


_WITHIN = same_everywhere("WITHIN", _within())


@kernel
def within(answer: View[float], row: int, term: int) -> float:
    """Return what term k of a force adds to v_l of a point within its sample, by the point's answer (FINE values)."""
    total = 0.0
    for n in range(FINE):
        total += answer[n] * _WITHIN[row, n, term]
    return total


@kernel
def settle_tables(tables: Tables, answer: View[float], eased: bool) -> None:
    """Set what the terms of a force do within a sample, by an answer (FINE values).

    eased: a dashpot in series with the contact, which its last term alone feels, takes the oscillation that a step
    doesn't resolve: with it the step is Radau's of the second kind, without it Gauss's.
    """
    for i in range(TERMS):
        for j in range(TERMS):
            tables.within[i, j] = within(answer, i, j)
            tables.within[i, TERMS + j] = 0.0
    if eased:
        tables.within[TERMS - 1, TERMS - 1] += tables.within[0, 0] / (2 * TERMS - 1)


@kernel
def take_rows(block: Block, laid: View[float], scale: float, samples: int, terms: int) -> None:
    """Take rows of the point's motion over so many samples that were laid one after the other, times `scale`; terms: of
    the forces, as many rows."""
    rows = motion_of(block)
    for n in range(samples):
        for r in range(terms):
            rows[(n + 1) * terms + r] = scale * laid[r * AHEAD + n]


@kernel
def take_answers(tables: Tables, moment: int, laid: View[float], samples: int, begin: int, terms: int) -> None:
    """Take the rows of the motion over so many samples that follow on a moment of a force that is 1; begin: 0, or
    AT_BEGIN or AT_END; terms: of the forces."""
    first = line_of(tables.later) + begin
    for r in range(terms):
        for n in range(samples):
            i = n * terms + r
            within = i % AT_ONCE
            tables.later[first + (i - within) * terms + moment * AT_ONCE + within] = laid[r * AHEAD + n]


@kernel
def feel(blocks: Items[Block], net: Net, size: int, n: int) -> None:
    """Add what the forces of sample n do to the rows of the samples after it in the block, of all contacts of a net of
    a size."""
    for i in range(size):
        block = blocks[net.block[i]]
        rows, begin, values = motion_of(block), (n + 2) * TERMS, (net.stop - net.begin - 1 - n) * TERMS
        for j in range(size):
            moments, later = blocks[net.block[j]].moments, block.tables[j].later
            share = net.gain[j] / net.gain[i] if i != j else 1.0
            felt = share * moments[0], share * moments[1], share * moments[2], share * moments[3]
            add_tables(rows, begin, later, line_of(later), felt, values)


@noinline_kernel
def feel_tile(block: Block, lanes: Lanes, i: int, samples: int, end: int) -> None:
    """Add what the forces of a lane's contact in the tile that ends at a sample do to the rows after it, of so many
    samples in the block: sums of whole lines, which may begin within the tile."""
    rows, later = motion_of(block), block.tables[0].later
    for s in range(TILE):
        done = (TILE - 1 - s) * SOFT_TERMS
        done -= done % AT_ONCE
        first, begin = end - TILE + s, SOFT_TERMS * s
        felt = lanes.felt[begin, i], lanes.felt[begin + 1, i], lanes.felt[begin + 2, i]
        count = (samples - 1 - first) * SOFT_TERMS - done
        add_tables(rows, (first + 2) * SOFT_TERMS + done, later, line_of(later) + done * SOFT_TERMS, felt, count)
