"""Sums in closed form beside plain sums over all samples."""

import numpy as np
import pytest

from carom.dsp.fitting.blow import pulse
from carom.dsp.fitting.sums import products, project, real_gram, ring

from .synthetic import RATE, modes

S = modes(5, 3).poles / RATE
AMPLITUDE = modes(5, 3).amplitude
N, ONSET = 1_300, 40
HEAD = pulse(0.002).later(-0.0005).head(S, RATE, ONSET)


def atoms(head) -> tuple[np.ndarray, np.ndarray]:
    """Return all atoms and slopes, sample by sample."""
    t = np.arange(N)[:, None] - (head.origin if head else 0)
    plain = np.exp(t * S)
    slopes = t * plain
    if head:
        plain[: head.length], slopes[: head.length] = head.atoms, head.slopes
    return plain, slopes


@pytest.mark.parametrize("head", [None, HEAD], ids=["plain", "blow"])
def test_products_projections_and_sounds_are_plain_sums(head):
    x = np.random.default_rng(1).standard_normal(N)
    plain = np.hstack(atoms(head))
    found = products(S, N, head, slopes=True)
    for sums, expected in zip(found, (plain.T @ plain, plain.conj().T @ plain), strict=True):
        assert np.abs(sums - expected).max() < 1e-9 * np.abs(expected).max()
    projected = project(x, S, head, slopes=True)
    assert np.abs(projected - x @ plain).max() < 1e-9 * np.abs(projected).max()
    columns = np.hstack([plain[:, :5].real, -plain[:, :5].imag])
    assert real_gram(*products(S, N, head)) == pytest.approx(columns.T @ columns, rel=1e-9, abs=1e-6)
    assert ring(AMPLITUDE, S, N, head) == pytest.approx((plain[:, :5] @ AMPLITUDE).real, abs=1e-10)


def test_the_slopes_of_a_blow_s_atoms_are_their_derivatives():
    step, blow = 1e-7, pulse(0.002).later(-0.0005)
    apart = [blow.head(S + sign * step, RATE, ONSET).atoms for sign in (1, -1)]
    slope = (apart[0] - apart[1]) / (2 * step)
    assert np.abs(slope - HEAD.slopes).max() < 1e-6 * np.abs(slope).max()


def test_after_a_blow_atoms_are_exponentials():
    longer = pulse(0.002).later(-0.0005).head(S, RATE, ONSET, HEAD.length + 10)
    t = np.arange(HEAD.length, HEAD.length + 10)[:, None] - ONSET
    assert np.abs(longer.atoms[HEAD.length :] - np.exp(t * S)).max() < 1e-9
