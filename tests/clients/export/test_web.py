"""A scene in Debian's Chromium, from plain files on a plain server: a render's bits, and the commands of a session.

Its engine is that of `tiny.py`: Carom's own, which takes two minutes to compile, plays in `tests.bench.web`.
"""

import hashlib
import json
import lzma
import math
import re
import shutil
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler
from pathlib import Path
from typing import Any

import pytest

from carom.clients.export.packing import compressed
from carom.clients.export.parting import parted
from carom.clients.export.scene_file import summed
from carom.dsp.native.wasm_object import CODE, as_leb
from tests import needs
from tests.clients.export.pages import RENDER, served

playwright = needs.module("playwright.sync_api")

pytestmark = [pytest.mark.slow, needs.without("chromium")]

TABLES = 36.0
"""MB of the tables of pulses: of one contact law, and of drops."""

OPENED = """async (asked) => {
  const { Carom } = await import("./carom.js");
  const { module, map, data, worklet } = await Carom.fetch();
  Object.assign(globalThis, { AudioWorkletProcessor: class {}, registerProcessor() {} });
  const { Scene } = await import(worklet);
  const scene = new Scene(module, map, data);
  scene.load(true);
"""
"""The beginning of a script that makes the scene of a page, without its sound."""

ASK = (
    OPENED
    + """  const found = [];
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
)

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

JOINED = """async (parts) => {
  const { joined } = await import("./wasm.js");
  return [...joined(new Uint8Array(parts))];
}"""
"""A script that joins a module's parts."""

WRONG = (
    OPENED
    + """  const bell = "/object/church_bell";
  const said = [[undefined], [5], ["constructor"], ["/object/constructor/damp", 1], [`${bell}/impact`, NaN],
    [`${bell}/impact`, 1, 0.5, "__proto__", "x"], [`${bell}/impact`, 1, 0.5, "striker", "constructor"],
    [`${bell}/impact`, 1, 0.5, "by", "toString"], [`${bell}/slide`, 1, 0.5, "surface", "valueOf"],
    ["/gain", []], ["/gain", [-3], "over", []], ["/gain", -3, "over"], ["/gain", -3, 5],
    ["/gain", -3, "over", 1, "over", 2], ["/gain", Array(65).fill(-3), "over", 1]];
  const told = said.map(([address, ...args]) => {
    const before = scene.whole(map.state.written);
    try {
      scene.messages.perform(address, args);
    } catch (error) {
      return scene.whole(map.state.written) === before ? error.message : `${error.message}, and is sent`;
    }
    return `${[address, ...args]}: is taken`;
  });
  const context = new AudioContext({ sampleRate: map.rate });
  const carom = await Carom.open(context, { files: { module, map, data, worklet } });
  const sent = [carom.send(), carom.send(`${bell}/impact`, () => 1)];
  sent.push(...[NaN, "x"].map((time) => carom.at(time).send("/panic")));
  const late = new Promise((done) => setTimeout(() => done("no answer"), 5000));
  const all = sent.map((each) => Promise.race([each.then(() => "is taken", (error) => error.message), late]));
  told.push(...(await Promise.all(all)));
  await context.close();
  return told;
}"""
)
"""A script that says what is wrong, to a scene and to a page's engine: the answers, in turn."""

ENDED = """async () => {
  const { Carom } = await import("./carom.js");
  const answered = (carom) => carom.send("/panic").then(() => "is taken", (error) => error.message);
  const late = () => new Promise((done) => setTimeout(() => done("no answer"), 5000));
  const told = [];
  for (const how of ["close", "stop"]) {
    const context = new AudioContext({ sampleRate: 48000 });
    const carom = await Carom.open(context);
    await carom.ready;
    if (how === "close") await context.close();
    const waits = how === "stop" && carom.send("/panic");
    if (how === "stop") {
      carom.hear = () => {}; // no answer comes
      carom.node.onprocessorerror();
      told.push(await Promise.race([waits.then(() => "is taken", (error) => error.message), late()]));
    }
    told.push(await Promise.race([answered(carom), late()]));
    if (how === "stop") await context.close();
  }
  return told;
}"""
"""A script that sends to an engine in a context that is closed, and to one that has stopped: the answers, in turn."""

CHANGED = """async ([count, mended]) => {
  const { unpacked: plain } = await import("./lzma.js");
  const { unpacked, rulesOf } = await import("./file.js");
  const { joined } = await import("./wasm.js");
  const { sumOf } = await import("./sum.js");
  const { Carom } = await import("./carom.js");
  const { worklet } = await Carom.fetch();
  Object.assign(globalThis, { AudioWorkletProcessor: class {}, registerProcessor() {} });
  const { Scene } = await import(worklet);
  const read = async (name) => new Uint8Array(await (await fetch(name)).arrayBuffer());
  const module = await WebAssembly.compile(joined(plain(await read("carom.wasm.lzma"))));
  const whole = plain(await read("scene.carom.lzma"));
  let state = 84;
  const drawn = (below) => Math.floor(((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32) * below);
  const length = new DataView(whole.buffer).getUint32(40, true);
  const told = {};
  for (let n = 0; n < count; n++) {
    let bytes = whole.slice();
    const at = n % 2 ? 48 + drawn(length) : drawn(bytes.length);
    if (n % 5 < 3) bytes[at] ^= 1 << drawn(8);
    else if (n % 5 < 4) bytes.fill(drawn(256), at, at + 8);
    else bytes = bytes.slice(0, 1 + drawn(bytes.length));
    if (mended && bytes.length > 48) {
      const rest = new Uint8Array([...bytes.subarray(0, 8), ...bytes.subarray(40)]);
      sumOf(rest).match(/../g).forEach((each, k) => (bytes[8 + k] = parseInt(each, 16)));
    }
    const begun = performance.now();
    let said = "finite";
    try {
      const { map, data } = unpacked(bytes.buffer, rulesOf(module));
      const scene = new Scene(module, map, data);
      scene.load(n % 3 > 0);
      for (let left = 4096; left > 0; ) {
        const now = scene.compute(left);
        if (!scene.sound.subarray(0, now * map.channels).every(Number.isFinite)) said = "not finite";
        left -= now;
      }
    } catch (error) {
      said = error instanceof WebAssembly.RuntimeError ? `trap: ${error.message}` : mended ? "refused" : error.message;
    }
    told[said] = Math.max(told[said] ?? 0, performance.now() - begun);
  }
  return told;
}"""
"""A script that opens and plays changed scenes: the longest time in ms for each thing that came of it."""

OPEN = """async (engine) => {
  const { Carom } = await import("./carom.js");
  const files = await Carom.fetch();
  const context = new OfflineAudioContext(files.map.channels, 128, files.map.rate);
  const map = { ...files.map, engine };
  return Carom.open(context, { files: { ...files, map } }).then(() => "is opened", (error) => error.message);
}"""
"""A script that opens a scene whose file names an engine: the answer."""

FULL = (
    OPENED
    + """  const count = (message) => {
    for (let n = 0; ; n++) {
      try {
        scene.messages.perform(...message);
      } catch {
        return n;
      }
    }
  };
  scene.messages.perform("/panic", []);
  const left = map.state.ring - scene.whole(map.state.written) + scene.whole(map.state.read);
  const taken = [left, count(["/gain", [Array(64).fill(-3), "over", 1]]), count(["/panic", []])];
  scene.push(map.batches[0][2]);
  return [...taken, scene.refused];
}"""
)
"""A script that fills the engine's ring: the room there was, the lists of 64 that it took, the commands after them, and
those of the score that found no room then."""

HEAR = """() => {
  const post = MessagePort.prototype.postMessage;
  window.said = [];
  MessagePort.prototype.postMessage = function (message, ...more) {
    if (message.address) window.said.push([message.address, ...message.args]);
    return post.call(this, message, ...more);
  };
}"""
"""A script that keeps what a page says to its engine, in `said`."""


@pytest.fixture(scope="module")
def page(folder: Path) -> Iterator[Any]:
    """The page of the scene, from a server of static files."""
    with served(folder) as address, playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=needs.program("chromium"), args=["--no-sandbox"])
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
    """The scene and the script are .lzma files as any program reads them, and say how large they are; so is the
    engine's, in parts."""
    for name, begins in (("carom.wasm", b""), ("scene.carom", b"carom 2\n"), ("worklet.js", b"// Messages")):
        content = (folder / f"{name}.lzma").read_bytes()
        plain = lzma.decompress(content, lzma.FORMAT_ALONE)
        assert plain.startswith(begins) and len(plain) == int.from_bytes(content[5:13], "little")


