"""The reference of addresses: a block for each, with its arguments and an example."""

from collections.abc import Iterable

from carom.dsp.macros import MACROS
from carom.dsp.schema import GESTURES, SETTINGS, STEERABLE, gestures_steered_by
from carom.server.osc.addresses import VERBS
from carom.server.osc.arguments import Key, Verb
from carom.server.osc.points import Change, Move
from carom.server.osc.tables import key_rows, range_of
from tests.documents.markdown import table

EXAMPLES = {
    "/object/new": "/object/new bell tubular-bell pan -0.3 size 0.5",
    "/object/NAME/impact": "/object/bell/impact 1.0 0.3 striker wood",
    "/object/NAME/bounce": "/object/plate/bounce 0.2 striker ping-pong id ball",
    "/object/NAME/roll": "/object/pane/roll 0.5 striker glass-marble surface glass travel 0.6 id marble",
    "/object/NAME/press": "/object/gong/press 5 striker felt id hand",
    "/object/NAME/spin": "/object/plate/spin 3 striker coin",
    "/object/NAME/slide": "/object/string/slide 0.2 striker bow force 2 id bow",
    "/object/NAME/rest": "/object/cup/rest table",
    "/object/NAME/rain": "/object/roof/rain 500 id shower",
    "/object/NAME/shake": "/object/cup/shake 60 striker dice speed 0.7 id dice",
    "/object/NAME/crumple": "/object/can/crumple 0.1 striker dents id crush",
    "/object/NAME/pour": "/object/bowl/pour 300 striker rice height 0.1 id rice",
    "/object/NAME/step": "/object/path/step 700 striker gravel",
    "/object/NAME/shatter": "/object/glass/shatter 3 striker glass-shards",
    "/object/NAME/gain": "/object/bell/gain -6 over 0.5",
    "/object/NAME/pan": "/object/bell/pan [-1 1 0] over [0.5 0.5 0.2]",
    "/object/NAME/distance": "/object/bell/distance 4",
    "/object/NAME/tune": "/object/bell/tune -3",
    "/object/NAME/decay": "/object/bell/decay 0.5",
    "/object/NAME/damp": "/object/bell/damp 0.7 over 0.1",
    "/object/NAME/gains": "/object/bell/gains 0.5 0.5 0 1",
    "/object/NAME/place": "/object/bell/place 2 3 0.8 over 3",
    **{f"/object/NAME/macro/{name}": f"/object/bell/macro/{name} 0.7 over 1" for name in MACROS},
    "/object/NAME/dice": "/object/bell/dice",
    "/object/NAME/undo": "/object/bell/undo",
    "/object/NAME/morph": "/object/bar/morph vibraphone-bar 0.3 over 2",
    "/object/NAME/note": "/object/bar/note 69 100",
    "/object/NAME/free": "/object/bell/free",
    "/object/NAME/get": "/object/bell/get 5",
    "/gesture/ID/stop": "/gesture/marble/stop",
    "/gesture/ID/point": "/gesture/marble/point 0.1 0 0.02 over 1",
    "/gesture/ID/by_point": "/gesture/cup/by_point 0.1 0 0",
    "/sensor/new": "/sensor/new tip bar 0.9 preset piezo-27",
    "/sensor/NAME/free": "/sensor/tip/free",
    "/listener": "/listener 0 0 1.6 yaw 90 layout binaural",
    "/floor": "/floor 0",
    "/room": "/room 8 6 3 x -4 y -3 t60 0.5",
    "/accuracy": "/accuracy -50",
    "/quality": "/quality 2",
    "/bank": "/bank float32",
    "/budget": "/budget 16 8192",
    "/gain": "/gain -6 over 2",
    "/limiter": "/limiter off",
    "/play": "/play on",
    "/headroom": "/headroom off",
    "/channels": "/channels 4",
    "/sensors": "/sensors 2",
    "/full_scale": "/full_scale 2",
    "/end": "/end",
    "/panic": "/panic",
    "/world/body": "/world/body ball sphere glass 0.02",
    "/world/pair": "/world/pair floor ball surface polished-wood",
    "/world/microphones": "/world/microphones -0.1 -1 0.5  0.1 -1 0.5",
    "/world/pose": "/world/pose ball 0.1 0 0.02  1 0 0 0  0.5 0 -1.2  0 25 0",
    "/world/touch": "/world/touch floor ball 0.1 0 0  0 0 1 approach 1.2 force 0.8",
    "/world/grains": "/world/grains stones bodies stone*",
    "/world/pour": "/world/pour rice floor 12 speed 1.5",
    "/world/step": "/world/step 1.25",
    "/world/end": "/world/end",
    "/midi/notes": "/midi/notes bar low C2 high B3",
    "/midi/learn": "/midi/learn /gesture/marble/speed",
    "/midi/control": "/midi/control 1 /object/bell/gain low -30 high 6",
    "/midi/forget": "/midi/forget address /object/bell/gain",
    "/midi/controls": "/midi/controls",
    "/objects": "/objects",
    "/gestures": "/gestures",
    "/presets": "/presets strikers",
    "/status": "/status",
    "/version": "/version",
    "/sync": "/sync 7",
    "/notify": "/notify 1 7400",
    "/record": "/record 1 name solo",
    "/dump": "/dump 1",
    "/quit": "/quit",
    **{f"/gesture/ID/{name}": f"/gesture/marble/{name} 1 over 2" for name in STEERABLE},
    "/gesture/ID/excitation": "/gesture/dice/excitation 0.5",
    "/gesture/ID/size": "/gesture/shower/size 0.0005",
}
"""A message to each address."""

