"""The pieces of what breaks: their masses sum to its own, and no blow gains energy."""

import math
from itertools import pairwise

import numpy as np
import pytest

from carom.dsp.numerics.constants import STANDARD_GRAVITY
from carom.dsp.swarm.pieces import (
    BOUNCES,
    SLOWEST,
    bend_piece,
    bounce_piece,
    break_up,
    freed_by_cracks,
    freed_within,
    heard_above,
    landing_of,
    number_of,
    piece_below,
    piece_beside,
)
from carom.dsp.swarm.record import SWARM
from carom.dsp.swarm.ringing import bent_by
from carom.dsp.swarm.tables import contact_form
from carom.dsp.swarm.times import GAP, seed_swarm, uniform


def broken(seed, count=200, whole=0.25, speed=3.0, height=0.5, steepness=1.35):
    """Return a swarm of the pieces of what broke."""
    swarm = np.zeros(1, SWARM)[0]
    seed_swarm(swarm, np.uint64(seed))
    swarm["m"] = 1e-3
    break_up(swarm, whole, count, speed, height, 5e-3, steepness)
    return swarm


@pytest.mark.parametrize("count", [1, 7, 200])
def test_pieces_have_the_mass_of_the_whole(count):
    mass = broken(3, count)["mass_of"]
    assert mass[:count].sum() == pytest.approx(0.25, rel=1e-12) and np.all(mass[:count] > 0) and not mass[count:].any()


@pytest.mark.parametrize("steepness", [1.17, 1.35, 1.5, 2.0])
def test_masses_follow_their_power_law(steepness):
    """n(m) as m^-b: by Hill's estimate of the tail's exponent, well below the largest there is."""
    ratios = []
    for seed in range(40):
        mass = np.sort(broken(seed, 200, steepness=steepness)["mass_of"][:200])
        ratios += list(mass / mass[0])
    ratios = np.array(ratios)
    inside = ratios[(ratios > 2.0) & (ratios < 100.0)] / 2.0
    # Of the exponent b the mean of ln x over a power law that is cut at 50.
    b = np.linspace(0.05, 1.5, 1451)
    mean = 1 / b - math.log(50.0) * 50.0**-b / (1 - 50.0**-b)
    assert b[np.argmin(np.abs(mean - np.log(inside).mean()))] == pytest.approx(steepness - 1.0, abs=0.06)


def high_of(swarm, p):
    """Return how high (m) the middle of a piece is as a corner of it lands."""
    corner = int(swarm["corner_of"][p]) & 3
    return swarm["tilt_of"][corner & 1, p] * (1 if corner < 2 else -1)


def corners_of(swarm, p):
    """Return the heights of a piece's corners (m) and how fast they fall (m/s)."""
    (x, y), (turn, other), r = swarm["tilt_of"][:, p], swarm["turn_of"][:, p], radius_of(swarm, p)
    flat = math.sqrt(max(1 - (x**2 + y**2) / r**2, 0.0))
    heights = high_of(swarm, p) - np.array([x, y, -x, -y])
    return heights, swarm["fall_of"][p] + flat * np.array([turn, other, -turn, -other])


def radius_of(swarm, p):
    """Return how far (m) the corners of a piece are from its middle: of a square of its area."""
    return swarm["wide"] * math.sqrt(swarm["mass_of"][p] * math.pi / 2)


def energy_of(swarm, p):
    """Return the energy (J) of a piece as a corner of it lands: of a square that falls, turns and stands on that. Its
    moment about a diagonal is m L^2/12, where corners are L/sqrt(2) away and go at `turn_of`."""
    fall, (turn, other) = swarm["fall_of"][p], swarm["turn_of"][:, p]
    return swarm["mass_of"][p] * (0.5 * fall**2 + (turn**2 + other**2) / 12 + STANDARD_GRAVITY * high_of(swarm, p))


def test_pieces_bring_the_energy_that_throws_them_and_of_their_fall():
    """Each flies at half of the speed, to any side alike: so up and down is even between both ends."""
    swarm, thrown = broken(5), 0.5 * 1.5**2
    for p in range(200):
        fallen = (
            energy_of(swarm, p) / swarm["mass_of"][p] + 0.5 * swarm["slide_of"][p] ** 2 - thrown
        ) / STANDARD_GRAVITY
        assert -1e-9 < fallen < 0.5 + 1e-9
    assert np.mean(swarm["slide_of"][:200] ** 2) == pytest.approx(2 / 3 * 1.5**2, rel=0.06)


