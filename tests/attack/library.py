"""Calls of an exported scene's library for C: messages, times and counts that can't be, and bytes that are no scene."""

import ctypes
import math
import random
import subprocess
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from carom.server.osc.score import format_line
from tests.attack import Tried, kind
from tests.attack.arguments import message
from tests.attack.children import Child, Died
from tests.bench import mutated_scenes

_SECONDS = 10
_CALLS = 200
_MOST = 8_192  # frames at once
_TIMES = (-1.0, 0.0, 0.1, math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 1e9, 2.0**63)
_WHOLES = (0, 1, -1, 2, 63, 64, 2**31 - 1, -(2**31))


@kind("library", 0)  # tests/clients/export/test_mutated.py has the short form, where there is a library
def library(chance: random.Random) -> Iterator[Tried]:
    """Two hundred calls, in any order, of a library whose engine is that of the tests."""
    with tempfile.TemporaryDirectory() as made, Child() as child:
        mutated_scenes.build(Path(made), tiny=True)
        shared = shared_of(Path(made))
        while True:
            seed, scene = chance.getrandbits(48), Path(made) / f"{chance.choice(list(mutated_scenes.SCORES))}.carom"
            try:
                refused, fine, fault = child.run(attempt, str(shared), scene.read_bytes(), seed, cpu=_SECONDS)
                yield Tried(refused, fine, (f"{fault}: {scene.stem}, {seed}",) if fault else ())
            except Died as died:
                yield Tried(faults=(f"{died}: {scene.stem}, {seed}",))


def shared_of(folder: Path) -> Path:
    """Return the shared library that a folder's static one becomes."""
    words = ["-shared", "-Wl,--whole-archive", "libcarom.a", "-Wl,--no-whole-archive", "-lm", "-o", "libcarom.so"]
    subprocess.run(["cc", *words], cwd=folder, check=True)
    return folder / "libcarom.so"


def attempt(shared: str, scene: bytes, seed: int) -> tuple[int, int, str]:
    """Make the calls of a seed; return how many were refused, how many were not, and what is wrong; "" nothing."""
    chance, c, refused, fine = random.Random(seed), _loaded(shared), 0, 0
    opened = ctypes.c_void_p(c.carom_open(scene, len(scene), chance.randrange(2)))
    sound = (ctypes.c_float * (_MOST * c.carom_channels(opened)))()
    for _ in range(_CALLS):
        what = chance.randrange(8)
        if what < 4:
            taken = c.carom_send(opened, _text(chance), chance.choice(_TIMES))
            if not taken and len(c.carom_answer(opened)) < 3:
                return refused, fine, "a refusal that says nothing"
            refused, fine = refused + (not taken), fine + taken
        elif what == 4:
            frames = chance.choice((0, 1, 63, 64, 65, _MOST))
            c.carom_process(opened, sound, frames)
            if not all(map(math.isfinite, sound[: frames * c.carom_channels(opened)])):
                return refused, fine, "a sample is no number"
            fine += 1
        elif what == 5:
            number = chance.choice(_WHOLES)
            c.carom_object(opened, number), c.carom_pitch(opened, number)
            fine += 1
        elif what == 6 and chance.random() < 0.2:
            c.carom_load(opened, chance.choice(_WHOLES))
            fine += 1
        else:
            cut = chance.choice((0, 1, 7, 8, 47, 48, len(scene) // 2, len(scene) - 1))
            refused += c.carom_open(scene[:cut], cut, 1) is None
    c.carom_close(opened)
    return refused, fine, ""


def _text(chance: random.Random) -> bytes:
    """Return a message as text: as a score has it, with names of the scenes, or bytes at random."""
    if chance.random() < 0.1:
        return chance.randbytes(chance.choice((0, 3, 300, 20_000))).replace(b"\0", b"\1")
    said = message(chance)
    try:
        text = format_line(0.0, said).split(" ", 1)[1]
    except (ValueError, TypeError):
        text = f"{said.address} {' '.join(map(str, said.args))}"
    for name, own in zip("abcdefgh", ("bell", "bar", "fork", "small", "ring", "other", "plate", "p"), strict=True):
        text = text.replace(f"/{name}/", f"/{own}/")
    return text.encode(errors="surrogatepass")


@cache
def _loaded(shared: str) -> ctypes.CDLL:
    c = ctypes.CDLL(shared)
    c.carom_open.restype, c.carom_open.argtypes = ctypes.c_void_p, [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_int]
    c.carom_send.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_double]
    c.carom_answer.restype, c.carom_object.restype, c.carom_pitch.restype = (
        ctypes.c_char_p,
        ctypes.c_char_p,
        ctypes.c_double,
    )
    c.carom_process.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t]
    return c
