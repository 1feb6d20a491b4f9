"""MuJoCo's sound: a bridge that reports to a World what a model's contacts and bodies do.

    model = mujoco.MjModel.from_xml_path("scene.xml")
    data = mujoco.MjData(model)
    bridge = carom.mujoco.Bridge(model, data, microphones=[(0, -1, 0.5)])
    for _ in range(1000):
        mujoco.mj_step(model, data)
        block = bridge.update()   # float32 (frames, channels), in pascals

It needs `pip install 'carom[mujoco]'`.
"""

import warnings
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_void_p, cast
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from .dsp.arguments import explain_all_arguments
from .dsp.mesh.surface import Surface
from .server.bridge.blows import Hit
from .server.bridge.bodies import NoModel
from .server.bridge.checks import WorldError
from .server.bridge.mujoco.arrays import ARRAYS
from .server.bridge.mujoco.layout import memory_layout, mujoco_library
from .server.bridge.mujoco.meshes import surface_of
from .server.bridge.mujoco.model import (
    Frame,
    Part,
    check_names,
    frame_of,
    inertia_of,
    material_of,
    named_apart,
    names_in,
    names_of,
    numbers_of,
    parts_of,
    written_in,
)
from .server.bridge.mujoco.stepping import listening, take_step
from .server.bridge.step import Pose
from .server.closing import Closing
from .world import Blocks, World

NO_STEPS = "its time goes on without mujoco.mj_step, so that nothing is heard: expected steps by mujoco.mj_step"


def bare(given: Any, kind: type[Any]) -> Any:
    """Return MuJoCo's own model or data, which dm_control keeps as `ptr`, robosuite as `_model` and `_data`."""
    for each in (given, *(getattr(given, name, None) for name in ("ptr", "_model", "_data"))):
        if isinstance(each, kind):
            return each
    raise WorldError(f"{given!r}: expected a {kind.__name__} of MuJoCo")


