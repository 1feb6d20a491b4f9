"""The page in a browser: what fingers, keys and files do, as the server's log and recording have it."""

import time
from itertools import pairwise

import numpy as np
import pytest
import soundfile

from carom.presets.library import Presets
from carom.server.osc.score import read
from carom.server.osc.wire import Message
from tests.clients.page.conftest import opened, served
from tests.support import render_lines

pytestmark = pytest.mark.slow

HOLD = 600  # ms: longer than a tap


def keys(message: Message) -> dict[str, object]:
    """Return the keys of a message, after its numbers."""
    words = list(message.args)
    first = next((n for n, each in enumerate(words) if isinstance(each, str)), len(words))
    return dict(zip(words[first::2], words[first + 1 :: 2], strict=True))


def test_the_first_click_in_the_middle_of_the_page_sounds(play):
    table = play()
    table.page.mouse.click(640, 400)
    (struck,) = table.until("/impact")
    preset = Presets().object("church-bell")
    args = preset.velocity, struck.message.args[1], "play", 1
    assert struck.message == Message("/object/church-bell/impact", args)
    # Nothing else plays: the click has let the browser be heard.
    table.settle("carom.sound.isHeard && carom.sound.state.playing")
    table.settle("Math.max(...carom.sound.latest.map(Math.abs)) > 0.002")


def test_a_tap_strikes_where_the_finger_is(play):
    table = play()
    places = (("marimba-bar", 0.2), ("marimba-bar", 0.9), ("steel-plate", 0.3), ("singing-bowl", 0.7))
    for count, (name, position) in enumerate(places, 1):
        table.page.mouse.click(*table.spot(name, position))
        struck = table.until("/impact", count)[-1].message
        assert struck.address == f"/object/{name}/impact"
        assert struck.args[1] == pytest.approx(position, abs=0.03)
        assert struck.args[0] == Presets().object(name).velocity
        table.settle(
            "document.querySelector('#force-note').textContent.includes('NAME')".replace("NAME", name.replace("-", " "))
        )
        assert "e+" not in table.ask("document.querySelector('#force-note').textContent")
    table.page.get_by_role("radio", name="rubber").click()
    table.page.mouse.click(*table.spot("marimba-bar", 0.5))
    assert keys(table.until("/impact", 5)[-1].message) == {"striker": "rubber", "play": 1}


@pytest.mark.parametrize("width", [1024, 1280, 1920])
def test_the_palette_shows_all_of_its_buttons(play, width):
    """Each preset's button that plays it lies within the palette, and so does its name, whose words are whole."""
    table = play(viewport={"width": width, "height": 800})
    table.settle("document.querySelectorAll('.preset .hear').length > 50")
    hidden = table.ask("""[...document.querySelectorAll(".preset")].flatMap((row) => {
      const [add, hear] = row.children, name = add.querySelector("span");
      const end = document.querySelector("#search").getBoundingClientRect().right;
      const text = name.firstChild, whole = [...text.data.matchAll(/\\S+/g)].every(({ 0: word, index }) => {
        const range = document.createRange();
        range.setStart(text, index);
        range.setEnd(text, index + word.length);
        return range.getClientRects().length === 1;
      });
      const inside = hear.getBoundingClientRect().right <= end + 1;
      const beside = name.getBoundingClientRect().right <= hear.getBoundingClientRect().left;
      return inside && beside && whole ? [] : [name.textContent];
    })""")
    assert hidden == []


def test_two_fingers_strike_two_objects(play):
    table = play(has_touch=True)
    touch = table.page.context.new_cdp_session(table.page)
    points = [dict(zip("xy", table.spot(name), strict=True)) for name in ("marimba-bar", "wood-board")]
    for n, point in enumerate(points):
        points[n] = {**point, "id": n}
    touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": points})
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert {line.message.address for line in table.until("/impact", 2)} == {
        "/object/marimba-bar/impact", "/object/wood-board/impact",
    }  # fmt: skip


