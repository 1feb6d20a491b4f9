"""Sounds that stay as they are, to the bit, on every processor."""

import json

import pytest

from carom.dsp.contact.accuracy import LEVELS
from carom.dsp.schema import GESTURES
from tests.bench import golden


@pytest.mark.slow
@pytest.mark.parametrize("kernel", ["Haswell", "Nehalem"])
def test_portable_code_makes_the_bits_that_are_known(kernel: str) -> None:
    """Who changes a sound means to: `python -m tests.bench.golden --renew` writes its hash, and the commit says why.

    kernel: of BLAS; with the older one, the C library takes no fused products either.
    """
    older = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA"} if kernel == "Nehalem" else {}
    assert golden.rendered(OPENBLAS_CORETYPE=kernel, **older) == json.loads(golden.FILE.read_text())


def test_the_known_sounds_have_each_gesture_and_each_accuracy() -> None:
    words = {word for score in golden.SCORES.values() for word in score.replace("/", " ").split()}
    assert {*GESTURES, *LEVELS} <= words and len(golden.SCORES) == 10
