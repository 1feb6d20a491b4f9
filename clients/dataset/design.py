"""The design of a data set: the factors of each item, which follow from the recipe and the item's number alone."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .recipe import GESTURE, SCORE, Recipe
from .scores import FILE
from .spread import Value

_BITS = 30  # of a Sobol point
_MOST_AHEAD = 32  # items that nobody may ask for
_BLOCK = 256  # of Sobol's points that are found together


@dataclass(frozen=True)
class Item:
    """An item of a data set. seed: of its gesture's random numbers. gesture: the section that says what is done.

    values: of that section and those of the objects, by section and key. factors: those that were drawn, by name.
    pair, differs: of a design of pairs, its pair's number, and the factor in which the second differs from the first.
    """

    number: int
    seed: int
    gesture: str
    values: Mapping[str, Mapping[str, Value]]
    factors: Mapping[str, Value] = field(default_factory=dict)
    pair: int = -1
    differs: str = ""


def items(recipe: Recipe, numbers: range) -> list[Item]:
    """Return the items of some numbers in a row."""
    shares = _sobol(recipe, numbers) if recipe.design == "sobol" else None
    return [_item(recipe, number, None if shares is None else shares[place]) for place, number in enumerate(numbers)]


def one_by_one(recipe: Recipe, numbers: Iterable[int]) -> Iterator[Item]:
    """Yield the items of numbers; of numbers in a row more and more are found at once, which takes a third of the
    time."""
    ahead: list[Item] = []
    count, expected = 1, -1
    for number in numbers:
        if not ahead or number != expected:
            count = min(2 * count, _MOST_AHEAD) if number == expected else 1
            ahead = items(recipe, range(number, min(number + count, recipe.count)))[::-1]
        yield ahead.pop()
        expected = number + 1


def _item(recipe: Recipe, number: int, shares: NDArray[np.float64] | None) -> Item:
    """Return an item. shares: of each factor's distribution, where the design says them."""
    pair = number // 2 if recipe.design == "pairs" else -1
    of_its_own = np.random.SeedSequence(recipe.seed, spawn_key=(number if pair < 0 else pair,))
    random = np.random.Generator(np.random.PCG64(of_its_own))
    drawn = random.random(len(recipe.factors))
    seed = int(random.integers(2**31))
    if shares is not None:
        drawn = shares
    if recipe.design == "grid":
        drawn = _on_grid(recipe, number, drawn)
    item = _made(recipe, number, seed, drawn)
    if pair < 0:
        return item
    place = _differing(recipe, item, random)
    if number % 2:
        drawn[place] = _other(recipe, place, drawn[place], random)
        item = _made(recipe, number, seed, drawn)
    return Item(number, seed, item.gesture, item.values, item.factors, pair, recipe.factors[place].name)


def _made(recipe: Recipe, number: int, seed: int, shares: NDArray[np.float64]) -> Item:
    drawn = {each.name: each.spread.at(u) for each, u in zip(recipe.factors, shares.tolist(), strict=True)}
    gesture = str(drawn.get(GESTURE, recipe.gestures[0]))
    used = [section for section in recipe.sections if section == gesture or section not in recipe.gestures]
    values: dict[str, dict[str, Any]] = {
        section: {key: drawn.get(f"{section}.{key}", value) for key, value in recipe.sections[section].items()}
        for section in used
    }
    factors = {name: value for name, value in drawn.items() if name == GESTURE or name.partition(".")[0] in used}
    if gesture == SCORE:  # a word that another score says alone makes no difference
        words = {FILE, *recipe.scores[str(values[SCORE][FILE])].words}
        factors = {name: value for name, value in factors.items() if name.partition(".")[2] in words}
    return Item(number, seed, gesture, values, factors)


def _on_grid(recipe: Recipe, number: int, shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the shares in which the factors of a grid are those of an item's point; the last factor changes
    fastest."""
    placed = shares.copy()
    for place, factor in reversed(list(enumerate(recipe.factors))):
        if factor.spread.levels:
            number, level = divmod(number, factor.spread.levels)
            placed[place] = factor.spread.middle(level)
    return placed


def _sobol(recipe: Recipe, numbers: range) -> NDArray[np.float64]:
    """Return points of Sobol's sequence, (items, factors), moved by a digital shift that the recipe's seed says.

    The shift keeps the evenness of any 2^m points in a row that begin at a multiple of 2^m.
    """
    count = len(recipe.factors)
    blocks = range(numbers.start // _BLOCK, -(-numbers.stop // _BLOCK))
    parts = [_shifted_block(recipe.seed, count, block) for block in blocks]
    points = parts[0] if len(parts) == 1 else np.concatenate(parts)
    first = blocks.start * _BLOCK
    return points[numbers.start - first : numbers.stop - first]


@lru_cache(maxsize=16)
def _shifted_block(seed: int, count: int, block: int) -> NDArray[np.float64]:
    """Return the points of a block, (_BLOCK, count), moved by the shift of a seed; read-only."""
    points: NDArray[np.float64] = ((_sobol_block(count, block) ^ _shift(seed, count)) + 0.5) / 2**_BITS
    points.flags.writeable = False
    return points


@lru_cache(maxsize=16)
def _shift(seed: int, count: int) -> NDArray[np.int64]:
    """Return the digital shift of each factor, (count,); read-only."""
    shift: NDArray[np.int64] = np.random.default_rng(np.random.SeedSequence(seed)).integers(2**_BITS, size=count)
    shift.flags.writeable = False
    return shift


@lru_cache(maxsize=16)
def _sobol_block(count: int, block: int) -> NDArray[np.int64]:
    """Return a block of _BLOCK points of Sobol's sequence, (_BLOCK, count), in steps of 2^-_BITS; read-only."""
    from scipy.stats import qmc  # slow to load

    sequence = qmc.Sobol(count, scramble=False, bits=_BITS)
    # scipy warns of a first draw that is no power of 2: it does not know that others come before and after it.
    if block:
        sequence.fast_forward(block * _BLOCK)
    points: NDArray[np.int64] = (sequence.random(_BLOCK) * 2**_BITS).astype(np.int64)
    points.flags.writeable = False
    return points


def _differing(recipe: Recipe, item: Item, random: np.random.Generator) -> int:
    """Return the place of the factor in which the items of a pair differ."""
    able = [
        place
        for place, factor in enumerate(recipe.factors)
        if factor.name in item.factors and factor.spread.levels != 1 and _may_differ(recipe.differ, factor.name)
    ]
    return able[int(random.integers(len(able)))]


def _may_differ(differ: Sequence[str], name: str) -> bool:
    return name in differ if differ else name != GESTURE


def _other(recipe: Recipe, place: int, share: float, random: np.random.Generator) -> float:
    """Draw another share of a factor's distribution, of another of its levels where it has such."""
    spread = recipe.factors[place].spread
    if not spread.levels:
        return float(random.random())
    others = [level for level in range(spread.levels) if level != spread.level(share)]
    return spread.middle(others[int(random.integers(len(others)))])
