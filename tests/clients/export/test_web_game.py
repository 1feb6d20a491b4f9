"""Contacts of a game in a page, in Debian's Chromium: it finds what a World finds; objects are made and freed."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests import needs
from tests.clients.export.pages import served
from tests.clients.export.tiny import HEAVY
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
  told.push(await why(carom.send("/object/new", "ground", "ball")));
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


LOST = """async (masses) => {
  const { Carom } = await import("./carom.js");
  const context = new AudioContext({ sampleRate: 48000 });
  const carom = await Carom.open(context);
  const warnings = [];
  const two = new Promise((done) => {
    carom.addEventListener("warning", ({ detail }) => warnings.push(detail) === 2 && done());
  });
  for (const mass of masses) await carom.send("/object/bell/impact", 1, "mass", mass, "stiffness", 1e6);
  await Promise.race([two, new Promise((done) => setTimeout(done, 5000))]);
  const report = await carom.report();
  await context.close();
  return [report, warnings];
}"""
"""A script that strikes with strikers of some masses: the report, and the warnings."""


@pytest.fixture(scope="module")
def page(game: Path) -> Iterator[Any]:
    """The page of the game."""
    with served(game) as address, playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=needs.program("chromium"), args=["--no-sandbox"])
        opened = browser.new_page()
        opened.goto(f"{address}index.html")
        yield opened
        browser.close()


def _told(touch: Any) -> dict[str, float]:
    known = {"impulse": touch.impulse, "speed": touch.approach, "slip": touch.slip}
    return {name: value for name, value in known.items() if not math.isnan(value)}


def test_frames_are_heard_as_a_world_hears_them(page: Any) -> None:
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
    found = page.evaluate(PLAY, [sent, FRAME])
    contacts, counts = found["contacts"], wanted.counts
    assert (contacts["blows"], contacts["slides"], contacts["faint"]) == (counts.hits, counts.gestures, counts.faint)
    assert contacts["blows"] >= 3 and contacts["slides"] == 2 and contacts["bodies"] == 4
    assert (found["refused"], found["made"], found["bodies"]) == (0, [], 24)
    said = (
        "seconds = 0",
        "nobody: no such body",
        "touch ball, floor",
        "ball: there is",
        "ground: there is a silent",
        "cheese",
    )
    for told, words in zip(found["told"], said, strict=True):
        assert words in told


def test_what_found_no_room_is_reported(page: Any) -> None:
    """A contact that found no room is a warning, and the report counts it."""
    report, warnings = page.evaluate(LOST, [1.0, HEAVY])
    assert (report["dropped"], report["linear"], report["refused"]) == (1, 1, 0)
    assert math.isclose(report["loudest"], 10.0 * math.log10(0.5) - 0.691) and 0.0 <= report["load"] < 1.0
    assert warnings == [
        "left out 1 contact, of at most -4 LUFS: play fewer at once",
        "1 blow did not make a plate swell: too many plates swell at once",
    ]
