"""The address space: every address, declared once for checking, for the README, for OSCQuery and for clients.

`python -m carom.server.osc.addresses` prints it as the README's tables.
"""

from dataclasses import dataclass
from functools import lru_cache

from ...dsp.schema import (
    BY_POSITION,
    BY_RADIUS,
    GAIN,
    GESTURES,
    LAW,
    POSITION,
    SETTINGS,
    STEERABLE,
    gestures_steered_by,
)
from ...dsp.schema import (
    Parameter as Number,
)
from .arguments import Either, Parameter, Refused, Verb, Word
from .patterns import is_pattern, match
from .wire import Message

STRIKER = Word("striker", "a preset; the object's own if none is given")

STRIKE: tuple[Number | Word, ...] = (
    STRIKER,
    *LAW,
    Word("by", "an object that strikes, and rings too"),
    BY_POSITION,
    BY_RADIUS,
    GAIN,
    Word("id", "names the gesture, for `/gesture/ID/...` and `/gesture/end`"),
)
"""Keys that every gesture takes."""

_WORDS = {"roll": (Word("surface", "a preset; wood if none is given"),)}
"""Keys of gestures that are not numbers."""

_SHARED = {key.name for key in STRIKE}
KEYS: dict[str, tuple[Number | Word, ...]] = {
    name: (*(key for key in gesture.keys if key.name not in _SHARED), *_WORDS.get(name, ()))
    for name, gesture in GESTURES.items()
}
"""The keys of each gesture besides those that every gesture takes."""


def _steers(name: str) -> str:
    """What a steerable parameter does: "steers a bounce (from its next flight on) or a roll"."""
    named = [
        f"{'an' if gesture == 'impact' else 'a'} {gesture}{f' ({number.steered})' if number.steered else ''}"
        for gesture, number in gestures_steered_by(name).items()
    ]
    return f"steers {', '.join(named[:-1])} or {named[-1]}" if named[1:] else f"steers {named[0]}"


_OBJECTS = (
    Verb(
        "/object/new",
        "makes an object from a preset; further keys change the preset (length, material, ...)",
        (Word("name"), Word("preset")),
        keys=(*SETTINGS.values(), POSITION, STRIKER),
        open_keys=True,
    ),
    *(
        Verb(f"/object/NAME/{name}", gesture.help, (gesture.argument,), (POSITION,), (*STRIKE, *KEYS[name]))
        for name, gesture in GESTURES.items()
    ),
    *(Verb(f"/object/NAME/{name}", setting.help, (setting,)) for name, setting in SETTINGS.items()),
    Verb(
        "/object/NAME/free",
        "removes it once silent, or with 1 at once (a 70 ms fade); its name is free",
        optional=(Number("at_once", 0, 1, default=0),),
    ),
)

_RUNNING = (
    Verb("/gesture/ID/stop", "ends it: a bouncing striker does not come back, a rolling body halts, a hand lets go"),
    *(
        Verb(f"/gesture/ID/{name}", _steers(name), (next(iter(gestures_steered_by(name).values())),))
        for name in STEERABLE
    ),
)

_ENGINE = (
    Verb(
        "/accuracy",
        "how exact contacts with objects that yield are from now on: -40, -60 (dB, the default), -80 or exact",
        (Either("accuracy", ("-40", "-60", "-80", "exact")),),
    ),
    Verb(
        "/quality",
        "how much is computed from now on; each step adds to those before it. 0: everything. 1: coupled contacts "
        "take one step per sample. 2: modes below -80 dB rest. 3: rolls have fewer micro-impacts. 4: objects "
        "untouched for 0.5 s fade out. 5, 6, 7, 8: only the newest 32, 16, 8, 4 bounces, rolls and presses run; older "
        "ones wait. Under load the server goes further by itself",
        (Number("quality", 0, 8, whole=True),),
    ),
    Verb(
        "/contact",
        "how contacts are solved from now on: closed (exact, the default), am1, verlet, heun or rk4",
        (Word("method"),),
        (Number("oversampling", 1, 64, default=1, whole=True),),
        (Word("correction", "none, hybrid, release, both, paper-release, paper-both"),),
    ),
    Verb("/panic", "silences everything at once; objects stay"),
)

