"""The methods of gestures and objects, and the keys of all methods, as editors and mypy read them:
`clients/gesture_methods.pyi`."""

import ast
import subprocess
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from textwrap import wrap

from carom.clients import actions
from carom.clients.actions import Actions
from carom.clients.gesture_methods import Gestures, ObjectMethods
from carom.dsp.macros import MACROS
from carom.dsp.schema import GESTURES, Gesture, Parameter
from carom.presets.schema import OBJECT, REST, SHAPES, SIZED, STRIKE
from carom.presets.values import Choice, Domain, Made, Many, Row, Rows, Text
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Key, Note, Numbers, Vector

STUB = Path(__file__).parents[2] / "clients" / "gesture_methods.pyi"

_HEAD = '''\
"""The methods of gestures and objects, with their keys; `make documents` writes this."""

from collections.abc import Callable, Sequence
from typing import Any, SupportsFloat, TypedDict, TypeVar

from numpy.typing import ArrayLike
from typing_extensions import Unpack

Value = Any

_Class = TypeVar("_Class", bound=type)

def with_gestures(cls: _Class) -> _Class: ...
def with_shared_help(cls: _Class) -> _Class: ...
def with_methods_of(scene: type) -> Callable[[_Class], _Class]: ...
'''
_VERBS = {
    "Ramp": "/object/NAME/gain",
    "Place": "/object/NAME/place",
    "Note": "/object/NAME/note",
    "Sensor": "/sensor/new",
    "Listener": "/listener",
    "Floor": "/floor",
    "Room": "/room",
    "Pair": "/world/pair",
}
"""An address for each set of keys of other methods."""
_LIST = "Sequence[SupportsFloat]"
_TYPED = "TypedDict, total=False"
_OF_ALL = ("material", "level", "stereo_width", "most_modes", "glide")  # keys of objects of any shape
_APART = ("material", "size")  # keys of objects that are arguments of World.body
_BODY = {"inertia": "ArrayLike", "surface": "bool"}  # what a World is told of a body, and not by a message
_GIVEN = "position: SupportsFloat | None = None, at: SupportsFloat | None = None"


def stub() -> str:
    """Return the text of the stub."""
    keys = {name: VERBS[f"/object/NAME/{name}"].keys for name in GESTURES}
    common = [key for key in keys["impact"] if all(key.name in {each.name for each in own} for own in keys.values())]
    names = {key.name for key in common}
    parts = [_HEAD, _record("Keys", _TYPED, "Keys of all gestures.", common)]
    for name, own in keys.items():
        more = [key for key in own if key.name not in names]
        parts.append(_record(f"{name.title()}Keys", "Keys, total=False", f"Keys of {name}.", more))
    for name, address in _VERBS.items():
        parts.append(_record(f"{name}Keys", _TYPED, f"Keys of `{address}`.", VERBS[address].keys))
    objects = {**_of_presets(), **_kinds(VERBS["/object/new"].keys)}
    bodies = {**_kinds(VERBS["/world/body"].keys), **_BODY}
    own = {key: kind for key, kind in objects.items() if key in _APART}
    shared = {key: kind for key, kind in objects.items() if key not in _APART}
    parts.append(_fields("ObjectKeys", _TYPED, "Keys of objects and bodies, and of presets of all shapes.", shared))
    parts.append(_fields("NewKeys", "ObjectKeys, total=False", "Keys of objects.", own))
    more = {key: kind for key, kind in bodies.items() if key not in shared}
    parts.append(_fields("BodyKeys", "ObjectKeys, total=False", "Keys of bodies.", more))
    steered = {address.rpartition("/")[2]: verb.required for address, verb in VERBS.items() if "/ID/" in address}
    kinds = {name: _LIST if len(values) > 1 else "SupportsFloat" for name, values in steered.items() if values}
    parts.append(_fields("SteerKeys", _TYPED, "What a gesture may be steered by.", kinds))
    macros = dict.fromkeys(MACROS, f"SupportsFloat | {_LIST}")
    parts.append(_fields("MacroKeys", _TYPED, "The macros of an object.", macros))
    gestures = GESTURES.values()
    parts.append(_class(Gestures, (_method(each, "name: str, ") for each in gestures)))
    parts.append(_class(ObjectMethods, [*(_method(each, "") for each in gestures), *_on_objects()]))
    formatter = [sys.executable, "-m", "ruff", "format", "--stdin-filename", str(STUB), "-"]
    return subprocess.check_output(formatter, input="\n".join(parts), text=True)


def _record(name: str, bases: str, doc: str, keys: Iterable[Key]) -> str:
    return _fields(name, bases, doc, _kinds(keys))


def _fields(name: str, bases: str, doc: str, kinds: Mapping[str, str]) -> str:
    fields = (f"    {key}: {kind}\n" for key, kind in kinds.items())
    return f'class {name}({bases}):\n    """{doc}"""\n\n' + "".join(fields)


def _kinds(keys: Iterable[Key]) -> dict[str, str]:
    """Return the types of keys' values."""
    return {key.name: _kind(key) for key in keys}


def _kind(key: Key) -> str:
    if isinstance(key, Vector):
        return _LIST
    if isinstance(key, Numbers):
        return "ArrayLike"
    if isinstance(key, Note):
        return "str | SupportsFloat"
    return "SupportsFloat" if isinstance(key, Parameter) else "str"


def _of_presets() -> dict[str, str]:
    """Return the types of what may change in a preset of any shape."""
    fields: dict[str, Domain] = {**STRIKE, **SIZED, "rest": REST["support"]}
    for shape in SHAPES.values():
        fields |= {**shape.fields, **shape.damping}
    fields |= {name: OBJECT[name] for name in _OF_ALL}
    return {name: _of_domain(domain) for name, domain in fields.items() if not isinstance(domain, Made)}


def _of_domain(domain: Domain) -> str:
    """Return the type of a preset's values. A list may be a text, too."""
    if isinstance(domain, Text | Choice):
        return "str"
    if isinstance(domain, Row | Many | Rows):
        return "str | ArrayLike"
    return "SupportsFloat"


def _class(cls: type, methods: Iterable[str]) -> str:
    return f'class {cls.__name__}:\n    """{cls.__doc__}"""\n\n' + "".join(methods)


def _method(gesture: Gesture, first: str) -> str:
    argument = "what: str" if gesture.what else f"{gesture.argument.name}: SupportsFloat | None = None"
    given = f"{first}{argument}, {_GIVEN}"
    doc = f"Begin a gesture that {gesture.help}."
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
