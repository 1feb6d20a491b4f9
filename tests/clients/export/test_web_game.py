"""Contacts of a game in a page, in Debian's Chromium: it finds what a World finds; objects are made and freed."""

import math
from pathlib import Path
from typing import Any

import pytest

from tests import needs
from tests.clients.export.pages import served
from tests.server.bridge.test_touching import FRAME, frames, simulation

playwright = needs.module("playwright.sync_api")

pytestmark = [pytest.mark.slow, needs.without("chromium")]

PLAY = """async ([frames, seconds]) => {
  const { Carom } = await import("./carom.js");
  const carom = await Carom.open(new AudioContext({ sampleRate: 48000 }));
  const why = (sent) => sent.then(() => "", (error) => error.message);
  carom.listen([0, 0, 1.5], [1, 0, 0]);
  for (const { moves, touches } of frames) {
    for (const move of moves) carom.move(...move);
    for (const [a, b, point, normal, told] of touches) carom.touch(a, b, point, normal, told);
    await carom.frame(seconds);
  }
  const { contacts, refused } = await carom.report();
  const told = [];
  told.push(await why(carom.frame(0)));
  carom.touch("ball", "nobody", [0, 0, 0], [0, 0, 1]);
  told.push(await why(carom.frame(0.01)));
  carom.touch("ball", "floor", [0, 0, 0], [0, 0, 2]);
  told.push(await why(carom.frame(0.01)));
  told.push(await why(carom.send("/object/new", "ball", "ball")));
  told.push(await why(carom.send("/object/new", "a", "ball", "material", "cheese")));
  const made = [];
  for (let n = 0; n < 600; n++) {
    const name = `ball.${n % 20}`;
    if (n >= 20) made.push(await why(carom.send(`/object/${name}/free`, 1)));
    const like = ["ball", "size", 0.5 + (n % 7) / 7, "material", n % 2 ? "glass" : "steel", "pan", -1];
    made.push(await why(carom.send("/object/new", name, ...like)));
    carom.move(name, [0, 0, 1]);
    if (n % 50 === 0) made.push(await why(carom.frame(0.01)));
    if (n % 20 === 19) await new Promise((done) => setTimeout(done, 30));
  }
  const { contacts: { bodies } } = await carom.report();
  await carom.context.close();
  return { contacts, refused, told, made: made.filter(Boolean), bodies };
}"""
"""A script that plays frames: the report, what of some wrong ones is refused, and what of objects that come and go."""


def _told(touch: Any) -> dict[str, float]:
    known = {"impulse": touch.impulse, "speed": touch.approach, "slip": touch.slip}
    return {name: value for name, value in known.items() if not math.isnan(value)}


def test_frames_are_heard_as_a_world_hears_them(game: Path) -> None:
    wanted, time, sent = simulation(), 0.0, []
    for touches, poses in frames(2.0):
        time += FRAME
        wanted.step(time, touches, poses)
        sent.append(
            {
                "moves": [(name, *pose) for name, pose in poses.items()],
                "touches": [(each.a, each.b, each.point, each.normal, _told(each)) for each in touches],
            }
        )
    with served(game) as address, playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=needs.program("chromium"), args=["--no-sandbox"])
        page = browser.new_page()
        page.goto(f"{address}index.html")
        found = page.evaluate(PLAY, [sent, FRAME])
        browser.close()
    contacts, counts = found["contacts"], wanted.counts
    assert (contacts["blows"], contacts["slides"], contacts["faint"]) == (counts.hits, counts.gestures, counts.faint)
    assert contacts["blows"] >= 3 and contacts["slides"] == 2 and contacts["bodies"] == 4
    assert (found["refused"], found["made"], found["bodies"]) == (0, [], 24)
    said = "seconds = 0", "nobody: no such body", "touch ball, floor", "ball: there is", "cheese: no such"
    for told, words in zip(found["told"], said, strict=True):
        assert words in told
