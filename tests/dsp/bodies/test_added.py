"""Additions to a shape's modes: partials, bands of noise, a cavity."""

import math
from dataclasses import replace

import numpy as np
import pytest

from carom.dsp import bodies
from carom.dsp.bodies import Noise, Partials
from carom.dsp.bodies.added import LOAD, Complete
from carom.dsp.bodies.air import IMPEDANCE
from carom.dsp.bodies.modes import MOST_MODES
from tests.dsp.bodies.reference import STEEL

BAR = {"material": STEEL, "length": 0.3, "width": 0.03, "thickness": 0.01}


def completed(*added, top=20000.0, written=STEEL, **changes):
    return Complete(bodies.bar, added, written)(top=top, **(BAR | changes))


def own_and_added(modes, **changes):
    """True for those of the modes that are the bar's own."""
    return np.isin(modes.frequency, bodies.bar(top=20000, **(BAR | changes)).frequency)


def loudness(modes):
    return np.sqrt((modes.strike**2).mean(axis=0) * (modes.pressure**2).mean(axis=0))


def test_partials_are_as_long_and_as_loud_as_they_are_given():
    modes = completed(Partials(frequency=(700.0, 5000.0, 30000.0), t60=(2.0, 0.5, 1.0), level=(-6.0, -30.0, 0.0)))
    own = own_and_added(modes)
    assert np.all(np.diff(modes.frequency) >= 0) and modes.mass == bodies.bar(top=20000, **BAR).mass
    assert modes.frequency[~own] == pytest.approx([700, 5000])
    assert modes.decay[~own] * [2.0, 0.5] == pytest.approx(math.log(1000))
    level = 20 * np.log10(loudness(modes)[~own] / loudness(modes)[own].max())
    assert level == pytest.approx([-6, -30], abs=1e-9)
    plain = bodies.bar(top=20000, **BAR)
    for array, other in ((modes.strike, plain.strike), (modes.pressure, plain.pressure), (modes.decay, plain.decay)):
        assert np.array_equal(array[..., own], other)


def test_a_partial_is_as_loud_at_any_sampling_rate():
    """The bar's loudest mode is at 7.1 kHz; at a rate of 8 kHz those up to 3.8 kHz are heard."""
    partials = Partials(frequency=(700.0, 3000.0), t60=(2.0, 0.5), level=(-6.0, -30.0))
    low, high = (completed(partials, top=top, thickness=0.005) for top in (3800.0, 20000.0))
    for frequency in (700.0, 3000.0):
        levels = [loudness(each)[each.frequency == frequency] for each in (low, high)]
        assert levels[0] == pytest.approx(levels[1], rel=1e-12)


def test_a_partial_is_as_loud_wherever_the_body_is_struck():
    modes = completed(Partials(frequency=(700.0,), t60=1.0, level=-6.0))
    (column,) = modes.strike[:, ~own_and_added(modes)].T
    assert np.ptp(column) == 0


def test_ratios_go_with_the_lowest_mode():
    for length in (0.3, 0.2):
        modes = completed(Partials(ratio=(1.5, 3.3), t60=1.0, level=-20.0), length=length)
        added = modes.frequency[~own_and_added(modes, length=length)]
        assert added / modes.frequency[0] == pytest.approx([1.5, 3.3])


def test_contacts_do_not_feel_what_is_added():
    partials, noise = (
        Partials(ratio=(1.5, 3.3, 4.0), t60=1.0, level=-50.0),
        Noise(edges=(1e3, 4e3), t60=1.0, level=-50.0),
    )
    modes = completed(partials, noise)
    yielding = (modes.strike[:, ~own_and_added(modes)] ** 2).sum(axis=1)
    assert yielding * modes.mass == pytest.approx(2 / LOAD)
    heard = loudness(modes)
    felt = completed(replace(partials, modal_mass=modes.mass), noise)
    assert loudness(felt) == pytest.approx(heard)
    assert (felt.strike**2).sum(axis=1) - (modes.strike**2).sum(axis=1) == pytest.approx(
        (3 - 1 / LOAD) / modes.mass, rel=1e-9
    )


def test_a_band_of_noise_is_as_many_modes_that_are_as_loud_together():
    noise = Noise(edges=(1000.0, 2000.0, 8000.0), t60=(0.5, 0.2), level=(-10.0, -20.0), modes=(40, 60))
    modes = completed(noise)
    added = ~own_and_added(modes)
    power = (loudness(modes) / loudness(modes)[~added].max()) ** 2
    for low, high, t60, level, count in ((1000, 2000, 0.5, -10, 40), (2000, 8000, 0.2, -20, 60)):
        band = added & (modes.frequency > low) & (modes.frequency < high)
        assert band.sum() == count
        assert 10 * math.log10(power[band].sum()) == pytest.approx(level)
        assert modes.decay[band] * t60 == pytest.approx(math.log(1000))
        step = (high - low) / count
        assert np.array_equal(np.floor((modes.frequency[band] - low) / step), np.arange(count))  # one in each part
        place = (modes.frequency[band] - low) / step % 1
        assert 0.35 < place.mean() < 0.65 and 0.2 < place.std() < 0.36  # anywhere there
    signs = np.sign(modes.pressure[0, added])
    assert 30 < (signs > 0).sum() < 70


