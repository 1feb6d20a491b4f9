"""Tables of the presets: the keys of every kind of file, the values that they may have, and all presets there are."""

import json
from collections.abc import Collection, Mapping
from pathlib import Path

from carom.dsp.schema import GESTURES
from carom.presets import BUILT_IN, KINDS, Presets, gestures
from carom.presets import schema as known
from carom.presets.meanings import MEANINGS
from carom.presets.supports import SUPPORTS
from carom.presets.values import Choice, Many, Name, OneOrMany, Quantity, Row, Rows, Whole
from tests.bench.loudness import MEASURED
from tests.documents.markdown import table

_HEAD = ("key", "value", "default", "meaning")
_REQUIRED_OF_OBJECT = ("description", "source", "shape", "level")


def _value(domain: known.Domain) -> str:
    """Return a domain in few words."""
    match domain:
        case Row(items):
            return f"{len(items)} values, each {_value(items[0])}"
        case OneOrMany(item):
            return f"{_value(item)}; one, or a list"
        case Many(Row() as item):
            return f"a list of rows: {_value(item)}"
        case Many(item):
            return f"a list, each {_value(item)}"
        case Rows(item):
            return f"a list of lists, each value {_value(item)}"
        case Quantity():
            return domain.allowed + ", whole" * isinstance(domain, Whole)
        case Choice(options):
            return ", ".join(f"`{word}`" for word in options)
        case Name():
            return "a preset's name"
    return str(domain)


def _keys(where: str, fields: known.Fields, required: Collection[str] = ()) -> str:
    rows = []
    for key, domain in fields.items():
        meaning, _, default = _meaning(where, key).partition(" | ")
        rows.append((f"`{key}`", _value(domain), "required" if key in required else default, _sentence(meaning)))
    return table(_HEAD, rows)


def _sentence(text: str) -> str:
    return f"{text[0].upper()}{text[1:]}."


def _usual(name: str) -> str:
    """Return the keys of a gesture's section that are required: the words, and the gesture's argument."""
    fields = gestures.FIELDS[name]
    words = {key: domain for key, domain in fields.items() if isinstance(domain, Name)}
    first = GESTURES[name].argument
    rows = [(f"`{key}`", "a preset's name", "required", f"Preset of the {key}.") for key in words]
    rows.append((f"`{first.name}`", first.allowed, "required", _sentence(first.help)))
    return table(_HEAD, rows)


def _meaning(where: str, key: str) -> str:
    return MEANINGS[where, key] if (where, key) in MEANINGS else MEANINGS["", key]


def object_keys() -> str:
    """Return the keys of an object's file and of its sections."""
    return _sections(
        {
            "An object": _keys("object", known.OBJECT, _REQUIRED_OF_OBJECT),
            "`[damping]`, in place of the material's": _keys("damping", known.DAMPING),
            "`[strike]`": _keys("strike", known.STRIKE, known.STRIKE),
            "`[rest]`": _keys("rest", known.REST, ("support",)),
            "`[mesh]`": _keys("mesh", known.MESH, ()),
            **{f"`[{name}]`": _keys(name, added.fields, added.required) for name, added in known.ADDED.items()},
            **{f"`[{name}]`": _usual(name) for name in known.SUITABLE},
        }
    )


def other_keys() -> str:
    """Return the keys of the files of strikers, materials and surfaces, and of their sections."""
    striker = "click", "ringing", "snap", "slide"
    of_striker = zip(striker, (known.CLICK, known.RINGING, known.SNAP, known.SLIDE), strict=True)
    needed = {
        "click": ("radius",),
        "ringing": ("frequency", "t60", "modal_mass"),
        "snap": tuple(known.SNAP),
        "slide": (),
    }
    parts = {
        "A striker": _keys("striker", known.STRIKER, known.DESCRIPTION),
        **{f"`[{name}]` of a striker": _keys(name, fields, needed[name]) for name, fields in of_striker},
        "A material": _keys("material", known.MATERIAL, known.MATERIAL_REQUIRED),
        "A surface": _keys("surface", known.SURFACE, known.SURFACE_REQUIRED),
    }
    return _sections(parts)


