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
from .platforms import assembly
from .store import Store
from .targets import Target


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
        for each in [*module.functions, *module.global_variables]:
            if not each.is_declaration and each.name != self.symbol:
                each.linkage = "internal"
        content: bytes = module.as_bitcode()
        return content


@cache
def _compiler() -> str:
    """Return a digest of all that makes machine code of bitcode."""
    here = Path(__file__).parent
    files = [(here / name).read_text() for name in ("units.py", "platforms.py", "store.py", "targets.py")]
    return digest(f"{llvmlite.__version__} {files}")


def make_object(store: Store, key: str, target: Target) -> None:
    """Make a unit's machine code for a target, and keep it. TypeError if it needs Python."""
    best = optimised(store.read_unit(key, "source", "bc") or b"", target)
    store.write_unit(key, str(target), "bc", best.as_bitcode())
    store.write_object(key, target, target.machine().emit_object(best), needed(best))


def optimised(source: bytes, target: Target) -> Any:
    """Return LLVM's module of bitcode, optimised for a target. TypeError if it needs Python."""
    module = llvm.parse_bitcode(source)
    machine = target.machine()
    support = llvm.parse_assembly(assembly(target.system, target.triple))
    for each in (module, support):
        each.triple, each.data_layout = target.triple, str(machine.target_data)
    names = [each.name for each in support.functions if not each.is_declaration]
    module.link_in(support)
    for name in names:
        module.get_function(name).linkage = "internal"
    optimise(module, target)
    passes = llvm.create_new_module_pass_manager()
    passes.add_global_dead_code_eliminate_pass()
    passes.add_strip_dead_prototype_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
    python = [each.name for each in module.functions if each.name.startswith(("Py", "numba_", "NRT_"))]
    if python:
        names = [each.name for each in module.functions if not each.is_declaration]
        raise TypeError(f"{', '.join(names)}: this code needs Python: {', '.join(python)}")
    return module


def optimise(module: Any, target: Target) -> None:
    """Run LLVM's optimiser, for a target; its vectors decide in which order sums are taken.

    Two runs: a scalar one, then the full one. The scalar run must not unroll loops: the full one vectorises unrolled
    modal loops by scatter and gather, which is 2.4 times slower.
    """
    machine = target.machine()
    tuning = llvm.create_pipeline_tuning_options(speed_level=1)
    tuning.loop_unrolling = tuning.loop_interleaving = False
    tuning.loop_vectorization = tuning.slp_vectorization = False
    scalar = llvm.create_pass_builder(machine, tuning)
    scalar.getModulePassManager().run(module, scalar)
    tuning = llvm.create_pipeline_tuning_options(speed_level=3)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    full = llvm.create_pass_builder(machine, tuning)
    full.getModulePassManager().run(module, full)


_OF_C_LIBRARY = ("sin", "cos", "tan", "exp", "exp2", "log", "log2", "log10", "pow")
"""Functions that LLVM has instructions for, and calls where a processor has none."""


def needed(module: Any) -> list[str]:
    """Return the functions of the system's libraries that the code of a module calls; other units' are left out."""
    names = [each.name for each in module.functions if each.is_declaration and not each.name.startswith("_ZN")]
    inner = [name.split(".")[1] for name in names if name.startswith("llvm.")]
    return sorted({name for name in names if not name.startswith("llvm.")} | set(inner) & set(_OF_C_LIBRARY))