def test_a_hold_presses_and_letting_go_ends_it(play):
    table = play()
    table.page.mouse.move(*table.spot("church-bell"))
    table.page.mouse.down()
    (press,) = table.until("/press")
    assert press.message.args[:1] == (5,) and keys(press.message)["striker"] == "hand"
    table.page.mouse.up()
    (stop,) = table.until("/stop")
    assert stop.message.address == f"/gesture/{keys(press.message)['id']}/stop"


def test_a_drag_along_rolls_at_the_pointers_speed_and_place(play):
    table = play()
    (x0, y0), (x1, y1) = table.spot("wood-board", 0.2), table.spot("wood-board", 0.8)
    table.drag_from(x0, y0)
    for n in range(4, 31):
        table.page.mouse.move(x0 + (x1 - x0) * n / 30, y0 + (y1 - y0) * n / 30)
        table.page.wait_for_timeout(16)
    metres = table.ask("carom.table.metresPerPixel(carom.scene.objects.get('wood-board'))") * np.hypot(x1 - x0, y1 - y0)
    places = [line.message.args[0] for line in table.until_last("/position", 0.8, near=0.03)]
    speeds = table.until_last("/speed", 0.01)  # it rests under the finger
    (roll,) = table.lines("/roll")
    moving = speeds[:-1]  # the last says that the pointer rests, and comes late where a machine is busy
    rolled = sum(now.message.args[0] * (later.time - now.time) for now, later in pairwise(moving))
    assert rolled == pytest.approx(25 / 30 * metres, rel=0.15), "as far as the pointer went"
    assert roll.message.args[1] == pytest.approx(0.2, abs=0.1) and places == sorted(places)
    table.page.mouse.up()
    assert len(table.until("/stop")) == 1


def test_a_pull_back_strikes_the_harder_the_further(play):
    table = play()
    x, y = table.spot("marimba-bar")
    for far, speed in ((80, 0.05 * 100 ** (80 / 260)), (200, 0.05 * 100 ** (200 / 260))):
        before = len(table.lines("/impact"))
        table.drag_from(x, y)
        for n in range(1, 6):
            table.page.mouse.move(x, y - far * n / 5)
        table.page.mouse.up()
        struck = table.until("/impact", before + 2)[-1].message
        assert struck.args[0] == pytest.approx(speed, rel=0.02) and struck.args[1] == pytest.approx(0.5, abs=0.02)
    assert len(table.lines("/stop")) == len(table.lines("/slide"))


def test_a_striker_that_is_let_fall_bounces_from_where_it_was(play):
    table = play()
    box = table.page.locator("#stage").bounding_box()
    table.page.mouse.move(box["x"] + 8, box["y"] + 8)
    table.page.mouse.down()
    table.page.mouse.move(*table.spot("steel-plate", 0.5))
    table.page.wait_for_timeout(500)
    table.page.mouse.up()
    (drop,) = table.until("/bounce")
    height, position = drop.message.args[:2]
    assert 0.03 * 40 ** (0.45 / 1.1) < height < 0.03 * 40 ** (0.8 / 1.1) and position == pytest.approx(0.5, abs=0.03)
    # The page draws the flight by the contacts that the engine tells: the ball comes back lower each time.
    table.settle("[...carom.table.marks.balls.values()].some((ball) => ball.up > 0)")


def test_objects_that_are_dragged_onto_each_other_meet(play):
    table = play()
    table.page.get_by_role("button", name="Move", exact=True).click()
    (x0, y0), (dx, dy) = (
        table.spot("wine-glass"),
        table.ask(
            "[0, 1].map((n) => ['church-bell', 'wine-glass'].map((name) => "
            "carom.table.middle(carom.scene.objects.get(name))[n]).reduce((a, b) => a - b))"
        ),
    )
    before = table.ask("[carom.scene.objects.get('wine-glass').x, carom.scene.objects.get('wine-glass').y]")
    table.page.mouse.move(x0, y0)
    table.page.mouse.down()
    for n in range(1, 21):
        table.page.mouse.move(x0 + dx * n / 20, y0 + dy * n / 20)
        table.page.wait_for_timeout(8)
    table.page.mouse.up()
    (met,) = table.until("/church-bell/impact")
    assert keys(met.message)["by"] == "wine-glass" and 0.05 <= met.message.args[0] <= 3
    assert table.ask("[carom.scene.objects.get('wine-glass').x, carom.scene.objects.get('wine-glass').y]") == before


