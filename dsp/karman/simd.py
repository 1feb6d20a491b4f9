"""Products of small matrices of float32, and what is done point by point, with sums in registers.

Arrays count as flat. Rows are multiples of LANES long. A tile of up to ROWS rows and WIDE vectors stays in registers
while the sum runs. What is written is 0 where it is FAINT: no product of two such numbers is a denormal, which many
processors multiply by a hundred times more slowly, and a page can't have flushed.
"""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View, f32
from .layout import FAINT

LANES = 8
"""Numbers of float32 in a vector: one register of AVX2."""

ROWS = 4
"""Rows of `dots`, and the most of a tile."""

_WIDE = 3  # vectors of a tile: ROWS of them, with as many loads and a factor, fill 16 registers
_FREE = ("contract", "reassoc", "nsz")


def _int64(value: int) -> Any:
    return ir.IntType(64)(value)


def _vector() -> Any:
    return ir.VectorType(ir.FloatType(), LANES)


def _zero() -> Any:
    return ir.Constant(_vector(), None)


class _Arrays:
    """The arrays of an intrinsic: loads and stores of vectors at places."""

    def __init__(self, context: Any, builder: Any, signature: Any, args: Any) -> None:
        self._builder = builder
        self._data = {
            n: context.make_array(kind)(context, builder, args[n]).data
            for n, kind in enumerate(signature.args)
            if isinstance(kind, types.Array)
        }

    def place(self, n: int, at: Any) -> Any:
        return self._builder.gep(self._data[n], [at])

    def load(self, n: int, at: Any) -> Any:
        pointer = self._builder.bitcast(self.place(n, at), _vector().as_pointer())
        return self._builder.load(pointer, align=4)

    def store(self, n: int, at: Any, value: Any) -> None:
        pointer = self._builder.bitcast(self.place(n, at), _vector().as_pointer())
        self._builder.store(_without_faint(self._builder, value), pointer, align=4)

    def spread(self, n: int, at: Any) -> Any:
        """Load one number into all lanes."""
        one = self._builder.insert_element(_zero(), self._builder.load(self.place(n, at)), ir.IntType(32)(0))
        return self._builder.shuffle_vector(one, _zero(), ir.Constant(ir.VectorType(ir.IntType(32), LANES), None))


def _without_faint(builder: Any, value: Any) -> Any:
    """Return a vector with 0 for numbers that are FAINT."""
    low, high = (ir.Constant(_vector(), [ir.Constant(ir.FloatType(), sign * FAINT)] * LANES) for sign in (-1.0, 1.0))
    faint = builder.and_(builder.fcmp_ordered(">", value, low), builder.fcmp_ordered("<", value, high))
    return builder.select(faint, _zero(), value)


def _times(builder: Any, a: Any, b: Any) -> Any:
    return builder.fmul(a, b, flags=_FREE)


def _plus(builder: Any, a: Any, b: Any) -> Any:
    return builder.fadd(a, b, flags=_FREE)


def _minus(builder: Any, a: Any, b: Any) -> Any:
    return builder.fsub(a, b, flags=_FREE)


@intrinsic
def put_products(
    typingctx: object,
    out: View[f32],
    first: int,
    stride: int,
    factors: View[f32],
    factor: int,
    down: int,
    along: int,
    table: View[f32],
    begin: int,
    step: int,
    depth: int,
    rows: int,
    width: int,
) -> Lowered[None]:
    """Set out[first + r stride + t] = sum_k factors[factor + r down + k along] table[begin + k step + t].

    For k below `depth`, r below `rows` and t below `width`, a multiple of LANES.
    """

    def codegen(context, builder, signature, args):
        arrays = _Arrays(context, builder, signature, args)
        _, first, stride, _, factor, down, along, _, begin, step, depth, rows, width = args
        vectors = builder.sdiv(width, _int64(LANES))
        # How many tiles of each width so many vectors are cut into: threes, but four of them into twos.
        rest = builder.srem(vectors, _int64(_WIDE))
        uneven = builder.and_(
            builder.icmp_signed("==", rest, _int64(1)), builder.icmp_signed(">", vectors, _int64(_WIDE))
        )
        kept = builder.select(uneven, builder.sub(vectors, _int64(4)), vectors)
        threes = builder.sdiv(kept, _int64(_WIDE))
        left = builder.sub(vectors, builder.mul(threes, _int64(_WIDE)))
        counts = [(_WIDE, threes), (2, builder.sdiv(left, _int64(2))), (1, builder.srem(left, _int64(2)))]
        row = cgutils.alloca_once_value(builder, _int64(0))
        for high in range(ROWS, 0, -1):
            groups = builder.sdiv(builder.sub(rows, builder.load(row)), _int64(high))
            with cgutils.for_range(builder, groups):
                at = builder.load(row)
                target = builder.add(first, builder.mul(at, stride))
                weight = builder.add(factor, builder.mul(at, down))
                column = cgutils.alloca_once_value(builder, _int64(0))
                builder.store(_int64(0), column)
                for wide, count in counts:
                    with cgutils.for_range(builder, count):
                        here = builder.load(column)
                        tile = _Tile(high, wide, builder.add(target, here), stride, weight, down)
                        _put_tile(builder, arrays, tile, along, builder.add(begin, here), step, depth)
                        builder.store(builder.add(here, _int64(wide * LANES)), column)
                builder.store(builder.add(at, _int64(high)), row)
        return context.get_dummy_value()

    index = types.intp
    return types.void(
        out, index, index, factors, index, index, index, table, index, index, index, index, index
    ), codegen


