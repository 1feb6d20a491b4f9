"""A scene's objects as instruments: a CLAP, VST3 or LV2 plug-in for a machine, with its sources.

The plug-in for CLAP is the instrument; those of the other formats are a host of it (`clap/guest.c`).
"""

from __future__ import annotations

import math
import os
import plistlib
import shutil
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from uuid import NAMESPACE_URL, uuid5

from ...dsp.engine.memory.state import QUANTUM
from ...dsp.native.targets import system
from . import c
from .baking import lay_out_macros, maker_of
from .instruments import MACROS, Instrument
from .machines import Machine
from .scene import ExportError, Scene
from .turtle import turtle_files

RATES = (44_100, 48_000, 88_200, 96_000)
"""The sampling rates that a plug-in plays at: its scene is baked for each."""

OWN_STRIKER = "the object's own"
"""The name of a striker that is left to the object's preset."""

HOMES = {
    "linux": {"clap": "~/.clap", "vst3": "~/.vst3", "lv2": "~/.lv2"},
    "darwin": {
        "clap": "~/Library/Audio/Plug-Ins/CLAP",
        "vst3": "~/Library/Audio/Plug-Ins/VST3",
        "lv2": "~/Library/Audio/Plug-Ins/LV2",
    },
    "windows": {
        "clap": r"%LOCALAPPDATA%\Programs\Common\CLAP",
        "vst3": r"%LOCALAPPDATA%\Programs\Common\VST3",
        "lv2": r"%APPDATA%\LV2",
    },
}
"""Where hosts look for a user's plug-ins, by system and format."""
FORMATS = tuple(HOMES["linux"])

_FILES = Path(__file__).parent
_CORE = ("plugin.c", "extensions.c", "instrument.c")
_HEADERS = ("plugin.h", "instrument.h")
_OTHERS = {"clap": ("clap",), "vst3": ("clap", "travesty"), "lv2": ("clap", "lv2")}
"""The folders of other people's headers that each format needs."""


def write_plugin(scenes: Sequence[Scene], folder: Path, machine: Machine, form: str = "clap") -> Path:
    """Write a plug-in of one scene at several rates, and its sources, into a folder that is there.

    form: one of FORMATS. Return the plug-in's file, or its folder. ExportError where the machine's compiler fails, and
    where no object has a mode that is heard.
    """
    instruments = _instruments(scenes[0])
    for scene in scenes:
        lay_out_macros(scene.baked, all_objects=True)
    described = _described(scenes, instruments)
    c.write_static(folder, machine)
    for scene in scenes:
        (folder / f"{int(scene.baked.engine.rate)}.carom").write_bytes(scene.file())
    (folder / "scene.h").write_text(described, encoding="utf-8", newline="\n")
    sources = [_FILES / "clap" / name for name in _CORE]
    if form != "clap":
        sources += [_FILES / "clap" / "guest.c", _FILES / form / f"{form}.c"]
        shutil.copyfile(_FILES / "clap" / "guest.h", folder / "guest.h")
    for path in (*sources, *(_FILES / "clap" / name for name in _HEADERS)):
        shutil.copyfile(path, folder / path.name)
    shutil.copyfile(_FILES / "vendor" / "NOTICE", folder / "NOTICE")
    for name in _OTHERS[form]:
        shutil.copytree(_FILES / "vendor" / name, folder / name, dirs_exist_ok=True)
    title = _file_name(scenes[0].title)
    made = folder / f"{title}.{form}"
    file = folder / _place(title, form, machine)
    if file != made:
        shutil.rmtree(made, ignore_errors=True)
        file.parent.mkdir(parents=True)
    if form == "lv2":
        strikers, channels = [OWN_STRIKER, *scenes[0].strikers.names], scenes[0].baked.engine.channels
        for name, text in turtle_files(instruments, strikers, channels, file.name).items():
            (made / name).write_text(text, encoding="utf-8", newline="\n")
    elif machine.system == "darwin":
        (made / "Contents" / "Info.plist").write_bytes(_property_list(title, form))
        (made / "Contents" / "PkgInfo").write_text("BNDL????")
    more = {"clap": [], "vst3": ["-fms-extensions"], "lv2": ["-I."]}[form]
    words: list[object] = [*more, *(each.name for each in sources), "libcarom.a"]
    machine.link(file.relative_to(folder).as_posix(), words, folder)
    return made


def _place(title: str, form: str, machine: Machine) -> Path:
    """Return where a plug-in's library lies in the folder of an export."""
    named = Path(f"{title}.{form}")
    if form == "lv2":
        return named / (title + {"windows": ".dll", "darwin": ".dylib"}.get(machine.system, ".so"))
    if machine.system == "darwin":
        return named / "Contents" / "MacOS" / title
    if form == "clap":
        return named
    within = {"windows": f"{machine.family}-win"}.get(machine.system, f"{machine.family}-{machine.system}")
    return named / "Contents" / within / f"{title}{'.vst3' if machine.system == 'windows' else '.so'}"


