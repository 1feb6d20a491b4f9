"""A baked scene's map, as JSON: from messages to commands. All of it follows from declarations and presets. What
follows from declarations alone is not the scene's, but goes with the engine that plays it: `rules`.

Whoever has it needs no Python: addresses and their arguments with ranges and defaults, the gestures with their traits,
where each value lies in a command, the contact laws of all strikers on the scene's objects, and surfaces.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any

import numpy as np

from ...dsp.bodies.striker import StrikerSound
from ...dsp.contact.accuracy import NUMBERS as ACCURACIES
from ...dsp.engine.memory import commands
from ...dsp.engine.memory.capacity import MOST_CHANNELS, SHAPE_VALUES
from ...dsp.engine.memory.commands import COMMAND, NUMBERS, Kind
from ...dsp.engine.memory.state import ENDED, EVENTS, QUANTUM, RING, ROLLS, STATE, End
from ...dsp.macros import ENGINE_SETTINGS, GLIDE, MACROS
from ...dsp.runtime.copies import CHANGES
from ...dsp.runtime.engine import Engine
from ...dsp.schema import DROPS, FORMS, GESTURES, SETTINGS, STEERABLE, STRIKE, TRAIT_NAMES, VELOCITY, Parameter
from ...dsp.swarm.record import PULSES as MOST_PULSES
from ...presets import Presets
from ...presets.kinds import DRY, ObjectPreset
from ...presets.reshaping import material_at
from ...server.bridge.touching import BODY_ROW, TOUCHING
from ...server.osc.addresses import VERBS
from ...server.osc.arguments import Either, Note, Numbers, Vector, Verb, Word
from ...server.osc.macro_verbs import MACRO
from ...server.osc.points import Change
from ...server.render import HIGHEST_RATE, LOWEST_RATE
from ...server.scene.limits import ContactLaws, least_radius
from ...server.scene.macros import FINE, LAWS, Law, number_of
from ...server.scene.objects import PlayedObject
from .baking import PULSE_VALUES, PULSES, Baked, MacroTable
from .bodies import LIKE, materials_of, said_of_bodies, said_of_materials

_BEGUN = [name for name, gesture in GESTURES.items() if not gesture.what and not gesture.breaks]
"""Gestures that a page can begin; those that name what an object lies on, or break it, are the score's alone."""
_PLAYED = ("note", "free", "stop", *_BEGUN, *SETTINGS, *STEERABLE)
_OF_ENGINE = ("/accuracy", "/quality", "/bank", "/gain", "/limiter", "/panic")
_ANY = 1e300
_SHARED = {each.name for each in STRIKE} | {"velocity"}


class Strikers:
    """All strikers of some presets: their laws, and the places of their sounds."""

    def __init__(self, presets: Presets) -> None:
        self._laws = ContactLaws(presets)
        self.names = presets.names("strikers")
        self.surfaces = presets.names("surfaces")

    def sounds(self) -> list[StrikerSound]:
        """Return the sounds of all of them, struck and held."""
        each = (self._laws.sound_of(name, held) for name in self.names for held in (False, True))
        return list(dict.fromkeys(sound for sound in each if sound))

    def said(self, baked: Baked, objects: Iterable[ObjectPreset]) -> dict[str, Any]:
        """Return the entries of each: its laws by object, its radius, how it slides, and where its sounds are."""
        presets = list(objects)
        return {
            name: {
                "radius": self._laws.radius_of(name),
                "sliding": dict(self._laws.sliding_of(name)),
                "laws": [tuple(self._laws.of(name, each.material)) for each in presets],
                "modulus": self._laws.modulus_of(name),
                "sound": self._place(baked, name, False),
                "held": self._place(baked, name, True),
            }
            for name in self.names
        }

    def said_of_surfaces(self) -> dict[str, Any]:
        """Return the description of each surface."""
        found = {name: self._laws.surface(name) for name in self.surfaces}
        return {
            name: {"profile": each.profile, "dissipation": each.dissipation, "least": least_radius(each, 1.0)}
            for name, each in found.items()
        }

    def _place(self, baked: Baked, name: str, held: bool) -> list[float]:
        sound = self._laws.sound_of(name, held)
        laid = baked.engine.lay_out_striker(sound) if sound else {"sound": 0.0, "sound_serial": 0.0}
        return [laid["sound"], laid["sound_serial"]]


