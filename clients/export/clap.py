"""A scene's objects as instruments: a CLAP plug-in for this machine, with its sources, over the library for C."""

from __future__ import annotations

import math
import shutil
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from ...dsp.native.targets import system
from . import c
from .baking import maker_of
from .scene import ExportError, Scene

RATES = (44_100, 48_000, 88_200, 96_000)
"""The sampling rates that a plug-in plays at: its scene is baked for each."""

OWN_STRIKER = "the object's own"
"""The name of a striker that is left to the object's preset."""

_FILES = Path(__file__).parent / "clap"
_SOURCES = ("plugin.c", "extensions.c", "instrument.c")
_HEADERS = ("plugin.h", "instrument.h")


def write_plugin(scenes: Sequence[Scene], folder: Path) -> Path:
    """Write a plug-in of one scene at several rates, and its sources, into a folder that is there; return its file.

    ExportError where this machine cannot make one, and where no object has a mode that is heard.
    """
    require_system()
    described = _described(scenes)
    compiler = c.write_static(folder)
    for scene in scenes:
        (folder / f"{int(scene.baked.engine.rate)}.carom").write_bytes(scene.file())
    (folder / "scene.h").write_text(described, encoding="utf-8")
    for name in (*_SOURCES, *_HEADERS):
        shutil.copyfile(_FILES / name, folder / name)
    shutil.copytree(_FILES / "clap", folder / "clap", dirs_exist_ok=True)
    made = folder / f"{_file_name(scenes[0].title)}.clap"
    flags = ("-std=c11", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", "-Wl,--exclude-libs,ALL")
    c.run(*compiler, *flags, *_SOURCES, "libcarom.a", "-lm", "-o", made.name, cwd=folder)
    return made


def require_system() -> None:
    """Raise ExportError where no plug-in can be made."""
    if system() != "linux":
        raise ExportError("a CLAP plug-in is made on Linux alone")


def _described(scenes: Sequence[Scene]) -> str:
    """Return the header that says what a plug-in is made of."""
    baked = scenes[0].baked
    if baked.engine.sensors:
        raise ExportError(f"{scenes[0].title}: expected no sensor, as a plug-in has channels of sound alone")
    objects, descriptors = [], []
    for name, obj in baked.objects.items():
        if not obj.modes.frequency.size:
            continue
        number, place = maker_of(baked, obj)
        settings = baked.batches[number].commands[place]["settings"]
        gain = round(20.0 * math.log10(max(float(settings["gain"]), 1e-6)), 9)
        values = (obj.preset.position, gain, *(float(settings[each]) for each in ("pan", "decay", "damp")))
        objects.append(f"    {{{_text(name)}, {', '.join(map(repr, values))}}},")
        plugin_id, title = f"carom.{_file_name(scenes[0].title)}.{_file_name(name)}", f"Carom {name}"
        words = (plugin_id, title, "Carom", "", "", "", version("carom"), obj.preset.description)
        descriptors.append(f"    {{CLAP_VERSION_INIT, {', '.join(map(_text, words))}, features}},")
    if not objects:
        raise ExportError(f"{scenes[0].title}: expected an object with a mode that is heard")
    strikers = [OWN_STRIKER, *scenes[0].strikers.names]
    rates = [int(scene.baked.engine.rate) for scene in scenes]
    return _HEAD.format(
        channels=baked.engine.channels,
        strikers="\n".join(f"    {_text(each)}," for each in strikers),
        objects="\n".join(objects),
        width="STEREO" if baked.engine.channels == 2 else "MONO",
        descriptors="\n".join(descriptors),
        declared="\n".join(f"BAKED({rate})" for rate in rates),
        scenes="\n".join(f"    {{{rate}.0, scene_{rate}, scene_{rate}_end}}," for rate in rates),
    )


_HEAD = """/* What a plug-in is made of. Written by Carom. */
#ifndef SCENE_H
#define SCENE_H

enum {{ CHANNELS = {channels} }};

#ifdef SCENES
const char *const strikers[] = {{
{strikers}
}};
const int striker_count = sizeof strikers / sizeof *strikers;

/* Name; position, gain (dB), pan, decay, damp. */
static const instrument_object objects[] = {{
{objects}
}};

static const char *features[] = {{
    CLAP_PLUGIN_FEATURE_INSTRUMENT, CLAP_PLUGIN_FEATURE_SYNTHESIZER, CLAP_PLUGIN_FEATURE_{width}, NULL,
}};

static const clap_plugin_descriptor_t descriptors[] = {{
{descriptors}
}};

/* The bytes of a file, as the assembler takes them from the folder in which the compiler runs. */
#define BAKED(rate) \\
    __asm__(".section .rodata\\n.balign 64\\nscene_" #rate ":\\n.incbin \\"" #rate ".carom\\"\\nscene_" #rate \\
            "_end:\\n.byte 0\\n.previous"); \\
    extern const unsigned char scene_##rate[] __attribute__((visibility("hidden"))); \\
    extern const unsigned char scene_##rate##_end[] __attribute__((visibility("hidden")));

{declared}

static const baked_scene scenes[] = {{
{scenes}
}};
#endif
#endif
"""


def _text(text: str) -> str:
    """Return a text as C writes it."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"').replace("?", "\\?")
    return '"' + " ".join(escaped.split()) + '"'


def _file_name(title: str) -> str:
    """Return a title as the name of a file, and a part of an id: letters, digits, - and _."""
    kept = "".join(each if (each.isalnum() and each.isascii()) or each in "-_" else "-" for each in title).strip("-")
    return kept or "carom"
