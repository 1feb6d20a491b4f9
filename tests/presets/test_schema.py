"""The schema: its keys are the arguments of the functions that make modes, its words are the bodies'."""

import inspect

from carom.presets.schema import SHAPES


def test_the_schema_is_the_functions_signature():
    for name, shape in SHAPES.items():
        arguments = set(inspect.signature(shape.make).parameters) - {"material", "top", "best"}
        assert set(shape.fields) == arguments, name
