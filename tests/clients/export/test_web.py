"""A scene in Debian's Chromium, from plain files on a plain server: a render's bits, and the commands of a session.

Its engine is that of `tiny.py`: Carom's own, which takes two minutes to compile, plays in `tests.bench.web`.
"""

import hashlib
import json
import lzma
import math
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.clients.export.pages import RENDER, served

playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")

CHROMIUM = shutil.which("chromium")

pytestmark = [pytest.mark.slow, pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")]

TABLES = 36.0
"""MB of the tables of pulses: of one contact law, and of drops."""

ASK = """async (asked) => {
  const { Carom } = await import("./carom.js");
  const { module, map, data, worklet } = await Carom.fetch();
  Object.assign(globalThis, { AudioWorkletProcessor: class {}, registerProcessor() {} });
  const { Scene } = await import(worklet);
  const scene = new Scene(module, map, data);
  scene.load(true);
  const found = [];
  const send = scene.send;
  for (const { message: [address, ...args], commands } of asked) {
    const sent = [];
    scene.send = (bytes) => sent.push(new DataView(bytes.buffer));
    try {
      scene.messages.perform(address, args);
    } catch (error) {
      found.push(`${address}: ${error.message}`);
      continue;
    }
    found.push(sent.map((view, n) => Object.fromEntries(Object.keys(commands[n] ?? {}).map((name) => {
      const [place, whole] = map.command.fields[name];
      return [name, whole ? Number(view.getBigInt64(place, true)) : view.getFloat64(place, true)];
    }))));
  }
  return found;
}"""


FETCHED = """async (changed) => {
  const { Carom } = await import("./carom.js");
  const store = await caches.open("carom");
  let kept;
  do kept = await store.keys();
  while (kept.length < 3);
  for (const file of kept) {
    const { headers } = await store.match(file);
    if (changed) headers.set("Made-Of", "another file");
    await store.put(file, new Response(new Uint8Array(64), { headers }));
  }
  return Carom.fetch().then(() => true, () => false);
}"""
"""A script that damages what a browser keeps, and fetches a page's files; changed: they have been."""


@pytest.fixture(scope="module")
def page(folder: Path) -> Iterator[Any]:
    """The page of the scene, from a server of static files."""
    with served(folder) as address, playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        opened = browser.new_page()
        errors: list[str] = []
        opened.on("pageerror", lambda error: errors.append(str(error)))
        opened.goto(f"{address}index.html")
        opened.wait_for_selector("main button")
        yield opened
        browser.close()
    assert not errors


def test_a_worklet_makes_the_bits_of_a_render(page: Any, folder: Path) -> None:
    """A score of all gestures sounds in a page without special headers as the engine of its sizes renders it."""
    sound = (folder / "sound.f32").read_bytes()
    assert len(sound) > 8 * 48_000 and any(sound)
    made = page.evaluate(RENDER)
    assert made["digest"] == hashlib.sha256(sound).hexdigest()
    assert not made["isolated"] and made["megabytes"] < 64.0 + TABLES


def test_files_are_unpacked_by_others_too(folder: Path) -> None:
    """The engine and the scene are .lzma files as any program reads them, and say how large they are."""
    for name, begins in (("carom.wasm", b"\0asm"), ("scene.carom", b"carom 1\n"), ("worklet.js", b"// Messages")):
        content = (folder / f"{name}.lzma").read_bytes()
        plain = lzma.decompress(content, lzma.FORMAT_ALONE)
        assert plain.startswith(begins) and len(plain) == int.from_bytes(content[5:13], "little")


def test_a_browser_keeps_decoded_files_until_they_change(page: Any) -> None:
    """A second visit takes what the first one has decoded, but not of other files of the same names."""
    assert not page.evaluate(FETCHED, False)
    assert page.evaluate(FETCHED, True)


def test_messages_become_the_commands_of_a_session(page: Any, folder: Path) -> None:
    """The page's messages reach its engine with the values that a session gives them."""
    asked = json.loads((folder / "asked.json").read_text())
    found = page.evaluate(ASK, asked)
    wrong = []
    for each, commands in zip(asked, found, strict=True):
        if isinstance(commands, str):  # it is refused
            wrong += [(each["message"], commands)] if each["commands"] else []
            continue
        if len(commands) != len(each["commands"]):
            wrong.append((each["message"], commands))
            continue
        for wanted, got in zip(each["commands"], commands, strict=True):
            differ = {k: (v, got.get(k)) for k, v in wanted.items() if not math.isclose(v, got[k], rel_tol=1e-12)}
            wrong += [(each["message"], differ)] if differ else []
    assert not wrong, f"{len(wrong)} of {len(asked)}: {wrong[:5]}"


def test_a_finger_on_the_page_is_heard(page: Any) -> None:
    """A page strikes an object that is clicked, in a context that sounds, and says nothing against it."""
    page.click("main button >> nth=1")
    page.keyboard.press("1")
    page.wait_for_function("document.querySelector('main button[aria-pressed=true]')")
    page.wait_for_timeout(300)
    assert page.inner_text("output") == ""