def test_a_piece_that_is_hardly_thrown_stays_low():
    """Pieces that are thrown at 0.1 m/s fly up by 0.1 mm at most, and have no energy but that."""
    swarm = broken(5, 50, 0.25, 0.1, 0.0)
    energy = sum(energy_of(swarm, p) for p in range(50))
    assert 0.0 < energy < 0.25 * 0.5 * 0.25 * 0.1**2 and swarm["tilt_of"].max() < 0.00015


def test_a_piece_that_has_room_to_turn_lands_with_its_normal_to_any_side_alike():
    """Directions that are even over a sphere have even cosines with the vertical (Archimedes)."""
    cosines = []
    for seed in range(20):
        swarm = broken(seed, height=50.0)
        radius = np.array([radius_of(swarm, p) for p in range(200)])
        cosines += list(np.sqrt(1.0 - np.sum(swarm["tilt_of"][:, :200] ** 2, axis=0) / radius**2))
    shares = np.linspace(0.1, 0.9, 9)
    assert np.quantile(cosines, shares) == pytest.approx(shares, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.7])
def test_pieces_come_to_rest_before_they_have_all_the_blows_that_they_may(restitution):
    """A fast corner does not wait for ever while slow ones land at the same time: 2 to 7 % of the pieces did. One in
    800 still ends so, whose corner hovers as it falls over."""
    bounced = []
    for seed in range(20):
        swarm = broken(seed, 40, 0.06, 2.0, 0.08)
        for p in range(40):
            while swarm["next_of"][p] < math.inf:
                bounce_piece(swarm, p, restitution)
        bounced += list(swarm["bounced"][:40])
    assert np.count_nonzero(np.array(bounced) == BOUNCES) <= 2


@pytest.mark.slow
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.6, 0.85])
def test_a_piece_that_clatters_loses_what_its_blows_take_and_nothing_else(restitution):
    """A corner that lands at v takes m'/2 v^2 (1 - e^2), with the mass m' that it meets the floor with. One beside
    another that rests may take more, as both stop. No corner is ever below the floor, none that rests moves."""
    swarm, blows = broken(5, 40), []
    for p in range(40):
        energy, heard, most = energy_of(swarm, p), 0, 1e-9 * swarm["mass_of"][p]
        while swarm["next_of"][p] < math.inf:
            at, (v, mass, flat) = swarm["next_of"][p], landing_of(swarm, p)
            assert mass == pytest.approx(swarm["mass_of"][p] / (1 + 6 * flat**2))
            bounce_piece(swarm, p, restitution)
            left = restitution if v > SLOWEST else 0.0
            energy, heard = energy - 0.5 * mass * v**2 * (1 - left**2), heard + (v > SLOWEST)
            if swarm["next_of"][p] < math.inf:
                now, held = energy_of(swarm, p), int(swarm["corner_of"][p]) >> 2
                assert now < energy * (1 + 1e-9) + most if bin(held).count("1") == 2 else abs(now - energy) < most
                assert swarm["next_of"][p] >= at
                heights, _ = corners_of(swarm, p)
                assert heights.min() > -1e-9 and np.hypot(*swarm["tilt_of"][:, p]) < radius_of(swarm, p)
                resting = [k for k in range(4) if held >> k & 1]
                assert np.abs(heights[resting]).max(initial=0.0) < 1e-9
                energy = now
        blows.append(heard)
    assert max(swarm["bounced"][:40]) < BOUNCES or restitution != 0.6
    assert np.mean(blows) > {0.0: 5, 0.3: 12, 0.6: 26, 0.85: 60}[restitution]