def scene_map(baked: Baked, strikers: Strikers, put: Callable[[bytes], int] = lambda content: 0) -> dict[str, Any]:
    """Return the map of a baked scene, without what `rules` has for all.

    put: keeps bytes in the scene's data, and says where.
    """
    presets: list[ObjectPreset] = []
    for obj in baked.objects.values():
        if obj.preset not in presets:
            presets.append(obj.preset)
    engine = baked.engine
    session, simulation = baked.session, baked.session.simulation
    return {
        **(said_of_bodies(session, simulation, presets, put) if simulation else {}),
        "materials": said_of_materials(materials_of(presets, simulation)),
        "rate": engine.rate,
        "channels": engine.width,
        "sensors": engine.sensors,
        "delay": engine.delay,
        "frames": len(baked.sound),
        "size": _size(engine),
        "pulses": sorted(engine.pulses.numbers.items()),
        "presets": [_preset(each, presets) for each in presets],
        "objects": {
            name: _object(obj, presets) | _macros(obj, baked.tables.get(name)) for name, obj in baked.objects.items()
        },
        "strikers": strikers.said(baked, presets),
        "surfaces": strikers.said_of_surfaces(),
    }


@cache
def rules() -> dict[str, Any]:
    """Return the rules of all scenes of this process's engine: who plays a scene has it from the engine, not from
    the scene."""
    said = {
        "quantum": QUANTUM,
        "state": _state(),
        "command": _command(),
        "kinds": {kind.name: int(kind) for kind in Kind},
        "verbs": {verb.address: _verb(verb) for verb in (*filter(_is_played, VERBS.values()), LIKE)},
        "touching": {"size": TOUCHING.itemsize, "rolls": ROLLS, "body": BODY_ROW, "changes": CHANGES},
        "gestures": {name: _gesture(name) for name in _BEGUN},
        "steerable": {name: place for place, name in enumerate(STEERABLE)},
        "settings": {name: place for place, name in enumerate(SETTINGS)},
        "joined": int(End.JOINED),
        "macros": {name: (list(ENGINE_SETTINGS).index(name), each.of_body) for name, each in MACROS.items()},
        "glide": GLIDE,
        "levels": ACCURACIES,
        "forms": FORMS,
        "dry": DRY,
        "rates": (LOWEST_RATE, HIGHEST_RATE),
    }
    told = "\n".join([*_laid("state", STATE), *_laid("command", COMMAND), json.dumps(said)])
    return said | {"layout": hashlib.sha256(told.encode()).hexdigest()[:16]}


def layout() -> str:
    """Return a name of how this process's engine lays its memory out, and the rules of all its scenes: another
    engine's scenes are none of its own."""
    return str(rules()["layout"])


def _laid(name: str, kind: np.dtype[Any]) -> Iterator[str]:
    """Yield each field of a record, and of records in it, with its place, its numbers and their type."""
    for field, (inner, offset, *_) in (kind.fields or {}).items():
        yield f"{name}.{field} {offset} {inner.shape} {inner.base.str}"
        yield from _laid(f"{name}.{field}", inner.base)


def _is_played(verb: Verb) -> bool:
    parts = verb.address.count("/")
    if verb.address.startswith(f"{MACRO}/"):
        return True
    return verb.address in _OF_ENGINE or (verb.target != "" and parts == 3 and verb.action in _PLAYED and verb.scored)


def _state() -> dict[str, Any]:
    """Return where those parts of the engine's memory are that others than the engine write or read."""
    paths = {
        "rate": "rate", "channels": "output.channels", "sensors": "output.sensors", "delay": "output.delay",
        "entries": "ring.entries", "written": "ring.written", "read": "ring.read", "position": "position",
        "ends": "ends.entries", "ended": "ends.written", "active": "stats.contacts_active", "load": "stats.load",
        "dropped": "stats.contacts_dropped", "loudest": "stats.loudest_dropped", "late": "stats.late",
        "linear": "stats.nonlinear_dropped",
        "sounding": "stats.sounding", "queued": "queue.size", "slots": "objects",
        "plates": "curves", "pulses": "pulses",
        **{name: f"bank.{name}" for name in ("frequency", "sigma", "weight", "balance")},
    }  # fmt: skip
    places = {name: _offset(path) for name, path in paths.items()}
    sizes = {"values": PULSE_VALUES, "most": STATE.itemsize, "ring": RING, "events": EVENTS, "most_ended": ENDED}
    objects, bank = (STATE.fields[name][0] for name in ("objects", "bank"))  # type: ignore[index]
    sizes |= {"object": objects.base.itemsize, "used": int(objects.base.fields["used"][1])}  # type: ignore[index]
    rooms = {
        "modes": bank["frequency"].shape[0],
        "objects": objects.shape[0],
        "most_channels": MOST_CHANNELS,
        "shapes": SHAPE_VALUES,
    }
    return {**places, **sizes, **rooms, "most_pulses": MOST_PULSES}


