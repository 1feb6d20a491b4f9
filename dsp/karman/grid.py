"""The force of a plate's stretching on its modes, on a polar grid.

A deflection w stretches the middle surface by L(w, w)/2 (von Karman). Airy's stress function is a sum over functions
psi_k, and so the energy is one of squares, V = 1/2 sum (s_k + l_k)^2, of which l_k is a dome's and linear in w. The
modes hold l_k^2/2 themselves; here is the rest and its gradient. Along each radius tables give three curvatures of w; a
quarter of the circle, with even and odd orders apart, gives the others by signs. What the grid leaves out of V it
leaves out of the gradient alike.
"""

from ..native.jit import kernel, noinline_kernel, simd_kernel
from ..native.typed import View, f32
from .layout import Grid, Space
from .simd import ROWS, dots, put_curvatures, put_products, put_tractions


@noinline_kernel
def stretch(grid: Grid, table: View[f32], functions: int, space: Space) -> float:
    """Return V (J) without what is linear, and set `space.answer`, its gradient, by `space.place`: (3, functions).

    The gradient is (2, functions): by cosines and by sines.
    """
    for i in range(2 * functions):
        space.answer[i] = 0.0
    _bend(grid, table, functions, space)
    put_curvatures(space.parts, space.fields, space.bends, grid.angles, grid.points)
    energy = _strain(grid, table, functions, space)
    _tighten(grid, table, space)
    put_tractions(space.bends, space.fields, space.parts, grid.angles, grid.points)
    _answer(grid, table, functions, space)
    return energy


@kernel
def _evens(orders: int) -> int:
    """Return how many of so many orders, from 0 on, are even."""
    return (orders + 1) // 2


@kernel
def _line(order: int, orders: int) -> int:
    """Return the row of an order: even ones come first."""
    return order // 2 + (_evens(orders) if order % 2 == 1 else 0)


@noinline_kernel
def _bend(grid: Grid, table: View[f32], functions: int, space: Space) -> None:
    """Find the three fields in parts: along radii for each order, then on the quarter of the circle."""
    points, orders, angles = grid.points, grid.orders, grid.angles
    width, both = 3 * points, 2 * points
    half = orders * width
    for order in range(orders):
        row, at = _line(order, orders) * width, grid.first[order]
        shapes = grid.shapes + grid.row[order] * width
        count = grid.count[order]
        put_products(space.waves, row, half, space.place, at, functions, 1, table, shapes, width, count, 2, both)
        # The third is a derivative around the circle: sines give cosines, and cosines sines of the other sign.
        put_products(
            space.waves, row + both, half, space.place, at + functions, functions, 1, table, shapes + both, width,
            count, 2, points,
        )  # fmt: skip
    size = angles * width
    evens = _evens(orders)
    for odd in range(2):
        begin, columns = evens * width if odd == 1 else 0, _columns(orders, odd)
        put_products(
            space.parts, odd * size, width, table, grid.cosine[odd], columns, 1, space.waves, begin, width, columns,
            angles, width,
        )  # fmt: skip
        put_products(
            space.parts, (2 + odd) * size, width, table, grid.sine[odd], columns, 1, space.waves, half + begin, width,
            columns, angles, width,
        )  # fmt: skip


@kernel
def _columns(orders: int, odd: int) -> int:
    """Return how many of so many orders are odd, or even."""
    return orders - _evens(orders) if odd == 1 else _evens(orders)


@noinline_kernel
def _strain(grid: Grid, table: View[f32], functions: int, space: Space) -> float:
    """Find the strains, put 2 (s_k + l_k) into `sums`, and return the energy; add a dome's part of the gradient."""
    points, orders, angles = grid.points, grid.stresses, grid.angles
    size, half = angles * points, orders * points
    evens = _evens(orders)
    for odd in range(2):
        begin = evens * points if odd == 1 else 0
        columns = _columns(orders, odd)
        put_products(
            space.strains, begin, points, table, grid.stress_cosine[odd], 1, columns, space.bends, odd * size, points,
            angles, columns, points,
        )  # fmt: skip
        put_products(
            space.strains, half + begin, points, table, grid.stress_sine[odd], 1, columns, space.bends,
            (2 + odd) * size, points, angles, columns, points,
        )  # fmt: skip
    count = grid.stress[orders]
    energy = 0.0
    for order in range(orders):
        line = _line(order, orders) * points
        begin, end = grid.stress[order], grid.stress[order + 1]
        k = begin
        while k < end:
            found = dots(table, grid.stretch + k * points, points, space.strains, line, half, points)
            for r in range(min(ROWS, end - k)):
                space.sums[k + r] = found[r]
                space.sums[count + k + r] = found[ROWS + r] if order > 0 else 0.0
            k += ROWS
        if grid.domed == 1 and order < grid.orders:
            energy += _curve(grid, table, order, functions, space)
        else:
            for k in range(begin, end):
                energy += 0.5 * (space.sums[k] ** 2 + space.sums[count + k] ** 2)
        for k in range(begin, end):
            space.sums[k] *= 2.0
            space.sums[count + k] *= 2.0
    return energy


