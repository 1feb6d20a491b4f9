"""An item as a clip: its sound, and the truth about it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...dsp.engine.memory.state import QUANTUM, TRACED_MOMENTS
from ...dsp.errors import CaromError
from ...presets import Presets
from ...server.new_object import NEW
from ...server.osc.score import Line, sample_at
from ...server.render import PIECE
from ..actions import CommandError
from ..contacts import Contact, assemble
from ..errors import KINDS, is_expected, plain
from ..performer import Performer
from .design import Item
from .level import QUANTIZED, quantized, step_of, whole_of
from .messages import OBJECT, lines_of, number
from .recipe import SCORE, SENSOR, Recipe
from .scenes import Scene, options_of, scene_for
from .truth import AMPLIFIED, PATH, Followed, Truth, about_contacts, path_of

_PLAIN = ("impact", "spin")
"""Gestures that push nothing, and change no settings: the truth has no more than modes and forces."""

_LONGEST = 64 * PIECE
"""Frames between two looks at the trace, which has room for the contacts of one gesture."""

_AT_ONCE = 16_000  # samples whose squares are added at once
_LEAST_LEVEL = 40.0  # dB of a clip above the noise of its samples' steps
_NO_FORCE, _NO_PATH = np.zeros((0, TRACED_MOMENTS)), np.zeros((0, PATH))


class ItemError(CaromError, RuntimeError):
    """An item that cannot be rendered; the text names it and says why."""


@dataclass(frozen=True)
class Clip:
    """An item's sound, (frames, channels): samples, or whole numbers of steps; its truth; and of all contacts, one
    after the other, the forces, (N, 6) float32 in N, and the paths of those that move, (M, 9) float32; and the signals
    of sensors, (frames, sensors) float32, each in the unit that the truth says."""

    samples: NDArray[np.float32] | NDArray[np.float64]
    truth: Truth
    force: NDArray[np.float32]
    path: NDArray[np.float32]
    sensed: NDArray[np.float32]


def render(recipe: Recipe, item: Item, presets: Presets) -> Clip:
    """Render the clip of an item. ItemError names it where it cannot be, or would exceed full scale."""
    try:
        return _render(recipe, item, presets)
    except KINDS as error:
        if isinstance(error, ItemError) or not is_expected(error):
            raise
        raise ItemError(f"item {item.number}: {plain(error)} ({_said(item)})") from None


def row_of(clip: Clip) -> dict[str, Any]:
    """Return a row: the truth, with each contact's forces in place, their other moments and its path flat."""
    contacts = []
    for told in clip.truth["contacts"]:
        force = clip.force[told["force_begin"] :][: told["force_count"]]
        path = clip.path[told["path_begin"] :][: told["path_count"]]
        contacts.append({**told, "force": force[:, 0], "moments": force[:, 1:].ravel(), "path": path.ravel()})
    return {**clip.truth, "contacts": contacts}


def _render(recipe: Recipe, item: Item, presets: Presets) -> Clip:
    lines = lines_of(recipe, item)
    plain = item.gesture in _PLAIN and SENSOR not in item.values
    made = [line.message for line in lines if line.message.address == NEW] if plain else []
    scene, followed = scene_for(recipe.rate, recipe.channels, made, presets), Followed()
    performer = scene.performer
    pressure, sensed, contacts = _played(recipe, item, scene, followed, lines[len(made) :], not made)
    peak = float(max(pressure.max(), -pressure.min()))
    full_scale = recipe.full_scale or whole_of(peak)
    if not peak <= full_scale:
        raise ItemError(
            f"item {item.number}: its peak is {peak:.4g} Pa: expected at most full_scale = {full_scale:g} Pa "
            f"({_said(item)})"
        )
    truth = _about(recipe, item, presets, peak, full_scale, pressure)
    objects = scene.objects()
    truth["objects"] = [
        each.about(recipe.frames, at, _moves(name, at, contacts), followed, name not in performer.off_path)
        for name, each, at in ((name, each, _touched(item, name, contacts)) for name, each in objects.items())
    ]
    kept = followed.all_in(each.handle.serial for each in performer.scene.objects.values())
    truth["linear"] = kept and all(each["linear"] for each in truth["objects"])
    truth["contacts"] = about_contacts(performer, contacts, objects)
    if sensed.shape[1]:
        truth["sensors"] = _about_sensors(performer)
    truth["warnings"] = [*performer.warnings, *_quiet(recipe, full_scale, truth["exposure"])]
    forces = [_NO_FORCE, *(contact.drive.moments for contact in contacts)]
    paths = [_NO_PATH, *(path_of(contact.drive) for contact in contacts if not contact.drive.stays)]
    scene.give()
    return Clip(
        quantized(pressure, peak, full_scale, recipe.samples), truth,
        np.concatenate(forces, dtype=np.float32), np.concatenate(paths, dtype=np.float32), sensed,
    )  # fmt: skip


def _moves(name: str, position: float | None, contacts: tuple[Contact, ...]) -> bool:
    """True if an object is touched elsewhere than at a position."""
    for each in contacts:
        if each.striker == name and each.by_position != position:
            return True
        if each.object == name and each.position != position:
            return True
        if each.object == name and not each.drive.stays and (each.drive.position != each.position).any():
            return True
    return False


