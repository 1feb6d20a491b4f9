"""The error of a recording that cannot be fitted."""

from ..errors import CaromError


class RecordingError(CaromError, ValueError):
    """A sound of which no body can be made; the text names what is wrong with it and what was expected."""
