"""The loss that leaves a restitution, against Lambert's W."""

import mpmath as mp
import numpy as np
import pytest

from carom.dsp import contact
from carom.dsp.contact.loss import loss_of


@pytest.mark.parametrize("restitution", [1e-6, 0.02, 0.03, 0.1, 0.5, 0.945, 0.99, 0.99998, 1 - 1e-5, 1 - 1e-6, 1.0])
def test_loss_and_restitution_are_inverses(restitution):
    w = loss_of(restitution)
    assert contact.restitution(1.0, w) == pytest.approx(restitution, rel=2e-14)
    assert 0.0 <= w <= 1.5 * (1 - restitution) / restitution * (1 + 1e-9)


def test_the_loss_solves_the_law():
    """v_in and -e v_in leave the same 1 + mu v - ln(1 + mu v): w + e w = ln((1 + w)/(1 - e w))."""
    with mp.workdps(50):
        for e in map(mp.mpf, np.linspace(0.05, 0.95, 19).tolist()):
            low, high = (
                w * (1 + e) - mp.log((1 + w) / (1 - w * e))
                for w in (mp.mpf(loss_of(float(e))) * (1 + mp.mpf(error)) for error in (-1e-13, 1e-13))
            )
            assert low > 0 > high
