"""The addresses that set what MIDI does."""

from ...dsp.schema import Parameter as Number
from .arguments import Either, Note, Refused, Verb, Word, shown
from .wire import Argument

CHANNEL = Number("channel", 0, 16, "", "channel of MIDI; 0: any", default=0.0, whole=True)
LOW = Number("low", -1e12, 1e12, "", "value at the controller's lowest position", otherwise="from the usual range")
HIGH = Number("high", -1e12, 1e12, "", "value at the controller's highest position", otherwise="from the usual range")
LOWEST = Note("low", "lowest note that the object plays")
HIGHEST = Note("high", "highest note that the object plays")
BEND, PRESSURE = "bend", "pressure"


class _Controller(Either):
    """A controller, whose error does not list them all."""

    def check(self, value: Argument) -> str:
        """Return its number as a text, or its name; raise Refused if it is none."""
        try:
            return super().check(value)
        except Refused:
            raise Refused(f"{self.name} = {shown(value)}: expected 0 to 127, {BEND} or {PRESSURE}") from None


_CONTROLLER = _Controller("controller", (*map(str, range(128)), BEND, PRESSURE), "0 to 127, bend or pressure")
_ADDRESS = Word("address", "address that takes one number")

MIDI = (
    Verb(
        "/midi/notes",
        "lets an object play a `channel`, notes `low` to `high`, or both; the object made last plays all other notes",
        (Word("object", "name of the object"),),
        keys=(CHANNEL, LOWEST, HIGHEST),
        scored=False,
    ),
    Verb(
        "/midi/learn",
        "waits for you to move a controller, and binds it to an address; the reply is then `/midi/learnt ADDRESS "
        "CONTROLLER CHANNEL`",
        (_ADDRESS,),
        keys=(CHANNEL, LOW, HIGH),
        scored=False,
    ),
    Verb(
        "/midi/control",
        "binds a controller to an address",
        (_CONTROLLER, _ADDRESS),
        keys=(CHANNEL, LOW, HIGH),
        scored=False,
    ),
    Verb("/midi/forget", "unbinds the controllers of an address, or all controllers", keys=(_ADDRESS,), scored=False),
    Verb(
        "/midi/controls",
        "answers with `/midi/controls.reply FIRST TOTAL`, then each one's controller, channel, address, low and high",
        scored=False,
    ),
)