@pytest.mark.parametrize("friction", [0.1, 0.4, 2.0])
def test_friction_brakes_pieces_by_what_the_floor_pushes_up_and_gives_nothing(friction):
    """A piece whose corners give the floor so much is braked by the friction of that at most, and what it loses is at
    least what its blows take. Its corners rub by turning as well, so that they brake less in the mean."""
    swarm, braked = broken(5, 40), []
    swarm["friction"] = friction
    for p in range(40):
        begin, pushed, mass = swarm["slide_of"][p], 0.0, swarm["mass_of"][p]
        while swarm["next_of"][p] < math.inf:
            at, before = swarm["next_of"][p], energy_of(swarm, p) + 0.5 * mass * swarm["slide_of"][p] ** 2
            v, light, _ = landing_of(swarm, p)
            left = 0.5 if v > SLOWEST else 0.0
            slides, given = swarm["slide_of"][p], (1 + left) * v * light / mass
            bounce_piece(swarm, p, left)
            if swarm["next_of"][p] < math.inf:
                after = energy_of(swarm, p) + 0.5 * mass * swarm["slide_of"][p] ** 2
                assert after < before - 0.5 * light * v**2 * (1 - left**2) + 1e-9 * mass
                weighs = STANDARD_GRAVITY * (swarm["next_of"][p] - at)
                assert abs(swarm["slide_of"][p] - slides) < friction * (given + weighs) + 1e-9
                pushed += given
        braked.append((begin - swarm["slide_of"][p], friction * pushed))
    less, most = np.sum(braked, axis=0)
    assert less > 0.3 * most if friction == 0.1 else less > 0.5 * swarm["slide_of"][:40].sum()


def test_a_corner_that_friction_stops_stands_as_one_of_a_rigid_square_does():
    """The change along the floor that stops it, by the mass with which a rigid lamina's corner moves that way, from its
    tensor of inertia (without a turn about the vertical)."""
    swarm = square((0.5 * radius_of(broken(3, 1), 0), 0.0), 0.0)
    swarm["slide_of"][0], swarm["friction"], swarm["turn_of"][:, 0] = 2.0, 100.0, (0.5, 0.3)
    r, mass, high = radius_of(swarm, 0), swarm["mass_of"][0], high_of(swarm, 0)
    along = 2 * math.pi * uniform(swarm, number_of(swarm, 0), GAP)
    flat = math.sqrt(1 - (high / r) ** 2)
    given = 1.5 * landing_of(swarm, 0)[0] / (1 + 6 * flat**2)
    u, turn = 2.0 * np.array([math.cos(along), math.sin(along)]), np.array([0.5 - 6 * flat * given, 0.3])
    spin = np.array([turn[1], -turn[0], 0.0]) / r * -1.0  # the vector about which the first axis goes down
    corner = np.array([*u, 0.0]) + np.cross(spin, [0.0, 0.0, -high])
    arm = np.cross(np.eye(3), [0.0, 0.0, -high])
    give = (np.eye(3) / mass + arm @ arm.T / (mass * r**2 / 6))[:2, :2]
    wanted = u - np.linalg.solve(give, corner[:2]) / mass
    bounce_piece(swarm, 0, 0.5)
    assert swarm["slide_of"][0] == pytest.approx(np.hypot(*wanted), rel=1e-9)


@pytest.mark.parametrize(("speed", "time"), [(1.0, 0.3), (3.0, 0.3), (3.0, 1.0)])
def test_pieces_land_on_others_as_often_as_these_cover_where_they_fly(speed, time):
    """Pieces as discs that fly to all sides as fast as a gas does, with the same energy: points of them, by chance."""
    found, swarms = [], [broken(seed, 60, 0.25, speed, 0.1) for seed in range(30)]
    for swarm in swarms:
        for p in range(60):
            below = piece_below(swarm, p, time)
            assert below != p
            found.append(below >= 0)
    numbers, covered = np.random.default_rng(1), []
    reach = 0.5 * speed * time * math.sqrt(2 / 3) / math.sqrt(2)  # on each axis, rms
    for swarm in swarms:
        places, radius = reach * numbers.normal(size=(60, 2)), swarm["wide"] * np.sqrt(swarm["mass_of"][:60])
        apart = np.hypot(*(places[:, None] - places[None]).transpose(2, 0, 1)) + np.diag(np.full(60, 9.0))
        covered += list((apart < radius[None]).any(axis=1))
    assert np.mean(found) == pytest.approx(np.mean(covered), abs=0.06)


def test_a_piece_lands_on_one_that_has_landed_before():
    """Soon after they come free, while those that flew up are in the air, pieces are on those that flew down."""
    swarm = broken(3, 60, 0.25, 3.0, 0.0)
    down = {p for p in range(60) if uniform(swarm, p, GAP) < 0.5}
    below = {piece_below(swarm, p, 1e-3) for p in range(60)} - {-1}
    assert below and below <= down


