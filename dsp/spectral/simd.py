"""Vector instructions of the spectral bank: eight terms, or a chunk of modes, at once.

Complex vectors lie in memory as TERMS real parts and then TERMS imaginary ones.
"""

from typing import Any

from ..native.jit import Lowered, cgutils, intrinsic, ir, types
from ..native.typed import View, View2D
from .basis import TERMS

CHUNK = 8
"""Modes of a chunk."""
MOTION = 4
"""Rows of a chunk that bring it further, each as long as its modes: c, exp(lambda FRAMES), by real and imaginary parts.
They are kept in float64 or in float32."""
WEIGHTS = 3
"""Rows behind these that it is heard by, always in float32: zeta, by real and imaginary parts, and balance."""
ROWS = MOTION + WEIGHTS
SUMS = 4 * TERMS
"""Sums of a bin: left by real and imaginary parts, then right."""

_AHEAD = {64: 4_096, 32: 2_048}
"""Bytes by which chunks are requested from memory before they are read, by bits of a number. Measured: without this a
million modes take 1.4 to 1.9 times as long, as they do not stay in the cache."""
_LINE = 64  # bytes that memory gives at once
_FAST = ("contract", "reassoc", "nsz")


def _i64(value: int) -> Any:
    return ir.IntType(64)(value)


def _mask(places: list[int]) -> Any:
    return ir.Constant(ir.VectorType(ir.IntType(32), len(places)), [ir.IntType(32)(place) for place in places])


def _vector_type(bits: int = 64) -> Any:
    return ir.VectorType(ir.DoubleType() if bits == 64 else ir.FloatType(), CHUNK)