def test_a_module_is_joined_to_the_byte(page: Any) -> None:
    """A module that was parted is as before once `wasm.js` has joined it: operands of all kinds, long numbers."""
    code = bytes.fromhex(
        "2001 2081 01 2101 2280 01 2001"  # locals, some by two bytes
        "41ff818080 00 428180808080808080 01 43 01020304 44 0102030405060708"
        "02 40 0c00 0d8001 0e02 000102 10 85808080 00 2300 28 0280 01 3f00 6a"
        "fc02 fc0a 0000 fc0b 00 fd0c 000102030405060708090a0b0c0d0e0f fd0d 0f0e0d0c0b0a09080706050403020100"
        "fd00 0480 08 fd15 07 fd5b 03 10 01 fd5d 03 8001 fdf0 01 0b"
    )
    function = b"\x01\xff\x01\x7c" + code  # 255 locals of float64
    bodies = b"\x02" + 2 * (as_leb(len(function)) + function)
    sections = b"\x01\x02\x01\x60", bytes([CODE]) + as_leb(len(bodies)) + bodies, b"\x0b\x01\x00"
    module = b"\0asm\1\0\0\0" + b"".join(sections)
    joined = page.evaluate(JOINED, list(parted(module)))
    assert bytes(joined) == module


def test_a_module_of_unknown_instructions_is_refused() -> None:
    """An instruction whose operands are unknown is named."""
    module = b"\0asm\1\0\0\0" + bytes([CODE, 5, 1, 3, 0, 0xD3, 0x0B])
    with pytest.raises(TypeError, match="0xd3"):
        parted(module)


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