@explain_all_arguments
class Bridge(Closing):
    """Report to a World what happens in MuJoCo's `data`. The end of a `with` closes the World, unless `world` gave it.

    Each body of the model becomes one body of the World, with all its colliding geoms; so does each geom of the
    world's own body. It has the shape of the largest geom, or, where this has less than half of the volume, that of a
    solid box with the same inertia. If the largest geom is a mesh, the body has the modes of all geoms together. They
    are computed once, in some seconds, and kept. A mesh that is open or without a volume rings as a box, with a
    warning. Flexes are silent.

    Parameters
    ----------
    model, data : MjModel, MjData
        MuJoCo's own, or as dm_control and robosuite wrap them.
    world : World, optional
        A World that is there already, in place of options.
    materials : dict, optional
        Preset of the material of geoms, bodies or MuJoCo's materials, by name. Before `default`: the model's custom
        text `carom` ("floor wood ball glass"), and materials that are named as presets.
    bodies : dict, optional
        Keys of `World.body`, by the name of the body.
    default : str, default "wood"
        Material of all others.
    modes : int, default 64
        Largest number of modes of each body.
    restitution : {"simulator", "materials"}
        Source of the restitution of blows.
    settle : float, default 0
        Time at the beginning in which no blow is heard, s.
    sensors : dict, optional
        By name a mapping with `site` (of the model) or `body`, and the keys of `World.sensor`.
    meshes : bool, default True
        Whether meshes ring by their own modes; else as the box with their inertia.
    grains : dict, optional
        By name the bodies, or their pattern, whose blows are heard together.
    **options
        Options of a World.

    Raises
    ------
    WorldError
        A name that the model does not have.

    Notes
    -----
    The time of a hit is that at which MuJoCo computes the contacts: the beginning of a step, with `RK4` its end. The
    sound comes `latency` (s) later. The effective mass of a blow is that of the mechanism, without equality constraints
    and friction.
    """

    def __init__(
        self,
        model: Any,
        data: Any,
        world: World | None = None,
        *,
        materials: Mapping[str, str] | None = None,
        bodies: Mapping[str, Mapping[str, Any]] | None = None,
        default: str = "wood",
        modes: int = 64,
        restitution: str = "simulator",
        settle: float = 0.0,
        sensors: Mapping[str, Mapping[str, Any]] | None = None,
        meshes: bool = True,
        grains: Mapping[str, str | Sequence[str]] | None = None,
        **options: Any,
    ) -> None:
        if restitution not in ("simulator", "materials"):
            raise WorldError(f"restitution = {restitution}: expected simulator or materials")
        for name, given in (("materials", materials), ("bodies", bodies), ("sensors", sensors), ("grains", grains)):
            if not (given is None or isinstance(given, Mapping)):
                raise WorldError(f"{name} = {given!r}: expected a mapping from names")
        model, data = bare(model, mujoco.MjModel), bare(data, mujoco.MjData)
        if (data.geom_xpos.shape[0], len(data.qvel)) != (model.ngeom, model.nv):
            raise WorldError("data: expected that of the model")
        if world is not None and options:
            raise WorldError(f"{next(iter(options))}: expected no options of a World that is there already")
        self._model, self._data = model, data
        self._late = model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4
        self._modes = modes
        self._by_simulator = restitution == "simulator"
        gravity = float(np.linalg.norm(model.opt.gravity))
        self._lent = world is not None
        self.world = world or World(**{"gravity": gravity, "start": self._now, **options})
        if world is not None and world.simulation.steps == 0:
            world.simulation.begin(min(world.time, self._now))
        mujoco.mj_kinematics(model, data)
        parts = named_apart(parts_of(model))
        chosen = {**written_in(model), **(materials or {})}
        check_names("materials", chosen, names_in(model))
        check_names("bodies", bodies or {}, {name for part in parts for name in names_of(model, part)})
        for name, keys in (bodies or {}).items():
            if not isinstance(keys, Mapping):
                raise WorldError(f"bodies: {name} = {keys!r}: expected a mapping of keys of World.body")
        self.world.simulation.settle(settle)
        self._first = len(self.world.bodies)
        mujoco.mj_comPos(model, data)
        frames = [frame_of(model, data, part) for part in parts]
        unsaid = []
        for part, frame in zip(parts, frames, strict=True):
            about = next((bodies[name] for name in names_of(model, part) if name in bodies), {}) if bodies else {}
            material = material_of(model, part, chosen) or str(about.get("material", ""))
            surface = surface_of(model, data, part, frame) if meshes and "shape" not in about else None
            if surface and not material:
                unsaid.append(part.name)
            self._add(part, frame, surface, material or default, about)
        if unsaid:
            text = f"no material is given for {', '.join(unsaid)}: {default}; materials={{{unsaid[0]!r}: ...}} gives it"
            warnings.warn(text, stacklevel=3)
        for name, keys in (sensors or {}).items():
            self._mount(name, keys, parts, frames)
        for name, chosen_bodies in (grains or {}).items():
            self.world.grains(name, chosen_bodies)
        moving = [part for part in parts if part.body]
        self._frames = frames[: len(moving)]
        self._bodies = np.array([part.body for part in moving], np.intp)
        self._roots = model.body_rootid[self._bodies].astype(np.intp)
        self._number = numbers_of(model, parts, self._first)
        self._arrays = self._described()
        time, count = (data._address + memory_layout()[name] for name in ("time", "count"))
        behind = 0 if self._late else model._address + memory_layout()["step"]
        kept = self._arrays, self._number, self._room, model, data
        self.report: Callable[[], int] = self.world.reporter(self._arrays.ctypes.data, time, count, behind, kept)
        """Report a step of MuJoCo to the World, to be called after each; return the number of its blows. WorldError
        for what is not finite, or if time has not gone on."""
        self.hits: list[Hit] = []
        """The blows of the last `step` or `update`: of all the steps that a function took."""

    @property
    def _now(self) -> float:
        """Time (s) of the contacts that are known: those at the beginning of the last step."""
        return float(self._data.time) - self._behind

    @property
    def _behind(self) -> float:
        return 0.0 if self._late else float(self._model.opt.timestep)

    @property
    def latency(self) -> float:
        """Time (s) from a moment of the simulation to its place in the sound, by `data.time`."""
        return self.world.latency + self._behind

    def _add(self, part: Part, frame: Frame, surface: Surface | None, material: str, about: Mapping[str, Any]) -> None:
        """Add a part to the World, with the mass and inertia of the body that moves it, by its surface or as its frame
        has it."""
        model, data = self._model, self._data
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, frame.axes.ravel())
        given: dict[str, Any] = {"held": True, "most_modes": self._modes}
        if part.body:
            mass, inertia = inertia_of(model, data, part, frame)
            given |= {"held": False, "mass": mass, "inertia": inertia}
        pose = Pose(tuple(frame.origin), tuple(quaternion))
        kind = str(about.get("shape", frame.shape))
        keys = given | {key: value for key, value in about.items() if key not in ("shape", "size", "material")}
        material = about.get("material", material)
        try:
            if surface is not None:
                try:
                    self.world.body(part.name, "mesh", tuple(surface), material, pose, **keys)
                    return
                except NoModel as error:
                    warnings.warn(f"geom {part.geom}: {error}; the box of its inertia rings for it", stacklevel=4)
                    keys.pop("wall", None)
            self.world.body(part.name, kind, about.get("size", frame.size), material, pose, **keys)
        except WorldError as error:
            raise WorldError(f"geom {part.geom}: {error}") from None

    def _mount(self, name: str, keys: Any, parts: list[Part], frames: list[Frame]) -> None:
        """Mount a sensor at a site of the model, or on a body as World.sensor does."""
        if not isinstance(keys, Mapping) or ("site" in keys) == ("body" in keys):
            raise WorldError(f"sensors: {name} = {keys!r}: expected a mapping with a site, or with a body")
        given = dict(keys)
        if "site" in given:
            site = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_SITE, str(given["site"]))
            if site < 0:
                raise WorldError(f"sensors: {name}: site = {given['site']}: the model has no such site")
            body = self._model.site_bodyid[site]
            at = next((n for n, part in enumerate(parts) if part.body == body and body > 0), -1)
            if at < 0:
                raise WorldError(f"sensors: {name}: site = {given['site']}: expected one on a body that moves")
            del given["site"]
            given["body"] = self.world.bodies[self._first + at]
            given["place"] = frames[at].axes.T @ (self._data.site_xpos[site] - frames[at].origin)
        self.world.sensor(name, given.pop("body"), given.pop("position", None), **given)

    def _described(self) -> NDArray[np.void]:
        """Return a record of ARRAYS: where MuJoCo has its poses and contacts, and whose they are."""
        data, count = self._data, len(self._bodies)
        made = np.zeros(1, ARRAYS)
        record = made[0]
        record["first"], record["bodies"] = self._first, count
        record["place"][:count] = [frame.place for frame in self._frames]
        record["turned"][:count] = [frame.turned for frame in self._frames]
        record["body"][:count], record["root"][:count] = self._bodies, self._roots
        record["late"] = self._late
        record["led"][:count] = self._model.body_mocapid[self._bodies] >= 0
        for name, array in (
            ("motions", data.cvel), ("abouts", data.subtree_com), ("numbers", self._number),
        ):  # fmt: skip
            record[name] = array.ctypes.data
        for name, place in memory_layout().items():
            if name in (ARRAYS.names or ()):
                record[name] = place
        for name in ("contacts", "forces"):
            record[name] += data._address
        self._mechanical(record["mechanism"])
        record["pyramids"] = self._model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
        return made

    def _mechanical(self, record: np.void) -> None:
        """Fill a record of MECHANISM."""
        model, data, layout, library = self._model, self._data, memory_layout(), mujoco_library()
        for name, function in (("jacobian", library["mj_jac"]), ("solve", library["mj_solveM"])):
            record[name] = cast(function, c_void_p).value or 0
        record["model"], record["data"] = model._address, data._address
        record["velocities"], record["own"] = model.nv, self._by_simulator
        record["smooth"], record["step"] = data._address + layout["smooth"], model._address + layout["step"]
        for name in ("reference", "impedance", "margin"):
            record[name] = layout[name]
        self._room = {"point": np.zeros(3), "slope": np.zeros((3, model.nv)), "along": np.zeros(model.nv)}
        self._room["answer"] = np.zeros(model.nv)
        for name, array in self._room.items():
            record[name] = array.ctypes.data

    def step(self, stepping: Callable[[], object] | None = None) -> Blocks:
        """Take one step of MuJoCo, or all steps of a function, and return their sound.

        Parameters
        ----------
        stepping : callable, optional
            Function that steps this model and data by `mujoco.mj_step`, such as dm_control's `physics.step` or a
            lambda with an environment's step. Where the data is reset, the sound begins anew.

        Returns
        -------
        array
            float32 (frames, channels), in Pa.

        Raises
        ------
        WorldError
            The function lets time go on without `mujoco.mj_step`.
        """
        if stepping is None:
            take_step(self._model, self._data)
            return self.update()
        self.hits = []
        told, time = self.world.simulation.steps, self._data.time
        with listening(self._data, self._take):
            stepping()
        if self.world.simulation.steps == told and self._data.time > time:
            raise WorldError(f"{stepping}: {NO_STEPS}")
        return self.world.block()

    def _take(self, step: Callable[[], None], count: int) -> None:
        """Take so many steps, and report each."""
        self.restart_if_set_back()
        for _ in range(count):
            step()
            if self.report_or_restart():
                self.hits += self.world.hits

    def update(self) -> Blocks:
        """Report a step of MuJoCo, and return the sound since the last update. To be called after each step.

        Returns
        -------
        array
            float32 (frames, channels), in Pa.

        Raises
        ------
        WorldError
            A number is not finite, or the time is that of the last update.
        """
        self.hits = list(self.world.hits) if self.report() else []
        return self.world.block()

    def close(self) -> None:
        """Close the World, unless it was given."""
        if not self._lent:
            self.world.close()

    def report_or_restart(self) -> int:
        """Report a step, as `report` does; restart if MuJoCo has reset an unstable simulation within it."""
        try:
            return self.report()
        except WorldError:
            if not self.restart_if_set_back():
                raise
            return 0

    def restart_if_set_back(self) -> bool:
        """Begin anew, as `restart` does, if the time of `data` was set back since the last step; True if so."""
        set_back = bool(self._data.time - self._behind < self.world.time)
        if set_back:
            self.restart()
        return set_back

    def restart(self) -> None:
        """Begin anew where `data` is now, in silence; to be called after MuJoCo's data was reset."""
        self._arrays["known"] = 0
        led = np.flatnonzero(self._arrays["led"][0])
        self.world.memory["position"][0, self._first + led] = np.nan  # what comes next is no motion of theirs
        self.world.restart(self._now)