def test_noise_is_the_same_whenever_it_is_made():
    noise = {"t60": 0.5, "level": -10.0}
    one, two = (completed(Noise(edges=(1000.0, 2000.0), **noise)) for _ in range(2))
    assert np.array_equal(one.frequency, two.frequency) and np.array_equal(one.pressure, two.pressure)
    alone, beside = Noise(edges=(1000.0, 2000.0), **noise), Noise(edges=(500.0, 1000.0, 2000.0), **noise)
    assert np.array_equal(alone.lines(1.0).frequency, beside.lines(1.0).frequency[24:])
    other = Noise(edges=(1001.0, 2001.0), **noise).lines(1.0).frequency
    assert np.abs(other - 1 - alone.lines(1.0).frequency).max() > 5
    relative = Noise(edge_ratio=(1000.0, 2000.0), **noise)
    assert relative.lines(2.0).frequency == pytest.approx(2 * alone.lines(1.0).frequency)


def test_losses_go_with_the_material_that_takes_the_place_of_another():
    partials = Partials(frequency=(3000.0, 6000.0), t60=(0.5, 40.0), level=-20.0)
    rubbery = replace(STEEL, loss_factor=0.1)
    same, changed = completed(partials), completed(partials, material=rubbery)
    decays = [modes.decay[np.isin(modes.frequency, (3000.0, 6000.0))] for modes in (same, changed)]
    assert decays[0] == pytest.approx(math.log(1000) / np.array([0.5, 40.0]))
    inside, other = STEEL.decay(np.array([3000.0, 6000.0])), rubbery.decay(np.array([3000.0, 6000.0]))
    assert decays[1][0] == pytest.approx(decays[0][0] - inside[0] + other[0])  # what it lost besides, it still loses
    assert decays[1][1] == pytest.approx(decays[0][1] * other[1] / inside[1])  # it had lost less than its material
    lossless = replace(STEEL, alpha=0.0, beta=0.0)
    again = completed(partials, written=lossless)
    assert again.decay[again.frequency == 3000.0] == pytest.approx(decays[0][0] + inside[0])


@pytest.mark.slow
def test_added_modes_take_the_place_of_the_highest_ones():
    make = Complete(bodies.disc, (Noise(edges=(1e3, 2e3), t60=1.0, level=0.0, modes=300),), STEEL)
    disc = {"material": STEEL, "radius": 0.3, "thickness": 0.001, "split": 0.004}
    full, plain = make(top=20000, **disc), bodies.disc(top=20000, **disc)
    assert full.frequency.size == plain.frequency.size == MOST_MODES
    own = np.isin(full.frequency, plain.frequency)
    assert np.array_equal(full.frequency[own], plain.frequency[: MOST_MODES - 300])
    with pytest.raises(ValueError, match="1024 modes are added: expected fewer than 1024"):
        replace(make, added=(Noise(edges=(1e3, 2e3, 3e3), t60=1.0, level=0.0, modes=512),))(top=20000, **disc)


@pytest.mark.parametrize(
    ("make", "arguments", "message"),
    [
        (Partials, {"t60": 1.0, "level": 0.0}, "frequency and ratio: expected one of the two"),
        (
            Partials,
            {"t60": 1.0, "level": 0.0, "frequency": (1.0,), "ratio": (1.0,)},
            "frequency and ratio: expected one",
        ),
        (Partials, {"t60": (1.0, 2.0), "level": 0.0, "ratio": (1.0,)}, "2 of t60, 1 of level: expected 1, as many as"),
        (Noise, {"t60": 1.0, "level": 0.0}, "edges and edge_ratio: expected one of the two"),
        (Noise, {"t60": 1.0, "level": 0.0, "edges": (100.0,)}, r"edges = \[100.0\]: expected two or more"),
        (Noise, {"t60": 1.0, "level": 0.0, "edges": (100.0, 100.0)}, "expected two or more, in ascending order"),
        (
            Noise,
            {"t60": 1.0, "level": (0.0, 1.0), "edges": (100.0, 200.0)},
            "2 of level.*: expected 1, as many as bands",
        ),
    ],
)
def test_arguments_that_do_not_fit_are_named(make, arguments, message):
    with pytest.raises(ValueError, match=message):
        make(**arguments)


def test_added_modes_radiate_no_more_than_they_lose():
    modes = completed(Partials(ratio=(1.5, 3.3, 4.0), t60=(1.0, 0.1, 9.0), level=(-40.0, 0.0, 10.0)))
    radiated = 4 * math.pi / IMPEDANCE * (modes.pressure**2).mean(axis=0)
    added = ~own_and_added(modes)
    assert np.all(radiated[added] <= 2 * modes.decay[added] * (1 + 1e-9))
    assert np.any(radiated[added] > 1.99 * modes.decay[added])  # the loud ones are as light as that asks for
