"""LLVM's modules as they are linked: which of their names can be seen, and what nobody needs."""

from collections.abc import Collection
from typing import Any

import llvmlite.binding as llvm


def show_only(module: Any, names: Collection[str]) -> None:
    """Make all that a module defines internal, but for some names."""
    for each in [*module.functions, *module.global_variables]:
        if not each.is_declaration and each.name not in names:
            each.linkage = "internal"


def tidy(module: Any, machine: Any) -> None:
    """Remove what a module hides and does not need; machine: LLVM's maker of machine code."""
    passes = llvm.create_new_module_pass_manager()
    passes.add_constant_merge_pass()
    passes.add_global_dead_code_eliminate_pass()
    passes.add_strip_dead_prototype_pass()
    passes.run(module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options()))
