"""The surfaces of a MuJoCo model's bodies, of which those that hold a mesh ring by their own modes."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from ....dsp.mesh import forms
from ....dsp.mesh.surface import Surface
from .model import Frame, Part, is_whole

_ROUND, _ROUNDS = 48, 3  # sides of what is round; times by which a ball's triangles are split
_ARC = 12  # sides of a quarter of a capsule's end


def surface_of(model: mujoco.MjModel, data: mujoco.MjData, part: Part, frame: Frame) -> Surface | None:
    """Return the surface of all geoms of a part in the axes of its frame, if its largest one is a mesh.

    It hangs on no pose, but for that of a part that does not move.
    """
    if model.geom_type[part.geom] != mujoco.mjtGeom.mjGEOM_MESH:
        return None
    found = []
    for geom in part.geoms:
        own = _geom_surface(model, geom)
        if own is not None:
            place, turn = _in_frame(model, data, part, frame, geom)
            found.append(forms.moved(own, place, turn))
    return forms.together(*found)


def _geom_surface(model: mujoco.MjModel, geom: int) -> Surface | None:
    """Return the surface of a geom in its own axes; None for one without an end."""
    kind = mujoco.mjtGeom(model.geom_type[geom])
    x, y, z = map(float, model.geom_size[geom])
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        face, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        points = np.asarray(model.mesh_vert[first : first + count], np.float64)
        return Surface(points, np.asarray(model.mesh_face[face : face + faces], np.int64))
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return forms.box(2 * x, 2 * y, 2 * z)
    if kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_ELLIPSOID):
        ball = forms.ball(1.0, _ROUNDS)
        radii = np.array([x, x, x] if kind == mujoco.mjtGeom.mjGEOM_SPHERE else [x, y, z])
        return Surface(ball.points * radii, ball.faces)
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return forms.lathe([[0, -y], [x, -y], [x, y], [0, y]], _ROUND)
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        arc = np.linspace(0, np.pi / 2, _ARC + 1)[1:]
        low = np.stack([x * np.sin(arc), -y - x * np.cos(arc)], axis=1)
        return forms.lathe(np.vstack([[[0, -y - x]], low, low[::-1] * [1, -1], [[0, y + x]]]), _ROUND)
    return None


def _in_frame(
    model: mujoco.MjModel, data: mujoco.MjData, part: Part, frame: Frame, geom: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the place and the rotation matrix of a geom in the axes of a part's frame."""
    if not part.body:
        turn = data.geom_xmat[geom].reshape(3, 3)
        return frame.axes.T @ (data.geom_xpos[geom] - frame.origin), frame.axes.T @ turn
    place, turn = model.geom_pos[geom].copy(), _matrix(model.geom_quat[geom])
    body = int(model.geom_bodyid[geom])
    while body != part.body:
        own = _matrix(model.body_quat[body])
        place, turn = model.body_pos[body] + own @ place, own @ turn
        body = int(model.body_parentid[body])
    if is_whole(model, part):
        origin, axes = model.body_ipos[body], _matrix(model.body_iquat[body])
    else:
        origin, axes = model.geom_pos[part.geom], _matrix(model.geom_quat[part.geom])
    return axes.T @ (place - origin), axes.T @ turn


def _matrix(quaternion: NDArray[np.float64]) -> NDArray[np.float64]:
    matrix = np.empty(9)
    mujoco.mju_quat2Mat(matrix, quaternion)
    return matrix.reshape(3, 3)
