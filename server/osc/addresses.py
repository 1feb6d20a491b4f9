"""The address space: every address, declared once for checking, for the documents, for OSCQuery and for clients."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, lru_cache
from typing import NamedTuple

from ...dsp.contact.accuracy import LEVELS, NUMBERS
from ...dsp.schema import (
    BY_DIRECTION,
    BY_POINT,
    BY_POSITION,
    BY_RADIUS,
    CHANNELS,
    DIRECTION,
    FORMS,
    FULL_SCALE,
    GAIN,
    GESTURES,
    LAW,
    MAIN_GAIN,
    OWN_GAIN,
    POINT,
    POSITION,
    RESISTANCE,
    RESTITUTION,
    ROOM,
    SENSED,
    SETTINGS,
    STEERABLE,
    STEPS,
    Gesture,
    gestures_steered_by,
)
from ...dsp.schema import (
    Parameter as Number,
)
from ...dsp.wording import near
from .arguments import Either, Note, Numbers, Refused, Vector, Verb, Word
from .macro_verbs import MACRO_VERBS
from .midi_verbs import MIDI
from .patterns import is_pattern, match
from .points import Change, Move
from .questions import QUESTIONS
from .sensor_verbs import SENSORS
from .space_verbs import LISTENING, PLACING
from .wire import MOST_PORT, Message
from .world_verbs import WORLD

STRIKER = Word("striker", "preset of the striker", "the object's usual one for this gesture, or else for strikes")

ON_SURFACE = Vector(
    "point", POINT, "point in the object's frame, in place of `position`; the nearest surface point counts"
)
BY_ON_SURFACE = Vector("by_point", BY_POINT, "point on the other object, which strikes or supports")
_DIRECTED = Vector("direction", DIRECTION, "direction of the force at `point`, in place of the normal")
_SLIPPING = Vector("direction", DIRECTION, "direction of the slip at `point`; `force` still acts along the normal")
_BY_DIRECTED = Vector("by_direction", BY_DIRECTION, "direction of the force on the striking object, at `by_point`")
PLAY = Number(
    "play", 0, 1, "", "1: with make-up, an automatic gain; 0: at the physical level", whole=True,
    otherwise="the setting of `/play`",
)  # fmt: skip
STRIKE: tuple[Number | Word | Vector, ...] = (
    STRIKER,
    *LAW,
    RESTITUTION,
    Word("by", "name of another object that strikes; it rings, too"),
    ON_SURFACE,
    BY_POSITION,
    BY_ON_SURFACE,
    BY_RADIUS,
    GAIN,
    PLAY,
    Word("id", "name of the gesture, for `/gesture/ID/...` and `/gesture/end`"),
)
"""Keys that every gesture takes."""

_SURFACE = Word("surface", "preset of the surface", "the object's usual one for this gesture, or else wood")
_PRESS = Word("press", "id of a press on the same object; the press's force is the normal force")
_ONTO = Word(
    "onto",
    "name of the object on which the pieces fall, or `none`",
    "`floor`; if missing, it is made from `wooden-floor`",
)


def _is_pushed(gesture: Gesture) -> bool:
    """True if a gesture is one blow, which has a direction on both objects."""
    return gesture.single and not gesture.breaks


_WORDS: dict[str, tuple[Word | Vector, ...]] = {
    name: (
        *((_SURFACE,) if gesture.along else ()),
        *((_PRESS,) if gesture.slips else ()),
        *((_ONTO,) if gesture.breaks else ()),
        *((_SLIPPING,) if gesture.slips else (_DIRECTED, _BY_DIRECTED) if _is_pushed(gesture) else ()),
    )
    for name, gesture in GESTURES.items()
}
"""Keys of gestures that are not numbers."""

_RESTING: tuple[Number | Word | Vector, ...] = (ON_SURFACE, BY_ON_SURFACE, BY_RADIUS, RESISTANCE, STRIKE[-1])
_SHARED = {key.name for key in STRIKE}
KEYS: dict[str, tuple[Number | Word | Vector, ...]] = {
    name: (*gesture.keys[: len(LAW)], *_RESTING, gesture.argument, *gesture.keys[len(LAW) :])
    if gesture.what
    else (*(key for key in gesture.keys if key.name not in _SHARED), *_WORDS.get(name, ()))
    for name, gesture in GESTURES.items()
}
"""The keys of each gesture besides those that every gesture takes that strikes; of one that names what, all of them."""


def _steers(name: str) -> str:
    """Describe the effect of a steerable parameter: "steers a bounce (from its next flight on) or a roll"."""
    named = [
        f"{'an' if gesture[0] in 'aeiou' else 'a'} {gesture}{f' ({number.steered})' if number.steered else ''}"
        for gesture, number in gestures_steered_by(name).items()
    ]
    return f"steers {', '.join(named[:-1])} or {named[-1]}" if named[1:] else f"steers {named[0]}"


def _steering(name: str) -> Number:
    """Return the number that steers gestures; its useful range covers that of each."""
    numbers = tuple(gestures_steered_by(name).values())
    ranges = [number.useful for number in numbers if number.useful]
    covers = (min(low for low, _ in ranges), max(high for _, high in ranges)) if len(ranges) == len(numbers) else None
    return replace(numbers[0], useful=covers)


def _begins(gesture: Gesture) -> Verb:
    """Return the verb that begins a gesture."""
    address, keys = f"/object/NAME/{gesture.name}", KEYS[gesture.name]
    if gesture.what:
        return Verb(address, gesture.help, (Word("what", gesture.what),), (POSITION,), keys)
    return Verb(address, gesture.help, (), (gesture.argument, POSITION), (*STRIKE, *keys))


GAINS = Numbers(OWN_GAIN, int(CHANNELS.high), "gains", "gain factor of each channel, in place of the pan")
NOTE = Note("note", "note of the lowest mode, or of the string; `tune` counts from there")
PITCH = Number("pitch", 1.0, 20_000.0, "Hz", "pitch, in place of a note", useful=(30.0, 4_000.0))
VELOCITY = Number("velocity", 0, 127, "", "MIDI velocity", useful=(1, 127))

_OBJECTS = (
    Verb(
        "/object/new",
        "makes an object from a preset; the preset's own keys, such as `length` or `material`, change its values",
        (Word("name", "name of the new object"), Word("preset", "name of its preset")),
        keys=(*SETTINGS.values(), GAINS, POSITION, STRIKER, NOTE, PITCH),
        open_keys=True,
    ),
    *(_begins(gesture) for gesture in GESTURES.values()),
    *(Change(f"/object/NAME/{name}", setting.help, (setting,)) for name, setting in SETTINGS.items()),
    *MACRO_VERBS,
    Verb(
        "/object/NAME/gains",
        "sets a gain factor for each channel, in place of the pan; without arguments, restores the pan",
        many=GAINS,
    ),
    PLACING,
    Verb(
        "/object/NAME/note",
        "strikes NAME.NOTE, a copy of the object tuned to the note; MIDI velocities 1 to 127 become 0.05 to 5 m/s",
        (NOTE, VELOCITY),
        (POSITION,),
        (STRIKER, PLAY),
    ),
    Verb(
        "/object/NAME/free",
        "removes the object and its `note` copies once silent; its name can be used again immediately",
        optional=(Number("at_once", 0, 1, "", "1: removes it immediately, with a short fade", default=0, whole=True),),
    ),
)

_RUNNING = (
    Verb(
        "/gesture/ID/stop",
        "ends the gesture: a bouncing striker is caught, a rolling or sliding body halts, a hand lets go",
    ),
    *(Change(f"/gesture/ID/{name}", _steers(name), (_steering(name),)) for name in STEERABLE),
    Move(
        "/gesture/ID/point",
        "moves a gesture to the surface point nearest to x y z, or along `[x y z x y z ...]`",
        POINT,
    ),
    Move(
        "/gesture/ID/by_point",
        "in a rest, moves the contact to the other object's surface point nearest to by_x by_y by_z",
        BY_POINT,
    ),
)

_ENGINE = (
    Verb(
        "/accuracy",
        "sets the error that is allowed in the sound of contacts",
        (Either("accuracy", LEVELS, "error of the sound, dB", "-60", tuple(NUMBERS)),),
    ),
    Verb(
        "/quality",
        "sets how much of the sound is left out to save time, from 0 (nothing) to 8; a loaded server leaves out more",
        (Number("quality", 0, 8, "", "quality number; higher numbers leave out more", whole=True),),
    ),
    Verb(
        "/bank",
        "sets the number format in which the modes of untouched objects are computed",
        (Either("bank", FORMS, "number format: float64, or float32 for speed", "float64"),),
    ),
    Verb(
        "/budget",
        "bounds the computing time of coupled contacts, in which the object gives way. Default: no bounds (`0 0`) in "
        "scores, `16 8192` in servers",
        (STEPS, ROOM),
    ),
    Change("/gain", "sets the level of everything", (MAIN_GAIN,)),
    Verb(
        "/limiter",
        "turns the limiter on or off; the limiter keeps true peaks below about -1 dB of full scale",
        (Either("limiter", ("on", "off", "1", "0"), "on or off", "on"),),
    ),
    Verb(
        "/headroom",
        "turns headroom, an automatic gain before the limiter, on or off. Default: on in servers, off in scores",
        (Either("headroom", ("on", "off", "1", "0"), "on or off", "on"),),
    ),
    Verb(
        "/play",
        "turns make-up, an automatic gain that makes all strikers audible, on or off for later gestures",
        (Either("play", ("on", "off", "1", "0"), "on or off", "off"),),
    ),
    Verb(
        "/channels",
        "sets a score's number of channels; a server accepts only the number it was started with",
        (CHANNELS,),
    ),
    Verb(
        "/sensors",
        "sets how many channels a score has for sensors; a server accepts only the number it was started with",
        (SENSED,),
    ),
    Verb(
        "/full_scale",
        "sets which pressure is full scale in a score; a server accepts only the pressure it was started with",
        (FULL_SCALE,),
    ),
    Verb("/end", "ends a score's render at this message's time; servers ignore this message"),
    Verb("/panic", "ends all gestures; the sound fades, and objects stay"),
)

_SERVER = (
    *(verb for verb, _ in QUESTIONS.values()),
    Verb("/status", "answers with `/status.reply`: nine values, then pairs of name and value", scored=False),
    Verb("/version", "answers with `/version.reply name major minor patch`", scored=False),
    Verb(
        "/sync",
        "answers with `/synced id` once everything that was sent before is done",
        (Number("id", -(2**31), 2**31 - 1, "", "number that the answer repeats", whole=True),),
        scored=False,
    ),
    Verb(
        "/notify",
        "subscribes the sender to warnings and reports",
        (
            Number(
                "level",
                0,
                3,
                "",
                "0: nothing; 1: warnings and ends of gestures; 2: also contacts; 3: also levels",
                whole=True,
            ),
        ),
        (Number("port", 1, MOST_PORT, "", "port for all answers to the sender's datagrams", whole=True),),
        scored=False,
    ),
    Verb(
        "/record",
        "begins or ends a recording in the server's `--recordings` folder. The reply is `/done /record FILE BEGIN` at "
        "the beginning, and `/done /record FILE BEGIN END` at the end; BEGIN and END count samples",
        (Number("on", 0, 1, "", "1 begins, 0 ends", whole=True),),
        keys=(Word("name", "name of the new file", "day and time"),),
        scored=False,
    ),
    Verb(
        "/dump",
        "makes the server print the first 2,000 characters of each message",
        (Number("on", 0, 1, "", "1: on, 0: off", whole=True),),
        scored=False,
    ),
    Verb("/quit", "ends the server", scored=False),
)

VERBS = {verb.address: verb for verb in (*_OBJECTS, *_RUNNING, *SENSORS, *LISTENING, *_ENGINE, *WORLD, *MIDI, *_SERVER)}

GONE = {"/contact": "the sampled methods are in `carom chart` alone, which compares them: leave it out"}
"""Addresses of earlier versions, and what came of each."""

_SHOWN = 60  # characters of what stands in an address, in an error


class Call(NamedTuple):
    """A message to one verb (None: nothing has its address), and the part of its address that stands for NAME or ID,
    perhaps a pattern."""

    message: Message
    verb: Verb | None
    target: str = ""


def calls(message: Message) -> list[Call]:
    """Return the calls that a message makes: one for each verb that its address, perhaps a pattern, matches.

    A pattern never matches /quit: nobody who sends to every address wants to end the server. An address that nothing
    has makes one call, without a verb. An address without arguments takes a button: pressed it calls, let go it makes
    no call.
    """
    if not is_pattern(message.address):
        found = [_named(message)]
    else:
        matched = _matched(message.address)
        found = [_named(Message(address, message.args)) for address in matched] or [Call(message, None)]
    return [_pressed(call) for call in found if not _is_let_go(call)]


def _is_let_go(call: Call) -> bool:
    """True of a button of a control surface that is let go, at an address without arguments: 0 or false."""
    return call.verb is not None and call.verb.is_bare and len(call.message.args) == 1 and _button(call) is False


def _pressed(call: Call) -> Call:
    """Return a call as it is, but for a button that is pressed, at an address without arguments: 1, true, nil or an
    impulse is none."""
    if call.verb is None or not call.verb.is_bare or len(call.message.args) != 1 or not _button(call):
        return call
    return call._replace(message=call.message._replace(args=()))


def _button(call: Call) -> bool | None:
    """Return whether a button is pressed, by its argument; None: it is none."""
    (value,) = call.message.args
    if value is None:
        return True
    return bool(value) if isinstance(value, int | float) and value in (0, 1) else None


_TARGETED = {(parts[1], *parts[3:]): verb for verb in VERBS.values() if len(parts := verb.address.split("/")) > 3}
"""Verbs with a NAME or an ID, by the parts before and after it."""


def _named(message: Message) -> Call:
    parts = message.address.split("/")
    if len(parts) > 3:
        return Call(message, _TARGETED.get((parts[1], *parts[3:])), parts[2])
    return Call(message, VERBS.get(message.address))


@lru_cache(maxsize=64)
def _matched(pattern: str) -> list[str]:
    """Return the addresses that a pattern matches; only the part for a NAME or an ID is still the pattern's."""
    parts = pattern.split("/")
    candidates = (verb.split("/") for verb in VERBS if verb != "/quit")
    return [
        "/".join(given if known.isupper() else known for given, known in zip(parts, verb, strict=True))
        for verb in candidates
        if len(verb) == len(parts)
        and all(known.isupper() or match(given, known) for given, known in zip(parts, verb, strict=True))
    ]