def square(tilt, fall=1.0):
    """Return a swarm of a square piece that falls at a speed (m/s), with its first corner by a tilt (m) lower."""
    swarm = broken(3, 1)
    swarm["fall_of"][0], swarm["turn_of"][:, 0], swarm["tilt_of"][:, 0], swarm["corner_of"][0] = fall, 0.0, tilt, 0
    return swarm


def test_a_flat_square_slaps_as_a_rigid_one_does():
    """A square that lands on a corner at a small angle, at 1 m/s and without a bounce: the opposite one goes down at
    12/7, and those beside it at 6/7, as its middle is slowed by 1/7 and turns by 6/7. The nearer of these lands next,
    with a seventh of the mass."""
    swarm = square((1e-6, -0.5e-6))
    bounce_piece(swarm, 0, 0.0)
    v, mass, _ = landing_of(swarm, 0)
    assert int(swarm["corner_of"][0]) == 3 | 1 << 2
    assert v == pytest.approx(6 / 7, rel=1e-4) and mass == pytest.approx(swarm["mass_of"][0] / 7)
    assert corners_of(swarm, 0)[1] == pytest.approx([0.0, 6 / 7, 12 / 7, 6 / 7], abs=1e-4)


@pytest.mark.slow
def test_a_piece_flies_as_a_square_that_is_followed_step_by_step():
    """A square at small angles, as three numbers: its height and two slopes, by short steps and with blows of its four
    corners. Its first eight blows are at the same corners, within 1 % of the speeds and 0.2 ms of the times: some
    at the corner that is opposite the one before, some at one beside it."""
    swarm = square((2e-3, 1.1e-3))
    height, rate = np.array([2e-3, 2e-3, 1.1e-3]), np.array([-1.0, 0.0, 0.0])  # and of corners below the middle
    axes = np.array([[1, -1, 0], [1, 0, -1], [1, 1, 0], [1, 0, 1]])  # heights of corners, of these
    r, time, step, blows = radius_of(swarm, 0), 0.0, 1e-6, []
    flat = math.sqrt(1 - (height[1] ** 2 + height[2] ** 2) / r**2)
    while len(blows) < 8:
        along = axes * [1, flat, flat]
        landed = [k for k in range(4) if axes[k] @ height <= 0 and along[k] @ rate < 0]
        if landed:
            flat = math.sqrt(1 - (height[1] ** 2 + height[2] ** 2) / r**2)
            along = axes * [1, flat, flat]
            blows.append((time, -(along[landed[0]] @ rate), landed[0]))
            rate = rate + 1.5 * blows[-1][1] / (1 + 6 * flat**2) * along[landed[0]] * [1, 6, 6]
        else:
            rate = rate - [STANDARD_GRAVITY * step, 0, 0]
            height = height + step * rate * [1, flat, flat]
            time += step
    begin, corners = swarm["next_of"][0], []
    for at, v, k in blows:
        corners.append(int(swarm["corner_of"][0]) & 3)
        assert swarm["next_of"][0] - begin == pytest.approx(at, abs=2e-4)
        assert landing_of(swarm, 0)[0] == pytest.approx(v, rel=0.01) and corners[-1] == k
        bounce_piece(swarm, 0, 0.5)
    assert {(a - b) & 1 for a, b in pairwise(corners)} == {0, 1}


def test_a_piece_falls_about_the_edge_between_two_corners_that_rest():
    """A square of side L that lies on an edge, from a small angle: the opposite edge falls at 3/2 g, as a rod does
    about its end (m L^2/3)."""
    swarm = square((1e-3, 1e-3), 0.0)
    swarm["corner_of"][0] = 1 | 1 << 2  # the second lands, beside the first, which rests
    bounce_piece(swarm, 0, 0.5)
    assert int(swarm["corner_of"][0]) >> 2 == 0b11
    assert landing_of(swarm, 0)[0] == pytest.approx(math.sqrt(2 * 1.5 * STANDARD_GRAVITY * 2e-3), rel=0.01)


SHARD = np.array([4130.0, 5990.0, 7440.0, 10640.0, 10680.0, 18690.0])  # Hz, of 2.8 g


