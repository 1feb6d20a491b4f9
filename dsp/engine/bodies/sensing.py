"""Sensors on objects: each senses the motion of a point in every frame, untouched by gains and by the limiter.

A sensed object rings frame by frame, and stays out of the spectral bank.
"""

from ...native.jit import noinline_kernel
from ...resonator.bank import Point
from ...resonator.sensed import SHAPE, set_sensed, sum_pushed, sum_sensed
from ..memory.commands import Event
from ..memory.mounted import SENSORS
from ..memory.state import QUANTUM, Object, State
from .objects import frequency_of, highest_of, place, shape_at
from .surface import put_at


@noinline_kernel
def mount(state: State, event: Event) -> None:
    """Mount a sensor on an object, or take it away."""
    sensor = state.sensors[event.channel]
    before = state.objects[sensor.point.slot]
    if sensor.point.serial > 0 and before.serial == sensor.point.serial:
        before.sensors -= 1
    sensor.point.serial = 0
    if event.value == 0.0:
        return
    obj = state.objects[event.slot]
    obj.sensors += 1
    sensor.point.slot, sensor.point.serial = event.slot, event.serial
    sensor.mounted = event.mounted
    sensor.retuned = -1
    sensor.pushed = 0.0
    sensor.memory[0] = sensor.memory[1] = 0.0
    spot = sensor.mounted.spot
    if event.mounted.on_surface == 1 and obj.faces > 0:
        put_at(state, obj, sensor.point, spot[0], spot[1], spot[2])
    else:
        place(sensor.point, event.mounted.position, obj)


@noinline_kernel
def begin_sensing(state: State, obj: Object) -> None:
    """Prepare the sensors on an object for a quantum, before any force acts in it."""
    for k in range(SENSORS):
        sensor = state.sensors[k]
        if sensor.point.serial == obj.serial and (sensor.retuned != obj.retuned or obj.stretch != 0.0):
            # Find the weights of an object's modes as they are tuned now. Its reliefs, clicks and modes that are only
            # felt are none.
            bank = state.bank
            sensor.retuned, sensor.count = obj.retuned, obj.felt
            way = sensor.mounted.direction
            turned = sensor.mounted.on_surface == 1 and obj.block > 0
            turned = turned and (way[0] != 0.0 or way[1] != 0.0 or way[2] != 0.0)
            for i in range(obj.felt):
                # The mass-normalised shape where the sensor is, in its direction: kg^-1/2.
                at, shape = obj.first + i, 0.0
                is_over = frequency_of(state, obj, i) > highest_of(state)
                if not is_over and not turned:
                    shape = shape_at(state, obj, sensor.point, i)
                elif not is_over:
                    value = obj.table + sensor.point.row * obj.size + i
                    for axis in range(3):
                        value += obj.block * obj.size
                        for n in range(3):
                            shape += way[axis] * sensor.point.weights[n] * bank.shape[value + n * obj.size]
                set_sensed(
                    sensor.rows, i, bank.a1[at], bank.a2[at], shape, bank.weight[at], state.rate,
                    sensor.mounted.acceleration == 1,
                )  # fmt: skip


@noinline_kernel
def push_sensed(state: State, obj: Object, point: Point, count: int, impulse: float) -> None:
    """Tell the sensors on an object of a force on its first `count` modes, by its impulse (N s) over a sample."""
    for k in range(SENSORS):
        sensor = state.sensors[k]
        if sensor.point.serial == obj.serial and sensor.mounted.acceleration == 1:
            n = min(count, sensor.count)
            sensor.pushed += impulse * state.rate * sum_pushed(sensor.rows[SHAPE, :n], point)


@noinline_kernel
def sense(state: State, obj: Object, frame: int) -> None:
    """Sense a frame to which an object has rung."""
    bank = state.bank
    for k in range(SENSORS):
        sensor = state.sensors[k]
        if sensor.point.serial == obj.serial:
            n = min(obj.live, sensor.count)
            y1, y2 = bank.y1[obj.first : obj.first + n], bank.y2[obj.first : obj.first + n]
            sensor.sensed[frame] = sensor.pushed + sum_sensed(y1, y2, sensor.rows[0, :n], sensor.rows[1, :n])
            sensor.pushed = 0.0


@noinline_kernel
def finish_sensing(state: State) -> None:
    """Filter what was sensed in a quantum as each sensor's resonance does; hold it back as long as the limiter does
    the sound."""
    for k in range(state.output.sensors):
        sensor = state.sensors[k]
        b0, b1, b2 = sensor.mounted.filter[0], sensor.mounted.filter[1], sensor.mounted.filter[2]
        a1, a2 = sensor.mounted.filter[3], sensor.mounted.filter[4]
        first, second = sensor.memory[0], sensor.memory[1]
        for n in range(QUANTUM):
            x = sensor.mounted.scale * sensor.sensed[n]
            y = b0 * x + first
            first = b1 * x - a1 * y + second
            second = b2 * x - a2 * y
            if state.output.delay > 0:
                sensor.sensed[n], sensor.held[n] = sensor.held[n], y
            else:
                sensor.sensed[n] = y
        sensor.memory[0], sensor.memory[1] = first, second
