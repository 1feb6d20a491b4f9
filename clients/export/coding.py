"""Numbers as bits whose odds are learned, as LZMA codes them: `bits.js` decodes them.

A bit has a model, of its probability in 2^-11, which adapts. A number has its length in bits, coded by a tree of models
that the lengths of the two before it choose, then its sign and its lower bits, whose odds are even.
"""

from collections.abc import Iterable

LENGTH_BITS = 6
"""Bits of a number's length."""
_EVEN = 1 << 10
_TOP = 1 << 24


class Coder:
    """A range coder: bits go in, bytes come out."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._low, self._range = 0, 0xFFFFFFFF
        self._held, self._waiting = 0, 1  # a byte that a carry may still change, and those of 255 after it

    def bit(self, models: list[int], place: int, bit: int) -> None:
        """Write a bit by a model, which learns it."""
        bound = (self._range >> 11) * models[place]
        if bit:
            self._low += bound
            self._range -= bound
            models[place] -= models[place] >> 5
        else:
            self._range = bound
            models[place] += (2048 - models[place]) >> 5
        while self._range < _TOP:
            self._shift()

    def direct(self, number: int, count: int) -> None:
        """Write the lowest bits of a number, the highest first, by even odds."""
        for n in range(count - 1, -1, -1):
            self._range >>= 1
            if number >> n & 1:
                self._low += self._range
            while self._range < _TOP:
                self._shift()

    def tree(self, models: list[int], first: int, number: int, count: int) -> None:
        """Write a number of so many bits, the highest first, by models whose first is given."""
        node = 1
        for n in range(count - 1, -1, -1):
            bit = number >> n & 1
            self.bit(models, first + node, bit)
            node = node << 1 | bit

    def finished(self) -> bytes:
        """Return all bytes; nothing is coded afterwards."""
        for _ in range(5):
            self._shift()
        return bytes(self._bytes)

    def _shift(self) -> None:
        self._range = self._range << 8 & 0xFFFFFFFF
        if self._low < 0xFF000000 or self._low > 0xFFFFFFFF:
            carry = self._low >> 32
            self._bytes += bytes([(self._held + carry) & 0xFF]) + bytes([(0xFF + carry) & 0xFF]) * (self._waiting - 1)
            self._held, self._waiting = self._low >> 24 & 0xFF, 0
        self._waiting += 1
        self._low = self._low << 8 & 0xFFFFFFFF


class Numbers:
    """A coder of sequences of whole numbers below 2^40."""

    def __init__(self, coder: Coder) -> None:
        self._coder = coder
        self._models = [_EVEN] * (2 << 2 * LENGTH_BITS)

    def put(self, numbers: Iterable[int]) -> None:
        """Write a sequence."""
        before = last = 0  # lengths of the two before
        for number in numbers:
            size = abs(number)
            length = size.bit_length()
            self._coder.tree(self._models, (2 * before + (last > 0)) << LENGTH_BITS, length, LENGTH_BITS)
            if length:
                self._coder.direct((number < 0) << (length - 1) | size & ~(1 << (length - 1)), length)
            before, last = last, length
