"""The server's account of itself to those who look it up over HTTP; any thread may ask."""

from collections.abc import Collection, Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ..dsp.bodies.material import Array
from ..dsp.bodies.mesh import Table
from ..dsp.bodies.modes import Modes
from ..dsp.macros import MACROS
from ..dsp.schema import GESTURES, MAIN_GAIN, SETTINGS, STRIKE, TRAIT_NAMES, Parameter
from ..presets import ObjectPreset, PresetError, Presets
from ..presets.supports import SUPPORTS
from .osc.questions import tuning_of
from .osc.score import format_line
from .osc.wire import Message
from .scene.notes import keys_of
from .scene.session import Session

_MOST_MODES = 64  # of an object that are shown
_MOST_POINTS = 65  # along its strike path
_PLACES = 5  # of points in m
_T60 = float(np.log(1e3))


class Knowledge:
    """A view of a session and its presets. log: the score of it that is written, if one is."""

    def __init__(self, session: Session, presets: Presets, log: Path | None) -> None:
        self._session = session
        self._presets = presets
        self._log = log
        self._catalogue: dict[str, Any] | None = None

    def names(self) -> dict[str, Collection[str]]:
        """Return the names that can stand for a word of the address space now."""
        library = self._presets
        return {
            "NAME": dict.fromkeys(self._session.objects),
            "ID": {id.name: None for id in self._session.gestures.running()},
            "preset": library.names("objects"),
            "what": (*SUPPORTS, *self._session.objects),
            **{kind[:-1]: library.names(kind) for kind in ("strikers", "surfaces", "materials")},
        }

    def value(self, path: str) -> list[Any] | None:
        """Return the values of an address now; None if it has none."""
        engine = self._session.engine
        if path.startswith("/object/") and path.count("/") > 2:
            _, _, name, *setting = path.split("/")
            obj = self._session.objects.get(name)
            values = {} if obj is None else obj.last_macros if setting[:-1] == ["macro"] else obj.settings
            return [values[setting[-1]]] if setting[-1] in values else None
        if path == "/gain":
            return [20.0 * float(np.log10(max(engine.gain, 1e-9)))]
        if path == "/limiter":
            return ["on" if engine.limiter else "off"]
        if path == "/accuracy":
            return [engine.accuracy]
        if path == "/bank":
            return [engine.bank]
        return [int(engine.quality)] if path == "/quality" else None

    def catalogue(self) -> dict[str, Any]:
        """Return all presets, and the parameters of gestures and objects with their ranges."""
        if self._catalogue is None:
            library = self._presets
            self._catalogue = {
                "version": version("carom"),
                "rate": self._session.engine.rate,
                "channels": self._session.engine.channels,
                "objects": [_described(library.object(name)) for name in self._good("objects")],
                "strikers": [self._striker(name) for name in self._good("strikers")],
                "surfaces": library.names("surfaces"),
                "gestures": {
                    name: {
                        "argument": _parameter(gesture.argument),
                        "what": [*SUPPORTS] if gesture.what else [],
                        "keys": [_parameter(key) for key in {k.name: k for k in (*STRIKE, *gesture.keys)}.values()],
                        "steerable": gesture.steerable,
                        **{trait: getattr(gesture, trait) for trait in TRAIT_NAMES},
                    }
                    for name, gesture in GESTURES.items()
                },
                "settings": [_parameter(setting) for setting in SETTINGS.values()],
                "macros": [{**_parameter(each.number), "ends": each.ends} for each in MACROS.values()],
                "gain": _parameter(MAIN_GAIN),
            }
        return self._catalogue

    def _good(self, kind: str) -> Iterable[str]:
        """Yield the names of the presets of a kind whose files are right."""
        load = self._presets.object if kind == "objects" else self._presets.striker
        for name in self._presets.names(kind):
            try:
                load(name)
            except PresetError:
                continue
            yield name

    def _striker(self, name: str) -> dict[str, Any]:
        preset = self._presets.striker(name)
        return {
            "name": name,
            "description": preset.description,
            "mass": preset.mass,
            "radius": preset.radius,
            "click_radius": preset.sound.radius if preset.sound else None,
            "material": preset.material.name if preset.material else "",
        }

    def shape_of(self, name: str) -> dict[str, Any] | None:
        """Return an object with its lowest modes: frequencies, decay times, levels and shapes along its strike path."""
        obj = self._session.objects.get(name)
        if obj is None:
            return None
        modes = obj.modes
        count = min(_MOST_MODES, len(modes.frequency))
        rows = np.unique(np.linspace(0, len(modes.along) - 1, min(_MOST_POINTS, len(modes.along))).round().astype(int))
        shapes = modes.strike[rows][:, :count]
        loud = np.sqrt(0.5 * (modes.pressure[:, :count] ** 2).sum(axis=0))
        return {
            **_described(obj.preset),
            "preset": obj.preset.name,
            "name": name,
            "mass": obj.mass,
            "settings": dict(obj.settings),
            "macros": {name: obj.last_macros[name] for name in MACROS},
            "made": keys_of(obj),
            "frequency": [round(tuning_of(obj) * float(f), 3) for f in modes.frequency[:count]],
            "t60": [round(_T60 / float(d), 4) if d > 0 else 0.0 for d in modes.decay[:count]],
            "loud": [float(f"{each:.4g}") for each in loud],
            "strike": _short(shapes),
            **_surface_shapes(modes, count),
        }

    def session(self) -> bytes | None:
        """Return the score of what was played until now; None if none is kept."""
        if self._log is None:
            return None
        end = self._session.engine.position / self._session.engine.rate
        return self._log.read_bytes() + (format_line(end, Message("/panic")) + "\n").encode()


