"""The scene: objects by name. It turns messages into engine commands, alike for a live server and a score."""

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

from ...dsp.bodies.material import Material
from ...dsp.contact.accuracy import LEVELS
from ...dsp.contact.sampled import CORRECTIONS, METHODS
from ...dsp.engine.state import GESTURES, RING, Command, Steering
from ...dsp.runtime.arena import EngineFull
from ...dsp.runtime.engine import NOW, Engine, Handle
from ...presets.library import ObjectPreset, PresetError, Presets
from ..osc.addresses import VERBS, Refused, Values, Verb, shown, spelled
from ..osc.patterns import is_pattern, match
from ..osc.wire import Argument, Message
from .gesture_ids import Ended, Gestures
from .limits import GRAVITY, LAW, Contact, fall, require_rest, require_rollable, require_short

_NAME = re.compile(r"[^\s#*,/?\[\]{}]{1,64}")
_FORBIDDEN = "# * , / ? [ ] { } or space"
_SURFACE = "wood"
_ANY_RADIUS = 0.01  # m: of a roll that is steered, and so has one
_APPROACH = 0.01  # m/s: how fast a pressing striker is laid on
_STEERED = ("position", "mass", "gain", "gravity", "radius", "friction", "asymmetry", "roughness")
"""What of a roll may be given anew while it goes on, by the bits of Command.ROLL."""

_SETTINGS = {"gain": 0.0, "pan": 0.0, "tune": 0.0, "decay": 1.0, "damp": 0.0}

EngineCommand = tuple[float, Command, Handle | None, tuple[float, ...]]


class Sent(NamedTuple):
    """The message that became a command, the serials of its object and of the one that strikes it (0: none), and the
    mass (kg) that strikes."""

    message: Message
    serial: int
    by: int
    mass: float


@dataclass(eq=False)
class _Object:
    handle: Handle
    preset: ObjectPreset
    mass: float  # kg
    born: float  # samples: nothing happens to it before
    leaves: float = math.inf  # samples: from then on its name is free


