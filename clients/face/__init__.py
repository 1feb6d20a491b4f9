"""Carom: hear bodies hit, bounce and roll.

Render a score to an array, or play a scene of your own, in this process and as fast as it computes:

    import carom

    with carom.Scene(rate=48000) as scene:
        plate = scene.new("plate", "steel-plate", thickness=0.002)
        plate.impact(1.5, position=0.3, striker="wood", at=0.1)  # m/s, and seconds
        plate.bounce(0.2, striker="ping-pong", at=0.5)           # dropped from 0.2 m
        sound = scene.render(seconds=2.0)
    sound.save("plate.wav")                                      # sound.samples: float32 (96000, 2)

`carom.render(score)` does the same for a score: a file's Path, a text, or lines. `carom.Client` plays on a running
server (`carom serve`) over OSC. `carom.World` is the microphone of a simulation: it is stepped with it, and turns its
contacts into blows, slides and rolls; `carom.mujoco` and `carom.gymnasium` connect it with these. `carom.Presets` has
the objects, strikers, materials and surfaces there are; on the command line, `carom presets` lists them. `carom.dsp`
holds the contact law, its closed forms and the modes of bodies.

`carom.fit` makes an object of recordings, `carom.mesh` one of a mesh. `carom.compare` says how far apart two sounds
are. `carom.rebuild` computes the sound of a data set's clip from its ground truth. `carom.render_many` renders the
items of a recipe without files, and `carom.torch` gives them to PyTorch.

Units are SI, but for levels (dB), tuning (semitones) and angles (degrees). A call that cannot be carried out raises an
error that names the culprit, its value and what was expected: CommandError from a Scene or a Client, ScoreError,
RenderError, PresetError, ItemError (an item of a recipe) or NotLinear elsewhere. All are CaromErrors. One that names an
argument which a call does not take, or lacks, is a TypeError, too.

Nothing is loaded before it is requested. The first sound of a checkout compiles the engine.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import dsp as dsp
    from . import gymnasium as gymnasium
    from . import mujoco as mujoco
    from . import torch as torch
    from .clients.actions import CommandError as CommandError
    from .clients.client import Client as Client
    from .clients.contacts import Contact as Contact
    from .clients.dataset.clip import ItemError as ItemError
    from .clients.dataset.stream import render_many as render_many
    from .clients.modes import ModeTable as ModeTable
    from .clients.rebuilding import NotLinear as NotLinear
    from .clients.rebuilding import rebuild as rebuild
    from .dsp.errors import CaromError as CaromError
    from .meshes import mesh as mesh
    from .offline import render as render
    from .presets import PresetError as PresetError
    from .presets import Presets as Presets
    from .recordings import compare as compare
    from .recordings import fit as fit
    from .report import Report as Report
    from .scene import Object as Object
    from .scene import Scene as Scene
    from .server.bridge.blows import Hit as Hit
    from .server.bridge.checks import WorldError as WorldError
    from .server.bridge.hearing import Hearing as Hearing
    from .server.bridge.hearing import Listener as Listener
    from .server.bridge.hearing import Microphone as Microphone
    from .server.bridge.step import Pose as Pose
    from .server.bridge.step import Touch as Touch
    from .server.files.whole import RenderError as RenderError
    from .server.osc.score import ScoreError as ScoreError
    from .sound import Sensed as Sensed
    from .sound import Sound as Sound
    from .world import World as World

    __version__: str

_HOMES = {
    "CaromError": "dsp.errors",
    "Client": "clients.client",
    "CommandError": "clients.actions",
    "Contact": "clients.contacts",
    "Hearing": "server.bridge.hearing",
    "Hit": "server.bridge.simulation",
    "ItemError": "clients.dataset.clip",
    "Listener": "server.bridge.hearing",
    "Microphone": "server.bridge.hearing",
    "ModeTable": "clients.modes",
    "NotLinear": "clients.rebuilding",
    "Object": "scene",
    "Pose": "server.bridge.step",
    "PresetError": "presets",
    "Presets": "presets",
    "RenderError": "server.files.whole",
    "Report": "report",
    "Scene": "scene",
    "ScoreError": "server.osc.score",
    "Sensed": "sound",
    "Sound": "sound",
    "Touch": "server.bridge.step",
    "World": "world",
    "WorldError": "server.bridge.checks",
    "compare": "recordings",
    "fit": "recordings",
    "mesh": "meshes",
    "rebuild": "clients.rebuilding",
    "render": "offline",
    "render_many": "clients.dataset.stream",
}
"""The module of each public name."""

__all__ = [
    "CaromError",
    "Client",
    "CommandError",
    "Contact",
    "Hearing",
    "Hit",
    "ItemError",
    "Listener",
    "Microphone",
    "ModeTable",
    "NotLinear",
    "Object",
    "Pose",
    "PresetError",
    "Presets",
    "RenderError",
    "Report",
    "Scene",
    "ScoreError",
    "Sensed",
    "Sound",
    "Touch",
    "World",
    "WorldError",
    "__version__",
    "compare",
    "dsp",
    "fit",
    "mesh",
    "rebuild",
    "render",
    "render_many",
]


if not TYPE_CHECKING:  # to a type checker names are those above alone

    def __getattr__(name: str) -> Any:
        if name in _HOMES:
            value = getattr(import_module(f".{_HOMES[name]}", __name__), name)
        elif name in ("dsp", "gymnasium", "mujoco", "torch"):
            value = import_module(f".{name}", __name__)
        elif name == "__version__":
            from importlib.metadata import version

            value = version("carom")
        else:
            from .dsp.wording import expected

            raise AttributeError(f"module {__name__!r} has no attribute {name!r}; {expected(name, __all__)}")
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__"))})
