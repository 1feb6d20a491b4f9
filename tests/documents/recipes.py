"""The keys of recipes, from their schema, and the recipes that there are."""

from carom.clients.dataset.recipe import DEFAULTS, GESTURES, KEYS, OWN, SCORE, read
from carom.clients.dataset.spread import FORMS
from carom.presets import BUILT_IN
from tests.documents.markdown import table

_MEANINGS = {
    "description": "description in one line",
    "design": "way in which the values of the items are drawn",
    "differ": "drawn keys (SECTION.KEY) that may differ within a pair; any if not given",
    "count": "number of items; for a grid, all of its points if not given",
    "seed": "seed of all random numbers",
    "seconds": "length of each clip",
    "rate": "sampling rate",
    "channels": "number of channels; 2: left and right",
    "format": "format of the sound files",
    "samples": "bits of a sample, or floats (WAV only)",
    "full_scale": "pressure of a sample of 1.0; if not given, a power of two for each item",
    "licence": "licence of the clips",
    "split": '`{ by = "geometry", test = 0.2, validation = 0.1 }`: shares of test and validation items',
    "shard": "number of items in a shard",
    "size": "factor of all lengths of the preset; also a key of `[by]`",
    "at": "beginning of the gesture; 0 if not given",
    "until": "time at which the gesture stops; never if not given",
}


def keys() -> str:
    """Return the keys of a recipe, those of its sections that no address has, and the distributions."""
    plain = {key: domain for key, domain in KEYS.items() if key not in (*OWN, *GESTURES, SCORE)}
    rows = [(f"`{key}`", _value(key, domain), _MEANINGS[key]) for key, domain in plain.items()]
    own = {"object": "`[object]` ", "impact": "any gesture's "}
    rows += [(f"{own[name]}`{key}`", str(domain), _MEANINGS[key]) for name in own for key, domain in OWN[name].items()]
    rows.append(
        (
            f"`[{SCORE}]` `file`",
            "a score in the recipe's folder",
            "score that every item plays; `$KEY` stands for a drawn value",
        )
    )
    forms = [(f"`{{ {form} }}`", what) for form, what in FORMS.items()]
    return "\n\n".join([table(("key", "value", "meaning"), rows), table(("distribution", "draws"), forms)])


def _value(key: str, domain: object) -> str:
    default = f"; {DEFAULTS[key]} if not given" if DEFAULTS.get(key) is not None else ""
    return f"{domain}{default}"


def listed() -> str:
    """Return the recipes that there are, and what each draws."""
    found = [read(path) for path in sorted((BUILT_IN / "recipes").glob("*.toml"))]
    return table(
        ("recipe", "items", "description"), [(f"`{each.name}`", f"{each.count:,}", each.description) for each in found]
    )
