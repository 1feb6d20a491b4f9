"""Experiments: rolls and coupled contacts as data, every method against the exact solution, and what each costs.

Names load when they are first used.
"""

from typing import TYPE_CHECKING

from ..lazy import lazily

if TYPE_CHECKING:
    from .coupled import Case, Run, simulate
    from .roll import make_roll, micro_impacts, roll_contacts, roll_force, roll_moments
    from .spectrum import spectrum_error
    from .wall import (
        PAPER_CASES,
        PAPER_RATE,
        Deviations,
        Law,
        Outcome,
        deviations,
        durations,
        exact_rebounds,
        outcomes,
        pareto,
        path,
        rebounds,
        scattered_laws,
    )

__all__ = [
    "PAPER_CASES", "PAPER_RATE", "Case", "Deviations", "Law", "Outcome", "Run", "deviations", "durations",
    "exact_rebounds", "make_roll", "micro_impacts", "outcomes", "pareto", "path", "rebounds", "roll_contacts",
    "roll_force", "roll_moments", "scattered_laws", "simulate", "spectrum_error",
]  # fmt: skip

_MODULES = {
    ".coupled": "Case Run simulate",
    ".roll": "make_roll micro_impacts roll_contacts roll_force roll_moments",
    ".spectrum": "spectrum_error",
    ".wall": "PAPER_CASES PAPER_RATE Deviations Law Outcome deviations durations exact_rebounds outcomes pareto path "
    "rebounds scattered_laws",
}
__getattr__, __dir__ = lazily(__name__, _MODULES)
