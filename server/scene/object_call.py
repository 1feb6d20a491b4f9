"""A message to one object: the object, what strikes it, and the id of the gesture that it starts."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain, islice

from ...dsp.bodies.material import CONTACT_RADIUS
from ...dsp.engine.memory.commands import Handle
from ...dsp.schema import BY_RADIUS, GESTURES, VELOCITY
from ...dsp.wording import MOST_COMPARED, there_are
from ...presets import ObjectPreset
from ...presets.kinds import STAND_IN
from ..osc.addresses import Call
from ..osc.arguments import Refused, Values, Verb, require_name, shown
from ..osc.patterns import is_pattern
from ..osc.wire import Argument, Message
from .gesture_ids import Begin
from .limits import Contact
from .objects import PlayedObject
from .transaction import Transaction
from .turned import recall


@dataclass
class Memory:
    """What was chosen as a gesture's message was carried out, and stays as it is where that is done again, as macros
    have its values otherwise by then."""

    id: str = ""
    number: int = 0
    goes_on: bool | None = None
    """Whether a gesture of that id went on."""
    is_played: bool | None = None
    ground: Handle | None = None
    """What a support's ground is in the engine, or what covers the object."""
    begin: Begin | None = None
    others: list[PlayedObject] = field(default_factory=list)
    """Other objects that it is about."""


@dataclass
class ObjectCall:
    """A call to one of the objects that the NAME in its address matches, and its checked arguments."""

    transaction: Transaction
    call: Call
    values: Values
    name: str
    obj: PlayedObject
    given: Values = field(default_factory=Values)
    """The same before macros changed any."""
    chosen_keys: dict[str, Argument] = field(default_factory=dict)
    """The keys that the message left to be chosen, such as a seed."""
    memory: Memory = field(default_factory=Memory)
    base: Contact | None = None
    """The contact law of its striker in the middle of the macro `hardness`; None of two objects."""

    @property
    def address(self) -> str:
        """The address without a pattern."""
        assert self.call.verb
        return f"/object/{self.name}/{self.call.verb.action}"

    @property
    def canonical(self) -> Message:
        """The message with the keys that it left to be chosen; the NAME in its address stays a pattern."""
        message = self.call.message
        return Message(message.address, (*message.args, *chain.from_iterable(self.chosen_keys.items())))

    @property
    def striker(self) -> str:
        """The preset of what strikes the object."""
        return self.values.words.get("striker", self.obj.preset.striker)

    def striking_object(self) -> PlayedObject | None:
        """Return the object that `by` names, None if it is not given; raise Refused if there is no other object of that
        name."""
        if "by" not in self.values.words:
            return None
        name, objects, time = self.values.words["by"], self.transaction.objects, self.transaction.time
        by = self.object_named(name)
        if by is None:
            others = [other for other in islice(objects.there(time), MOST_COMPARED) if other != self.name]
            known = self.transaction.suggestion(name, others) or there_are(others)
            raise Refused(f"by = {shown(name)}: expected another object; {known}")
        return by

    def object_named(self, name: str) -> PlayedObject | None:
        """Return the other object of a name; None if there is none."""
        found = None if is_pattern(name) else self.transaction.objects.at(name, self.transaction.time).get(name)
        if found is None or found is self.obj:
            return None
        recall(self.transaction, found)
        if found not in self.memory.others:
            self.memory.others.append(found)
        return found

    @property
    def by_materials(self) -> bool:
        """True if the contact is that of two objects, by their materials, and not a striker's."""
        return "by" in self.values.words and "striker" not in self.values.words

    @property
    def is_point_mass(self) -> bool:
        """True if a mass and a stiffness strike the object, and no striker that is named: they sound of nothing."""
        return "striker" not in self.values.words and {"mass", "stiffness"} <= self.values.numbers.keys()

    @property
    def contact_radius(self) -> float:
        """The radius (m) of the object that strikes where it touches: that on which it rolls, if it does."""
        numbers = self.values.numbers
        return numbers.get(BY_RADIUS.name, numbers.get("radius", CONTACT_RADIUS))

    @property
    def is_played(self) -> bool:
        """True if the gesture gets make-up; the canonical message says so."""
        if self.memory.is_played is None:
            self.memory.is_played = bool(self.values.numbers.get("play", self.transaction.makeup.on))
        if self.memory.is_played:
            self.say("play", 1)
        return self.memory.is_played and not self.transaction.scale.calibrated

    def goes_on(self, id: str) -> bool:
        """True if a gesture of this kind goes on, or was sent before, that has an id."""
        if self.memory.goes_on is None:
            self.memory.goes_on = self.transaction.gestures.is_running(id, self.address)
        return self.memory.goes_on

    def say(self, key: str, value: Argument) -> None:
        """Add the value of a key that was not given to the canonical message."""
        if key not in self.values.numbers:
            self.chosen_keys[key] = value

    def warn_of_stand_ins(self, other: PlayedObject, other_name: str) -> None:
        """Warn the sender, once for each, which of the object and another have no material."""
        for name, obj in ((self.name, self.obj), (other_name, other)):
            if obj.preset.material is None and not obj.warned_of_stand_in:
                obj.warned_of_stand_in = True
                self.transaction.on_undo(partial(setattr, obj, "warned_of_stand_in", False))
                text = f"{name} has no material: where it and another object meet, it counts as {STAND_IN}"
                self.transaction.replies.append(Message("/warning", (text,)))

    def id(self, choose: Callable[[str], str]) -> str:
        """Return the id of the gesture: the given one, else one that is chosen for the object's name."""
        if "id" in self.values.words:
            return self.values.words["id"]
        self.memory.id = self.chosen_keys["id"] = id = self.memory.id or choose(self.name)
        return id

    def start(self, id: str) -> int:
        """Return the number of a gesture that begins."""
        if self.memory.number:
            return self.memory.number
        require_name("id", id)
        gestures = self.transaction.gestures
        started = gestures.start(id, self.address, self.transaction.source)
        self.transaction.on_undo(lambda: gestures.take_back(started))
        self.memory.number = started.number
        return started.number

    def end_at_once(self) -> None:
        """End at once, as nothing moves: whoever gave an id is notified that its gesture is over."""
        if "id" in self.values.words:
            id = self.values.words["id"]
            require_name("id", id)
            self.transaction.gestures.end_at_once(id, self.address, self.transaction.source)
            self.transaction.on_undo(self.transaction.gestures.take_back_end)

    def seed(self, number: int) -> float:
        """Return the seed of a gesture's random numbers: the given one, else the gesture's number."""
        if "seed" not in self.values.numbers:
            self.chosen_keys["seed"] = number
        return self.values.numbers.get("seed", number)