def _size(engine: Engine) -> int:
    """Return the bytes of memory that a scene takes: up to the last table that it has."""
    used = PULSE_VALUES + engine.pulses.reached * np.dtype(np.float32).itemsize
    needed = used if engine.pulses.reached else PULSES if engine.had_plates else _offset("curves")
    return -(-needed // 8) * 8


def _offset(path: str) -> int:
    """Return where a field of a record of a record of STATE begins, in bytes."""
    kind, at = STATE, 0
    for name in path.split("."):
        kind, offset = kind.fields[name][:2]  # type: ignore[index]
        at += offset
    return at


def _command() -> dict[str, Any]:
    """Return the size of a command, and of each field its place and 1 if it is a whole number."""
    return {"size": COMMAND.itemsize, "fields": dict(_fields(COMMAND, "", 0))}


def _fields(kind: np.dtype[Any], prefix: str, at: int) -> Iterable[tuple[str, tuple[int, int]]]:
    for name, (inner, offset, *_) in (kind.fields or {}).items():
        if inner.names:
            yield from _fields(inner, f"{prefix}{name}.", at + offset)
        elif not inner.shape:
            yield f"{prefix}{name}", (at + offset, int(inner.kind == "i"))


def _gesture(name: str) -> dict[str, Any]:
    """Return the declaration of a gesture."""
    gesture = GESTURES[name]
    return {
        "number": NUMBERS[name],
        "argument": gesture.argument.name,
        "instead": gesture.instead,
        "most": VELOCITY.high,
        "laws": {value: _law(name, value, law) for value, law in LAWS[name].items()},
        "own": [key.name for key in gesture.keys if key.name not in _SHARED],
        "steerable": gesture.steerable,
        "values": commands.DEFAULTS[name],
        **{trait: bool(getattr(gesture, trait)) for trait in TRAIT_NAMES if trait != "meets"},
        "drops": gesture.swarms == DROPS,
        "seeded": any(key.name == "seed" for key in gesture.keys),
    }


def _law(gesture: str, value: str, law: Law) -> tuple[str, float, float, float, float]:
    """Return how a macro changes a value of a gesture, and the range that it stays in."""
    number = number_of(gesture, value)
    low, high = (number.low, number.high) if number else (-_ANY, _ANY)
    return (*law, max(low, -_ANY), min(high, _ANY))


def _verb(verb: Verb) -> dict[str, Any]:
    """Return the declaration of an address's arguments."""
    lists = {"required": verb.required, "optional": verb.optional, "keys": verb.keys}
    plain = {name: [each for each in given if not isinstance(each, Vector)] for name, given in lists.items()}
    said = {name: [_argument(each) for each in given] for name, given in plain.items() if given}
    return {**said, "changes": True} if isinstance(verb, Change) else said


def _argument(each: Parameter | Word | Either | Note | Numbers) -> dict[str, Any]:
    if isinstance(each, Parameter):
        said = {"name": each.name, "low": each.low, "high": each.high, "unit": each.unit, "expected": each.expected}
        least = each.low <= 0.0 and each.least
        more = {"default": each.default, "whole": each.whole, "orZero": each.or_zero, "least": least}
        return said | {key: value for key, value in more.items() if value is not None and value is not False}
    if isinstance(each, Note):
        return {"name": each.name, "low": each.low, "high": each.high, "unit": "", "expected": "a number from 0 to 127"}
    words = {"words": tuple(dict.fromkeys((*each.words, *each.old)))} if isinstance(each, Either) else {}
    return {"name": each.name, **words}


def _preset(preset: ObjectPreset, others: list[ObjectPreset]) -> dict[str, Any]:
    """Return the entries of an object's preset; `touching`: its law with each other's material, at a radius of 1 m."""
    usual = {
        name: {"striker": each.striker, "surface": each.surface, "numbers": dict(each.numbers)}
        for name, each in preset.gestures.items()
    }
    touching = [preset.struck_by(other, 1.0) for other in others]
    return {
        "name": preset.name,
        "description": preset.description,
        "striker": preset.striker,
        "velocity": preset.velocity,
        "position": preset.position,
        "material": preset.material.name if preset.material else "",
        "usual": usual,
        "touching": touching,
    }


def _object(obj: PlayedObject, presets: list[ObjectPreset]) -> dict[str, Any]:
    return {
        "slot": obj.handle.slot,
        "serial": obj.handle.serial,
        "preset": presets.index(obj.preset),
        "mass": obj.mass,
        "pitch": obj.modes.pitch,
    }


def _macros(obj: PlayedObject, table: MacroTable | None) -> dict[str, Any]:
    """Return what the macros of an object's body go by: its table, the octaves of its shapes by setting and place, and
    how it yields where it is touched (1/Pa) by place of `material`."""
    if table is None:
        return {}
    touched = [1.0 / material_at(obj.preset, place / FINE).dented_modulus for place in range(FINE + 1)]
    said = {
        "table": table.first,
        "amplitudes": [[each.amplitude for each in axis] for axis in table.axes],
        "touched": touched,
    }
    return {"macros": said}