def test_objects_are_added_heard_and_removed_and_undo_takes_it_back(play):
    table = play()
    table.page.get_by_label("Find an object").fill("triangle")
    table.page.get_by_role("button", name="Add triangle").click()
    assert table.until("/object/new", 7)[-1].message.args[:2] == ("triangle", "triangle")
    table.settle("carom.scene.selected === 'triangle'")
    table.page.get_by_role("button", name="Remove").click()
    table.until("/triangle/free")
    table.settle("!carom.scene.objects.has('triangle')")
    table.page.get_by_title("Undo (Ctrl+Z)").click()
    table.settle("carom.scene.objects.has('triangle')")
    table.page.get_by_role("button", name="Hear triangle").click()
    heard = table.until("/impact")[-1].message.address.split("/")[2]
    assert heard.startswith("try~") and table.until("/free", 2)[-1].message.address == f"/object/{heard}/free"
    assert not table.ask("[...carom.scene.objects.keys()].some((name) => name.startsWith('try'))")


def test_controls_cover_what_is_useful_and_set_what_they_say(play):
    table = play()
    for section in ("Object", "Impact"):
        table.page.locator("summary", has_text=section).click()
    slider = table.page.get_by_role("slider", name="velocity").first
    for place, speed in (("0", 0.01), ("500", (0.01 * 5.0) ** 0.5), ("1000", 5.0)):
        slider.fill(place)
        table.page.get_by_role("button", name="Strike", exact=True).click()
        struck = table.until("/impact", 1 + (place != "0") + (place == "1000"))[-1].message
        assert struck.args[0] == pytest.approx(speed, rel=1e-3)
    table.page.get_by_role("slider", name="tune").fill("750")
    assert table.until("/tune")[-1].message.args == (12.0,)
    table.page.get_by_title("Undo (Ctrl+Z)").click()
    assert table.until("/tune", 2)[-1].message.args == (0,)


DECLARED = """
const fetched = window.fetch;
window.fetch = async (url, ...rest) => {
  const response = await fetched(url, ...rest);
  if (url !== "/page/catalogue.json") return response;
  const catalogue = await response.json();
  const argument = { ...catalogue.gestures.press.argument, name: "load", low: 1, high: 100 };
  catalogue.gestures.lean = { ...catalogue.gestures.press, argument };
  return new Response(JSON.stringify(catalogue));
};
window.sent = [];
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (data) {
  if (typeof data !== "string") window.sent.push(new TextDecoder("latin1").decode(data));
  return send.call(this, data);
};"""


def test_a_gesture_that_the_server_declares_is_played_and_steered_by_its_argument(play):
    table = play(DECLARED)
    table.page.locator("summary", has_text="Lean").click()
    table.page.get_by_role("slider", name="load").fill("1000")
    table.page.get_by_role("button", name="Lean", exact=True).click()
    table.settle("sent.some((each) => /^.gesture.lean-.*stop/.test(each))")
    (begun,) = table.ask("sent.filter((each) => /^.object.church-bell.lean/.test(each))")
    assert "\0\0\0d" in begun and "load" not in begun  # 100 N
    table.page.get_by_text("unknown action 'lean'").first.wait_for()