def test_wrong_calls_from_javascript_are_refused_with_their_reason(page: Any) -> None:
    """No value of JavaScript becomes a command that it is not, and none is left without an answer."""
    culprits = ["undefined", "5", "constructor", "constructor", "velocity = NaN", "__proto__", "striker = constructor",
                "by = toString", "surface = valueOf", "gain", "over", "over", "5: no such key", "over = 2: given twice",
                "65 values", "undefined", "1", "NaN", "NaN"]  # fmt: skip
    told = page.evaluate(WRONG)
    assert len(told) == len(culprits)
    for text, culprit in zip(told, culprits, strict=True):
        assert culprit in text and not text.endswith(("is taken", "is sent", "no answer")), (culprit, text)
        assert not any(word in text for word in ("Cannot", "not iterable", "is not a function")), text


def test_an_engine_that_has_ended_answers(page: Any) -> None:
    """No message is left without an answer where the context is closed, or the engine has stopped."""
    closed, *stopped = page.evaluate(ENDED)
    assert closed == "the context is closed; expected one that plays"
    assert stopped == ["the engine has stopped", "the engine has stopped"]


def test_a_scene_of_another_engine_is_refused(page: Any, folder: Path, tmp_path: Path) -> None:
    """The page says so, and so does its module: its words would be written to wrong places of the engine's memory."""
    said = "the scene is of another engine; expected carom.wasm.lzma and scene.carom.lzma of one export"
    assert [page.evaluate(OPEN, engine) for engine in ("another", None)] == [said, said]
    other = shutil.copytree(folder, tmp_path / "other")
    scene = lzma.decompress((folder / "scene.carom.lzma").read_bytes())
    changed = re.sub(rb'"engine":"[0-9a-f]{20}"', b'"engine":"' + 20 * b"0" + b'"', scene)
    assert len(changed) == len(scene) and changed != scene
    (other / "scene.carom.lzma").write_bytes(compressed(summed(changed), words=True))
    with served(other) as address:
        opened = page.context.browser.new_page()
        opened.goto(f"{address}index.html")
        opened.wait_for_function("said => document.querySelector('output').textContent === said", arg=said)
        opened.close()


