"""A number that takes its time: where it goes, how long each way takes, and by which curve."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import accumulate

from ...dsp.schema import CURVE, OVER, Parameter
from .arguments import Key, Point, Refused, Values, Verb, check_number, shown, spelled
from .wire import Argument

CHANGE = (OVER, CURVE)
"""Keys of what changes a number."""
MOST_POINTS = 64
"""Most points of a list."""


@dataclass(frozen=True)
class Change(Verb):
    """An address that changes a number: at once, in a time, or by a list of values with the time of each."""

    keys: tuple[Key, ...] = CHANGE

    @property
    def number(self) -> Parameter:
        """The number that it changes."""
        (number,) = self.required
        assert isinstance(number, Parameter)
        return number

    def parse(self, args: tuple[Argument, ...]) -> Values:
        """Return the last value by name, and the points on the way there; raise Refused that names the argument that
        does not fit."""
        if not args:
            return super().parse(args)
        keys: dict[str, Argument] = {}
        for key, value in self.pairs(args[1:]):
            if key in keys:
                raise Refused(f"{key} = {shown(value)}: given twice")
            keys[key] = value
        points = _points(self.number, args[0], keys)
        return Values({self.number.name: points[-1].value}, points=points)


@dataclass(frozen=True)
class Move(Verb):
    """An address that moves a point: x, y and z, or a list of points with the time of each, as a change's values."""

    keys: tuple[Key, ...] = CHANGE

    @property
    def numbers(self) -> tuple[Parameter, ...]:
        """The numbers that it changes."""
        return tuple(each for each in self.required if isinstance(each, Parameter))

    def parse(self, args: tuple[Argument, ...]) -> Values:
        """Return the last point, and for each number the points on the way there; raise Refused that names the argument
        that does not fit."""
        count = len(self.numbers)
        listed = bool(args) and isinstance(args[0], tuple | str)
        if not listed and len(args) < count:
            return super().parse(args)
        first = args[0] if listed else args[:count]
        values = tuple(first.split(",")) if isinstance(first, str) else first
        assert isinstance(values, tuple)
        if len(values) % count or not values:
            raise Refused(f"{self.action} = {shown(first)}: expected {count} numbers for each point")
        keys: dict[str, Argument] = {}
        for key, value in self.pairs(args[1:] if listed else args[count:]):
            if key in keys:
                raise Refused(f"{key} = {shown(value)}: given twice")
            keys[key] = value
        columns = [tuple(map(spelled, values[k::count])) for k in range(count)]
        paths = tuple(_points(number, each, keys) for number, each in zip(self.numbers, columns, strict=True))
        last = {number.name: path[-1].value for number, path in zip(self.numbers, paths, strict=True)}
        return Values(last, paths=paths)


def _points(number: Parameter, value: Argument, keys: Mapping[str, Argument]) -> tuple[Point, ...]:
    values = _numbers(number, value)
    if len(values) > MOST_POINTS:
        raise Refused(f"{number.name}: {len(values)} values: expected at most {MOST_POINTS}")
    if len(values) != 1 and OVER.name not in keys:
        raise Refused(f"{number.name} = {shown(value)}: over is missing: expected the time of each value, s")
    over, curve = (_of_each(len(values), each, keys.get(each.name, 0.0)) for each in (OVER, CURVE))
    return tuple(map(Point, values, accumulate(over, initial=0.0), over, curve))


def _of_each(count: int, number: Parameter, given: Argument) -> tuple[float, ...]:
    """Return a number for each of some values: a list, or one that is the same for all."""
    numbers = _numbers(number, given)
    if len(numbers) == 1:
        return numbers * count
    if len(numbers) != count:
        raise Refused(f"{number.name} = {shown(given)}: expected one number, or as many as there are values: {count}")
    return numbers


def _numbers(number: Parameter, value: Argument) -> tuple[float, ...]:
    """Return the numbers of a list, of a text such as 0.2,1, or of a number alone."""
    if isinstance(value, str) and "," in value:
        value = tuple(map(spelled, value.split(",")))
    if isinstance(value, tuple) and value:
        return tuple(check_number(number, each) for each in value)
    return (check_number(number, value),)