class Scene:
    """The objects that an engine plays, by name."""

    def __init__(self, engine: Engine, presets: Presets) -> None:
        self.engine = engine
        self.presets = presets
        self.objects: dict[str, _Object] = {}
        self.gestures = Gestures(engine)
        self._displaced: list[tuple[str, _Object]] = []  # that are still there when their name is another's
        self._undo: list[Callable[[], object]] = []
        self.on_sent: Callable[[int, list[Sent]], object] = lambda first, sent: None
        """Told of every command that is sent: the number of the first, and what each stands for."""
        self._time = NOW
        self._source: Any = None
        self._said: list[Message] = []  # for each command of a message, what says the same without leaving a choice
        self._added: tuple[Argument, ...] = ()  # what a message to an object left to be chosen
        self._contacts: dict[tuple[str, Material | None], Contact] = {}  # read from files once an object was made

    def perform(self, messages: Iterable[Message], time: float, source: Any = None) -> list[Message]:
        """Carry out messages of a source together at a time (samples); returns /done and /fail replies.

        A message that is refused leaves no trace and does not hold up the others. Either all their commands reach the
        engine or, where it has no room for them, none.
        """
        replies: list[Message] = []
        commands: list[EngineCommand] = []
        meant: list[Message] = []
        accepted: list[str] = []
        self._undo.clear()
        self._time = time
        self._source = source
        self._forget_gone()
        plain = [each for message in messages for each in spelled(message)]
        try:
            for place, message in enumerate(plain):
                done = len(self._undo)
                self._said = [message]
                try:
                    more, reply = self._translate(message)
                except (Refused, PresetError, EngineFull) as error:
                    self._undo_from(done)
                    replies.append(fail(message.address, str(error)))
                else:
                    commands += more
                    meant += self._said
                    replies += reply
                    accepted.append(message.address)
                if len(commands) > RING:  # they will never be sent: spare the time to translate the rest
                    accepted += [rest.address for rest in plain[place + 1 :]]
                    break
            first = self.engine.sent
            self.engine.send(commands)
        except EngineFull as error:
            self._undo_from(0)
            replies = [r for r in replies if r.address == "/fail"]
            return replies + [fail(address, str(error)) for address in accepted]
        except BaseException:
            self._undo_from(0)
            raise
        self.on_sent(first, list(map(_sent, meant, commands)))
        return replies

    def _undo_from(self, first: int) -> None:
        """Take back what was done in the scene for commands that are not sent."""
        while len(self._undo) > first:
            self._undo.pop()()

    def _living(self, pattern: str = "*") -> dict[str, _Object]:
        """The objects whose names match that are there, or the next to be, at the time of what is being carried out."""
        now = max(self._time, float(self.engine.position))
        living: dict[str, _Object] = {}
        if is_pattern(pattern):
            named = [(name, obj) for name, obj in (*self._displaced, *self.objects.items()) if match(pattern, name)]
        else:  # most are, and to look through all objects for one takes long
            named = [(name, obj) for name, obj in self._displaced if name == pattern]
            named += [(pattern, self.objects[pattern])] if pattern in self.objects else []
        for name, obj in named:
            if obj.leaves > now:
                living.setdefault(name, obj)
        return living

    def take_ends(self) -> list[Ended]:
        """Gestures that have ended since the last call."""
        return self.gestures.take_ends()

    def _forget_gone(self) -> None:
        self.gestures.collect()
        gone = self.engine.position
        self._displaced = [(name, obj) for name, obj in self._displaced if obj.leaves > gone]
        for name in [name for name, obj in self.objects.items() if obj.leaves <= gone]:
            del self.objects[name]

    def _for(self, obj: _Object, kind: Command, *values: float) -> EngineCommand:
        """A command to an object: what is for now waits for one that is yet to be."""
        time = max(self._time, obj.born) if obj.born > self.engine.position else self._time
        return time, kind, obj.handle, values

    def _translate(self, message: Message) -> tuple[list[EngineCommand], list[Message]]:
        if message.address == "/panic":
            VERBS["/panic"].parse(message.args)
            return [(self._time, Command.PANIC, None, ())], []
        if message.address in VERBS and not VERBS[message.address].scored:
            raise Refused("only a running server carries it out; expected what sounds")
        if message.address == "/object/new":
            return self._new(VERBS["/object/new"].parse(message.args))
        if message.address == "/quality":
            quality = _whole("quality", VERBS["/quality"].parse(message.args).numbers["quality"])
            return [(self._time, Command.QUALITY, None, (quality,))], []
        if message.address == "/accuracy":
            accuracy = LEVELS.index(VERBS["/accuracy"].parse(message.args).words["accuracy"])
            return [(self._time, Command.ACCURACY, None, (float(accuracy),))], []
        if message.address == "/contact":
            choice = _contact_choice(VERBS["/contact"].parse(message.args))
            return [(self._time, Command.CONTACT, None, choice)], []
        parts = message.address.split("/")
        if len(parts) == 4 and parts[1] == "gesture":
            return self._steer(parts[2], parts[3], message.args), []
        if len(parts) != 4 or parts[:2] != ["", "object"]:
            raise Refused(f"no such address; expected one of {', '.join(VERBS)}")
        _, _, pattern, action = parts
        verb = VERBS.get(f"/object/NAME/{action}")
        if verb is None:
            actions = ", ".join(a.rsplit("/", 1)[1] for a in VERBS if a.startswith("/object/NAME/"))
            raise Refused(f"{action}: nothing an object does; expected {actions}")
        values = verb.parse(message.args)
        objects = self._living(pattern)
        if not objects:
            known = ", ".join(list(self._living())[:8]) or "none"
            raise Refused(f"{pattern}: no such object; there are {known}")
        commands = []
        self._said = []
        for name, obj in objects.items():
            self._added = ()
            more = self._act(name, obj, verb, values)
            commands += more
            self._said += [Message(message.address, message.args + self._added)] * len(more)
        return commands, []

    def _act(self, name: str, obj: _Object, verb: Verb, values: Values) -> list[EngineCommand]:
        action = verb.address.rsplit("/", 1)[1]
        if action == "impact":
            return self._impact(name, obj, values)
        if action == "bounce":
            return self._bounce(name, obj, values)
        if action == "roll":
            return self._roll(name, obj, values)
        if action == "press":
            return self._press(name, obj, values)
        if action == "free":
            return [self._free(obj, values.numbers.get("at_once", 0.0))]
        return [self._for(obj, Command[action.upper()], _physical(action, values.numbers[action]))]

    def _free(self, obj: _Object, at_once: float) -> EngineCommand:
        command = self._for(obj, Command.FREE, at_once)
        before = obj.leaves
        if before == math.inf:
            self.engine.leave(obj.handle)
            self._undo.append(lambda: self.engine.stay(obj.handle))
        self._undo.append(lambda: setattr(obj, "leaves", before))
        obj.leaves = min(before, max(command[0], float(self.engine.position)))
        return command

    def _new(self, values: Values) -> tuple[list[EngineCommand], list[Message]]:
        name = values.words["name"]
        if not _NAME.fullmatch(name) or not name.isprintable() or name == "new":
            raise Refused(f"name = {shown(name)}: expected 1 to 64 printable characters, none of them {_FORBIDDEN}")
        if self._living(name):
            raise Refused(f"name = {name}: there is such an object already; free it first")
        settings = {key: values.numbers.pop(key, default) for key, default in _SETTINGS.items()}
        preset = self.presets.object(values.words["preset"])
        changes = {**values.others, **values.numbers}
        if "striker" in values.words:
            changes["striker"] = values.words["striker"]
        if changes:
            preset = preset.replace(**changes)
        self._contacts.clear()
        self._contact(preset.striker, preset.material)
        modes = preset.modes(self.engine.top_frequency)
        handle, size, rows = self.engine.lay_out(modes, 10 ** (preset.level / 20))
        obj = _Object(handle, preset, modes.mass, self._time)
        before = self.objects.get(name)
        if before:
            self._displaced.append((name, before))
            self._undo.append(lambda: self.objects.update({name: before}))
            self._undo.append(lambda: self._displaced.remove((name, before)))
        self.objects[name] = obj
        self._undo += [lambda: self.engine.release(handle), lambda: self.objects.pop(name)]
        initial = (_physical(key, value) for key, value in settings.items())
        new = self._for(obj, Command.NEW, handle.first, size, handle.table, rows, *initial)
        return [new], [Message("/done", ("/object/new", name))]

    def _impact(self, name: str, obj: _Object, values: Values) -> list[EngineCommand]:
        velocity = values.numbers["velocity"]
        if velocity == 0.0:
            return self._stay(name, "impact", values)
        contact = self._law(obj, values)
        require_short(velocity, contact)
        id = values.words.get("id")
        return [self._strike(obj, Command.IMPACT, velocity, contact, values, self._start(id, name, "impact"))]

    def _bounce(self, name: str, obj: _Object, values: Values) -> list[EngineCommand]:
        numbers = values.numbers
        contact = self._law(obj, values)
        gravity = numbers.get("gravity", GRAVITY)
        velocity, seconds = fall(numbers["height"], numbers.get("velocity", 0.0), gravity)
        if velocity == 0.0:
            return self._stay(name, "bounce", values)
        require_short(velocity, contact)
        require_rest(velocity, contact, gravity)
        serial = self._start_named(values, name, "bounce")
        motion = (
            gravity,
            numbers.get("irregularity", 0.0),
            self._seed(values, serial),
            seconds,
            numbers.get("weight", 0.0),
        )
        return [self._strike(obj, Command.BOUNCE, velocity, contact, values, serial, motion)]

    def _roll(self, name: str, obj: _Object, values: Values) -> list[EngineCommand]:
        numbers = values.numbers
        speed = numbers["speed"]
        surface = self.presets.surface(values.words.get("surface", _SURFACE))
        numbers.setdefault("dissipation", surface.dissipation)
        contact = self._law(obj, values)
        id = values.words.get("id", name)
        radius = numbers.get("radius", self._radius(obj, values))
        if speed > 0.0 and not self.gestures.goes_on(id, f"/object/{name}/roll"):
            if not radius:
                raise Refused("radius is missing: the striker has none")
            require_rollable(radius, surface, numbers.get("roughness", 1.0))
        if "id" not in values.words:
            self._added += ("id", name)
        serial = self._start(id, name, "roll")
        given = sum(1 << bit for bit, key in enumerate(_STEERED) if key in numbers)
        motion = (
            numbers.get("gravity", GRAVITY), radius or _ANY_RADIUS, *surface.profile, self._seed(values, serial),
            numbers.get("friction", 0.0), numbers.get("asymmetry", 0.0), numbers.get("roughness", 1.0),
            numbers.get("travel", 0.0), float(given),
            _whole("corners", numbers.get("corners", 0.0)),
        )  # fmt: skip
        return [self._strike(obj, Command.ROLL, speed, contact, values, serial, motion)]

    def _radius(self, obj: _Object, values: Values) -> float:
        """The radius of the ball that a message rolls, 0 if it is none."""
        return self.presets.striker(values.words.get("striker", obj.preset.striker)).radius or 0.0

    def _press(self, name: str, obj: _Object, values: Values) -> list[EngineCommand]:
        contact = self._law(obj, values)
        force = values.numbers["force"]
        require_short(_APPROACH, contact)
        serial = self._start_named(values, name, "press")
        return [self._strike(obj, Command.PRESS, _APPROACH, contact, values, serial, (force,))]

    def _law(self, obj: _Object, values: Values) -> Contact:
        """The contact of what a message strikes with."""
        preset = self._contact(values.words.get("striker", obj.preset.striker), obj.preset.material)
        law = dict(zip(LAW, preset, strict=True))
        if "by" in values.words:
            law["mass"] = self._striker(obj, values).mass
        mass, stiffness, dissipation, exponent = (values.numbers.get(key, value) for key, value in law.items())
        return mass, stiffness, dissipation, exponent

    def _striker(self, obj: _Object, values: Values) -> _Object:
        """The object that a message strikes another one with."""
        name = values.words["by"]
        striker = None if is_pattern(name) else self._living(name).get(name)
        if striker is None or striker is obj:
            known = ", ".join([other for other, each in self._living().items() if each is not obj][:8]) or "none"
            raise Refused(f"by = {shown(name)}: expected another object; there are {known}")
        return striker

    def _start(self, id: str | None, name: str, action: str) -> int:
        """The number of a gesture on the object NAME, 0 for one that nobody will ask for."""
        if id is None:
            return 0
        if not _NAME.fullmatch(id) or not id.isprintable():
            raise Refused(f"id = {shown(id)}: expected 1 to 64 printable characters, none of them {_FORBIDDEN}")
        started = self.gestures.new(id, f"/object/{name}/{action}", self._source)
        self._undo.append(lambda: self.gestures.forget(started))
        return started.number

    def _stay(self, name: str, action: str, values: Values) -> list[EngineCommand]:
        """Nothing happens; who gave an id is told that it is over."""
        if "id" in values.words:
            self.gestures.end_at_once(values.words["id"], f"/object/{name}/{action}", self._source)
        return []

    def _start_named(self, values: Values, name: str, action: str) -> int:
        """The number of a gesture that has a name in any case."""
        if "id" in values.words:
            return self._start(values.words["id"], name, action)
        id = self.gestures.numbered(name)
        self._added += ("id", id)
        return self._start(id, name, action)

    def _seed(self, values: Values, serial: int) -> float:
        """The seed of what is left to chance: another one for every gesture, unless it is given."""
        if "seed" not in values.numbers:
            self._added += ("seed", serial)
        return _whole("seed", values.numbers.get("seed", serial))

    def _strike(
        self, obj: _Object, kind: Command, velocity: float, contact: Contact, values: Values, serial: int,
        motion: tuple[float, ...] = (),
    ) -> EngineCommand:  # fmt: skip
        numbers = values.numbers
        position = numbers.get("position", obj.preset.position)
        gain = _physical("gain", numbers.get("gain", 0.0))
        by = (0.0, 0.0, 0.0)
        time, _, handle, _ = self._for(obj, kind)
        if "by" in values.words:
            other = self._striker(obj, values)
            by = (other.handle.slot, other.handle.serial, numbers.get("by_position", other.preset.position))
            time = max(time, self._for(other, kind)[0])
        return time, kind, handle, (velocity, position, *contact, gain, serial, *by, *motion)

    def _steer(self, pattern: str, action: str, args: tuple[Argument, ...]) -> list[EngineCommand]:
        verb = VERBS.get(f"/gesture/ID/{action}")
        if verb is None:
            actions = ", ".join(a.rsplit("/", 1)[1] for a in VERBS if a.startswith("/gesture/"))
            raise Refused(f"{action}: nothing a gesture does; expected {actions}")
        numbers = verb.parse(args).numbers
        known = self.gestures.known()
        meant = [id for id in known if match(pattern, id.name)]
        if not meant:
            raise Refused(f"{pattern}: no such gesture; there are {', '.join(id.name for id in known[-8:]) or 'none'}")
        if is_pattern(pattern):  # what was sent and hasn't ended; one that is named may be on its way in any case
            meant = [id for id in meant if id.started]
        value = _physical(action, numbers.get(action, 0.0))
        steering = float(Steering[action.upper()])
        self._said = [Message(f"/gesture/{id.name}/{action}", args) for id in meant]
        return [(self._time, Command.STEER, None, (float(id.number), steering, value)) for id in meant]

    def _contact(self, striker: str, material: Material | None) -> Contact:
        if (striker, material) not in self._contacts:
            self._contacts[striker, material] = self.presets.striker(striker).contact(material)
        return self._contacts[striker, material]


