"""Tables of the keys of gestures and addresses, in Markdown, for the pages and for `help`."""

from collections.abc import Iterable

from ...dsp.macros import MACROS
from ...dsp.schema import GESTURES, LAW, gestures_steered_by
from ...dsp.schema import Parameter as Number
from .addresses import KEYS, STRIKE, VERBS
from .arguments import Either, Key, Note, Numbers, Vector, Word
from .points import CHANGE

_HEAD = "| key | range | default | meaning |\n|---|---|---|---|"
_STEERED = "| key | range | default | steered | meaning |\n|---|---|---|---|---|"


def gesture_table(name: str) -> str:
    """Return the argument and the keys of a gesture, but for those that all gestures share."""
    gesture = GESTURES[name]
    shared = {key.name for key in STRIKE}
    own = [key for key in KEYS[name] if key.name not in shared or gesture.what]
    argument = [VERBS[f"/object/NAME/{name}"].required[0] if gesture.what else gesture.argument]
    rows = [_row(key, "yes" * (key.name in gesture.steerable)) for key in (*argument, *own)]
    return "\n".join([_STEERED, *dict.fromkeys(rows)])


def shared_table() -> str:
    """Return the keys that all gestures share, and the position."""
    position = VERBS["/object/NAME/impact"].named["position"]
    steered = dict.fromkeys(("position", "point", "gain"), "yes")
    steered |= {key.name: ", ".join(gestures_steered_by(key.name)) for key in LAW}
    return "\n".join([_STEERED, *(_row(key, steered.get(key.name, "")) for key in (position, *STRIKE))])


def macro_table() -> str:
    """Return the macros: their ends, controllers and laws."""
    lines = ["| macro | at 0 | at 1 | MIDI | effect at the value m |\n|---|---|---|---|---|"]
    for name, each in MACROS.items():
        lines.append(f"| `{name}` | {each.ends[0]} | {each.ends[1]} | {each.controller} | {_sentence(each.law)} |")
    return "\n".join(lines)


def change_table() -> str:
    """Return the keys of what takes its time."""
    return key_rows(CHANGE)


def key_rows(keys: Iterable[Key]) -> str:
    """Return a table of keys."""
    return "\n".join([_HEAD, *map(_row, keys)])


def _row(key: Key, steered: str | None = None) -> str:
    cells = [
        f"`{key.name}`",
        range_of(key),
        default_of(key),
        *([] if steered is None else [steered]),
        _sentence(key.help),
    ]
    return f"| {' | '.join(cells)} |"


def _sentence(help: str) -> str:
    return f"{help[:1].upper()}{help[1:]}{'.' * (help != '')}"


def range_of(key: Key) -> str:
    """Return the values that a key may have."""
    match key:
        case Number():
            return key.allowed + (f", usually {key.useful[0]:g} to {key.useful[1]:g}" if key.useful else "")
        case Either():
            return ", ".join(f"`{word}`" for word in key.words) if len(key.words) < 10 else "a number or a name"
        case Note():
            return "0 to 127, or a name such as C#4"
        case Vector():
            return f"three numbers of {key.axes[0].bounds}"
        case Numbers():
            return f"up to {key.most} numbers of {key.number.bounds}"
        case Word():
            return "a name"


def default_of(key: Key) -> str:
    """Return the value of a key that is not given; "" where there is none."""
    if isinstance(key, Number) and key.default is not None:
        return f"{key.default:g}"
    return key.otherwise if isinstance(key, Number | Word | Either) else ""