def _quiet(recipe: Recipe, full_scale: float, exposure: list[float]) -> list[str]:
    """Warn of a clip that is silent, or hardly above the steps of its samples. exposure: Pa^2 s, of each channel."""
    mean = sum(exposure) * recipe.rate / (recipe.frames * len(exposure))
    if mean == 0.0:
        return ["it is silent"]
    if recipe.samples not in QUANTIZED:
        return []
    level = 10.0 * math.log10(12.0 * mean / step_of(full_scale, recipe.samples) ** 2)
    if level >= _LEAST_LEVEL:
        return []
    return [f"it is {level:.0f} dB above the noise of its samples; expected at least {_LEAST_LEVEL:g}"]


def _energy(samples: NDArray[np.float32]) -> float:
    """Return the sum of squares as numpy adds up, in halves; so that what is added lies in the processor's cache."""
    if len(samples) > _AT_ONCE:
        half = len(samples) // 2 // 8 * 8
        return _energy(samples[:half]) + _energy(samples[half:])
    squares = samples.astype(np.float64)
    return float(np.square(squares, out=squares).sum())


def _said(item: Item) -> str:
    """Describe the factors of an item in words."""
    return (
        ", ".join(
            f"{name} = {value:.4g}" if isinstance(value, float) else f"{name} = {value}"
            for name, value in item.factors.items()
        )
        or "it has no factors"
    )


def _played(
    recipe: Recipe, item: Item, scene: Scene, followed: Followed, lines: Sequence[Line], is_new: bool
) -> tuple[NDArray[np.float32], NDArray[np.float32], tuple[Contact, ...]]:
    """Play lines of an item; return its sound (Pa), the signals of its sensors, and its contacts. is_new: the scene has
    received nothing so far.

    CommandError names the line of a score that was refused.
    """
    pieces, traces, performer = [], [], scene.performer
    follows = item.gesture not in _PLAIN
    head = options_of(recipe.rate, recipe.channels).head if is_new else []
    if head and (not lines or lines[0].time > 0.0):
        performer.perform(head, None)
        head = []
    longest = QUANTUM if follows else _LONGEST
    done, frames = 0, recipe.frames
    for line in [*lines, None]:
        due = _due(recipe, item, line) if line else frames
        while done < min(due, frames):
            end = min(done + longest, due, frames)
            pieces.append(performer.engine.process(end - done))
            traces.append(performer.traced(end))
            if follows:
                followed.look(performer)
            done = end
        if line:
            try:
                scene.perform([*head, line.message], line.time)
                head = []
            except CommandError as error:
                raise CommandError(f"{line.where}: {error}" if line.where else str(error)) from None
    heard = [each for each in traces if len(each)] or traces[:1]
    trace = heard[0] if len(heard) == 1 else np.concatenate(heard)
    width, channels = performer.engine.width, performer.engine.channels
    whole = _joined(pieces, frames, width)
    contacts = assemble(trace, recipe.rate, 0, performer.striking)
    pressure = np.ascontiguousarray(whole[:, :channels])
    pressure *= np.float32(1.0 / AMPLIFIED)  # a power of two
    return pressure, whole[:, channels:], contacts


def _joined(pieces: list[NDArray[np.float32]], frames: int, width: int) -> NDArray[np.float32]:
    """Return the pieces of a sound one after the other, (frames, width); those from before a sensor have fewer
    channels."""
    if len(pieces) == 1 and pieces[0].shape[1] == width:
        return pieces[0]
    whole, first = np.zeros((frames, width), np.float32), 0
    for piece in pieces:
        whole[first : first + len(piece), : piece.shape[1]] = piece
        first += len(piece)
    return whole


def _about_sensors(performer: Performer) -> list[Truth]:
    """Describe the sensors, in the order of their channels."""
    return [
        {
            "name": name, "object": each.object, "position": each.position, "quantity": each.sensor.quantity,
            "unit": each.unit, "full": each.full, "resonance": each.sensor.resonance, "damping": each.sensor.damping,
        }
        for _, (name, each) in sorted(performer.scene.sensors.channels.items())
    ]  # fmt: skip


def _due(recipe: Recipe, item: Item, line: Line) -> int:
    """Return the frame before which a line is carried out: a score's in time, as what it says may depend on what has
    ended."""
    return int(sample_at(line.time, recipe.rate)) // QUANTUM * QUANTUM if item.gesture == SCORE else 0


def _touched(item: Item, name: str, contacts: tuple[Contact, ...]) -> float | None:
    """Return where along its strike path an object is touched; by a score, where it is hit hardest. None: not given."""
    if item.gesture != SCORE:
        key = "position" if name == OBJECT else "by_position"
        return number(item.values[item.gesture], key) if key in item.values[item.gesture] else None
    hits = [contact for contact in contacts if contact.object == name]
    return max(hits, key=lambda contact: contact.impulse).position if hits else None


def _about(
    recipe: Recipe, item: Item, presets: Presets, peak: float, full_scale: float, pressure: NDArray[np.float32]
) -> Truth:
    """Describe an item, and its loudness. exposure: Pa^2 s, of each channel."""
    paired = {"pair": item.pair, "differs": item.differs} if item.pair >= 0 else {}
    return {
        "item": item.number,
        "seed": item.seed,
        **paired,
        "gesture": item.gesture,
        "licence": recipe.licence,
        "split": recipe.split.side(item.factors, presets) if recipe.split else "train",
        "factors": dict(item.factors),
        "rate": recipe.rate,
        "frames": recipe.frames,
        "full_scale": full_scale,
        "peak": peak,
        "exposure": [_energy(channel) / recipe.rate for channel in pressure.T],
    }