def _sections(parts: Mapping[str, str]) -> str:
    return "\n\n".join(f"## {title}\n\n{part}" for title, part in parts.items())


def shapes() -> str:
    """Return the keys of `[geometry]`, shape by shape."""
    parts = []
    for name, shape in known.SHAPES.items():
        one, other = ([f"`{key}`" for key in shape.fields if key in side] for side in shape.either)
        single = len(one) == len(other) == 1
        rule = "Give either {} or {}." if single else "Give keys from only one of these groups: {}; or {}."
        note = f"\n\n{rule.format(', '.join(one), ', '.join(other))}" if one else ""
        parts.append(f"## `{name}`\n\n{_keys(name, shape.fields, shape.required)}{note}")
    return "\n\n".join(parts)


def listed() -> str:
    """Return the presets of each kind, each with what it says of itself."""
    presets = Presets()
    parts = []
    for kind in KINDS:
        names = presets.names(kind)
        rows = [(f"`{name}`", presets.description(kind, name).replace("\n", " ")) for name in names]
        if kind == "materials":
            rows = [(name, _material(presets, name.strip("`"))) for name, _ in rows]
        parts.append(f"## {len(names)} {kind}\n\n{table(('name', 'description'), rows)}")
    return "\n\n".join(parts)


def _material(presets: Presets, name: str) -> str:
    material = presets.material(name)
    return f"{material.density:g} kg/m³, {material.youngs_modulus / 1e9:.3g} GPa"


def scores() -> str:
    """Return the scores, each with the comment that it begins with."""
    rows = [
        (f"[{path.name}](scores/{path.name})", _comment(path)) for path in sorted((BUILT_IN / "scores").glob("*.txt"))
    ]
    return table(("score", "events"), rows)


def _comment(path: Path) -> str:
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#") or line.startswith("# time "):  # the head of its columns
            break
        lines.append(line.lstrip("# ").split("   ")[0])
    return " ".join(lines)


def levels() -> str:
    """Return the loudness of each object at its defaults, as `make levels` measured it."""
    rows = []
    for name, row in json.loads(MEASURED.read_text(encoding="utf-8")).items():
        others = (f"{row['gestures'][each]:+.0f}" if each in row["gestures"] else "" for each in known.SUITABLE)
        strike = f"{row['level']:.1f}", f"{row['loudness']:.1f}", f"{row['peak']:.1f}"
        rows.append((f"`{name}`", *strike, f"{row['pascals']:.2g}", f"{row['pressure_level']:.0f}", *others))
    head = "name", "level, dB", "LUFS", "peak, dBFS", "Pa", "dB SPL", *known.SUITABLE
    return table(head, rows)


def supports() -> str:
    """Return the table of supports."""
    lines = ["| support | is | stiffness and resistance at a load |", "|---|---|---|"]
    for name, each in SUPPORTS.items():
        load = each.load or 1.0
        spring = each.exponent * each.stiffness ** (1 / each.exponent) * load ** (1 - 1 / each.exponent)
        law = f"{spring:.2g} N/m, {each.dissipation * load:.2g} N s/m at {load:g} N"
        ground = f"; ground: {each.resistance:.3g} N s/m" if each.resistance else ""
        mass = f"; mass {each.mass:g} kg" if each.mass else ""
        of = f"from the object's material and {each.material}" if each.material else law
        lines.append(f"| `{name}` | {each.description} | {of}{mass}{ground} |")
    return "\n".join(lines)


def support_sources() -> str:
    """Return where the figures of supports are from."""
    return "\n".join(f"- `{name}`: {each.source}." for name, each in SUPPORTS.items())
