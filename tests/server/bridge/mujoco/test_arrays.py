"""A step that is gathered from a simulator's arrays against the same step in the tracker's own columns."""

import numpy as np

from carom.server.bridge.mujoco.arrays import ARRAYS
from carom.server.bridge.telling import LOOK, NOT_WHOLE, OBJECTS, PER_BLOW, TELLING, begin_telling, tell
from carom.server.bridge.tracking.microphones import MICROPHONE_STATE
from carom.server.bridge.tracking.state import POINTS, new_state

CONTACT = np.dtype(
    [("dist", "f8"), ("pos", "f8", 3), ("frame", "f8", 9), ("pad", "f8", 5), ("dim", "i4"), ("geom", "i4", 2),
     ("address", "i4")], align=True,
)  # fmt: skip


class Step:
    """A step's time and the number of its contacts, and what they are told to."""

    def __init__(self, state: np.ndarray, arrays: np.ndarray | None = None) -> None:
        self.microphones, self.objects = np.zeros(1, MICROPHONE_STATE), np.zeros(1, OBJECTS)
        self.time, self.points = np.zeros(1), np.zeros(1, np.int32)
        self.telling = np.zeros(1, TELLING)
        begin_telling(self.telling, state=state, microphones=self.microphones, objects=self.objects)
        self.telling["time"], self.telling["points"] = self.time.ctypes.data, self.points.ctypes.data
        self.telling["arrays"] = 0 if arrays is None else arrays.ctypes.data

    def told(self, time: float, points: int) -> int:
        self.time[0], self.points[0] = time, points
        return tell(self.telling.ctypes.data)


class Simulator:
    """Three geoms, of which the last two move, and three contacts in a struct's memory."""

    def __init__(self) -> None:
        generator = np.random.default_rng(1)
        self.places = generator.normal(size=(3, 3))
        self.turns = np.stack([np.linalg.qr(generator.normal(size=(3, 3)))[0] for _ in range(3)])
        self.motions = generator.normal(size=(4, 6))
        self.abouts = generator.normal(size=(4, 3))
        self.numbers = np.array([0, 1, 2], np.int32)
        self.forces = np.arange(1.0, 13.0)
        self.contacts = np.zeros(3, CONTACT)
        self.contacts["dist"] = -0.001, -0.002, 0.001
        self.contacts["pos"] = generator.normal(size=(3, 3))
        self.contacts["frame"][:, :3] = (0, 0, 1.0), (0, 1.0, 0), (1.0, 0, 0)
        self.contacts["geom"] = (0, 1), (1, 2), (0, 2)
        self.contacts["dim"], self.contacts["address"] = 3, (4, 8, -1)
        self.pointers = np.array([self.contacts.ctypes.data, self.forces.ctypes.data])

    def described(self, pyramids: bool) -> np.ndarray:
        made = np.zeros(1, ARRAYS)
        record = made[0]
        record["first"], record["bodies"] = 1, 2
        record["body"][:2], record["root"][:2] = (2, 3), (2, 3)
        record["place"][:2] = [each.ctypes.data for each in self.places[1:]]
        record["turned"][:2] = [each.ctypes.data for each in self.turns[1:]]
        for name, array in zip(
            ("motions", "abouts", "numbers"),
            (self.motions, self.abouts, self.numbers),
            strict=True,
        ):
            record[name] = array.ctypes.data
        record["contacts"], record["forces"] = self.pointers.ctypes.data, self.pointers.ctypes.data + 8
        record["stride"], record["pyramids"] = CONTACT.itemsize, pyramids
        for name, of in {"point": "pos", "normal": "frame", "distance": "dist", "geoms": "geom", "row": "address",
                         "dimensions": "dim"}.items():  # fmt: skip
            record[name] = CONTACT.fields[of][1]
        return made

    def told(self, state: np.ndarray, pyramids: bool) -> None:
        """Write the same as columns."""
        record, contact = state[0], self.contacts
        record["position"][1:3], record["turn"][1:3] = self.places[1:], self.turns[1:].reshape(2, 9)
        record["spin"][1:3], record["velocity"][1:3] = self.motions[2:, :3], self.motions[2:, 3:]
        record["about"][1:3] = self.abouts[2:]
        record["pair"][:3] = contact["geom"]
        record["pair"][2, 1] = 0  # it is not in force
        record["point"][:3], record["normal"][:3] = contact["pos"], contact["frame"][:, :3]
        record["depth"][:3] = -contact["dist"]
        rows = 4 if pyramids else 1
        record["force"][:3] = [self.forces[n : n + rows].sum() if n >= 0 else 0.0 for n in contact["address"]]


def test_a_step_is_the_same_from_a_simulators_arrays():
    for pyramids in (False, True):
        simulator, states = Simulator(), [new_state(0.01, 9.81) for _ in range(2)]
        for state in states:
            state["bodies"], state["lightness"][:, 1:3], state["yielding"][:, 1:3] = 3, 2.0, 5.0
            state["rings"], state["most"] = 1, 24
        arrays = simulator.described(pyramids)
        steps = [Step(states[0]), Step(states[1], arrays)]
        for time in (0.001, 0.002, 0.04, 0.08):
            simulator.places += 1e-3
            simulator.told(states[0], pyramids)
            told = [step.told(time, 3) for step in steps]
            blows = int(states[0]["struck"][0])
            assert told[0] == told[1] and told[0] // PER_BLOW == blows
            assert time > 0.001 or told[0] == PER_BLOW + LOOK
            found = [int(state["happened"][0]) for state in states]
            assert found[0] == found[1] and (time > 0.001 or found[0] > 0)
            assert states[0]["events"][0, : found[0]].tobytes() == states[1]["events"][0, : found[0]].tobytes()


def test_too_many_contacts_are_refused_before_they_are_read():
    state, arrays = new_state(0.01, 9.81), Simulator().described(False)
    assert Step(state, arrays).told(0.001, POINTS + 1) == NOT_WHOLE
