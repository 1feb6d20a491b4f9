"""The methods of gestures and objects, as editors and mypy read them: `clients/gesture_methods.pyi`."""

import ast
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path
from textwrap import wrap

from carom.clients import actions
from carom.clients.actions import Actions
from carom.clients.gesture_methods import Gestures, ObjectMethods
from carom.dsp.schema import GESTURES, Gesture, Parameter
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Key, Vector

STUB = Path(__file__).parents[2] / "clients" / "gesture_methods.pyi"

_HEAD = '''\
"""The methods of gestures and objects, with their keys; `make documents` writes this."""

from collections.abc import Callable, Sequence
from typing import Any, SupportsFloat, TypedDict, TypeVar

from typing_extensions import Unpack

Value = Any

_Class = TypeVar("_Class", bound=type)

def with_gestures(cls: _Class) -> _Class: ...
def with_methods_of(scene: type) -> Callable[[_Class], _Class]: ...
'''
_GIVEN = "position: SupportsFloat | None = None, at: SupportsFloat | None = None"


def stub() -> str:
    """Return the text of the stub."""
    keys = {name: VERBS[f"/object/NAME/{name}"].keys for name in GESTURES}
    shared = [key for key in keys["impact"] if all(key.name in {each.name for each in own} for own in keys.values())]
    names = {key.name for key in shared}
    parts = [_HEAD, _record("Keys", "TypedDict, total=False", "Keys of all gestures.", shared)]
    for name, own in keys.items():
        more = [key for key in own if key.name not in names]
        parts.append(_record(f"{name.title()}Keys", "Keys, total=False", f"Keys of {name}.", more))
    gestures = GESTURES.values()
    parts.append(_class(Gestures, (_method(each, "name: str, ") for each in gestures)))
    parts.append(_class(ObjectMethods, [*(_method(each, "") for each in gestures), *_on_objects()]))
    formatter = [sys.executable, "-m", "ruff", "format", "--stdin-filename", str(STUB), "-"]
    return subprocess.check_output(formatter, input="\n".join(parts), text=True)


def _record(name: str, bases: str, doc: str, keys: Iterable[Key]) -> str:
    fields = (f"    {key.name}: {_kind(key)}\n" for key in keys)
    return f'class {name}({bases}):\n    """{doc}"""\n\n' + "".join(fields)


def _kind(key: Key) -> str:
    """Return the type of a key's values."""
    if isinstance(key, Vector):
        return "Sequence[SupportsFloat]"
    return "SupportsFloat" if isinstance(key, Parameter) else "str"


def _class(cls: type, methods: Iterable[str]) -> str:
    return f'class {cls.__name__}:\n    """{cls.__doc__}"""\n\n' + "".join(methods)


def _method(gesture: Gesture, first: str) -> str:
    argument = "what: str" if gesture.what else f"{gesture.argument.name}: SupportsFloat | None = None"
    given = f"{first}{argument}, {_GIVEN}"
    doc = f"Begin a gesture that {gesture.help.replace(' it', ' the object', 1)}."
    return _definition(gesture.name, ["self", *given.split(", "), f"**keys: Unpack[{gesture.name.title()}Keys]"], doc)


def _on_objects() -> Iterable[str]:
    """Yield the methods of Actions on objects, without the name."""
    classes = [each for each in ast.parse(Path(actions.__file__).read_text()).body if isinstance(each, ast.ClassDef)]
    for each in (each for cls in classes if cls.name == Actions.__name__ for each in cls.body):
        if (
            isinstance(each, ast.FunctionDef)
            and each.name[0] != "_"
            and [a.arg for a in each.args.args][1:2] == ["name"]
        ):
            del each.args.args[1]
            doc = (ast.get_docstring(each) or "").partition("\n")[0]
            yield _definition(each.name, ast.unparse(each.args).split(", "), doc)


def _definition(name: str, given: Iterable[str], doc: str) -> str:
    lines = "\n        ".join(wrap(doc, 105))
    return f'    def {name}({", ".join(given)}) -> None:\n        """{lines}"""\n\n'
