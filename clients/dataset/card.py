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


def card(recipe: Recipe, said: Mapping[str, Any]) -> str:
    """Return the card of a data set. said: the contents of dataset.json."""
    size = next((name for most, name in _SIZES if recipe.count < most), _MANY)
    factors = "\n".join(f"- `{each.name}`" for each in recipe.factors) or "- none"
    full = f"{recipe.full_scale:g} Pa" if recipe.full_scale else "a power of two of each item's own, in Pa"
    return f"""---
license: {recipe.licence.lower()}
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
  - split: train
    path: {said["table"]}
---

# {recipe.name}

{recipe.description or "Clips of bodies that sound, with their ground truth."}

{recipe.count:,} clips of {recipe.seconds:g} s at {recipe.rate} Hz, computed by Carom {said["computed_by"]["carom"]}.
Full scale is {full}: the column `full_scale`.
The column `split` says which items are to be tested with. The table `{said["table"]}` has the truth, a row for each
clip, and the shards the sounds. `carom.rebuild(row)` computes a clip's sound from its row, where `linear` is true.

Drawn for each item:

{factors}
"""