def test_everything_can_be_played_from_the_keyboard(play):
    table = play()
    press = table.page.keyboard.press
    press("2")
    assert table.until("/impact")[0].message.address == "/object/wine-glass/impact"
    press("a")  # middle C on the selected object
    made, struck = table.until("/object/wine-glass.60/impact"), table.until("/object/new", 7)[-1].message
    assert made[0].message.args[0] == pytest.approx(0.05 * 100 ** (89 / 126))
    assert struck.args[:2] == ("wine-glass.60", "wine-glass") and keys(Message("", struck.args[2:]))["note"] == 60
    table.page.locator(".pill", has_text="marimba bar").focus()
    press("Enter")
    press("b")
    table.until("/marimba-bar/impact")
    table.until("/marimba-bar/bounce")
    table.page.keyboard.down("h")
    table.until("/marimba-bar/press")
    table.page.keyboard.up("h")
    table.until("/stop")
    press("ArrowLeft")
    press("Delete")
    table.until("/marimba-bar/free")
    press("Escape")
    table.until("/panic")


def test_a_session_renders_to_the_bits_of_its_recording(browser, tmp_path):
    """The score that is downloaded, from the sample on at which the recording began."""
    with served(tmp_path) as (server, url), opened(browser, server, url, tmp_path) as table:
        table.page.get_by_title("Record a WAV file").click()
        table.page.mouse.click(*table.spot("church-bell"))
        table.page.mouse.click(*table.spot("marimba-bar", 0.3))
        table.page.keyboard.press("3")
        table.page.wait_for_timeout(700)
        with table.page.expect_download() as wav:
            table.page.get_by_title("Record a WAV file").click()
        with table.page.expect_download() as score:
            table.page.get_by_role("link", name="Score").click()
        first = int(wav.value.suggested_filename.removesuffix(".wav").rsplit("-", 1)[1])
        wav.value.save_as(table.folder / "page.wav")
        score.value.save_as(table.folder / "page.txt")
        sound, rate = soundfile.read(table.folder / "page.wav", dtype="float32")
        rendered = render_lines(read(table.folder / "page.txt"), rate=rate)
        assert np.array_equal(sound, rendered[first : first + len(sound)])
        assert np.abs(sound).max() > 0.05


def test_a_score_is_dropped_and_played(play):
    table = play()
    table.ask(
        """() => { const data = new DataTransfer();
        const lines = ["0 /object/church-bell/impact 0.7 0.1\\n", "0.3 /object/wood-board/impact 0.6 0.4\\n"];
        data.items.add(new File(lines, "two.txt"));
        dispatchEvent(new DragEvent("drop", { dataTransfer: data })); }"""
    )
    one, two = table.until("/impact", 2)
    assert one.message.args == (0.7, 0.1) and two.message.args == (0.6, 0.4)
    assert two.time - one.time == pytest.approx(0.3, abs=1e-3)
    table.page.get_by_text("two.txt: 2 messages").wait_for()


def test_a_page_that_closes_lets_go(play):
    table = play()
    table.page.mouse.move(*table.spot("church-bell"))
    table.page.mouse.down()
    (press,) = table.until("/press")
    table.page.context.close()
    deadline = time.monotonic() + 5.0
    while not table.lines("/stop"):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    assert table.lines("/stop")[0].message.address == f"/gesture/{keys(press.message)['id']}/stop"


@pytest.mark.parametrize(
    ("size", "scheme"), [((320, 568), "dark"), ((320, 568), "light"), ((768, 1024), "light"), ((3840, 2160), "dark")]
)
def test_page_fits_small_and_large_screens(play, size, scheme):
    table = play(viewport={"width": size[0], "height": size[1]}, color_scheme=scheme)
    assert table.ask("document.documentElement.scrollWidth") <= size[0]
    unnamed = """[...document.querySelectorAll("button, a, input, select, [role=img]")].filter((each) =>
        each.offsetParent && !(each.getAttribute("aria-label") || each.labels?.length || each.textContent.trim()))
        .length"""
    assert table.ask(unnamed) == 0
    assert table.ask(CONTRAST) == []
    for name in ("church-bell", "wine-glass", "marimba-bar"):
        table.page.mouse.click(*table.spot(name))
        table.until(f"/{name}/impact")


