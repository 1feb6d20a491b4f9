"""An item as a clip: its sound, and the truth about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dsp.engine.memory.state import QUANTUM
from ...dsp.schema import GESTURES
from ...presets import Presets
from ...server.osc.score import Line, sample_at
from ...server.render import Options
from ..actions import CommandError
from ..contacts import Contact, assemble
from ..errors import KINDS, is_expected, plain
from ..modes import mode_table
from ..performer import TRACED, Performer
from .design import Item
from .messages import OBJECT, lines_of, number
from .recipe import SCORE, Recipe

Truth = dict[str, Any]
"""Ground truth of a clip, by name: numbers, words, and lists of these."""

FREE = tuple(name for name, gesture in GESTURES.items() if not gesture.lasts)
"""Gestures between whose contacts a striker flies: nothing but the contact changes its speed then."""


_PIECE = 16 * TRACED
"""Frames between two looks at the trace, which has room for the contacts of one gesture."""


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
    """Render the clip of an item. ItemError names it where it cannot be, or would exceed full scale."""
    try:
        return _render(recipe, item, presets)
    except KINDS as error:
        if isinstance(error, ItemError) or not is_expected(error):
            raise
        raise ItemError(f"item {item.number}: {plain(error)} ({_said(item)})") from None


def _render(recipe: Recipe, item: Item, presets: Presets) -> Clip:
    options = Options(recipe.rate, calibrated=True, channels=recipe.channels)
    performer = Performer(options, (), presets, stems=False, contacts=True, steers_ended=True)
    performer.perform(options.head, None)
    pressure, contacts = _played(recipe, item, performer)
    peak = float(np.abs(pressure).max())
    if not peak <= recipe.full_scale:
        raise ItemError(
            f"item {item.number}: its peak is {peak:.4g} Pa: expected at most full_scale = {recipe.full_scale:g} Pa "
            f"({_said(item)})"
        )
    truth = _about(recipe, item, peak, pressure)
    touched = {name: _touched(item, name, contacts) for name in performer.scene.objects}
    told = (_object(performer, recipe, name, position) for name, position in touched.items())
    truth["objects"] = [each for each in told if each]
    truth["contacts"] = _contacts(contacts)
    truth["warnings"] = performer.warnings
    forces = [np.zeros(0), *(contact.force for contact in contacts)]
    return Clip(pressure / np.float32(recipe.full_scale), truth, np.concatenate(forces).astype(np.float32))


def _said(item: Item) -> str:
    """Describe the factors of an item in words."""
    return (
        ", ".join(
            f"{name} = {value:.4g}" if isinstance(value, float) else f"{name} = {value}"
            for name, value in item.factors.items()
        )
        or "it has no factors"
    )


def _played(recipe: Recipe, item: Item, performer: Performer) -> tuple[NDArray[np.float32], tuple[Contact, ...]]:
    """Play an item; return its sound (Pa), and its contacts. CommandError names the line of a score that was
    refused."""
    pieces, traces = [], []
    longest = TRACED if item.gesture == SCORE else _PIECE
    done = 0
    for line in [*lines_of(recipe, item, performer.presets), None]:
        due = _due(recipe, item, line) if line else recipe.frames
        while done < min(due, recipe.frames):
            end = min(done + longest, due, recipe.frames)
            pieces.append(performer.engine.process(end - done))
            traces.append(performer.traced(end))
            done = end
        if line:
            try:
                performer.perform([line.message], line.time)
            except CommandError as error:
                raise CommandError(f"{line.where}: {error}" if line.where else str(error)) from None
    trace = np.concatenate([*filter(len, traces)] or traces)
    return np.concatenate(pieces), assemble(trace, recipe.rate, 0, performer.striking)


def _due(recipe: Recipe, item: Item, line: Line) -> int:
    """Return the frame before which a line is carried out: a score's in time, as what it says may depend on what has
    ended."""
    return int(sample_at(line.time, recipe.rate)) // QUANTUM * QUANTUM if item.gesture == SCORE else 0


def _touched(item: Item, name: str, contacts: tuple[Contact, ...]) -> float | None:
    """Return where along its strike path an object is touched; by a score, where it is hit hardest. None: not said."""
    if item.gesture != SCORE:
        key = "position" if name == OBJECT else "by_position"
        return number(item.values[item.gesture], key) if key in item.values[item.gesture] else None
    hits = [contact for contact in contacts if contact.object == name]
    return max(hits, key=lambda contact: contact.impulse).position if hits else None


def _about(recipe: Recipe, item: Item, peak: float, pressure: NDArray[np.float32]) -> Truth:
    """Describe an item, and its loudness. exposure: Pa^2 s, of each channel."""
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


def _object(performer: Performer, recipe: Recipe, name: str, touched: float | None) -> Truth:
    """Describe an object: what it is, and the modes that a blow where it is touched excites; empty where it came too
    late."""
    placed = performer.placed(name)
    heard = performer.heard(placed)
    if heard is None:
        return {}
    preset = performer.scene.objects[name].preset
    position = placed.position if touched is None else touched
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
    """Return damped sines: frequencies (Hz), decays (1/s), and for each channel the gains (Pa per N s)."""
    return {"frequency": frequency.tolist(), "decay": decay.tolist(), "gain": gain.T.tolist()}


def _contacts(contacts: tuple[Contact, ...]) -> list[Mapping[str, Any]]:
    """Describe the contacts; where their forces begin among all forces, and how many they are."""
    told: list[Mapping[str, Any]] = []
    begin = 0
    for each in contacts:
        free = each.gesture in FREE
        told.append(
            {
                "object": each.object, "by": each.striker, "gesture": each.gesture, "id": each.id,
                "start": each.start, "duration": each.duration, "position": each.position,
                "speed": each.speed, "velocity": each.velocity, "mass": each.mass, "impulse": each.impulse,
                "peak": each.peak, "energy": 0.5 * each.mass * each.velocity**2 if free else 0.0,
                "loss": each.impulse * (each.velocity - 0.5 * each.impulse / each.mass) if free else 0.0,
                "first": each.first, "force_begin": begin, "force_count": len(each.force),
            }
        )  # fmt: skip
        begin += len(each.force)
    return told
