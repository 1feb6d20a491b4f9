"""The base of all errors that are Carom's own."""


class CaromError(Exception):
    """An error of Carom's: its text names the culprit, its value and what was expected."""
