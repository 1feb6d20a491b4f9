"""What hosts of LV2 read of a plug-in before they load it: its ports and their ranges, in Turtle."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from .instruments import MACROS, Instrument, Macro

_PREFIXES = """\
@prefix atom: <http://lv2plug.in/ns/ext/atom#> .
@prefix doap: <http://usefulinc.com/ns/doap#> .
@prefix lv2: <http://lv2plug.in/ns/lv2core#> .
@prefix midi: <http://lv2plug.in/ns/ext/midi#> .
@prefix rdf: <http://www.w3.org/1999/02/22-rdf-syntax-ns#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix units: <http://lv2plug.in/ns/extensions/units#> .
@prefix urid: <http://lv2plug.in/ns/ext/urid#> .
"""
_UNITS = {"semitones": "units:semitone12TET", "dB": "units:db", "times": "units:coef"}
_NOTES = """\
a lv2:InputPort , atom:AtomPort ;
        atom:bufferType atom:Sequence ;
        atom:supports midi:MidiEvent ;
        lv2:designation lv2:control ;
        lv2:symbol "notes" ;
        lv2:name "Notes\""""
_LATENCY = """\
a lv2:OutputPort , lv2:ControlPort ;
        lv2:designation lv2:latency ;
        lv2:portProperty lv2:reportsLatency , lv2:integer , lv2:connectionOptional ;
        lv2:minimum 0 ;
        lv2:maximum 8192 ;
        lv2:symbol "latency" ;
        lv2:name "Latency\""""


def turtle_files(
    instruments: Sequence[Instrument], strikers: Sequence[str], channels: int, library: str
) -> dict[str, str]:
    """Return the texts of a bundle's files by their names. library: the name of its library."""
    listed = "".join(
        f"\n<{each.uri}>\n    a lv2:Plugin ;\n    lv2:binary <{library}> ;\n    rdfs:seeAlso <plugins.ttl> .\n"
        for each in instruments
    )
    described = "".join(_plugin(each, strikers, channels) for each in instruments)
    return {"manifest.ttl": _PREFIXES + listed, "plugins.ttl": _PREFIXES + described}


def _plugin(instrument: Instrument, strikers: Sequence[str], channels: int) -> str:
    ports = [_NOTES, *(_control(each, instrument, strikers) for each in MACROS)]
    ports += [_output(n, channels) for n in range(channels)]
    listed = " , ".join(
        f"[\n        lv2:index {n} ;\n        {port}\n    ]" for n, port in enumerate([*ports, _LATENCY])
    )
    return f"""
<{instrument.uri}>
    a lv2:InstrumentPlugin , lv2:Plugin ;
    doap:name {_quoted(instrument.title)} ;
    doap:license <http://opensource.org/licenses/mit> ;
    rdfs:comment {_quoted(instrument.description)} ;
    lv2:requiredFeature urid:map ;
    lv2:optionalFeature lv2:hardRTCapable ;
    lv2:port {listed} .
"""


def _control(macro: Macro, instrument: Instrument, strikers: Sequence[str]) -> str:
    is_list = math.isnan(macro.high)
    high = len(strikers) - 1 if is_list else macro.high
    usual = instrument.position if math.isnan(macro.usual) else macro.usual
    lines = [
        "a lv2:InputPort , lv2:ControlPort",
        f'lv2:symbol "{_symbol(macro.name)}"',
        f"lv2:name {_quoted(macro.name)}",
        f"lv2:default {usual:.9f}",
        f"lv2:minimum {macro.low:.9f}",
        f"lv2:maximum {high:.9f}",
    ]
    if macro.unit in _UNITS:
        lines.append(f"units:unit {_UNITS[macro.unit]}")
    if is_list:
        points = " , ".join(f"[ rdfs:label {_quoted(each)} ; rdf:value {n} ]" for n, each in enumerate(strikers))
        lines += ["lv2:portProperty lv2:integer , lv2:enumeration", f"lv2:scalePoint {points}"]
    return " ;\n        ".join(lines)


def _output(place: int, channels: int) -> str:
    name = ("Left", "Right")[place] if channels == 2 else "Output"
    lines = ["a lv2:OutputPort , lv2:AudioPort", f'lv2:symbol "{name.lower()}"', f'lv2:name "{name}"']
    return " ;\n        ".join(lines)


def _symbol(name: str) -> str:
    """Return a name as LV2 takes a symbol: of letters, digits and _."""
    return re.sub(r"\W", "_", name.lower(), flags=re.ASCII)


def _quoted(text: str) -> str:
    """Return a text as Turtle writes it."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + " ".join(escaped.split()) + '"'
