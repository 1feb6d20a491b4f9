"""Arguments that no public call takes, or that it lacks: a sentence names the call, the argument and its value."""

import inspect

import numpy as np
import pytest

import carom
from carom.dsp.arguments import explain_arguments

SCENE = carom.Scene()
BAR = SCENE.new("bar", "marimba-bar")
WORLD = carom.World()

REFUSED = {
    "rebuild(): row missing: expected row": lambda: carom.rebuild(),
    "row = 'x': it has no 'frames'; expected a row of a data set's table": lambda: carom.rebuild("x"),
    "row = {'frames': 3}: it has no 'rate'; expected a row": lambda: carom.rebuild({"frames": 3}),
    "a = array([0., 0.]): expected a sound file": lambda: carom.compare(np.zeros(2), np.zeros(2)),
    "fit(): out, name missing: expected recordings, out, name": lambda: carom.fit(5),
    "recordings = 5: expected sound files": lambda: carom.fit(5, "mine", "bar"),
    "recordings = 6: expected sound files": lambda: carom.fit([6], "mine", "bar"),
    "fit(): mode = 3: did you mean modes?": lambda: carom.fit("a.wav", "mine", "bar", mode=3),
    "mesh(): wal = 0.1: did you mean wall?": lambda: carom.mesh("a.obj", "mine", "cup", "steel", wal=0.1),
    "file = 5: expected a mesh file": lambda: carom.mesh(5, "mine", "cup", "steel"),
    "recipe = 5: expected the name of a recipe": lambda: carom.render_many(5),
    "render(): second = 3: did you mean seconds?": lambda: carom.render("0 /panic", second=3),
    "Scene(): foo = 3: expected one of rate, limiter, gain": lambda: carom.Scene(foo=3),
    "World(): foo = 3: expected one of rate, microphones": lambda: carom.World(foo=3),
    "Client(): prot = 3: did you mean port?": lambda: carom.Client(prot=3),
    "Hearing(): foo = 2: expected one of microphones": lambda: carom.Hearing(foo=2),
    "Touch(): b, point, normal missing: expected a, b, point, normal": lambda: carom.Touch("a"),
    "Pose(): position missing: expected position": lambda: carom.Pose(),
    "render(): sec = 3: did you mean seconds?": lambda: SCENE.render(sec=3),
    "new(): preset missing: expected name, preset": lambda: SCENE.new("a"),
    "damp(): amount missing: expected amount": lambda: BAR.damp(),
    "damp(): amount missing: expected name, amount": lambda: SCENE.damp("bar"),
    "impact(): 4: one argument without a name too many; expected at most velocity, position, at": lambda: BAR.impact(
        1, 0.5, 3, 4
    ),
    "quality(): level = 2: it was given twice; expected it once": lambda: SCENE.quality(1, level=2),
    "body(): material missing: expected name, shape, size, material": lambda: WORLD.body("a", "box", (1, 1, 1)),
    "step(): time missing: expected time": lambda: WORLD.step(),
}


@pytest.mark.parametrize("text", REFUSED)
def test_an_argument_that_is_not_taken_or_lacks_is_named(text):
    with pytest.raises(TypeError) as caught:
        REFUSED[text]()
    assert isinstance(caught.value, carom.CaromError)
    assert str(caught.value).startswith(text)


def test_a_rate_that_is_an_array_is_refused_in_words():
    with pytest.raises(carom.RenderError, match="expected 8000 to 192000 Hz"):
        carom.Scene(rate=np.zeros(3))


def test_errors_of_the_call_itself_stay_as_they_are():
    @explain_arguments
    def adds(number, other=0):
        return number + other

    assert adds(2, other=3) == 5
    with pytest.raises(TypeError, match="can only concatenate"):
        adds("a", None)


def test_calls_keep_their_signatures():
    assert [*inspect.signature(carom.Scene).parameters][:2] == ["rate", "limiter"]
    assert [*inspect.signature(carom.fit).parameters][:3] == ["recordings", "out", "name"]
    assert [*inspect.signature(carom.Touch).parameters][:2] == ["a", "b"]
