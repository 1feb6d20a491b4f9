"""Controllers and the addresses that they set: how a place of one becomes a value."""

from collections.abc import Iterator
from dataclasses import dataclass

from ...dsp.schema import GESTURES, Parameter
from ..osc.addresses import calls, unknown
from ..osc.arguments import Refused, Values, check_number
from ..osc.midi_verbs import CHANNEL, HIGH, LOW
from ..osc.points import Change
from ..osc.wire import Argument, Message

_SMOOTH = 0.03
"""s in which what a controller sets gets from one of its 128 places to the next."""
_WIDE = 30.0  # a range of a greater ratio is covered by equal ratios
MOST = 1_024
"""Controls that there may be."""
_BEGIN = tuple(name for name, gesture in GESTURES.items() if gesture.along)  # gestures that a further message steers


@dataclass(frozen=True)
class Control:
    """An address that a controller sets, on a channel (0: any), and the values at its ends."""

    address: str
    controller: str
    channel: int
    low: float
    high: float
    is_change: bool
    """True if the address takes its time: it needs no steps then."""

    def hears(self, controller: str, channel: int) -> bool:
        """True if it is about a controller of a channel."""
        return self.controller == controller and self.channel in (0, channel)

    def message(self, share: float) -> Message:
        """Return the message for a share of the controller's way from its lowest to its highest place."""
        if min(self.low, self.high) > 0.0 and not 1 / _WIDE <= self.high / self.low <= _WIDE:
            value = self.low * (self.high / self.low) ** share
        else:
            value = self.low + (self.high - self.low) * share
        value = min(max(value, min(self.low, self.high)), max(self.low, self.high))
        return Message(self.address, (value, "over", _SMOOTH) if self.is_change else (value,))


def control(values: Values, controller: str) -> Control:
    """Return the control that a message asks for. Refused says what is wrong with its address or range."""
    address = values.words["address"]
    number, is_change = _number_of(address)
    low, high = number.useful or (number.low, number.high)
    low = check_number(number, values.numbers.get(LOW.name, low))
    high = check_number(number, values.numbers.get(HIGH.name, high))
    return Control(address, controller, int(values.numbers.get("channel", CHANNEL.default or 0)), low, high, is_change)


def _number_of(address: str) -> tuple[Parameter, bool]:
    """Return the number that an address takes, and whether it is a change."""
    made = calls(Message(address))
    for call in made:
        if call.verb is None:
            raise unknown(address)
    first = made[0].verb if len(made) == 1 else None
    if isinstance(first, Change) and len(first.required) == 1:
        return first.number, True
    if first and first.action in _BEGIN:
        number = (*first.required, *first.optional)[0]
        if isinstance(number, Parameter):
            return number, False
    raise Refused(f"address = {address}: expected one that sets one number, such as /gesture/ID/speed")


class Controls:
    """All controls, and the one that is to be learnt."""

    def __init__(self) -> None:
        self._by_address: dict[str, Control] = {}

    def bind(self, control: Control) -> None:
        """Bind a controller to an address; no other one sets it any more. Refused where there are too many."""
        self.require_room(control.address)
        self._by_address[control.address] = control

    def require_room(self, address: str) -> None:
        """Raise Refused if there are too many controls for one of another address."""
        if address not in self._by_address and len(self._by_address) >= MOST:
            raise Refused(f"address = {address}: {MOST} addresses are set already: expected /midi/forget first")

    def forget(self, address: str) -> None:
        """Unbind an address, all if it is empty. Refused if nothing sets it."""
        if address and address not in self._by_address:
            raise Refused(f"address = {address}: no controller sets it")
        for each in [address] if address else list(self._by_address):
            del self._by_address[each]

    def of(self, controller: str, channel: int) -> list[Control]:
        """Return those that hear a controller."""
        return [each for each in self._by_address.values() if each.hears(controller, channel)]

    def listed(self) -> Iterator[tuple[Argument, ...]]:
        """Yield each as /midi/controls lists it."""
        for each in self._by_address.values():
            yield each.controller, each.channel, each.address, each.low, each.high