def _described(preset: ObjectPreset) -> dict[str, Any]:
    """Return what the page shows of an object's preset."""
    return {
        "name": preset.name,
        "description": preset.description,
        "shape": preset.shape,
        "geometry": _plain(preset.geometry),
        "material": preset.material.name if preset.material else "",
        "striker": preset.striker,
        "velocity": preset.velocity,
        "position": preset.position,
        **_surface(preset),
        "gestures": {
            kind: {"striker": usual.striker, "surface": usual.surface, **usual.numbers}
            for kind, usual in preset.gestures.items()
        },
    }


def _surface(preset: ObjectPreset) -> dict[str, Any]:
    """Return points (m) and triangles of the surface of an object of a mesh."""
    table = preset.geometry.get("table")
    if not isinstance(table, Table):
        return {}
    return {"surface": {"points": table.points.round(_PLACES).tolist(), "faces": table.faces.tolist()}}


def _surface_shapes(modes: Modes, count: int) -> dict[str, Any]:
    """Return a body's surface, and the shapes of its lowest modes at the points."""
    if modes.faces is None:
        return {}
    rows = (modes.faces.rows[:, None] + np.arange(3)).reshape(-1)
    points, first, faces = np.unique(modes.faces.corners.reshape(-1, 3), axis=0, return_index=True, return_inverse=True)
    surface = {"points": points.round(_PLACES).tolist(), "faces": faces.reshape(-1, 3).tolist()}
    return {"surface": surface, "shapes": _short(modes.strike[rows[first], :count])}


def _plain(geometry: Mapping[str, Any]) -> dict[str, Any]:
    """Return the lengths, words and points of a geometry, without what modes are listed by."""
    return {k: v for k, v in geometry.items() if isinstance(v, int | float | str) or k in ("path_from", "path_to")}


def _short(rows: Array) -> list[list[float]]:
    return [[float(f"{each:.4g}") for each in row] for row in rows]


def _parameter(parameter: Parameter) -> dict[str, Any]:
    low, high = parameter.useful or (parameter.low, parameter.high)
    return {
        "name": parameter.name,
        "low": low,
        "high": high,
        "unit": parameter.unit,
        "help": parameter.help,
        "default": parameter.default,
        "whole": parameter.whole,
    }
