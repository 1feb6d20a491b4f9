"""Objects that are made like others: their modes are those of bodies that are made so from the first."""

import numpy as np
import pytest

from carom.dsp.engine.memory.capacity import MODES
from carom.dsp.engine.memory.commands import COMMAND, Command, Kind, write
from carom.dsp.runtime.copies import CHANGES, DENSITY, OTHER, OWN, SIZE, SPEED
from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from tests.clients.export import tiny

RATE = 48_000
LIBRARY = Presets()


def losses(name: str) -> tuple[float, float, float, float]:
    material = LIBRARY.material(name)
    return material.alpha, material.beta, material.loss_factor, material.loss_exponent


def octaves(one: str, other: str) -> tuple[float, float]:
    """Return the octaves of the wave speed and of the density from one material to another."""
    a, b = LIBRARY.material(one), LIBRARY.material(other)
    denser = np.log2(b.density / a.density)
    return float(0.5 * (np.log2(b.youngs_modulus / a.youngs_modulus) - denser)), float(denser)


@pytest.mark.parametrize(
    ("size", "material", "off", "lost"), [(2.0, "", 1e-3, 0.02), (0.7, "", 1e-3, 0.02), (1.0, "steel", 0.02, 0.2)]
)
def test_an_object_is_similar_to_the_one_that_it_is_made_like(
    size: float, material: str, off: float, lost: float
) -> None:
    """A bar in another size, or of another material: its frequencies, decays and what a blow makes of each."""
    engine = Engine(RATE)
    own = LIBRARY.object("triangle").replace(ends="free", length=0.3, width=0.03, thickness=0.01, material="aluminium")
    more = {"material": material} if material else {}
    other = own.replace(length=0.3 * size, width=0.03 * size, thickness=0.01 * size, **more)
    first, second = (engine.lay_out(each.modes(engine.top_frequency), 1.0) for each in (own, other))
    event, changes = np.zeros(1, COMMAND), np.zeros(CHANGES)
    write(event[0], 0, Command(-1.0, Kind.NEW, first[0], {**first[1], **_SETTINGS}))
    changes[SIZE], changes[OWN:OTHER], changes[OTHER:] = (
        np.log2(size),
        losses("aluminium"),
        losses(material or "aluminium"),
    )
    changes[SPEED], changes[DENSITY] = octaves("aluminium", material or "aluminium")
    to = int(second[1]["first"]) + int(second[1]["size"])
    count = int(first[1]["size"])
    assert tiny.copy(engine.pointer, event.ctypes.data, to, changes.ctypes.data) == to + count
    layout, bank = event[0]["layout"], engine.state[0]["bank"]
    assert (layout["first"], layout["sheet"], layout["table"]) == (to, -1, first[1]["table"])
    table, rows = int(layout["table"]), int(layout["rows"])
    shapes = bank["shape"][table : table + rows * count].reshape(rows, count) * 2.0 ** layout["lighter"]
    its_table, its_rows, its_count = (int(second[1][name]) for name in ("table", "rows", "size"))
    its = bank["shape"][its_table : its_table + its_rows * its_count].reshape(its_rows, its_count)
    wanted = slice(int(second[1]["first"]), int(second[1]["first"] + second[1]["felt"]))
    lowest = np.argsort(bank["frequency"][to : to + int(first[1]["felt"])])[:6]
    for mode in lowest:
        made = to + mode
        like = int(np.argmin(np.abs(bank["frequency"][wanted] - bank["frequency"][made])))
        real = wanted.start + like
        pairs = [
            (bank["frequency"][made], bank["frequency"][real], off),
            (bank["sigma"][made], bank["sigma"][real], lost),
            (np.sqrt((shapes[:, mode] ** 2).mean()), np.sqrt((its[:, like] ** 2).mean()), off + 0.01),
            (abs(bank["weight"][made]), abs(bank["weight"][real]), lost),
        ]
        for found, there, within in pairs:
            assert found == pytest.approx(there, rel=within), (mode, pairs)


_SETTINGS = {"gain": 1.0, "pan": 0.0, "decay": 1.0, "tune": 1.0, "damp": 0.0}


def test_what_cannot_be_is_not_copied() -> None:
    """No mode is written beyond the bank, over the object's own, or by numbers that are none."""
    engine = Engine(RATE)
    _, layout = engine.lay_out(LIBRARY.object("triangle").modes(engine.top_frequency), 1.0)
    event, changes = np.zeros(1, COMMAND), np.zeros(CHANGES)
    for name, value in layout.items():
        event[0]["layout"][name] = value
    after = int(layout["first"] + layout["size"])
    before = engine.state[0]["bank"]["frequency"][: 4 * after].copy()
    for to, place, value in ((after - 1, 0, 0.0), (MODES - 1, 0, 0.0), (-1, 0, 0.0), (after, SIZE, np.nan),
                             (after, SPEED, 11.0), (after, OWN, np.inf)):  # fmt: skip
        changes[:] = 0.0
        changes[place] = value
        assert tiny.copy(engine.pointer, event.ctypes.data, to, changes.ctypes.data) == 0
    event["kind"] = Kind.FREE
    changes[:] = 0.0
    assert tiny.copy(engine.pointer, event.ctypes.data, after, changes.ctypes.data) == 0
    assert (engine.state[0]["bank"]["frequency"][: 4 * after] == before).all()