class _Writer:
    """Writes instructions for vectors of CHUNK numbers, which are as many as TERMS; bits: of a number, 64 or 32."""

    def __init__(self, context: Any, builder: Any, bits: int = 64) -> None:
        self._context, self.builder, self._bits = context, builder, bits

    def data(self, array_type: Any, array: Any) -> Any:
        return self._context.make_array(array_type)(self._context, self.builder, array).data

    def place(self, data: Any, index: Any, offset: int = 0) -> Any:
        at = self.builder.gep(data, [self.builder.add(index, _i64(offset))])
        return self.builder.bitcast(at, _vector_type(self._bits).as_pointer())

    def load(self, data: Any, index: Any, offset: int = 0) -> Any:
        return self.builder.load(self.place(data, index, offset), align=self._bits // 8)

    def store(self, value: Any, data: Any, index: Any, offset: int = 0) -> None:
        self.builder.store(value, self.place(data, index, offset), align=self._bits // 8)

    def taken(self, value: Any) -> Any:
        """Return a vector of float32 as one of this writer's numbers."""
        return value if self._bits == 32 else self.builder.fpext(value, _vector_type())

    def ask_for(self, data: Any, index: Any, numbers: int) -> None:
        """Prefetch so many numbers from memory that lie _AHEAD of those at `index`. There may be nothing."""
        byte, word = ir.IntType(8).as_pointer(), ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [byte, word, word, word])
        fetch = cgutils.get_or_insert_function(self.builder.module, kind, "llvm.prefetch.p0")
        begin = self.builder.bitcast(self.place(data, index), byte)
        for offset in range(_AHEAD[self._bits], _AHEAD[self._bits] + numbers * self._bits // 8, _LINE):
            self.builder.call(fetch, [self.builder.gep(begin, [_i64(offset)]), word(0), word(3), word(1)])

    def add(self, a: Any, b: Any) -> Any:
        return self.builder.fadd(a, b, flags=_FAST)

    def subtract(self, a: Any, b: Any) -> Any:
        return self.builder.fsub(a, b, flags=_FAST)

    def times(self, a: Any, b: Any) -> Any:
        return self.builder.fmul(a, b, flags=_FAST)

    def complex_times(self, a: Any, b: Any) -> Any:
        return (
            self.subtract(self.times(a[0], b[0]), self.times(a[1], b[1])),
            self.add(self.times(a[0], b[1]), self.times(a[1], b[0])),
        )

    def complex_add(self, a: Any, b: Any) -> Any:
        return self.add(a[0], b[0]), self.add(a[1], b[1])

    def complex_subtract(self, a: Any, b: Any) -> Any:
        return self.subtract(a[0], b[0]), self.subtract(a[1], b[1])

    def pair(self, data: Any, index: Any, offset: int = 0) -> Any:
        return self.load(data, index, offset), self.load(data, index, offset + TERMS)

    def store_pair(self, value: Any, data: Any, index: Any, offset: int = 0) -> None:
        self.store(value[0], data, index, offset)
        self.store(value[1], data, index, offset + TERMS)

    def filled(self, scalar: Any) -> Any:
        """Return a vector of equal numbers."""
        undefined = ir.Constant(_vector_type(self._bits), ir.Undefined)
        return self.shuffle(self.builder.insert_element(undefined, scalar, ir.IntType(32)(0)), undefined, [0] * CHUNK)

    def shuffle(self, a: Any, b: Any, places: list[int]) -> Any:
        return self.builder.shuffle_vector(a, b, _mask(places))

    def sums(self, vectors: Any) -> Any:
        """Return the sum of each of eight vectors, as a vector."""
        for low, high in (
            ([0, 8, 2, 10, 4, 12, 6, 14], [1, 9, 3, 11, 5, 13, 7, 15]),
            ([0, 1, 8, 9, 4, 5, 12, 13], [2, 3, 10, 11, 6, 7, 14, 15]),
            ([0, 1, 2, 3, 8, 9, 10, 11], [4, 5, 6, 7, 12, 13, 14, 15]),
        ):
            pairs = zip(vectors[::2], vectors[1::2], strict=True)
            vectors = [self.add(self.shuffle(a, b, low), self.shuffle(a, b, high)) for a, b in pairs]
        return vectors[0]


@intrinsic
def spread(
    typingctx: object, chunks: View[float], weights: View[float], first: int, last: int, sums: View[float], at: int
) -> Lowered[None]:
    """Add up the modes of a bin, in chunks `first` to `last`, and bring them a block further.

    sums[at + j] = sum_m Re(c_m zeta_m^j), then Im at TERMS; from 2 TERMS on the same times the modes' balance. Then
    c_m <- c_m exp(lambda_m FRAMES). Arrays are flat: chunks (MOTION rows each) float64 or float32, which all but the
    last addition of a bin's modes is done in; weights (WEIGHTS rows) float32; sums float64.
    """
    bits = chunks.dtype.bitwidth  # type: ignore[attr-defined]

    def codegen(context, builder, signature, args):
        w, wide, narrow = _Writer(context, builder, bits), _Writer(context, builder), _Writer(context, builder, 32)
        chunks, weights, first, last, sums, at = args
        data, target = w.data(signature.args[0], chunks), wide.data(signature.args[4], sums)
        heard = narrow.data(signature.args[1], weights)
        totals = [cgutils.alloca_once(builder, _vector_type(bits)) for _ in range(SUMS)]
        for total in totals:
            builder.store(ir.Constant(_vector_type(bits), None), total)

        def gather(place, value):
            builder.store(w.add(builder.load(totals[place]), value), totals[place])

        with cgutils.for_range_slice(builder, first, last, _i64(1), ir.IntType(64)) as (chunk, _):
            begin, behind = builder.mul(chunk, _i64(MOTION * CHUNK)), builder.mul(chunk, _i64(WEIGHTS * CHUNK))
            w.ask_for(data, begin, MOTION * CHUNK)
            narrow.ask_for(heard, behind, WEIGHTS * CHUNK)
            re, im, e_re, e_im = (w.load(data, begin, row * CHUNK) for row in range(MOTION))
            z_re, z_im, balance = (w.taken(narrow.load(heard, behind, row * CHUNK)) for row in range(WEIGHTS))
            w.store_pair(w.complex_times((re, im), (e_re, e_im)), data, begin)
            power = re, im
            for j in range(TERMS):
                for part in range(2):
                    gather(part * TERMS + j, power[part])
                    gather((2 + part) * TERMS + j, w.times(balance, power[part]))
                power = w.complex_times(power, (z_re, z_im))
        for k in range(4):
            total = w.sums([builder.load(total) for total in totals[k * TERMS : (k + 1) * TERMS]])
            wide.store(builder.fpext(total, _vector_type()) if bits == 32 else total, target, at, k * TERMS)
        return context.get_dummy_value()

    return types.void(chunks, weights, types.intp, types.intp, sums, types.intp), codegen


@intrinsic
def pack(typingctx: object, sums: View[float], at: int, points: View[float], up: int, down: int) -> Lowered[None]:
    """Write a bin's sums at sums[at] as points of a transform: left + i right at `up`, with both conjugate at `down`.

    Points are counted in numbers: 2 TERMS each.
    """

    def codegen(context, builder, signature, args):
        w = _Writer(context, builder)
        sums, at, points, up, down = args
        source, target = w.data(signature.args[0], sums), w.data(signature.args[2], points)
        left_re, left_im, right_re, right_im = (w.load(source, at, k * TERMS) for k in range(4))
        w.store_pair((w.subtract(left_re, right_im), w.add(left_im, right_re)), target, up)
        w.store_pair((w.add(left_re, right_im), w.subtract(right_re, left_im)), target, down)
        return context.get_dummy_value()

    return types.void(sums, types.intp, points, types.intp, types.intp), codegen


@intrinsic
def butterfly(
    typingctx: object,
    source: View[float],
    at: int,
    step: int,
    target: View[float],
    to: int,
    stride: int,
    turns: tuple[float, ...],
) -> Lowered[None]:
    """Transform four points, source[at + k step] to target[to + k stride], where the last three are turned.

    `turns` is a tuple of cos and sin for each of these three.
    """

    def codegen(context, builder, signature, args):
        w = _Writer(context, builder)
        source, at, step, target, to, stride, turns = args
        data, out = w.data(signature.args[0], source), w.data(signature.args[3], target)
        a, b, c, d = (w.pair(data, builder.add(at, builder.mul(step, _i64(k)))) for k in range(4))
        even, odd = w.complex_add(a, c), w.complex_add(b, d)
        half, other = w.complex_subtract(a, c), w.complex_subtract(b, d)
        results = [
            w.complex_add(even, odd),
            (w.subtract(half[0], other[1]), w.add(half[1], other[0])),
            w.complex_subtract(even, odd),
            (w.add(half[0], other[1]), w.subtract(half[1], other[0])),
        ]
        angles = [w.filled(each) for each in cgutils.unpack_tuple(builder, turns)]
        for k, result in enumerate(results):
            turned = result if k == 0 else w.complex_times(result, angles[2 * k - 2 : 2 * k])
            w.store_pair(turned, out, builder.add(to, builder.mul(stride, _i64(k))))
        return context.get_dummy_value()

    i = types.intp
    return types.void(source, i, i, target, i, i, turns), codegen


@intrinsic
def weighted(
    typingctx: object, points: View[float], at: int, weights: View2D[float], first: int
) -> Lowered[tuple[float, float]]:
    """Return sums of a point's real parts and of its imaginary ones, each times weights[first + j]: a tuple."""

    def codegen(context, builder, signature, args):
        w = _Writer(context, builder)
        points, at, weights, first = args
        data, table = w.data(signature.args[0], points), w.data(signature.args[2], weights)
        psi = w.load(table, first)
        both = [w.times(part, psi) for part in w.pair(data, at)]
        total = w.sums([*both, *[ir.Constant(_vector_type(), None)] * 6])
        return cgutils.pack_array(builder, [builder.extract_element(total, ir.IntType(32)(k)) for k in range(2)])

    return types.UniTuple(types.float64, 2)(points, types.intp, weights, types.intp), codegen