_FAMILIES = {
    "objects": ("/object/",),
    "gestures": ("/gesture/",),
    "space and sensors": ("/listener", "/floor", "/room", "/sensor"),
    "everything": (
        "/gain",
        "/limiter",
        "/headroom",
        "/play",
        "/panic",
        "/accuracy",
        "/quality",
        "/bank",
        "/budget",
    ),
    "scores": ("/channels", "/full_scale", "/end"),
    "simulations": ("/world/",),
    "midi": ("/midi/",),
    "questions and the server": ("/",),
}
"""The first words of the addresses of each part; an address belongs to the first part that has it."""


_OVER_TIME = "[over time](gestures.md#changes-over-time)"
_MORE = {
    "/object/new": " [Keys of presets](../presets/object-keys.md).",
    "/quality": " [Levels](accuracy.md#quality).",
    "/budget": " [Budget](accuracy.md#budget).",
    "/status": " [Values](replies.md#status).",
}
"""Where a reader finds more about an address."""


def addresses() -> str:
    """Return a section for each family of addresses."""
    left, parts = list(VERBS.values()), []
    for family, beginnings in _FAMILIES.items():
        here = [verb for verb in left if verb.address.startswith(beginnings)]
        left = [verb for verb in left if verb not in here]
        title = "MIDI" if family == "midi" else family.capitalize()
        parts.append("\n\n".join([f"## {title}", *_blocks(here)]))
    return "\n\n".join(parts)


def _blocks(verbs: Iterable[Verb]) -> Iterable[str]:
    """Yield a block for each address; one for all that set a number of an object, and one for all that steer."""
    settings = [verb for verb in verbs if verb.address.startswith("/object/NAME/") and verb.action in SETTINGS]
    steering = [verb for verb in verbs if verb.address.startswith("/gesture/ID/") and verb.action in STEERABLE]
    macros = [verb for verb in verbs if verb.address.startswith("/object/NAME/macro/")]
    for verb in verbs:
        if verb in settings[:1]:
            rows = [(f"`{each.address}`", range_of(each.required[0]), _said(each)) for each in settings]
            example = "\n".join(f"    {EXAMPLES[each.address]}" for each in settings[:2])
            yield "### `/object/NAME/SETTING value [over s] [curve c]`"
            yield f"Sets a number of the object, at once or {_OVER_TIME}."
            yield example
            yield table(("address", "value", "meaning"), rows)
        elif verb in steering[:1]:
            rows = [(f"`{each.address}`", range_of(each.required[0]), _steered(each.action)) for each in steering]
            yield "### `/gesture/ID/KEY value [over s] [curve c]`"
            yield f"Steers a running gesture, at once or {_OVER_TIME}."
            yield f"    {EXAMPLES[verb.address]}"
            yield table(("address", "value", "steers"), rows)
        elif verb in macros[:1]:
            rows = [(f"`{each.address}`", range_of(each.required[0]), _said(each)) for each in macros]
            yield "### `/object/NAME/macro/MACRO value [over s] [curve c]`"
            yield f"Turns a [macro](macros.md), at once or {_OVER_TIME}."
            yield f"    {EXAMPLES[verb.address]}"
            yield table(("address", "value", "meaning"), rows)
        elif verb not in (*settings, *steering, *macros):
            yield from _block(verb)


def _block(verb: Verb) -> Iterable[str]:
    yield f"### `{verb.usage()}`"
    gesture = GESTURES.get(verb.action) if verb.address.startswith("/object/NAME/") else None
    link = f" [Keys](gestures/{verb.action}.md)." if gesture else _MORE.get(verb.address, "")
    yield f"{_said(verb)}{link}"
    yield f"    {EXAMPLES[verb.address]}"
    arguments: list[Key] = [*verb.required, *verb.optional, *([verb.many] if verb.many else [])]
    keys = () if gesture or isinstance(verb, Change | Move) else verb.keys
    if (arguments or keys) and not gesture:
        yield key_rows([*arguments, *keys])


def _said(verb: Verb) -> str:
    return f"{verb.help[0].upper()}{verb.help[1:]}."


def _steered(name: str) -> str:
    found = gestures_steered_by(name)
    if len(found) > len(GESTURES) - 3:
        lacking = [gesture for gesture in GESTURES if gesture not in found]
        return f"all but {' and '.join(lacking)}" if lacking else "all"
    return ", ".join(f"{gesture}{f' ({each.steered})' if each.steered else ''}" for gesture, each in found.items())
