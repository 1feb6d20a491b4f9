"""An item as a clip: its sound, and the truth about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...presets import Presets
from ...server.osc.wire import Message
from ...server.render import Options
from ..contacts import Contact, assemble
from ..errors import KINDS, is_expected, plain
from ..modes import mode_table
from ..performer import TRACED, Performer, Placed
from .design import Item
from .messages import BY, OBJECT, gesture_message, number, object_message
from .recipe import OBJECTS, Recipe

Truth = dict[str, Any]
"""What is known of a clip, by name: numbers, words, and lists of these."""

FREE = ("impact", "bounce", "spin")
"""Gestures between whose contacts a striker flies: nothing but the contact changes its speed then."""


_PIECE = 16 * TRACED
"""Frames between two looks at the trace, which has room for the contacts of an item's one gesture."""


class ItemError(RuntimeError):
    """An item that cannot be rendered; the text names it and says why."""


@dataclass(frozen=True)
class Clip:
    """An item's sound, float32 (frames, channels), 1.0 being full scale; its truth; and the forces (N, float32) of all
    contacts, one after the other."""

    samples: NDArray[np.float32]
    truth: Truth
    force: NDArray[np.float32]


def render(recipe: Recipe, item: Item, presets: Presets) -> Clip:
    """The clip of an item. ItemError names it where it cannot be, or would exceed full scale."""
    try:
        return _render(recipe, item, presets)
    except KINDS as error:
        if isinstance(error, ItemError) or not is_expected(error):
            raise
        raise ItemError(f"item {item.number}: {plain(error)} ({_said(item)})") from None


def _render(recipe: Recipe, item: Item, presets: Presets) -> Clip:
    options = Options(recipe.rate, calibrated=True, channels=recipe.channels)
    performer = Performer(options, recipe.channels, presets, stems=False, contacts=True, steers_ended=True)
    performer.perform(options.head, None)
    placed = _perform(item, performer)
    pieces, traces = [], []
    for first in range(0, recipe.frames, _PIECE):
        end = min(first + _PIECE, recipe.frames)
        pieces.append(performer.engine.process(end - first))
        traces.append(performer.traced(end))
    contacts = assemble(np.concatenate([*filter(len, traces)] or traces), recipe.rate, 0, performer.striking)
    pressure = np.concatenate(pieces)
    peak = float(np.abs(pressure).max())
    if not peak <= recipe.full_scale:
        raise ItemError(
            f"item {item.number}: its peak is {peak:.4g} Pa: expected at most full_scale = {recipe.full_scale:g} Pa "
            f"({_said(item)})"
        )
    truth = _about(recipe, item, peak, pressure)
    truth["objects"] = [_object(performer, recipe, item, name, each) for name, each in placed.items()]
    truth["contacts"] = _contacts(contacts)
    forces = [np.zeros(0), *(contact.force for contact in contacts)]
    return Clip(pressure / np.float32(recipe.full_scale), truth, np.concatenate(forces).astype(np.float32))


def _said(item: Item) -> str:
    """The factors of an item in words."""
    return (
        ", ".join(
            f"{name} = {value:.4g}" if isinstance(value, float) else f"{name} = {value}"
            for name, value in item.factors.items()
        )
        or "it has no factors"
    )


def _perform(item: Item, performer: Performer) -> dict[str, Placed]:
    """Have an item's messages carried out; its objects by name."""
    placed = {}
    for name in OBJECTS:
        if name in item.values:
            performer.perform([object_message(name, item.values[name], performer.presets)], 0.0)
            placed[name] = performer.newest(name)
    values = item.values[item.gesture]
    gesture = gesture_message(item.gesture, values, item.seed, BY in item.values)
    performer.perform([gesture], number(values, "at"))
    if "until" in values:
        performer.perform([Message(f"/gesture/{item.gesture}/stop")], number(values, "until"))
    return placed


def _about(recipe: Recipe, item: Item, peak: float, pressure: NDArray[np.float32]) -> Truth:
    """What an item is, and how loud. exposure: Pa^2 s, of each channel."""
    paired = {"pair": item.pair, "differs": item.differs} if item.pair >= 0 else {}
    return {
        "item": item.number,
        "seed": item.seed,
        **paired,
        "gesture": item.gesture,
        "factors": dict(item.factors),
        "rate": recipe.rate,
        "frames": recipe.frames,
        "full_scale": recipe.full_scale,
        "peak": peak,
        "exposure": [float(each) for each in np.square(pressure, dtype=np.float64).sum(axis=0) / recipe.rate],
    }


def _object(performer: Performer, recipe: Recipe, item: Item, name: str, placed: Placed) -> Truth:
    """An object: what it is, and the modes that a blow where it is touched excites."""
    heard = performer.heard(placed)
    assert heard
    preset = performer.scene.objects[name].preset
    values, key = item.values[item.gesture], "position" if name == OBJECT else "by_position"
    position = number(values, key, placed.position)
    table = mode_table(placed.modes, placed.level, *heard, position, recipe.rate)
    relief = table.relief
    return {
        "name": name,
        "preset": preset.name,
        "shape": preset.shape,
        "material": preset.material.name if preset.material else "",
        "mass": placed.modes.mass,
        "position": position,
        "modes": _sines(table.frequencies, table.decays, table.gains),
        "clicks": [
            {"frequency": each.frequency, "decay": each.decay, "gain": each.gains.tolist()} for each in table.clicks
        ],
        "relief": _sines(relief.frequencies, relief.decays, relief.gains) if relief else {},
    }


def _sines(frequency: NDArray[np.float64], decay: NDArray[np.float64], gain: NDArray[np.float64]) -> Truth:
    """Damped sines: frequencies (Hz), decays (1/s), and for each channel the gains (Pa per N s)."""
    return {"frequency": frequency.tolist(), "decay": decay.tolist(), "gain": gain.T.tolist()}


def _contacts(contacts: tuple[Contact, ...]) -> list[Mapping[str, Any]]:
    """The contacts; where their forces begin among all forces, and how many they are."""
    told: list[Mapping[str, Any]] = []
    begin = 0
    for each in contacts:
        free = each.gesture in FREE
        told.append(
            {
                "object": each.object, "by": each.striker, "start": each.start, "duration": each.duration,
                "position": each.position, "speed": each.speed, "mass": each.mass, "impulse": each.impulse,
                "peak": each.peak, "energy": 0.5 * each.mass * each.speed**2 if free else 0.0,
                "loss": each.impulse * (each.speed - 0.5 * each.impulse / each.mass) if free else 0.0,
                "first": each.first, "force_begin": begin, "force_count": len(each.force),
            }
        )  # fmt: skip
        begin += len(each.force)
    return told
