"""The checked build, CAROM_CHECKED=1: kernels that compare what they otherwise trust, and end the process at a fault.

Compared are, as each kernel is translated: every index of an array (negative ones too) and both ends of every slice
with the array's size; every load and store of an intrinsic, whole vectors too, with the array or record that its
pointer comes from; every float that becomes an integer with what that can hold; every shift with the integer's bits. A
fault is one line on standard error with kernel, file:line, value and size, then abort().

Not seen: a wrong place within the right array, lengths that `carray` is given, raw addresses, what numpy does, races.
It is for Linux and macOS: the teller is the C library's `dprintf`. Its bits are its own, as LLVM orders sums otherwise.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

from llvmlite import ir

from . import CHECKED

_ROOT = Path(__file__).resolve().parents[2]  # an editable install has links here
_INT, _WORD, _FLOAT, _BYTES = ir.IntType(32), ir.IntType(64), ir.DoubleType(), ir.IntType(8).as_pointer()
_MANTISSA = {"float": 24, "double": 53}  # bits

_translated: list[Any] = []
"""numba's writers of the functions that are translated now, each within the one before."""

_called: list["_Intrinsic"] = []
"""The intrinsics whose instructions are written now."""


def options() -> dict[str, bool]:
    """Return numba's options that a checked kernel needs beyond those of others."""
    return {"boundscheck": True} if CHECKED else {}


@cache
def changes(
    lower: type[Any], context: type[Any], cgutils: Any, slicing: Any, pointer_of: Callable[[Any], Any]
) -> list[tuple[Any, str, Any]]:
    """Return what to change in numba while it translates checked kernels: owners, names and values.

    lower, context, cgutils, slicing: numba's writer of a function, its base of contexts, and two of its modules.
    """
    if not CHECKED:
        return []
    write, fix, make, builder = lower.lower_inst, slicing.fix_slice, context.make_array, ir.IRBuilder

    def lower_inst(writer: Any, instruction: Any) -> None:
        _translated.append(writer)
        try:
            _check_int(writer, instruction)
            write(writer, instruction)
        finally:
            _translated.pop()

    def do_boundscheck(_: Any, builder: Any, index: Any, size: Any, axis: int | None = None) -> None:
        where = f" of axis {axis}" if axis else ""
        _tell_if(builder, builder.icmp_unsigned(">=", index, size), f"index %lld{where}, size %lld", index, size)

    def fix_slice(builder: Any, cut: Any, size: Any) -> None:
        _check_slice(builder, cut, size)
        fix(builder, cut, size)

    def make_array(own: Any, kind: Any) -> Any:
        made = make(own, kind)
        return _called[-1].keeping(own, kind, made, pointer_of) if _called else made

    changed = [
        (lower, "lower_inst", lower_inst),
        (cgutils, "do_boundscheck", do_boundscheck),
        (slicing, "fix_slice", fix_slice),
        (context, "make_array", make_array),
    ]
    checks: dict[Callable[..., None], tuple[str, ...]] = {
        _check_float: ("fptosi",),
        partial(_check_float, signed=False): ("fptoui",),
        _check_shift: ("shl", "ashr", "lshr"),
        _check_load: ("load", "load_atomic"),
        _check_store: ("store", "store_atomic"),
        _check_exchange: ("cmpxchg",),
    }
    return changed + [
        (builder, name, _before(getattr(builder, name), check)) for check, names in checks.items() for name in names
    ]