class _Tile:
    """A tile of a product: its rows and vectors, where it goes, and where the factors of its rows are."""

    def __init__(self, high: int, wide: int, target: Any, stride: Any, weight: Any, down: Any) -> None:
        self.high, self.wide = high, wide
        self.target, self.stride, self.weight, self.down = target, stride, weight, down


def _put_tile(builder: Any, arrays: _Arrays, tile: _Tile, along: Any, begin: Any, step: Any, depth: Any) -> None:
    """Compute a tile: one sum for each of its vectors."""
    sums = [[cgutils.alloca_once(builder, _vector()) for _ in range(tile.wide)] for _ in range(tile.high)]
    for each in sums:
        for one in each:
            builder.store(_zero(), one)
    downs = [builder.add(tile.weight, builder.mul(tile.down, _int64(r))) for r in range(tile.high)]
    with cgutils.for_range(builder, depth) as loop:
        at = builder.add(begin, builder.mul(loop.index, step))
        values = [arrays.load(7, builder.add(at, _int64(u * LANES))) for u in range(tile.wide)]
        for r, each in enumerate(sums):
            weight = arrays.spread(3, builder.add(downs[r], builder.mul(loop.index, along)))
            for one, value in zip(each, values, strict=True):
                builder.store(_plus(builder, builder.load(one), _times(builder, weight, value)), one)
    for r, each in enumerate(sums):
        for u, one in enumerate(each):
            place = builder.add(tile.target, builder.mul(tile.stride, _int64(r)))
            arrays.store(0, builder.add(place, _int64(u * LANES)), builder.load(one))


@intrinsic
def dots(
    typingctx: object, table: View[f32], first: int, stride: int, pair: View[f32], begin: int, apart: int, width: int
) -> Lowered[tuple[f32, ...]]:
    """Return sum_t table[first + r stride + t] pair[begin + s apart + t], t below `width`, a tuple: s = 0 for ROWS r,
    then s = 1."""

    def codegen(context, builder, signature, args):
        arrays = _Arrays(context, builder, signature, args)
        _, first, stride, _, begin, apart, width = args
        sums = [cgutils.alloca_once(builder, _vector()) for _ in range(2 * ROWS)]
        for each in sums:
            builder.store(_zero(), each)
        starts = [builder.add(first, builder.mul(stride, _int64(r))) for r in range(ROWS)]
        with cgutils.for_range(builder, builder.sdiv(width, _int64(LANES))) as loop:
            t = builder.mul(loop.index, _int64(LANES))
            here = builder.add(begin, t)
            both = arrays.load(3, here), arrays.load(3, builder.add(here, apart))
            for r, start in enumerate(starts):
                value = arrays.load(0, builder.add(start, t))
                for s, other in enumerate(both):
                    total = sums[s * ROWS + r]
                    builder.store(_plus(builder, builder.load(total), _times(builder, value, other)), total)
        total = _without_faint(builder, _sums_of(builder, [builder.load(each) for each in sums]))
        return cgutils.pack_array(builder, [builder.extract_element(total, ir.IntType(32)(i)) for i in range(LANES)])

    index = types.intp
    returned = types.UniTuple(types.float32, 2 * ROWS)
    return returned(table, index, index, pair, index, index, index), codegen


