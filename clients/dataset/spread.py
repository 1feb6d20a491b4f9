"""The spread of a value over items: distributions, each a function of a number u from 0 to below 1."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

from ...dsp.wording import expected
from ...presets.schema import PresetError, check
from ...presets.values import Domain, Quantity, Row, Text, Unfit, Whole, shown

Value = float | int | str | tuple[float | int | str, ...]
"""A value of a key; lists stand as they are, and are not drawn from."""

_ANY = Quantity(-1e12, 1e12)
_POSITIVE = Quantity(1e-12, 1e12)
_STEPS = Whole(2, 1_000_000)
_MOST_OPTIONS = 10_000


class Spread(ABC):
    """A distribution."""

    levels: int = 0
    """Number of values that there are; 0: any number."""

    @property
    @abstractmethod
    def ends(self) -> tuple[Value, ...]:
        """The values at both ends, or all of a choice."""

    @abstractmethod
    def at(self, u: float) -> Value:
        """Return the value at a share u of the distribution."""

    def level(self, u: float) -> int:
        """Return which of its levels a share u gives."""
        return int(u * self.levels)

    def middle(self, level: int) -> float:
        """Return a share u that gives a level."""
        return (level + 0.5) / self.levels


@dataclass(frozen=True)
class Between(Spread):
    """Even between two numbers, or even in their logarithm; levels: so many values alone, both ends among them."""

    low: float
    high: float
    by_ratios: bool = False
    levels: int = 0

    @property
    def ends(self) -> tuple[Value, ...]:
        return self.low, self.high

    def at(self, u: float) -> float:
        if self.levels:
            u = self.level(u) / (self.levels - 1)
        if u == 1.0:
            return self.high
        return self.low * (self.high / self.low) ** u if self.by_ratios else self.low + (self.high - self.low) * u


@dataclass(frozen=True)
class Normal(Spread):
    """Normal with a mean and a standard deviation, cut off at two numbers."""

    mean: float
    deviation: float
    low: float
    high: float

    @property
    def ends(self) -> tuple[Value, ...]:
        return self.low, self.high

    def at(self, u: float) -> float:
        from scipy.special import ndtr, ndtri  # slow to load

        below, above = (float(ndtr((end - self.mean) / self.deviation)) for end in (self.low, self.high))
        value = self.mean + self.deviation * float(ndtri(below + (above - below) * u))
        return min(max(value, self.low), self.high)


@dataclass(frozen=True)
class Choice(Spread):
    """One of some values, each as likely as its weight is high."""

    options: tuple[Value, ...]
    weights: tuple[float, ...] = ()

    @property
    def levels(self) -> int:  # type: ignore[override]
        return len(self.options)

    @property
    def ends(self) -> tuple[Value, ...]:
        return self.options

    def at(self, u: float) -> Value:
        return self.options[self.level(u)]

    def level(self, u: float) -> int:
        if not self.weights:
            return super().level(u)
        target = u * sum(self.weights)
        return next(n for n, above in enumerate(accumulate(self.weights)) if target < above)

    def middle(self, level: int) -> float:
        if not self.weights:
            return super().middle(level)
        return (sum(self.weights[:level]) + 0.5 * self.weights[level]) / sum(self.weights)


@dataclass(frozen=True)
class _Options:
    """Numbers, or words."""

    def __str__(self) -> str:
        return f"a list of 1 to {_MOST_OPTIONS} numbers, or of words"

    def fit(self, value: object) -> tuple[Any, ...]:
        if isinstance(value, list) and 0 < len(value) <= _MOST_OPTIONS:
            if all(isinstance(each, str) for each in value):
                return tuple(value)
            if all(isinstance(each, int | float) and not isinstance(each, bool) for each in value):
                return tuple(map(float, value))
        raise Unfit(value, self)


@dataclass(frozen=True)
class _Weights:
    """The weights of a choice: as many numbers as there are options, which the caller knows."""

    def __str__(self) -> str:
        return "a list of numbers above 0, one for each of the choice"

    def fit(self, value: object) -> tuple[float, ...]:
        if not isinstance(value, list) or not value:
            raise Unfit(value, self)
        return tuple(_POSITIVE.fit(each) for each in value)


@dataclass(frozen=True)
class Words(Text):
    """A list of words."""

    def __str__(self) -> str:
        return "a list of words"

    def fit(self, value: object) -> Any:
        if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
            raise Unfit(value, self)
        return tuple(value)


_PAIR = Row((_ANY, _ANY))
_KINDS: Mapping[str, Mapping[str, Any]] = {
    "uniform": {"uniform": _PAIR, "steps": _STEPS},
    "log_uniform": {"log_uniform": Row((_POSITIVE, _POSITIVE)), "steps": _STEPS},
    "normal": {"normal": Row((_ANY, _POSITIVE)), "low": _ANY, "high": _ANY},
    "choice": {"choice": _Options(), "weights": _Weights()},
}
"""The keys of each kind of distribution; the first is its own name."""

FORMS = {
    "uniform = [low, high]": "evenly between two numbers; with `steps = N`, one of N values, which include both ends",
    "log_uniform = [low, high]": "evenly on a logarithmic scale, from low to high; `steps` as above",
    "normal = [mean, deviation], low = X, high = Y": "from a normal distribution, cut off at two numbers",
    "choice = [...]": "one of the words or numbers; `weights = [...]` sets how often each is drawn",
}
"""Forms of a distribution as recipes have them, and what each draws."""


def spread_of(where: str, table: Mapping[str, object]) -> Spread:
    """Return the distribution that a table of a recipe says. `where` begins the text of a PresetError."""
    kinds = [kind for kind in _KINDS if kind in table]
    if len(kinds) != 1:
        known = f"expected one of {', '.join(_KINDS)}" if kinds else expected(next(iter(table), ""), _KINDS)
        raise PresetError(f"{where.rstrip(' .')} = {shown(dict(table))}: {known}")
    kind = kinds[0]
    fields: Mapping[str, Domain] = _KINDS[kind]
    values = check(where, table, fields, ("low", "high") if kind == "normal" else ())
    if kind == "choice":
        return _choice(where, values)
    if kind == "normal":
        mean, deviation = values["normal"]
        _require_order(where, "low, high", values["low"], values["high"])
        return Normal(mean, deviation, values["low"], values["high"])
    low, high = values[kind]
    _require_order(where, kind, low, high)
    return Between(low, high, kind == "log_uniform", values.get("steps", 0))


def _choice(where: str, values: Mapping[str, Any]) -> Choice:
    options, weights = values["choice"], values.get("weights", ())
    if weights and len(weights) != len(options):
        raise PresetError(f"{where}weights = {shown(weights)}: expected {len(options)}, one for each of the choice")
    if len(set(options)) != len(options):
        raise PresetError(f"{where}choice = {shown(options)}: expected each of them once")
    return Choice(options, weights)


def _require_order(where: str, key: str, low: float, high: float) -> None:
    if not low < high:
        raise PresetError(f"{where}{key} = {shown([low, high])}: expected two numbers, the lower one first")
