"""The addresses that say what MIDI does."""

from ...dsp.schema import Parameter as Number
from .arguments import Either, Note, Refused, Verb, Word, shown
from .wire import Argument

CHANNEL = Number("channel", 0, 16, "", "of MIDI; 0: any", default=0.0, whole=True)
LOW = Number("low", -1e12, 1e12, "", "value at the controller's lowest place")
HIGH = Number("high", -1e12, 1e12, "", "value at its highest one")
LOWEST = Note("low", "the lowest note that it plays")
HIGHEST = Note("high", "the highest one")
BEND, PRESSURE = "bend", "pressure"


class _Controller(Either):
    """A controller, whose error does not list them all."""

    def check(self, value: Argument) -> str:
        """Return its number as a text, or its name; raise Refused if it is none."""
        try:
            return super().check(value)
        except Refused:
            raise Refused(f"{self.name} = {shown(value)}: expected 0 to 127, {BEND} or {PRESSURE}") from None


_CONTROLLER = _Controller("controller", (*map(str, range(128)), BEND, PRESSURE))
_ADDRESS = Word("address")

MIDI = (
    Verb(
        "/midi/notes",
        "has an object play the notes of a channel, or those from `low` to `high`, as /object/NAME/note does. What no "
        "object was given plays the newest one",
        (Word("object"),),
        keys=(CHANNEL, LOWEST, HIGHEST),
        scored=False,
    ),
    Verb(
        "/midi/learn",
        "has the controller that is moved next set an address with one number, such as /gesture/ID/speed; answers "
        "/midi/learnt ADDRESS CONTROLLER CHANNEL then. Its range is that of a fader if no other is given",
        (_ADDRESS,),
        keys=(CHANNEL, LOW, HIGH),
        scored=False,
    ),
    Verb(
        "/midi/control",
        "the same for a controller that is named: 0 to 127, bend or pressure",
        (_CONTROLLER, _ADDRESS),
        keys=(CHANNEL, LOW, HIGH),
        scored=False,
    ),
    Verb("/midi/forget", "has no controller set an address any more; or none at all", keys=(_ADDRESS,), scored=False),
    Verb(
        "/midi/controls",
        "answers /midi/controls.reply FIRST TOTAL and controller, channel, address, low and high of each",
        scored=False,
    ),
)
