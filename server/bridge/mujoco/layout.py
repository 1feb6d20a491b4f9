"""MuJoCo's memory: where its poses and contacts stand in it, and its functions."""

import math
from ctypes import CDLL, c_int32, c_uint64
from functools import cache
from pathlib import Path

import mujoco
import numpy as np

from ..checks import WorldError

_LOOKED = 64  # words of a struct that are looked at together


@cache
def memory_layout() -> dict[str, int]:
    """Return where MuJoCo has its time, the number of contacts, these and their forces in its data, and the fields of
    each contact (bytes), as ARRAYS names them.

    Found in data with contacts: a pointer is where its value stands, as is a time, and a number that goes as the
    contacts' does.
    """
    ball = '<body><freejoint/><geom size="1"/></body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{3 * ball}</worldbody></mujoco>")
    model.opt.timestep = math.e
    data = mujoco.MjData(model)
    data.time = math.pi
    time = _standing(data, int(np.float64(math.pi).view(np.uint64)))
    found: set[int] = set()
    for place in (0.0, 9.0, 0.0):  # the third ball touches both others, or none
        data.qpos[14] = place
        mujoco.mj_forward(model, data)
        words = (c_int32 * _LOOKED).from_address(data._address + time - 4 * _LOOKED)[:]  # it stands just before
        here = {place for place, word in enumerate(words) if word == data.ncon}
        found = found & here if found else here
    (count,) = found
    contact = data.contact
    first = contact.dist.ctypes.data
    parts = {
        "point": contact.pos, "normal": contact.frame, "distance": contact.dist, "geoms": contact.geom,
        "row": contact.efc_address, "dimensions": contact.dim, "reference": contact.solref,
        "impedance": contact.solimp, "margin": contact.includemargin, "friction": contact.friction,
    }  # fmt: skip
    return {
        "time": time,
        "count": time + 4 * (count - _LOOKED),
        "contacts": _standing(data, first),
        "forces": _standing(data, data.efc_force.ctypes.data),
        "smooth": _standing(data, data.qacc_smooth.ctypes.data),
        "step": _standing(model, int(np.float64(model.opt.timestep).view(np.uint64))),
        "stride": contact.dist.strides[0],
        **{name: part.ctypes.data - first for name, part in parts.items()},
    }


@cache
def mujoco_library() -> CDLL:
    """Return MuJoCo's functions, in the library that its package has loaded."""
    folder = Path(mujoco.__file__).parent
    found = [each for pattern in ("libmujoco*", "mujoco.dll") for each in folder.glob(pattern)]
    if not found:
        raise WorldError(f"{folder}: expected MuJoCo's library there, libmujoco")
    return CDLL(str(found[0]))


def _standing(data: mujoco.MjData | mujoco.MjModel, pointer: int) -> int:
    """Return where in MuJoCo's data, as a struct, a pointer stands (bytes): it has one to each of its arrays."""
    offset = 0
    while True:
        words = (c_uint64 * _LOOKED).from_address(data._address + offset)[:]
        if pointer in words:
            return offset + 8 * words.index(pointer)
        offset += 8 * _LOOKED
