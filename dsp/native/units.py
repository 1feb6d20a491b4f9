"""Units: the pieces in which LLVM compiles. Each is a function that is not inlined, with all that is inlined into it.

A unit's key is a hash of its bitcode's parts and of what optimises it; its machine code lies by that key. To cut finer,
mark a kernel `noinline_kernel`: LLVM's passes take more than in proportion to a function's length. Nothing here imports
numba: processes that compile units begin at once.
"""

from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import llvmlite.binding as llvm

from .digests import digest
from .linking import show_only, tidy
from .platforms import assembly
from .portable import strict, with_own_functions
from .sources import source_of
from .store import Store
from .targets import PORTABLE, WASM, Target


class Unit(NamedTuple):
    """A function and what is inlined into it: LLVM's symbol, and the bitcode of each.

    The function's comes first, the others by their symbols.
    """

    symbol: str
    parts: tuple[bytes, ...]

    @property
    def key(self) -> str:
        """The name by which its code is kept."""
        return digest(f"{_compiler()} {self.symbol} {[digest(part) for part in self.parts]}")

    def source(self) -> bytes:
        """Return its bitcode, in which it alone can be seen from elsewhere."""
        module = llvm.parse_bitcode(self.parts[0])
        for part in self.parts[1:]:
            module.link_in(llvm.parse_bitcode(part))
        show_only(module, {self.symbol})
        content: bytes = module.as_bitcode()
        return content


@cache
def _compiler() -> str:
    """Return a digest of all that makes machine code of bitcode."""
    here = Path(__file__).parent
    names = "linking.py", "platforms.py", "portable.py", "store.py", "targets.py", "units.py"
    files = [source_of(str(here / name)) for name in names]
    return digest(f"{llvmlite.__version__} {files}")


def make_object(store: Store, key: str, target: Target) -> None:
    """Make a unit's machine code for a target, and keep it. TypeError if it needs Python."""
    if target.is_portable:
        best = _portable(store, key, target)
    else:
        best = optimised(store.read_unit(key, "source", "bc") or b"", target)
    store.write_unit(key, str(target), "bc", best.as_bitcode())
    store.write_object(key, target, best.as_bitcode() if target.system == WASM else for_image(best, target))


def for_image(module: Any, target: Target) -> bytes:
    """Return the machine code of LLVM's module as an object file that `images.py` links."""
    machine = target.image_machine()
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    made: bytes = machine.emit_object(module)
    return made


def _portable(store: Store, key: str, target: Target) -> Any:
    """Return LLVM's module of a unit for a target, by the code that is optimised once for all of them."""
    kept = store.read_unit(key, PORTABLE, "bc")
    if kept is None:
        source = with_own_functions(llvm.parse_bitcode(store.read_unit(key, "source", "bc") or b""))
        small = _optimised(source.clone(), target, unrolls=False)
        kept = strict(_optimised(source, target) if _can_fail(small) else small).as_bitcode()
        store.write_unit(key, PORTABLE, "bc", kept)
    module = _with_system(llvm.parse_bitcode(kept), target)
    module.triple, module.data_layout = target.triple, str(target.machine().target_data)
    tidy(module, target.machine())
    return module


def _can_fail(module: Any) -> bool:
    """True if LLVM has not proved that a module's code cannot fail: of loops it sees some things once they are
    unrolled."""
    return any(each.name.startswith(".const.picklebuf") for each in module.global_variables)


def _with_system(module: Any, target: Target) -> Any:
    """Return LLVM's module with what it calls of a target's system."""
    support = llvm.parse_assembly(assembly(target.system, target.triple, flushes=not target.is_portable))
    support.triple, support.data_layout = module.triple, module.data_layout
    names = [each.name for each in support.functions if not each.is_declaration]
    module.link_in(support)
    for name in names:
        module.get_function(name).linkage = "internal"
    return module


def optimised(source: bytes, target: Target) -> Any:
    """Return LLVM's module of bitcode, optimised for a target. TypeError if it needs Python."""
    return _optimised(_with_system(llvm.parse_bitcode(source), target), target)


def _optimised(module: Any, target: Target, unrolls: bool = True) -> Any:
    """Optimise LLVM's module, and return it."""
    machine = target.optimiser()
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    optimise(module, target, unrolls)
    tidy(module, machine)
    python = [each.name for each in module.functions if each.name.startswith(("Py", "numba_", "NRT_"))]
    if python:
        names = [each.name for each in module.functions if not each.is_declaration]
        raise TypeError(f"{', '.join(names)}: this code needs Python: {', '.join(python)}")
    return module


def optimise(module: Any, target: Target, unrolls: bool = True) -> None:
    """Run LLVM's optimiser, for a target; its vectors decide in which order sums are taken.

    Two runs: a scalar one, then the full one. The scalar run must not unroll loops: the full one vectorises unrolled
    modal loops by scatter and gather, which is 2.4 times slower. unrolls: as portable code does not where it can do
    without: it is as fast, and a seventh smaller for pages.
    """
    machine = target.optimiser()
    tuning = llvm.create_pipeline_tuning_options(speed_level=1)
    tuning.loop_unrolling = tuning.loop_interleaving = False
    tuning.loop_vectorization = tuning.slp_vectorization = False
    scalar = llvm.create_pass_builder(machine, tuning)
    scalar.getModulePassManager().run(module, scalar)
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    tuning.loop_unrolling = tuning.loop_interleaving = unrolls
    full = llvm.create_pass_builder(machine, tuning)
    full.getModulePassManager().run(module, full)
