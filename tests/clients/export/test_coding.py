"""Coded numbers, decoded by a reader of its own: LZMA's, as its specification has it."""

import random

import numpy as np

from carom.clients.export.coding import LENGTH_BITS, Coder, Numbers
from carom.clients.export.tables import BITS, EXPONENT_BITS, KIND_BITS, STEPS, SUM, coded
from carom.dsp.runtime.series import rounded, sum_of, terms, values_of


class Reader:
    """A decoder of bits, by the words of LZMA's specification."""

    def __init__(self, content: bytes) -> None:
        assert content[0] == 0
        self._rest = iter(content[5:])
        self._code, self._range = int.from_bytes(content[1:5], "big"), 0xFFFFFFFF

    def bit(self, models: list[int], place: int) -> int:
        bound = (self._range >> 11) * models[place]
        if self._code < bound:
            self._range, bit = bound, 0
            models[place] += (2048 - models[place]) >> 5
        else:
            self._code, self._range, bit = self._code - bound, self._range - bound, 1
            models[place] -= models[place] >> 5
        self._fill()
        return bit

    def direct(self, count: int) -> int:
        number = 0
        for _ in range(count):
            self._range >>= 1
            bit = int(self._code >= self._range)
            self._code -= bit * self._range
            number = number << 1 | bit
            self._fill()
        return number

    def tree(self, models: list[int], first: int, count: int) -> int:
        node = 1
        for _ in range(count):
            node = node << 1 | self.bit(models, first + node)
        return node - (1 << count)

    def numbers(self, models: list[int], count: int) -> list[int]:
        found, before, last = [], 0, 0
        for _ in range(count):
            length = self.tree(models, (2 * before + (last > 0)) << LENGTH_BITS, LENGTH_BITS)
            told = self.direct(length)
            top = 1 << max(length - 1, 0)
            found.append(0 if not length else -told if told & top else told | top)
            before, last = last, length
        return found

    def _fill(self) -> None:
        if self._range < 1 << 24:
            self._range = self._range << 8 & 0xFFFFFFFF
            self._code = (self._code << 8 | next(self._rest)) & 0xFFFFFFFF


def test_numbers_come_back() -> None:
    """Sequences of numbers of all sizes, and none, are read as they were written, with what lies between them."""
    chance = random.Random(46)
    sequences = [[chance.randrange(-(2**n), 2**n) for n in range(1, 40)] + [0] * 5 for _ in range(50)] + [[]]
    coder = Coder()
    writer = Numbers(coder)
    for each in sequences:
        writer.put(each)
        coder.direct(len(each), 32)
    reader, models = Reader(coder.finished()), [1 << 10] * (2 << 2 * LENGTH_BITS)
    for each in sequences:
        assert reader.numbers(models, len(each)) == each
        assert reader.direct(32) == len(each)


def test_a_long_row_of_likely_bits_takes_little() -> None:
    """Ten thousand bits of 1 take some tens of bytes; carries through bytes of 255 are not lost."""
    coder, models = Coder(), [1 << 10]
    bits = [1] * 10_000 + [0] * 3 + [1] * 100
    for bit in bits:
        coder.bit(models, 0, bit)
    content = coder.finished()
    assert len(content) < 500
    reader, models = Reader(content), [1 << 10]
    assert [reader.bit(models, 0) for _ in bits] == bits


def test_columns_come_back_to_the_bit() -> None:
    """Columns of smooth shapes, of multiples of a step and of any values are told by their kinds, and come back."""
    x = np.linspace(0.0, 1.0, 100)[:, None]
    smooth = np.cos(np.pi * x * np.arange(1, 13)).astype(np.float32)
    rough = np.random.default_rng(46).normal(size=(100, 4)).astype(np.float32)
    table = np.concatenate([rounded(np.concatenate([smooth, rough], axis=1)), rough], axis=1)
    reader, kinds = Reader(coded([table])), [1 << 10] * (1 << KIND_BITS)
    models = {kind: [1 << 10] * (2 << 2 * LENGTH_BITS) for kind in (SUM, STEPS)}
    found = []
    for column in table.T:
        found.append(reader.tree(kinds, 0, KIND_BITS))
        if found[-1] == BITS:
            back = np.array([reader.direct(32) for _ in column], np.uint32).view(np.float32)
        else:
            scale = np.ldexp(np.ones(1), reader.direct(EXPONENT_BITS) - 1023)
            count = terms(100) if found[-1] == SUM else 100
            told = np.array(reader.numbers(models[found[-1]], count))[:, None]
            back = (sum_of(told, 100, scale) if found[-1] == SUM else values_of(told.cumsum(0).cumsum(0), scale))[:, 0]
        assert back.tobytes() == column.tobytes()
    assert found == [SUM] * 12 + [STEPS] * 4 + [BITS] * 4
