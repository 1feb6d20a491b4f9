"""Loudness of the page's strokes beside a blow: a drag at a hand's speed, as the page sends it, rendered."""

import warnings

import numpy as np
import pyloudnorm
import pytest

from carom.presets import Presets
from carom.server.osc.score import parse
from tests.clients.page.conftest import Table
from tests.support import render_lines

pytestmark = pytest.mark.slow

FARTHEST = 14.0  # LU from a strike
HAND = 600.0  # px/s


def loudness(text: str) -> float:
    """Return the greatest momentary loudness (LUFS) of a score."""
    sound = np.pad(render_lines(parse(text.encode(), "score")).astype(float), ((0, 19_200), (0, 0)))
    meter = pyloudnorm.Meter(48_000, block_size=0.4)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # blocks of silence have a loudness of -inf
        meter.integrated_loudness(sound)
    return max(map(float, meter.blockwise_loudness))


DRAWN = """([name, pixels]) => import("/page/strokes.js").then(({ speedOf }) => {
  const { scene, hands, table, link } = carom, object = scene.objects.get(name), sent = [];
  const { send } = link;
  link.send = (...message) => sent.push(message);
  const speed = speedOf(hands.stroke(object), pixels * table.metresPerPixel(object), pixels);
  hands.draw(object, 0.1, Math.min(5, speed));
  link.send = send;
  return { message: sent[0].map(String), share: pixels / (object.body.w * table.scale) };
})"""


def drawn(table: Table, name: str) -> str:
    """Return the score of a drag to and fro over an object for 0.6 s, at a hand's speed."""
    told = table.page.evaluate(DRAWN, [name, HAND])
    id = told["message"][told["message"].index("id") + 1]
    lines = ["0.1 " + " ".join(told["message"])]
    for n in range(1, 36):
        there = 0.1 + told["share"] * n / 60
        place = abs((there - 0.1) % 1.6 - 0.8)  # between 0.1 and 0.9
        lines.append(f"{0.1 + n / 60} /gesture/{id}/position {0.9 - place}")
    return "\n".join([*lines, f"0.7 /gesture/{id}/stop", "1.0 /panic"])


def test_a_drag_at_a_hands_speed_is_about_as_loud_as_a_strike(play):
    table = play()
    apart = {}
    for name in ("bass-string", "tom", "marimba-bar", "tubular-bell"):
        if not table.ask(f"carom.scene.objects.has('{name}')"):
            table.ask(f"carom.scene.add('{name}')")
            table.settle(f"carom.scene.objects.get('{name}')?.modes")
        preset = Presets().object(name)
        blow = f"0.1 /object/{name}/impact {preset.velocity} {preset.position}\n1.5 /panic"
        stroke, struck = (loudness(f"0 /object/new {name} {name}\n{text}\n") for text in (drawn(table, name), blow))
        apart[name] = round(stroke - struck, 1)
    assert {name: each for name, each in apart.items() if abs(each) > FARTHEST} == {}