def unknown(address: str) -> Refused:
    """Return the error for an address that nothing has."""
    if address in GONE:
        return Refused(GONE[address])
    first, *rest = address.split(maxsplit=1)
    if rest:
        return Refused(
            f"arguments inside the address: expected the address {first} alone, and {rest[0][:_SHOWN]} as its arguments"
        )
    meant = _meant(address)
    if meant:
        return Refused(f"no such address; did you mean {' or '.join(meant)}?")
    parts = address.split("/")
    above = (*parts[1:2], *parts[3:-1])
    actions = [verb.action for beside, verb in _TARGETED.items() if len(parts) > 3 and beside[:-1] == above]
    if actions:
        return Refused(f"unknown action '{parts[-1]}'; expected {', '.join(actions)}")
    return Refused(f"no such address; expected one of {', '.join(_families())}")


@cache
def _families() -> list[str]:
    """Return the addresses; of several that begin alike only that beginning, as in /gesture/ID/..."""
    families: dict[tuple[str, ...], list[str]] = {}
    for address in VERBS:
        families.setdefault(tuple(address.split("/")[1:-1][:2]), []).append(address)
    alone = families.pop(())
    return [
        *(each[0] if len(each) == 1 else f"/{'/'.join(parts)}/..." for parts, each in families.items()),
        *alone,
    ]