def shard(scale, restitution, width, below=0.0):
    """Return what a shard that lies flat does: `bend_piece`'s answer for one `scale` as heavy as glass-shards, on a
    floor or on another that is `below` as heavy."""
    swarm = np.zeros(1, SWARM)[0]
    swarm["usual"], swarm["bends"], swarm["bending"], swarm["a"] = 0.0028, 6, 2.0, 1.5
    swarm["bend"][:6] = SHARD
    swarm["mass_of"][:2] = 0.0028 * scale, 0.0028 * below
    other = 1 if below else -1
    return bend_piece(swarm, 0, 0.0028 * scale / 7, math.log(width), 1.0, 1 + restitution, other)


@pytest.mark.parametrize("scale", [0.01, 0.25, 1.0, 4.0, 100.0])
@pytest.mark.parametrize("restitution", [0.2, 0.8])
def test_a_piece_rings_with_at_most_half_of_what_its_blow_brings(scale, restitution):
    for width in (1e-6, 1e-5, 1e-4):
        alike, shorter, left = shard(scale, restitution, width)
        bent = bent_by(SHARD / scale, 6, 2.0 * 2.0 / 7, math.log(width) - shorter)
        rings = (alike * (1 + restitution)) ** 2 * bent  # of m v^2/2; the modes of TILT have twice the mass
        assert rings < 0.5 and left**2 + rings < 1.0 and 0.0 < left <= restitution


def dropped(mass, frequency, v, stiffness=8.3e8, dissipation=0.25, step=2e-7, below=0.0):
    """Return the restitution of a flat square with modes of its own that lands on a corner, and these modes' share of
    the energy, step by step: Hunt and Crossley's contact, which touches as often as it will. below: kg, of a like one
    that lies there, whose middle is struck: its modes have a quarter of phi^2 there."""
    omega, phi = 2 * np.pi * frequency, np.full(6, 4.0 / mass)
    if below > 0.0:
        omega, phi = np.append(omega, omega * mass / below), np.append(phi, np.full(6, 1.0 / below))
    rigid, speed, q, p, apart = 0.0, v, np.zeros(len(phi)), np.zeros(len(phi)), 0
    while apart < 1_000:
        x, rate = rigid + q.sum(), speed + p.sum()
        force = max(stiffness * x**1.5 * (1 + dissipation * rate), 0.0) if x > 0 else 0.0
        apart = 0 if force > 0 else apart + 1
        speed -= force * step * 7 / mass
        rigid += speed * step
        p -= (omega**2 * q + force * phi) * step
        q += p * step
    return -speed / v, 0.5 * ((p**2 + (omega * q) ** 2) / phi).sum() / (0.5 * v**2 * mass / 7)


@pytest.mark.parametrize("scale", [0.25, 1.0, 4.0])
def test_a_piece_bounces_and_rings_as_one_that_is_computed_step_by_step(scale):
    """A piece touches up to six times within 0.6 ms, whose sum a bounce is: both within 0.15."""
    mass = 0.0028 * scale
    bounced, rings = dropped(mass, SHARD / scale, 1.0)
    form = contact_form(0.25, 1.5)
    width = form.width * (mass / 7 / 8.3e8) ** 0.4
    e = form.momentum - 1.0
    _, _, left = shard(scale, e, width)
    assert left == pytest.approx(bounced, abs=0.15)
    assert 1 - (left / e) ** 2 == pytest.approx(rings, abs=0.15)


@pytest.mark.parametrize("below", [0.5, 1.0, 4.0])
def test_a_piece_that_lands_on_another_shares_its_blow_with_that(below):
    """Both are computed step by step, as above; together they ring with half of what the blow brings at most."""
    bounced, rings = dropped(0.0028, SHARD, 1.0, below=0.0028 * below)
    form = contact_form(0.25, 1.5)
    width, e = form.width * (0.0028 / 7 / 8.3e8) ** 0.4, form.momentum - 1.0
    kept, shorter, left = shard(1.0, e, width, below)
    at = math.log(width) - shorter
    shares = [bent_by(SHARD, 6, 4.0 / 7, at), bent_by(SHARD / below, 6, 1.0 / 7 / below, at)]
    modes = (kept * (1 + e)) ** 2 * sum(shares)
    assert modes == pytest.approx(1 - (left / e) ** 2) and shares[1] > 0.05 * shares[0]
    assert left == pytest.approx(bounced, abs=0.15) and modes == pytest.approx(rings, abs=0.15) and modes < 0.5
    assert left < shard(1.0, e, width)[2]


