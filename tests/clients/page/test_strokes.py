"""Loudness of the page's strokes beside a blow: a drag at a hand's speed, as the page sends it, rendered."""

import pytest

from carom.dsp.runtime.loudness import heard
from carom.presets import Presets
from carom.server.osc.score import parse
from tests.clients.page.conftest import Table
from tests.support import render_lines

pytestmark = pytest.mark.slow

FARTHEST = 14.0  # LU from a strike
FARTHER = {"wine-glass": 20.0, "drinks-can": 20.0}
"""The same of a glass, which takes longer than the drag to sing, and a can, whose air a nail hardly moves."""
HAND = 600.0  # px/s
RATE = 48_000
OWN = ("aluminium-pipe", "singing-bowl", "cymbal", "cello-string", "wine-glass", "tuning-fork")
BOWED = ("vibraphone-bar",)  # which the page does not bow
DRAWN_FROM = 0.8  # s


DRAWN = """([name, pixels]) => Promise.all([import("/page/strokes.js"), import("/page/bodies.js")]).then(([s, b]) => {
  const { scene, hands, table, link } = carom, preset = scene.presets.get(name), sent = [];
  const object = { name, preset, material: preset.material, body: b.bodyOf(preset) };
  const { send } = link;
  table.spread();
  link.send = (...message) => sent.push(message);
  const speed = s.speedOf(hands.stroke(object), pixels * table.metresPerPixel(object), pixels);
  hands.draw(object, 0.1, Math.min(5, speed));
  link.send = send;
  return { message: sent[0].map(String), share: pixels / (object.body.w * table.scale) };
})"""


def drawn(table: Table, name: str) -> str:
    """Return the score of a drag to and fro over an object for 0.6 s, at a hand's speed."""
    told = table.page.evaluate(DRAWN, [name, HAND])
    id = told["message"][told["message"].index("id") + 1]
    lines = [f"{DRAWN_FROM} " + " ".join(told["message"])]
    for n in range(1, 36):
        there = 0.1 + told["share"] * n / 60
        place = abs((there - 0.1) % 1.6 - 0.8)  # between 0.1 and 0.9
        lines.append(f"{DRAWN_FROM + n / 60} /gesture/{id}/position {0.9 - place}")
    return "\n".join([*lines, f"{DRAWN_FROM + 0.6} /gesture/{id}/stop", f"{DRAWN_FROM + 0.7} /panic"])


def louder(name: str, drag: str) -> float:
    """Return how much louder (LU) a drag over an object, as a score, is than its strike."""
    preset = Presets().object(name)
    made = f"0 /object/new {name} {name}\n0 /limiter off"
    blow = f"0.1 /object/{name}/impact {preset.velocity} {preset.position}\n{DRAWN_FROM - 0.1} /panic"
    sound = render_lines(parse(f"{made}\n{blow}\n{drag}\n".encode(), "score"))
    half = round(DRAWN_FROM * RATE)
    return heard(sound[half:], RATE).loudness - heard(sound[:half], RATE).loudness


def names() -> list[str]:
    """Return the objects whose stroke the page chooses, and some that roll or slide as their presets say."""
    chosen = [
        name for name in Presets().names("objects") if not {"roll", "slide"} & set(Presets().object(name).gestures)
    ]
    return [*OWN, *BOWED, *chosen]


def test_a_drag_at_a_hands_speed_is_about_as_loud_as_a_strike(play):
    table = play()
    drags = {name: drawn(table, name) for name in names()}
    table.page.close()  # it would go on drawing while they are rendered
    apart = {name: round(louder(name, drag), 1) for name, drag in drags.items()}
    assert {name: each for name, each in apart.items() if abs(each) > FARTHER.get(name, FARTHEST)} == {}