def checked_intrinsic(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return an intrinsic whose loads and stores are compared."""
    if not CHECKED:
        return function

    def wrapped(*args: Any) -> Any:
        returned = function(*args)
        if returned is None:
            return None
        signature, codegen = returned

        def checked(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            with _calling(_Intrinsic(function.__name__, context, signature.args, args)):
                return codegen(context, builder, signature, args)

        return signature, checked

    wrapped.__name__, wrapped.__doc__, wrapped.__module__ = function.__name__, function.__doc__, function.__module__
    wrapped.__wrapped__ = function  # type: ignore[attr-defined]
    return wrapped


class _Intrinsic:
    """An intrinsic whose instructions are written: what its pointers may come from, with how much of each there is."""

    def __init__(self, name: str, context: Any, kinds: Any, args: Any) -> None:
        self.name, self.context = name, context
        self._held: dict[int, tuple[Any, Any, Any]] = {}  # by the identity of what a pointer is loaded from
        for kind, value in zip(kinds, args, strict=True):
            if isinstance(value.type, ir.PointerType) and hasattr(kind, "fields"):
                self._held[id(value)] = value, ir.Constant(_WORD, kind.size), 1

    def keeping(self, own: Any, kind: Any, made: Any, pointer_of: Callable[[Any], Any]) -> Callable[..., Any]:
        """Return numba's maker of an array's parts, which keeps what it makes here."""
        if kind.layout != "C":
            raise TypeError(f"{self.name}: an array of layout {kind.layout}: expected one without gaps (C)")

        def build(*args: Any, **kwargs: Any) -> Any:
            parts = made(*args, **kwargs)
            size = own.get_abi_sizeof(own.get_data_type(kind.dtype))
            self._held[id(pointer_of(parts))] = parts, None, size
            return parts

        return build

    def extent(self, builder: Any, pointer: Any) -> tuple[Any, Any, int] | None:
        """Return where what a pointer comes from begins, its bytes, and those of one of its items; None: it comes from
        a variable of the intrinsic or from an address that the kernel has as a number."""
        root = self._root(pointer)
        if isinstance(root, ir.AllocaInstr) or (isinstance(root, ir.CastInstr) and root.opname == "inttoptr"):
            return None
        held = self._held.get(id(root))
        if held is None and isinstance(root, ir.LoadInstr):
            held = self._held.get(id(self._root(root.operands[0])))
        if held is None:
            raise TypeError(f"{self.name}: a pointer that comes neither from an array nor from a record: {root}")
        parts, size, item = held
        if size is None:
            return parts.data, builder.mul(parts.nitems, _WORD(item)), item
        return parts, size, item

    def _root(self, pointer: Any) -> Any:
        """Return what a pointer is reckoned from, as far back as that is not one that is held here."""
        while id(pointer) not in self._held:
            if isinstance(pointer, ir.GEPInstr):
                pointer = pointer.pointer
            elif isinstance(pointer, ir.CastInstr) and pointer.opname == "bitcast":
                pointer = pointer.operands[0]
            else:
                break
        return pointer


@contextmanager
def _calling(intrinsic: _Intrinsic) -> Iterator[None]:
    _called.append(intrinsic)
    try:
        yield
    finally:
        _called.pop()


def _before(method: Any, check: Callable[..., None]) -> Callable[..., Any]:
    def checked(builder: Any, *args: Any, **kwargs: Any) -> Any:
        check(builder, *args, **kwargs)
        return method(builder, *args, **kwargs)

    return checked


def _check_slice(builder: Any, cut: Any, size: Any) -> None:
    """Compare a slice's ends with the size of what it is cut from; a stop that is not given is the greatest integer."""
    start, stop = cut.start, cut.stop
    _tell_if(builder, builder.icmp_unsigned(">", start, size), "slice from %lld, size %lld", start, size)
    given = builder.icmp_signed("!=", stop, stop.type(2 ** (stop.type.width - 1) - 1))
    beyond = builder.and_(given, builder.icmp_unsigned(">", stop, size))
    _tell_if(builder, beyond, "slice to %lld, size %lld", stop, size)
    _tell_if(builder, builder.icmp_signed("<", stop, start), "slice from %lld to %lld", start, stop)


def _check_int(writer: Any, instruction: Any) -> None:
    """Compare where `int` is called: numba has a function of its own for that, whose line would say nothing."""
    called: Any = getattr(instruction, "value", None)
    if getattr(called, "op", None) == "call" and getattr(writer.typeof(called.func.name), "typing_key", None) is int:
        for each in called.args:
            value = writer.loadvar(each.name)
            if str(value.type) in _MANTISSA:
                _check_float(writer.builder, value, _WORD)


def _check_float(builder: Any, value: Any, kind: Any, name: str = "", signed: bool = True) -> None:
    """Compare a float, or each of a vector, with the range of the integer that it becomes."""
    bits = getattr(kind, "element", kind).width
    for each in _lanes(builder, value):
        least = -(2.0 ** (bits - 1)) if signed else 0.0
        # What lies less than 1 below the least becomes that, where there is such a number.
        fine = bits < _MANTISSA[str(each.type)]
        low = (
            builder.fcmp_unordered("<=", each, each.type(least - 1.0))
            if fine
            else builder.fcmp_unordered("<", each, each.type(least))
        )
        high = builder.fcmp_unordered(">=", each, each.type(2.0 ** (bits - signed)))
        shown = each if each.type == _FLOAT else builder.fpext(each, _FLOAT)
        _tell_if(builder, builder.or_(low, high), f"%.17g made an integer of {bits} bits", shown)


def _check_shift(builder: Any, value: Any, amount: Any, name: str = "", flags: Any = ()) -> None:
    """Compare by how much an integer, or each of a vector, is shifted with its bits."""
    for each in _lanes(builder, amount):
        if isinstance(each, ir.Constant) and each.constant in range(each.type.width):
            continue
        bits = each.type(each.type.width)
        _tell_if(builder, builder.icmp_unsigned(">=", each, bits), "shift by %lld, bits %lld", each, bits)


def _check_load(builder: Any, pointer: Any, *args: Any, typ: Any = None, **kwargs: Any) -> None:
    if _called:
        _check_access(builder, pointer, typ or pointer.type.pointee)


def _check_store(builder: Any, value: Any, pointer: Any, *args: Any, **kwargs: Any) -> None:
    if _called:
        _check_access(builder, pointer, value.type)


def _check_exchange(builder: Any, pointer: Any, before: Any, *args: Any, **kwargs: Any) -> None:
    if _called:
        _check_access(builder, pointer, before.type)


def _check_access(builder: Any, pointer: Any, kind: Any) -> None:
    """Compare what an intrinsic loads or stores with the array or record that its pointer comes from."""
    intrinsic = _called.pop()  # what is written here is no part of it
    try:
        extent = intrinsic.extent(builder, pointer)
        if extent is None:
            return
        begin, size, item = extent
        length = intrinsic.context.get_abi_sizeof(kind)
        at = builder.sub(builder.ptrtoint(pointer, _WORD), builder.ptrtoint(begin, _WORD))
        beyond = builder.icmp_signed(">", builder.add(at, _WORD(length)), size)
        bad = builder.or_(builder.icmp_signed("<", at, _WORD(0)), beyond)
        what = "byte" if item == 1 else "index"
        many = f"{length // item} values from " if length > item > 1 else ""
        text = f"{many}{what} %lld, size %lld ({intrinsic.name})"
        _tell_if(builder, bad, text, builder.sdiv(at, _WORD(item)), builder.sdiv(size, _WORD(item)))
    finally:
        _called.append(intrinsic)


def _lanes(builder: Any, value: Any) -> list[Any]:
    if not isinstance(value.type, ir.VectorType):
        return [value]
    return [builder.extract_element(value, _INT(i)) for i in range(value.type.count)]


def _tell_if(builder: Any, bad: Any, what: str, *values: Any) -> None:
    """Write a branch that reports a fault and ends the process. what: as `printf` has it, of integers, or of a
    float."""
    writer = _translated[-1]
    module, line = writer.func_ir.func_id.modname, writer.loc.line
    file = Path(writer.loc.filename).resolve()
    file = file.relative_to(_ROOT) if file.is_relative_to(_ROOT) else Path(file.name)
    text = f"carom: checked build: {module}.{writer.func_ir.func_id.func_qualname} ({file}:{line}): {what}\n"
    with builder.if_then(bad, likely=False):
        wide = [each if each.type in (_WORD, _FLOAT) else builder.sext(each, _WORD) for each in values]
        called = _teller(builder.module, tuple(each.type for each in wide))
        builder.call(called, [writer.context.insert_const_string(builder.module, text), *wide])
        builder.unreachable()


def _teller(module: Any, kinds: tuple[Any, ...]) -> Any:
    """Return the function of a module that writes a text with values to standard error, and ends the process."""
    name = f"carom_tell_{'_'.join(map(str, kinds))}"
    if name in module.globals:
        return module.globals[name]
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [_BYTES, *kinds]), name)
    function.linkage = "linkonce_odr"
    for each in ("noinline", "cold", "noreturn", "nounwind"):
        function.attributes.add(each)
    builder = ir.IRBuilder(function.append_basic_block())
    tell = _declared(module, "dprintf", ir.FunctionType(_INT, [_INT, _BYTES], var_arg=True))
    builder.call(tell, [_INT(2), *function.args])
    builder.call(_declared(module, "abort", ir.FunctionType(ir.VoidType(), [])), [])
    builder.unreachable()
    return function


def _declared(module: Any, name: str, kind: Any) -> Any:
    return module.globals[name] if name in module.globals else ir.Function(module, kind, name)