@simd_kernel
def _curve(grid: Grid, table: View[f32], order: int, functions: int, space: Space) -> float:
    """Add the linear strains of a dome to those of one order, and to the gradient what they make; return the
    energy."""
    total, begin, end = grid.stress[grid.stresses], grid.stress[order], grid.stress[order + 1]
    first, count = grid.first[order], grid.count[order]
    energy = 0.0
    for side in range(2 if order > 0 else 1):
        at = side * functions + first
        place, answer = space.place[at : at + count], space.answer[at : at + count]
        for k in range(begin, end):
            row = grid.bent + grid.strain[order] + (k - begin) * count
            bent = table[row : row + count]
            linear = 0.0
            for i in range(count):
                linear += bent[i] * place[i]
            strain = space.sums[side * total + k]
            energy += strain * (0.5 * strain + linear)
            for i in range(count):
                answer[i] += strain * bent[i]
            space.sums[side * total + k] = strain + linear
    return energy


@noinline_kernel
def _tighten(grid: Grid, table: View[f32], space: Space) -> None:
    """Find the stress on the quarter of the circle, in parts, in `bends`."""
    points, orders, angles = grid.points, grid.stresses, grid.angles
    size, half, count = angles * points, orders * points, grid.stress[orders]
    for order in range(orders):
        begin = grid.stress[order]
        put_products(
            space.strains, _line(order, orders) * points, half, space.sums, begin, count, 1, table,
            grid.stretch + begin * points, points, grid.stress[order + 1] - begin, 2, points,
        )  # fmt: skip
    evens = _evens(orders)
    for odd in range(2):
        begin = evens * points if odd == 1 else 0
        columns = _columns(orders, odd)
        put_products(
            space.bends, odd * size, points, table, grid.stress_cosine[odd], columns, 1, space.strains, begin, points,
            columns, angles, points,
        )  # fmt: skip
        put_products(
            space.bends, (2 + odd) * size, points, table, grid.stress_sine[odd], columns, 1, space.strains,
            half + begin, points, columns, angles, points,
        )  # fmt: skip


@noinline_kernel
def _answer(grid: Grid, table: View[f32], functions: int, space: Space) -> None:
    """Add the gradient by all functions that are coupled, from the products of stress and curvatures."""
    points, orders, angles = grid.points, grid.orders, grid.angles
    width, both = 3 * points, 2 * points
    size, half = angles * width, orders * width
    evens = _evens(orders)
    for odd in range(2):
        begin = evens * width if odd == 1 else 0
        columns = _columns(orders, odd)
        for side in range(2):
            angular = grid.sine[odd] if side == 1 else grid.cosine[odd]
            source = (2 * side + odd) * size
            put_products(
                space.waves, side * half + begin, width, table, angular, 1, columns, space.parts, source, width,
                angles, columns, both,
            )  # fmt: skip
            put_products(
                space.waves, (1 - side) * half + begin + both, width, table, angular, 1, columns, space.parts,
                source + both, width, angles, columns, points,
            )  # fmt: skip
    for order in range(orders):
        line, at = _line(order, orders) * width, grid.first[order]
        shapes, count = grid.shapes + grid.row[order] * width, grid.count[order]
        i = 0
        while i < count:
            found = dots(table, shapes + i * width, width, space.waves, line, half, width)
            for r in range(min(ROWS, count - i)):
                space.answer[at + i + r] += found[r]
                if order > 0:
                    space.answer[functions + at + i + r] += found[ROWS + r]
            i += ROWS
