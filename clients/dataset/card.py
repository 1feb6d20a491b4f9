"""The card of a data set: README.md, with the metadata that the Hugging Face Hub reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from .recipe import Recipe

_SIZES = ((1_000, "n<1K"), (10_000, "1K<n<10K"), (100_000, "10K<n<100K"), (1_000_000, "100K<n<1M"), (10**7, "1M<n<10M"))
_MANY = "10M<n<100M"

CARD = "README.md"
"""The file of the card."""

_HUB = """
afl-3.0 agpl-3.0 apache-2.0 artistic-2.0 bsd-2-clause bsd-3-clause bsd-3-clause-clear bsl-1.0 c-uda cc-by-2.0 cc-by-2.5
cc-by-3.0 cc-by-4.0 cc-by-nc-2.0 cc-by-nc-3.0 cc-by-nc-4.0 cc-by-nc-nd-3.0 cc-by-nc-nd-4.0 cc-by-nc-sa-2.0
cc-by-nc-sa-3.0 cc-by-nc-sa-4.0 cc-by-nd-4.0 cc-by-sa-3.0 cc-by-sa-4.0 cc0-1.0 cdla-permissive-1.0 cdla-permissive-2.0
cdla-sharing-1.0 ecl-2.0 epl-1.0 epl-2.0 etalab-2.0 eupl-1.1 gpl-2.0 gpl-3.0 isc lgpl-2.1 lgpl-3.0 lppl-1.3c mit mpl-2.0
ms-pl ncsa odbl odc-by ofl-1.1 osl-3.0 pddl postgresql unknown unlicense wtfpl zlib
"""
"""The licences that the Hub knows: its page "Licenses". It takes no other word."""

_SHORTER = {"odbl-1.0": "odbl", "odc-by-1.0": "odc-by", "pddl-1.0": "pddl"}
"""The Hub's words for some identifiers of SPDX."""


def _licence(identifier: str) -> str:
    """Return the lines that name a licence to the Hub, by its SPDX identifier."""
    plain = identifier.lower()
    known = _SHORTER.get(plain, plain.removesuffix("-only").removesuffix("-or-later"))
    return f"license: {known}" if known in _HUB.split() else f"license: other\nlicense_name: {plain}"


def card(recipe: Recipe, said: Mapping[str, Any]) -> str:
    """Return the card of a data set. said: the contents of dataset.json."""
    size = next((name for most, name in _SIZES if recipe.count < most), _MANY)
    factors = "\n".join(f"- `{each.name}`" for each in recipe.factors) or "- none"
    files = "\n".join(f"  - split: {side}\n    path: {name}" for side, name in said["tables"].items())
    full = f"{recipe.full_scale:g} Pa" if recipe.full_scale else "a power of two of each item's own, in Pa"
    return f"""---
{_licence(recipe.licence)}
pretty_name: {json.dumps(recipe.name)}
size_categories:
- {size}
task_categories:
- audio-classification
tags:
- audio
- synthetic
- physical-modelling
configs:
- config_name: default
  data_files:
{files}
---

# {recipe.name}

{recipe.description or "Clips of bodies that sound, with their ground truth."}

{recipe.count:,} clips of {recipe.seconds:g} s at {recipe.rate} Hz, computed by Carom {said["computed_by"]["carom"]}.
Full scale is {full}: the column `full_scale`.
The tables have the truth, a row for each clip, and the shards the sounds; of a split each side has its table, and the
column `split` names it. `carom.rebuild(row)` computes a clip's sound from its row, where `linear` is true.

Drawn for each item:

{factors}
"""
