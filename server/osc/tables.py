"""The tables of addresses and of keys in the pages of server/; `python -m carom.server.osc.tables` prints them."""

from ...dsp.schema import Parameter as Number
from .addresses import KEYS, NOTE, PITCH, STRIKE, VERBS
from .arguments import Key, Verb
from .midi_verbs import MIDI
from .points import CHANGE, Change, Move
from .sensor_verbs import SENSORS
from .space_verbs import LISTENING, PLACING
from .world_verbs import WORLD


def table() -> str:
    """Return two Markdown tables: all addresses, and the keys of gestures."""
    return f"{address_table()}\n\n{key_table()}"


def address_table() -> str:
    """Return every address, its arguments and its meaning, as a Markdown table."""

    def listed(verb: Verb) -> str:
        if isinstance(verb, Change | Move):
            return "; keys: a change's"
        shared = len(STRIKE) if verb.keys[: len(STRIKE)] == STRIKE else 0
        whole = verb.keys if verb in (*WORLD, *MIDI, *SENSORS, *LISTENING, PLACING) else (NOTE, PITCH)
        own = [_marked(key) if key in whole else f"`{key.name}`" for key in verb.keys[shared:]]
        keys = ["a gesture's"] * bool(shared) + own
        return f"; keys: {', '.join(keys)}" if keys else ""

    lines = ["| address | arguments | does |", "|---|---|---|"]
    for verb in VERBS.values():
        many = [f"[{_marked(verb.many)}]"] if verb.many else []
        optional = [f"[{_marked(number)}]" for number in verb.optional]
        arguments = ", ".join([*map(_marked, verb.required), *optional, *many])
        lines.append(f"| `{verb.address}` | {arguments}{listed(verb)} | {verb.help} |")
    return "\n".join(lines)


def key_table() -> str:
    """Return the keys of gestures, as a Markdown table."""
    keys: dict[str, list[str]] = {_row(key): ["all"] for key in STRIKE}
    for name, own in KEYS.items():
        for key in own:
            if key not in STRIKE:
                keys.setdefault(_row(key), []).append(name)
    keys |= {_row(key): ["changes"] for key in CHANGE}
    lines = ["| a gesture's key | of | meaning |", "|---|---|---|"]
    lines += [row.format(", ".join(gestures)) for row, gestures in keys.items()]
    return "\n".join(lines)


def _row(key: Key) -> str:
    """Return the row of a gesture's key, with a place for the gestures that take it."""
    return f"| {_marked(key)} | {{}} | {key.help}{default_of(key)} |"


def _marked(parameter: Key) -> str:
    """Return a parameter in Markdown."""
    return str(parameter).replace(parameter.name, f"`{parameter.name}`", 1)


def default_of(parameter: Key) -> str:
    """Say which value a key has that is not given, as the end of its help; "" where it has none of its own."""
    if not isinstance(parameter, Number) or parameter.default is None:
        return ""
    return f"{'; ' * bool(parameter.help)}{parameter.default:g} if not given"


if __name__ == "__main__":
    print(table())
