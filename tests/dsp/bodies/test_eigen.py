"""Two quadratic forms at once, and Python's lock meanwhile."""

import threading
import time

import numpy as np
import pytest
import scipy.linalg

from carom.dsp.bodies.eigen import eigh


def forms(size):
    rng = np.random.default_rng(1)
    stiffness, inertia = (each @ each.T for each in rng.standard_normal((2, size, size)))
    return stiffness, inertia + 0.1 * np.eye(size)


def test_eigenvalues_and_vectors_are_scipys():
    stiffness, inertia = forms(40)
    values, vectors = eigh(stiffness, inertia)
    np.testing.assert_allclose(values, scipy.linalg.eigh(stiffness, inertia)[0], rtol=1e-9, atol=1e-11)
    np.testing.assert_allclose(vectors.T @ inertia @ vectors, np.eye(40), atol=1e-11)
    np.testing.assert_allclose(stiffness @ vectors, inertia @ vectors * values, atol=1e-9 * values[-1])
    with pytest.raises(np.linalg.LinAlgError):
        eigh(stiffness, -inertia)


@pytest.mark.slow
def test_other_threads_go_on_meanwhile():
    stiffness, inertia = forms(900)
    done = threading.Event()

    def solve():
        eigh(stiffness, inertia)
        done.set()

    thread = threading.Thread(target=solve)
    wakes = 0
    thread.start()
    while not done.is_set():
        time.sleep(0.001)
        wakes += 1
    thread.join()
    assert wakes > 20, "scipy's holds the lock to the end: five"
