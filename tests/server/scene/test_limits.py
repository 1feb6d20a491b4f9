"""The limits of gestures: how long a contact and a bounce last, and how a striker falls."""

from contextlib import nullcontext

import pytest

from carom.server.osc.arguments import Refused
from carom.server.scene.limits import Contact, fall, require_rest, require_short

GRAVITY = 9.80665  # m/s^2: the standard acceleration of free fall


@pytest.mark.parametrize("velocity", [0.0, 2.0, -2.0])
def test_a_fall_is_a_parabola(velocity):
    v_in, t = fall(1.5, velocity, GRAVITY)
    assert velocity * t + GRAVITY * t**2 / 2 == pytest.approx(1.5) and v_in == pytest.approx(velocity + GRAVITY * t)
    assert fall(0.0, 0.0, GRAVITY) == (0.0, 0.0)
    assert fall(1e-9, 100.0, GRAVITY)[1] == pytest.approx(1e-11, rel=1e-6, abs=0.0)  # nothing cancels


@pytest.mark.parametrize(
    ("contact", "short"),
    [
        (Contact(0.08, 1.0, 0.0, 1.0), True),  # pi sqrt(m/k) = 0.89 s
        (Contact(0.11, 1.0, 0.0, 1.0), False),  # 1.04 s
        (Contact(0.0225, 1.0, 0.0, 1.0), True),  # 0.47 s,
        (Contact(0.0225, 1.0, 10.0, 1.0), False),  # but it sticks
        (Contact(0.0225, 1.0, 0.0, 1.0, 0.5), True),
        (Contact(0.0225, 1.0, 0.0, 1.0, 0.1), False),
    ],
)
def test_a_contact_lasts_a_second_at_most(contact, short):
    with nullcontext() if short else pytest.raises(Refused, match="the contact would last"):
        require_short(1.0, contact)


def test_a_bounce_lasts_an_hour_at_most():
    require_rest(1.0, Contact(0.01, 1e9, 0.0012, 1.5), GRAVITY)
    with pytest.raises(Refused, match="the bounce might last"):
        require_rest(1.0, Contact(0.01, 1e9, 0.00085, 1.5), GRAVITY)
    require_rest(1.0, Contact(0.01, 1e9, 0.0, 1.5, 0.9999), GRAVITY)
    with pytest.raises(Refused, match=r"restitution = 0.99999: the bounce might last"):
        require_rest(1.0, Contact(0.01, 1e9, 0.0, 1.5, 0.99999), GRAVITY)
    with pytest.raises(Refused, match="restitution = 1: the bounce would never end"):
        require_rest(1.0, Contact(0.01, 1e9, 0.0, 1.5, 1.0), GRAVITY)
