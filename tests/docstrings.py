"""A lint for docstrings: they open with a verb or a noun phrase. `make lint` runs it; CONTRIBUTING.md has the rule."""

import ast
import sys
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("dsp", "server", "clients", "presets", "tests")

_VERBS = """
Accept Act Add Adjust Advance Align Allow Answer Append Apply Arrange Ask Assemble Assert Assign Average Await Begin
Bind Blend Book Bounce Bound Break Bring Build Call Cancel Carry Change Charge Check Choose Clear Close Collect
Combine Compare Compile Complete Compute Connect Continue Convert Copy Correct Count Couple Create Cut Decide Decode
Define Delete Deliver Derive Describe Detect Discard Disconnect Divide Do Document Drag Draw Drive Drop Dump Emit
Empty Encode End Enter Estimate Evaluate Exchange Expand Export Extend Extrapolate Fade Fail Fetch Fill Filter Find
Finish Fit Fly Fold Follow Forget Format Free Freeze Gather Generate Give Go Group Halt Hand Handle Hash Hear Hold
Ignore Import Init Initialize Inject Insert Install Integrate Interpolate Invert Join Judge Keep Kill Lay Learn Leave
Limit Link List Listen Load Lock Log Look Lower Make Map Mark Match Measure Merge Mix Modulate Mount Move Multiply Mute
Name Normalize Note Open Optimise Order Pack Parse Pass Pause Perform Place Plan Play Predict Prefetch Prepare Press
Pretend Print Process Project Publish Put Queue Raise Read Receive Record Reduce Refine Refuse Register Release
Remember Remove Rename Render Reopen Repeat Replace Report Resample Reset Resolve Restart Restore Resume Retune Return
Ring Roll Round Run Sample Save Say Scale Schedule Seek Select Send Sense Serve Set Shake Show Shut Simulate Skip Slide
Smooth Solve Sort Spend Spin Split Stand Start Steer Step Stop Store Stretch Strike Subtract Sum Summarise Switch
Synthesize Take Tell Test Thin Throw Tie Topple Touch Transform Translate Try Unbind Undo Update Use Validate Verify
Wait Wake Warn Watch Weigh Write Yield
"""
VERBS = frozenset(_VERBS.split())
"""Verbs that functions open with. The list grows: add the verb that you need."""

_CLAUSES = """
what where how when which that whether who whose whom why if as while so than and but or nor because until unless though
although since after before however also once
"""
_PREPOSITIONS = """
of by from for at in on to with without within over under up between through among against above below beyond during
into out off behind beside
"""
_PRONOUNS = "it they he she this that these those there its their theirs"
_AUXILIARIES = "have has had let lets is are was were does did can could may might must shall should will would not"
REFUSED = frozenset(f"{_CLAUSES} {_PREPOSITIONS} {_PRONOUNS} {_AUXILIARIES}".split())
"""Words that open neither a noun phrase nor a command."""

_Function = ast.FunctionDef | ast.AsyncFunctionDef


def docstrings(tree: ast.Module) -> Iterator[tuple[ast.AST, ast.Constant]]:
    """Yield each module, class, function and assignment that has a docstring, with it."""
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body:
            if isinstance(node, ast.Module | ast.ClassDef | _Function) and (text := _string(body[0])):
                yield node, text
            for statement, after in pairwise(body):
                if isinstance(statement, ast.Assign | ast.AnnAssign) and (text := _string(after)):
                    yield statement, text


def _string(node: ast.AST) -> ast.Constant | None:
    """Return the string that stands as a statement by itself, or None."""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
        return node.value
    return None


def fault(node: ast.AST, text: str) -> str | None:
    """Say why the docstring of `node` may not open as it does, or return None."""
    word = (text.split() or [""])[0].rstrip(".,:;")
    if isinstance(node, _Function) and not _stands_for_a_noun(node):
        if word not in VERBS and not (word == "True" and text.split()[1:2] in (["if"], ["for"], ["where"], ["once"])):
            return f"opens with '{word}': expected a verb that {Path(__file__).name} lists, or 'True if'"
    elif word.lower() in REFUSED or not word:
        return f"opens with '{word}': expected a noun phrase, or in a test a sentence that begins with its subject"
    return None


def _stands_for_a_noun(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """True if a function is a test, which states a fact, or a property or fixture, which is used as a value."""
    decorators = " ".join(map(ast.unparse, function.decorator_list))
    return function.name.startswith("test_") or "property" in decorators or "fixture" in decorators


def faults(text: str, name: str) -> list[str]:
    """List the faults in the text of a file, each in one line with its place."""
    found = ((part, fault(node, str(part.value))) for node, part in docstrings(ast.parse(text)))
    return [f"{name}:{part.lineno}: the docstring {why}" for part, why in found if why]


def main() -> None:
    paths = [path for folder in FOLDERS for path in sorted((ROOT / folder).rglob("*.py"))]
    found = [line for path in paths for line in faults(path.read_text("utf-8"), path.relative_to(ROOT).as_posix())]
    sys.exit("\n".join(found) or None)


if __name__ == "__main__":
    main()