def test_a_damaged_scene_is_refused_and_a_wrong_one_plays_finite_sound_at_most(page: Any) -> None:
    """A changed bit, eight bytes or an end: a sentence; with a mended checksum that, or finite sound. No trap."""
    told = page.evaluate(CHANGED, [300, False])
    assert all(text.startswith(("the scene is damaged", "expected a scene")) for text in told), told
    assert {*page.evaluate(CHANGED, [30, True])} == {"refused", "finite"}


def test_a_list_is_taken_whole_or_not_at_all(page: Any) -> None:
    """No point of a list is sent where there is no room for all of them; what the score has no room for is counted."""
    left, lists, after, refused = page.evaluate(FULL)
    assert left % 64 and lists == left // 64 and after == left % 64 and refused == 1


def test_a_finger_on_the_page_is_heard(page: Any) -> None:
    """A page strikes an object that is clicked, in a context that sounds, and says nothing against it."""
    page.evaluate("document.querySelector('output').textContent = ''")  # of a test before it, on the same page
    page.click("main button >> nth=1")
    page.keyboard.press("1")
    page.wait_for_function("document.querySelector('main button[aria-pressed=true]')")
    page.wait_for_timeout(300)
    assert page.inner_text("output") == ""


def test_fingers_on_one_object_do_not_know_of_each_other(page: Any) -> None:
    """A finger that rested and goes stops its own press, whatever another one on the same object does."""
    page.evaluate(HEAR)
    box = page.locator("main button >> nth=0").bounding_box()
    first, second = (
        {"x": box["x"] + share * box["width"], "y": box["y"] + 9, "id": n} for n, share in ((1, 0.3), (2, 0.7))
    )
    finger = page.context.new_cdp_session(page)

    def touch(kind: str, *points: dict[str, float]) -> None:
        finger.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [*points]})

    touch("touchStart", first)
    page.wait_for_function("said.some(([address]) => address.endsWith('/press'))")
    touch("touchStart", first, second)
    touch("touchEnd", first)
    touch("touchEnd")
    page.wait_for_timeout(100)
    said = page.evaluate("said")
    (press,) = (args for address, *args in said if address.endswith("/press"))
    assert [address for address, *_ in said if address.endswith("/stop")] == [f"/gesture/{press[-1]}/stop"]


def test_enter_strikes_what_is_focused(page: Any) -> None:
    """Whoever has no pointer strikes an object by its button."""
    page.evaluate(HEAR)
    page.focus("main button >> nth=2")
    page.keyboard.press("Enter")
    page.wait_for_function("said.some(([address]) => address.endsWith('/impact'))")


