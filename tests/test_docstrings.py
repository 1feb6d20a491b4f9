"""The lint for docstrings finds those that open wrongly, and those alone."""

import inspect
from collections.abc import Iterator

import pytest

import carom
from tests import docstrings

WRONG = (
    '"""What a contact leaves."""',
    '"""How kernels are marked."""',
    'WHERE = 1\n"""Where the rows begin."""',
    'class A:\n    """Which of two it is."""',
    'class A:\n    def __init__(self):\n        self.on = True\n        """Whether it wants to hear."""',
    'class A:\n    @property\n    def on(self):\n        """Whether it is on."""',
    'def f():\n    """What is left."""',
    'def f():\n    """Have a contact begin."""',
    'def f():\n    """Let modes ring."""',
    'def f():\n    """The moments of a force."""',
    'def f():\n    """Writes rows into a file."""',
    'def f():\n    """True."""',
    'def f():\n    """"""',
    'async def f():\n    """As `g` does."""',
    'def f():\n    def g():\n        """That modes ring."""\n    return g',
    'def test_it():\n    """When struck, it rings."""',
)
RIGHT = (
    '"""The path of a body over a surface."""',
    '"""Writes what an engine carries out as a score."""',
    'RATE = 1\n"""Hz."""',
    'RATE: int = 1\n"""1/s: of the mode."""',
    'class A:\n    """A thread that makes objects."""',
    'class A:\n    @functools.cached_property\n    def size(self):\n        """Number of modes."""',
    'def f():\n    """Return what is left."""',
    'def f():\n    """True if modes ring."""',
    'def f():\n    """Solve x = f(x)."""',
    'def f():\n    "a".join("b")',
    '@pytest.fixture(scope="module")\ndef bell():\n    """A bell that rings."""',
    'def test_it():\n    """The bell rings when it is struck."""',
)


@pytest.mark.parametrize("text", WRONG)
def test_a_docstring_that_opens_wrongly_is_found_once_with_its_place(text):
    place = 1 + text.partition('"""')[0].count("\n")
    (line,) = docstrings.faults(text, "dsp/a.py")
    assert line.startswith(f"dsp/a.py:{place}: the docstring opens with '")


@pytest.mark.parametrize("text", RIGHT)
def test_others_are_left_alone(text):
    assert docstrings.faults(text, "dsp/a.py") == []


def test_the_command_fails_with_a_line_for_each(tmp_path, monkeypatch):
    (tmp_path / "dsp").mkdir()
    (tmp_path / "dsp" / "a.py").write_text('"""What it is."""\n\n\ndef f():\n    """Return 1."""\n')
    monkeypatch.setattr(docstrings, "ROOT", tmp_path)
    with pytest.raises(SystemExit, match=r"^dsp/a.py:1: the docstring opens with 'What': expected a noun phrase"):
        docstrings.main()


def public() -> Iterator[tuple[str, object]]:
    """Yield all functions and classes that users import, and the methods and properties of the classes."""
    for module, names in ((carom, carom.__all__), (carom.dsp, carom.dsp.__all__)):
        for name in names:
            value = getattr(module, name)
            if callable(value):
                yield name, value
            for owner in value.__mro__ if inspect.isclass(value) else ():
                for own, member in vars(owner).items() if owner.__module__.startswith("carom") else ():
                    if not own.startswith("_") and (inspect.isfunction(member) or isinstance(member, property)):
                        yield f"{name}.{own}", member


def test_public_docstrings_open_with_a_sentence_in_a_line_of_its_own():
    said = {name: (inspect.getdoc(value) or "").split("\n\n")[0] for name, value in public()}
    assert len(said) > 150
    assert {name: text for name, text in said.items() if not text or "\n" in text or ". " in text} == {}