_SERVER = (
    Verb("/status", "answers /status.reply", scored=False),
    Verb("/version", "answers /version.reply name major minor patch", scored=False),
    Verb(
        "/sync",
        "answers /synced id once everything sent before it is done",
        (Number("id", -(2**31), 2**31 - 1),),
        scored=False,
    ),
    Verb("/notify", "1: sends you /warning text from now on; 0: no more", (Number("on", 0, 1),), scored=False),
    Verb("/dump", "1: prints every message that arrives; 0: no more", (Number("on", 0, 1),), scored=False),
    Verb("/quit", "ends the server", scored=False),
)

VERBS = {verb.address: verb for verb in (*_OBJECTS, *_RUNNING, *_ENGINE, *_SERVER)}


@dataclass(frozen=True)
class Call:
    """A message to one verb (None: nothing has its address), and the part of its address that stands for NAME or ID,
    perhaps a pattern."""

    message: Message
    verb: Verb | None
    target: str = ""


def calls(message: Message) -> list[Call]:
    """The calls that a message makes: one for each verb that its address, perhaps a pattern, matches.

    A pattern never matches /quit: nobody who sends to every address wants to end the server. An address that nothing
    has makes one call, without a verb.
    """
    if not is_pattern(message.address):
        return [_named(message)]
    return [_named(Message(address, message.args)) for address in _matched(message.address)] or [Call(message, None)]


_TARGETED = {tuple(address.split("/")[1::2]): verb for address, verb in VERBS.items() if address.count("/") == 3}
"""Verbs with a NAME or an ID, by the parts before and after it."""


def _named(message: Message) -> Call:
    parts = message.address.split("/")
    if len(parts) == 4:
        return Call(message, _TARGETED.get((parts[1], parts[3])), parts[2])
    return Call(message, VERBS.get(message.address))


@lru_cache(maxsize=64)
def _matched(pattern: str) -> list[str]:
    """The addresses that a pattern matches; only the part for a NAME or an ID is still the pattern's."""
    parts = pattern.split("/")
    candidates = (verb.split("/") for verb in VERBS if verb != "/quit")
    return [
        "/".join(given if known.isupper() else known for given, known in zip(parts, verb, strict=True))
        for verb in candidates
        if len(verb) == len(parts)
        and all(known.isupper() or match(given, known) for given, known in zip(parts, verb, strict=True))
    ]


def unknown(address: str) -> Refused:
    """The error for an address that nothing has."""
    parts = address.split("/")
    if len(parts) == 4:
        actions = [verb.action for (container, _), verb in _TARGETED.items() if container == parts[1]]
        if actions:
            return Refused(f"unknown action '{parts[3]}'; expected {', '.join(actions)}")
    return Refused(f"no such address; expected one of {', '.join(VERBS)}")


def table() -> str:
    """The address space as two Markdown tables: addresses, and the keys of gestures."""

    def listed(verb: Verb) -> str:
        shared = len(STRIKE) if verb.keys[: len(STRIKE)] == STRIKE else 0
        keys = ["a gesture's"] * bool(shared) + [f"`{key.name}`" for key in verb.keys[shared:]]
        return f"; keys: {', '.join(keys)}" if keys else ""

    lines = ["| address | arguments | does |", "|---|---|---|"]
    for verb in VERBS.values():
        arguments = ", ".join([*map(_marked, verb.required), *(f"[{_marked(number)}]" for number in verb.optional)])
        lines.append(f"| `{verb.address}` | {arguments}{listed(verb)} | {verb.help} |")
    keys: dict[str, list[str]] = {_row(key): ["all"] for key in STRIKE}
    for name, own in KEYS.items():
        for key in own:
            keys.setdefault(_row(key), []).append(name)
    lines += ["", "| a gesture's key | of | meaning |", "|---|---|---|"]
    lines += [row.format(", ".join(gestures)) for row, gestures in keys.items()]
    return "\n".join(lines)


def _row(key: Parameter) -> str:
    """The row of a gesture's key, with a place for the gestures that take it."""
    return f"| {_marked(key)} | {{}} | {key.help}{_default(key)} |"


def _marked(parameter: Parameter) -> str:
    """A parameter in Markdown."""
    return str(parameter).replace(parameter.name, f"`{parameter.name}`", 1)


def _default(parameter: Parameter) -> str:
    if not isinstance(parameter, Number) or parameter.default is None:
        return ""
    return f"{'; ' * bool(parameter.help)}{parameter.default:g} if not given"


if __name__ == "__main__":
    print(table())