def completed(values: Values, verb: Verb | None, preset: ObjectPreset) -> Values:
    """Return the values of a message; of a gesture's with those that the preset has for what it leaves out.

    A message that says what strikes takes none of the preset's striker; the surface is the object's all the same.
    Refused if neither says the gesture's first argument.
    """
    if verb is None or verb.action not in GESTURES or GESTURES[verb.action].what:
        return values
    usual, gesture = preset.gestures.get(verb.action), GESTURES[verb.action]
    argument, words, defaults = gesture.argument.name, values.words, values.defaults
    instead = values.numbers.get(gesture.instead)
    if instead is not None and argument in values.numbers:
        both = f"{argument} = {values.numbers[argument]:g}, {gesture.instead} = {instead:g}"
        raise Refused(f"{both}: expected one of the two")
    if not usual and argument == VELOCITY.name:
        defaults = {**defaults, argument: preset.velocity}
    if usual:
        strikes = {"striker", "by"} & words.keys() or {"mass", "stiffness"} <= values.numbers.keys()
        named = {"surface": usual.surface} if usual.surface else {}
        words = {**named, **({} if strikes else {"striker": usual.striker}), **words}
        defaults = {**defaults, **({argument: usual.numbers[argument]} if strikes else usual.numbers)}
    if instead is not None:
        defaults = {**defaults, argument: 0.0}
    elif argument not in values.numbers and argument not in defaults:
        raise Refused(f"{argument} is missing, and {preset.name} has none: expected {verb.usage()}")
    return replace(values, words=words, defaults=defaults)