def fail(address: str, reason: str) -> Message:
    """The reply to what can't be done."""
    return Message("/fail", (address, reason))


def _sent(message: Message, command: EngineCommand) -> Sent:
    _, kind, handle, values = command
    mass, by = (values[2], int(values[9])) if kind in GESTURES else (0.0, 0)
    return Sent(message, handle.serial if handle else 0, by, mass)


def _contact_choice(values: Values) -> tuple[float, float, float]:
    """How contacts are to be solved, as the engine takes it."""
    method = values.words["method"]
    correction = values.words.get("correction", "none")
    oversampling = values.numbers.get("oversampling", 1.0)
    if method != "closed" and method not in METHODS:
        raise Refused(f"method = {shown(method)}: expected closed, {', '.join(METHODS)}")
    if correction not in CORRECTIONS:
        raise Refused(f"correction = {shown(correction)}: expected {', '.join(CORRECTIONS)}")
    if oversampling != int(oversampling):
        raise Refused(f"oversampling = {oversampling:g}: expected a whole number")
    if method == "closed":
        if correction != "none" or oversampling != 1:
            raise Refused("closed: it is exact already; expected neither correction nor oversampling")
        return 0.0, 0.0, 0.0
    return 1.0 + METHODS.index(method), float(CORRECTIONS[correction]), oversampling


def _whole(name: str, value: float) -> float:
    if value != int(value):
        raise Refused(f"{name} = {value:g}: expected a whole number")
    return value


def _physical(setting: str, value: float) -> float:
    """A setting as the engine takes it: dB as amplitude, semitones as a ratio."""
    if setting == "gain":
        return 10 ** (value / 20)
    if setting == "tune":
        return 2 ** (value / 12)
    return value
