"""Keys and the pedal: which notes are struck, and which are damped."""

from ..osc.wire import Message


class Keys:
    """The keys that are held, and the dampers that a pedal brings, as a piano has them.

    Before a pedal's first message there are no dampers: what is struck rings on. From then on a note is damped once its
    key is up, by as much as the pedal is up.
    """

    def __init__(self) -> None:
        self._held: set[tuple[int, int]] = set()  # channel, note
        self._pedals: dict[int, float] = {}  # by channel: 1 is down
        self._struck: dict[str, tuple[int, int]] = {}  # by the name of the copy: its channel and note
        self._told: dict[str, float] = {}  # damp of copies, where it is not the object's own

    def press(self, channel: int, name: str, note: int, velocity: int) -> list[Message]:
        """Press a key: the object `name` plays its note."""
        self._held.add((channel, note))
        self._struck[f"{name}.{note}"] = channel, note
        return [*self._damped(), Message(f"/object/{name}/note", (note, velocity, "play", 1))]

    def release(self, channel: int, note: int) -> list[Message]:
        """Release a key."""
        self._held.discard((channel, note))
        return self._damped()

    def release_all(self, channel: int) -> list[Message]:
        """Release all keys of a channel."""
        self._held = {each for each in self._held if each[0] != channel}
        return self._damped()

    def pedal(self, channel: int, place: float) -> list[Message]:
        """Move the pedal to a place from 0, up, to 1, down."""
        self._pedals[channel] = place
        return self._damped()

    def forget(self, copy: str) -> None:
        """Forget a copy that is gone."""
        self._struck.pop(copy, None)
        self._told.pop(copy, None)

    def is_copy(self, name: str) -> bool:
        """True if an object was made for a note."""
        return name in self._struck

    def _damped(self) -> list[Message]:
        """Return the messages for dampers that change."""
        messages = []
        for copy, key in self._struck.items():
            damp = 0.0 if key in self._held else 1.0 - self._pedals.get(key[0], 1.0)
            if damp != self._told.get(copy, 0.0):
                self._told[copy] = damp
                messages.append(Message(f"/object/{copy}/damp", (damp,)))
        return messages