CONTRAST = """(() => {
  const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const rgb = (color, under = [0, 0, 0]) => {
    canvas.fillStyle = `rgb(${under.join()})`; canvas.fillRect(0, 0, 1, 1);
    canvas.fillStyle = color; canvas.fillRect(0, 0, 1, 1);
    return [...canvas.getImageData(0, 0, 1, 1).data].slice(0, 3);
  };
  const light = (color) => color.map((each) => each / 255)
    .map((each) => each <= 0.04045 ? each / 12.92 : ((each + 0.055) / 1.055) ** 2.4)
    .reduce((sum, each, n) => sum + each * [0.2126, 0.7152, 0.0722][n], 0);
  const under = (node) => node ? rgb(getComputedStyle(node).backgroundColor, under(node.parentElement)) : [0, 0, 0];
  const bad = [];
  for (const node of document.querySelectorAll("button, h1, h2, p, summary, span, output, figcaption, a")) {
    if (!node.offsetParent || !node.textContent.trim() || node.disabled || node.closest(".as-preset, #table")) continue;
    const back = under(node), [a, b] = [light(rgb(getComputedStyle(node).color, back)), light(back)];
    if ((Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < 4.5) bad.push(node.textContent.trim());
  }
  return bad;
})()"""


def test_the_controls_slide_a_bow_along_the_selected_object(play):
    table = play()
    table.page.locator("summary", has_text="Slide").click()
    table.page.get_by_role("button", name="Slide", exact=True).click()
    (slid,) = table.until("/slide")
    assert slid.message.args[:1] == (0.1,) and keys(slid.message).items() >= {"striker": "bow", "force": 2.0}.items()
    table.until("/stop")


def test_the_meter_shows_peaks_loudness_and_the_limiters_gain(play):
    """The levels come in the very messages that a server sends; one that tells no loudness shows none."""
    table = play(color_scheme="dark")
    shown = """(levels) => { carom.link.heard.delete("/meter"); const { views } = carom;
      Object.assign(views, { limited: 0, peaks: [-200, -200] });
      views.meter(0, 0.1, 0, levels.length > 2 ? 7 : 0, 0, ...levels);
      views.levels();
      const canvas = document.getElementById("meter"), { width, height } = canvas;
      const copy = Object.assign(document.createElement("canvas"), { width, height });
      const g = copy.getContext("2d", { willReadFrequently: true });
      g.drawImage(canvas, 0, 0);
      const at = (x, y) => g.getImageData(x * width, y * height, 1, 1).data[0];
      const places = [[0.2, 0.25], [0.8, 0.25], [0.7, 0.5], [0.97, 0.9]];
      return [document.getElementById("numbers").textContent, ...places.map((each) => at(...each))]; }"""
    words, low, high, _, right = table.page.evaluate(shown, [-30.0, -200.0])
    assert "LUFS" not in words and low != high
    words, _, _, line, limited = table.page.evaluate(shown, [-18.0, -6.0, -30.0, -200.0])
    assert "-18 LUFS" in words and "limiter -6.0 dB" in words
    assert line > 200 and limited > 200 > right


def test_macros_come_first_and_a_die_turns_them_until_undo(play):
    table = play()
    sliders = table.page.locator("#inspector").get_by_role("slider")
    macros = table.ask("carom.scene.catalogue.macros.map(({ name }) => name)")
    assert [each.get_attribute("aria-label") for each in sliders.all()] == macros
    sliders.first.fill("750")
    name = table.ask("carom.scene.selected")
    assert table.until("/macro/size")[-1].message == Message(f"/object/{name}/macro/size", (0.75,))
    table.page.get_by_role("button", name="Die").click()
    table.until("/macro/roughness")
    turned = f"carom.scene.objects.get('{name}').macros"
    table.settle(f"{turned}.roughness !== 0.5")
    table.page.get_by_title("Undo (Ctrl+Z)").click()
    table.settle(f"{turned}.roughness === 0.5 && {turned}.size === 0.75")
    table.page.get_by_title("Undo (Ctrl+Z)").click()
    assert table.until_last("/macro/size", 0.5)