def _property_list(title: str, form: str) -> bytes:
    """Return what macOS reads of a plug-in's folder before it loads it."""
    said = {
        "CFBundleExecutable": title,
        "CFBundleIdentifier": f"carom.{form}.{title}",
        "CFBundleName": title,
        "CFBundlePackageType": "BNDL",
        "CFBundleSignature": "????",
        "CFBundleShortVersionString": version("carom"),
        "CFBundleVersion": version("carom"),
        "CFBundleDevelopmentRegion": "en",
        "CFBundleInfoDictionaryVersion": "6.0",
    }
    return plistlib.dumps(said)


def install(made: Path) -> Path:
    """Put a plug-in where this machine's hosts look for it; return where that is."""
    home = Path(os.path.expandvars(HOMES[system()][made.suffix[1:]])).expanduser()
    home.mkdir(parents=True, exist_ok=True)
    there = home / made.name
    if made.is_dir():
        shutil.rmtree(there, ignore_errors=True)
        shutil.copytree(made, there)
    else:
        partly = there.with_suffix(".part")
        shutil.copyfile(made, partly)
        partly.replace(there)  # whole, whoever has loaded the old one
    return there


def _instruments(scene: Scene) -> list[Instrument]:
    """Return the objects of a scene that are heard."""
    baked, found = scene.baked, []
    if baked.engine.sensors:
        raise ExportError(f"{scene.title}: expected no sensor, as a plug-in has channels of sound alone")
    for name, obj in baked.objects.items():
        if not obj.modes.frequency.size:
            continue
        number, place = maker_of(baked, obj)
        settings = baked.batches[number].commands[place]["settings"]
        gain = round(20.0 * math.log10(max(float(settings["gain"]), 1e-6)), 9)
        values = (obj.preset.position, gain, *(float(settings[each]) for each in ("pan", "decay", "damp")))
        own_id = f"carom.{_file_name(scene.title)}.{_file_name(name)}"
        found.append(Instrument(name, obj.preset.description, own_id, *values))
    if not found:
        raise ExportError(f"{scene.title}: expected an object with a mode that is heard")
    return found


def _described(scenes: Sequence[Scene], instruments: Sequence[Instrument]) -> str:
    """Return the header that says what a plug-in is made of."""
    baked = scenes[0].baked
    strikers = [OWN_STRIKER, *scenes[0].strikers.names]
    objects, descriptors = [], []
    for each in instruments:
        objects.append(f"    {{{_text(each.name)}, {', '.join(map(repr, each[3:]))}}},")
        words = (each.id, each.title, "Carom", "", "", "", version("carom"), each.description)
        descriptors.append(f"    {{CLAP_VERSION_INIT, {', '.join(map(_text, words))}, features}},")
    macros = [
        each._replace(
            unit=each.unit and f" {each.unit}",
            high=len(strikers) - 1.0 if math.isnan(each.high) else each.high,
            usual=0.0 if math.isnan(each.usual) else each.usual,
        )
        for each in MACROS
    ]
    rates = [int(scene.baked.engine.rate) for scene in scenes]
    return _HEAD.format(
        channels=baked.engine.channels,
        latency=baked.engine.delay + QUANTUM - 1,
        macros="\n".join(
            f"    {{{_text(one.name)}, {_text(one.unit)}, {', '.join(map(repr, one[2:]))}}}," for one in macros
        ),
        uris="\n".join(f"    {_text(each.uri)}," for each in instruments),
        ids="\n".join(f"    {{{', '.join(map(str, uuid5(NAMESPACE_URL, each.uri).bytes))}}}," for each in instruments),
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

enum {{ CHANNELS = {channels}, LATENCY = {latency} }}; /* LATENCY: frames */

/* The names by which hosts know the objects in other formats. */
static const char *const lv2_uris[] = {{
{uris}
}};
static const unsigned char vst3_ids[][16] = {{
{ids}
}};

#ifdef SCENES
const macro macros[MACROS] = {{
{macros}
}};

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
#if defined __APPLE__
#define READ_ONLY ".section __TEXT,__const"
#define AS_C(name) "_" name
#elif defined _WIN32
#define READ_ONLY ".section .rdata,\\"dr\\""
#define AS_C(name) name
#else
#define READ_ONLY ".section .rodata"
#define AS_C(name) name
#endif
#define BAKED(rate) \\
    __asm__(READ_ONLY "\\n.balign 64\\n" AS_C("scene_" #rate) ":\\n.incbin \\"" #rate ".carom\\"\\n" \\
            AS_C("scene_" #rate "_end") ":\\n.byte 0\\n.text"); \\
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
