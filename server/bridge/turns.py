"""Turns as quaternions w x y z of length 1, of the matrices that `rows.rotation` makes of them."""

import math

import numpy as np
from numpy.typing import NDArray


def quaternion_of(m: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the quaternion of a matrix (3, 3), with w >= 0. S. W. Shepperd, 1978."""
    squares = np.array([
        1 + m[0, 0] + m[1, 1] + m[2, 2], 1 + m[0, 0] - m[1, 1] - m[2, 2],
        1 - m[0, 0] + m[1, 1] - m[2, 2], 1 - m[0, 0] - m[1, 1] + m[2, 2],
    ])  # fmt: skip
    k = int(np.argmax(squares))
    root = 0.5 * math.sqrt(squares[k])
    rows = (
        (4 * root * root, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]),
        (m[2, 1] - m[1, 2], 4 * root * root, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]),
        (m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 4 * root * root, m[1, 2] + m[2, 1]),
        (m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 4 * root * root),
    )
    q = np.array(rows[k]) / (4 * root)
    return -q if q[0] < 0 else q