class _Plain(SimpleHTTPRequestHandler):
    """A server that knows no scripts."""

    def guess_type(self, path: Any) -> str:
        """Return the type of a file."""
        return "text/plain" if str(path).endswith(".js") else super().guess_type(path)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing."""


NO_STORE = "Object.defineProperty(window, 'caches', { get() { throw new DOMException('none', 'SecurityError'); } })"


def test_a_page_says_why_it_cannot_play_wherever_it_is_opened(page: Any, folder: Path) -> None:
    """As a file, from a server that sends no scripts, over http, and where the browser lacks a part."""
    with served(folder) as address, served(folder, _Plain) as plain:
        elsewhere = address.replace("127.0.0.1", "phone.test")
        words = ["--no-sandbox", "--host-resolver-rules=MAP phone.test 127.0.0.1"]
        kind = page.context.browser.browser_type
        browser = kind.launch(executable_path=needs.program("chromium"), args=words)
        for opened, lacks, said in (
            (folder.as_uri() + "/", "", "opened as a file can't play: serve its folder"),
            (plain, "", "expected a server that sends .js files as text/javascript"),
            (elsewhere, "", f"over https, or from localhost: expected https in place of {elsewhere[:-1]}"),
            (address, "delete window.AudioWorkletNode", "This browser has no AudioWorkletNode"),
            (address, "delete window.WebAssembly", "This browser has no WebAssembly"),
        ):
            tried = browser.new_page()
            tried.add_init_script(lacks)
            tried.goto(f"{opened}index.html")
            tried.wait_for_function("said => document.querySelector('output').textContent.includes(said)", arg=said)
            tried.close()
        tried = browser.new_page()
        tried.add_init_script(NO_STORE)
        tried.goto(f"{address}index.html")
        tried.click("main button >> nth=0")
        tried.wait_for_timeout(300)
        assert tried.inner_text("output") == ""
        browser.close()


KEYBOARD = """async (events) => {
  const { Keyboard } = await import("./keyboard.js");
  const said = [];
  const keyboard = new Keyboard((...message) => said.push(message));
  for (const event of events) keyboard.hear("bell", event);
  return said;
}"""
"""A script that plays MIDI on a keyboard of its own, for the messages."""

NOTE, COPY = ["/object/bell/note", 60, 90], "/object/bell.60"


@pytest.mark.parametrize(
    ("events", "said"),
    [
        ([(0x90, 60, 90), (0x80, 60, 0)], [NOTE]),
        ([(0x90, 60, 90), (0xB0, 64, 127), (0x80, 60, 0), (0xB0, 64, 0)], [NOTE, [f"{COPY}/damp", 1]]),
        ([(0xB0, 64, 0), (0x90, 60, 90), (0x90, 60, 0), (0x90, 60, 90)],
         [NOTE, [f"{COPY}/damp", 1], [f"{COPY}/damp", 0], NOTE]),
        ([(0x90, 60, 90), (0xE0, 0, 96)], [NOTE, [f"{COPY}/tune", 1]]),
        ([(0xE1, 0, 64), (0x91, 60, 90), (0xE1, 0, 96), (0xE0, 0, 0)],
         [NOTE, [f"{COPY}/tune", 24], [f"{COPY}/tune", 22]]),
        ([(0xB0, 101, 0), (0xB0, 100, 6), (0xB0, 6, 15), (0xB3, 101, 0), (0xB3, 100, 0), (0xB3, 6, 12), (0x91, 60, 90),
          (0xE1, 0, 96)], [NOTE, [f"{COPY}/tune", 6]]),
        ([(0x91, 60, 90), (0xD1, 127)], [NOTE, [f"{COPY}/damp", 1]]),
    ],
)  # fmt: skip
def test_a_keyboard_plays_as_its_players_expect(page: Any, events: list[tuple[int, ...]], said: list[Any]) -> None:
    """Its pedal brings dampers, as the server's; MPE bends far, whether it says so or not."""
    assert page.evaluate(KEYBOARD, events) == said


BUTTONS = """async () => {
  const { Carom } = await import("./carom.js");
  const files = await Carom.fetch();
  const carom = await Carom.open(new OfflineAudioContext(2, 480, files.map.rate), { files });
  const tried = [["/panic", 1], ["/panic", 0], ["/panic", true], ["/gesture/none/stop", 0], ["/gesture/none/stop", 1]];
  const told = ({ message }) => message;
  return Promise.all(tried.map(([address, value]) => carom.send(address, value).then(() => "", told)));
}"""


def test_a_button_that_is_let_go_does_nothing(page: Any) -> None:
    assert page.evaluate(BUTTONS) == ["", "", "", "", "none: no such gesture is running"]


@pytest.mark.parametrize("size", [(390, 844), (844, 250)])
def test_objects_lie_side_by_side_in_any_window(page: Any, size: tuple[int, int]) -> None:
    """No object covers another one, or the window's edge, on a phone either."""
    usual = page.viewport_size
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.wait_for_timeout(50)
    boxes = [each.bounding_box() for each in page.locator("main button").all()]
    page.set_viewport_size(usual)
    assert all(box["x"] >= 0 and box["x"] + box["width"] <= size[0] for box in boxes)
    for n, box in enumerate(boxes):
        for other in boxes[:n]:
            apart = (abs(box[at] - other[at]) >= 0.999 * box[long] for at, long in (("x", "width"), ("y", "height")))
            assert any(apart), (box, other)