def test_cracks_let_go_a_quarter_of_the_energy_or_the_strain_that_pieces_hold():
    """40 discs of 1.5 mm of 0.14 kg in all, each bent to the stress at which cracks branch that began as far away as it
    is wide: the strain's energy is summed over the thickness. 70 J/m2 of all their edges were twelve times as much."""
    swarm = broken(3, 40, whole=0.14)
    swarm["cracked"] = 40
    radius = (5e-3 / (math.pi * 2500.0 * 0.1)) ** (1 / 3)
    thick, modulus, held = 0.1 * radius, 70e9, 0.0
    depth = (np.arange(1000) - 499.5) / 500.0  # of half of the thickness
    for mass in swarm["mass_of"][:40]:
        area = mass / (2500.0 * thick)
        strain = math.sqrt(70.0 * modulus / (2 * math.sqrt(area / math.pi))) / modulus * depth
        held += area * thick * np.mean(0.5 * modulus * strain**2)
    assert freed_by_cracks(swarm, 0.14, 0.5) == pytest.approx(0.25 * 0.0175)
    assert freed_by_cracks(swarm, 0.14, 20.0) == pytest.approx(held, rel=1e-4)
    assert 0.01 < held < 0.06


def test_a_piece_comes_free_while_a_crack_runs_round_it():
    """The times at which its rim comes free are even over a run at 1500 m/s, and have that rms."""
    swarm = broken(3, 7)
    radius = (5e-3 / (math.pi * 2500.0 * 0.1)) ** (1 / 3)
    times = (np.arange(10_000) + 0.5) / 10_000 * 2 * math.pi * radius / 1500.0
    assert math.exp(freed_within(swarm, 5e-3)) == pytest.approx(times.std(), rel=1e-6)
    assert freed_within(swarm, 4 * 5e-3) - freed_within(swarm, 5e-3) == pytest.approx(math.log(2.0))


@pytest.mark.parametrize("sine", [0.01, 0.1, 0.3])
def test_a_low_piece_is_heard_as_a_dipole_and_its_image_are(sine):
    """Two dipoles of opposite signs, as far apart as the middle of a square is above its corner and its image, heard
    from straight above at k a = 1, where a disc of its area is loudest."""
    height = math.sqrt(math.pi / 2) * sine
    wanted = abs(np.exp(1j * height) - np.exp(-1j * height))
    assert heard_above(math.sqrt(1 - sine**2)) == pytest.approx(wanted, rel=0.03)
    assert heard_above(0.5) == 1.0 and heard_above(1.0) == 0.0


def test_pieces_fly_apart_without_a_momentum_of_their_own():
    """Pieces fly up and down at up to half of the speed: their mean is that of the whole, which has been stopped.
    None lands before it can: a piece that is at most h high, at up to v/2, within h/(v/2) and more."""
    speed, momentum = 3.0, []
    for seed in range(100):
        swarm = broken(seed, 200, speed=speed)
        up = STANDARD_GRAVITY * swarm["next_of"][:200] - swarm["fall_of"][:200]
        assert np.all(np.abs(up) <= 0.5 * speed + 1e-9) and np.all(swarm["next_of"][:200] >= 0.0)
        high = np.array([high_of(swarm, p) for p in range(200)])
        above = high + (swarm["fall_of"][:200] ** 2 - up**2) / (2 * STANDARD_GRAVITY)
        assert np.all((above > -1e-9) & (above <= 0.5 + 1e-9))
        momentum.append(swarm["mass_of"][:200] @ up / 0.25)
    assert abs(np.mean(momentum)) < 3 * np.std(momentum) / 10 < 0.05 * speed


def test_a_crack_is_beside_a_piece_as_often_as_its_edge_is_long():
    swarm = broken(3, 7)
    swarm["cracked"] = 7
    edges = np.sqrt(swarm["mass_of"][:7])
    beside = [piece_beside(swarm, (n + 0.5) / 2_000) for n in range(2_000)]
    assert np.bincount(beside, minlength=7) / 2_000 == pytest.approx(edges / edges.sum(), abs=1e-3)