def _meant(address: str) -> list[str]:
    """Return up to two addresses that a wrong one may stand for: its parts are near theirs, or one is missing or
    misplaced."""
    given = [part for part in address.split("/") if part]
    if not 1 <= len(given) <= 3:
        return []
    whole = [verb for verb in VERBS if _are_near(given, verb.split("/")[1:])]
    acting = [verb for parts, verb in _TARGETED.items() if len(parts) == 2]
    exact = [verb for verb in acting if verb.action == given[-1]]
    acting = exact or [verb for verb in acting if _is_near(given[-1], verb.action)]
    there = [verb for verb in acting if len(given) > 1 and _is_near(given[0], verb.address.split("/")[1])]
    if len(given) == 3 and any(given[0] == container for container, *_ in _TARGETED):  # it was not misspelt
        acting = [verb for verb in acting if verb.action == given[-1]]
    found = whole or [_filled(verb.address, given, bool(there)) for verb in there or acting]
    from difflib import SequenceMatcher  # for an error alone

    return sorted(found, key=lambda each: -SequenceMatcher(None, each, address).ratio())[:2]


def _are_near(given: Sequence[str], known: Sequence[str]) -> bool:
    return len(given) == len(known) and all(map(_is_near, given, known))


@lru_cache(maxsize=1_024)
def _is_near(word: str, known: str) -> bool:
    return bool(near(word, [known]))


def _filled(template: str, given: Sequence[str], has_container: bool) -> str:
    """Return the template of an address with the name that was given, if one was."""
    _, container, name, action = template.split("/")
    if len(given) == 3 or (len(given) == 2 and not has_container):
        name = given[-2]
    return f"/{container}/{name}/{action}"