def _sums_of(builder: Any, vectors: list[Any]) -> Any:
    """Return the sums of LANES vectors, one in each lane of one vector."""
    half = LANES // 2
    while half > 0:
        low = [2 * half * (i // half) + i % half for i in range(LANES)]
        picks = [ir.Constant(ir.VectorType(ir.IntType(32), LANES), [at + offset for at in low]) for offset in (0, half)]
        vectors = [
            _plus(builder, *(builder.shuffle_vector(a, b, pick) for pick in picks))
            for a, b in zip(vectors[::2], vectors[1::2], strict=True)
        ]
        half //= 2
    return vectors[0]


def _quadrants(builder: Any, classes: list[Any]) -> list[Any]:
    """Return values at theta, -theta, pi - theta and pi + theta from the parts of even and odd order: two of cosines,
    two of sines."""
    even, odd, even_sine, odd_sine = classes
    near, far = _plus(builder, even, odd), _minus(builder, even, odd)
    sine, other = _plus(builder, even_sine, odd_sine), _minus(builder, odd_sine, even_sine)
    return [
        _plus(builder, near, sine), _minus(builder, near, sine), _plus(builder, far, other), _minus(builder, far, other)
    ]  # fmt: skip


def _classes(builder: Any, values: list[Any]) -> list[Any]:
    """Return the sums of values at these four angles that their products with such parts come to: the transpose."""
    first, second, third, fourth = values
    near, far = _plus(builder, first, second), _plus(builder, third, fourth)
    sine, other = _minus(builder, first, second), _minus(builder, third, fourth)
    return [
        _plus(builder, near, far), _minus(builder, near, far), _minus(builder, sine, other), _plus(builder, sine, other)
    ]  # fmt: skip


@intrinsic
def put_curvatures(
    typingctx: object, parts: View[f32], fields: View[f32], bends: View[f32], angles: int, points: int
) -> Lowered[None]:
    """Find three fields on the whole grid from their parts, and a^2 - b^2 - c^2, in parts again.

    parts: (4, angles, 3 points); fields: (angles, 4, 3 points); bends: (4, angles, points).
    """

    def codegen(context, builder, signature, args):
        arrays = _Arrays(context, builder, signature, args)
        angles, points = args[3:]
        width = builder.mul(points, _int64(3))
        size, small = builder.mul(width, angles), builder.mul(points, angles)
        with cgutils.for_range(builder, angles) as outer:
            at, low = builder.mul(outer.index, width), builder.mul(outer.index, points)
            whole = builder.mul(at, _int64(4))
            with cgutils.for_range_slice(builder, _int64(0), points, _int64(LANES)) as (t, _):
                bent = [_zero()] * 4
                for f in range(3):
                    here = builder.add(builder.mul(points, _int64(f)), t)
                    place = builder.add(at, here)
                    loaded = [arrays.load(0, builder.add(place, builder.mul(size, _int64(c)))) for c in range(4)]
                    values = _quadrants(builder, loaded)
                    for c, value in enumerate(values):
                        target = builder.add(builder.add(whole, here), builder.mul(width, _int64(c)))
                        arrays.store(1, target, value)
                        square = _times(builder, value, value)
                        bent[c] = square if f == 0 else _minus(builder, bent[c], square)
                for c, value in enumerate(_classes(builder, bent)):
                    target = builder.add(builder.add(low, t), builder.mul(small, _int64(c)))
                    arrays.store(2, target, value)
        return context.get_dummy_value()

    return types.void(parts, fields, bends, types.intp, types.intp), codegen


@intrinsic
def put_tractions(
    typingctx: object, stress: View[f32], fields: View[f32], parts: View[f32], angles: int, points: int
) -> Lowered[None]:
    """Multiply the three fields by a stress, given in parts, b and c by its negative: the products in parts again.

    stress: (4, angles, points); fields, parts: as in `put_curvatures`. The sines' parts of c's change their sign.
    """

    def codegen(context, builder, signature, args):
        arrays = _Arrays(context, builder, signature, args)
        angles, points = args[3:]
        width = builder.mul(points, _int64(3))
        size, small = builder.mul(width, angles), builder.mul(points, angles)
        with cgutils.for_range(builder, angles) as outer:
            at, low = builder.mul(outer.index, width), builder.mul(outer.index, points)
            whole = builder.mul(at, _int64(4))
            with cgutils.for_range_slice(builder, _int64(0), points, _int64(LANES)) as (t, _):
                place = builder.add(low, t)
                loaded = [arrays.load(0, builder.add(place, builder.mul(small, _int64(c)))) for c in range(4)]
                tension = _quadrants(builder, loaded)
                for f in range(3):
                    here = builder.add(builder.mul(points, _int64(f)), t)
                    products = []
                    for c in range(4):
                        source = builder.add(builder.add(whole, here), builder.mul(width, _int64(c)))
                        products.append(_times(builder, arrays.load(1, source), tension[c]))
                    for c, value in enumerate(_classes(builder, products)):
                        target = builder.add(builder.add(at, here), builder.mul(size, _int64(c)))
                        negative = f == 1 or (f == 2 and c < 2)
                        arrays.store(2, target, _minus(builder, _zero(), value) if negative else value)
        return context.get_dummy_value()

    return types.void(stress, fields, parts, types.intp, types.intp), codegen
