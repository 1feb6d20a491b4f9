"""The table in a browser: found again by a restarted server, kept by name, shared as a score; room; looks."""

import re
from contextlib import ExitStack
from itertools import combinations

import numpy as np
import pytest

from carom.server.osc.score import read
from carom.server.osc.wire import Message
from tests.clients.page.conftest import SIZE, Table, served
from tests.clients.page.test_page import keys
from tests.support import render_lines

pytestmark = pytest.mark.slow

LAID = "[...carom.scene.objects.values()].map(({ name, x, y }) => [name, x, y])"
KNOWN = "[...carom.scene.objects.values()].every((each) => each.modes)"
BOXES = """() => { const { scene, table } = carom; return [...scene.objects.values()].map((each) =>
    table.box(table.size > 0.5 ? each.name : "", each.body, table.middle(each)))
    .concat([[0, 0, table.w, table.h]]); }"""


def misplaced(table: Table) -> list[object]:
    """Return the boxes that lie on another one or beyond the table, but for what places are rounded to."""
    *boxes, (_, _, width, height) = np.array(table.page.evaluate(BOXES))
    beyond = [box for box in boxes if box[:2].min() <= -1 or box[2] >= width + 1 or box[3] >= height + 1]
    pairs = [
        (a, b) for a, b in combinations(boxes, 2) if (np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2]) > 1).all()
    ]
    return [*beyond, *pairs]


def test_a_restarted_server_finds_the_pages_table_again(browser, tmp_path):
    with ExitStack() as stack:
        context = browser.new_context(viewport=SIZE)
        stack.callback(context.close)
        page = context.new_page()
        with served(tmp_path) as (server, url):
            page.goto(url)
            table = Table(page, server, url, tmp_path, 0)
            table.settle("window.carom?.scene.objects.size === 6 && carom.scene.pending.size === 0")
            page.get_by_role("button", name="Add glass ball").click()
            table.settle("carom.scene.selected === 'glass-ball' && carom.scene.objects.get('glass-ball').modes")
            page.locator("summary", has_text="Object").click()
            page.get_by_role("slider", name="tune").fill("750")
            with server.client() as client:
                client.new("pane", "glass-plate", length=0.3, edges=["free", "free", "clamped", "free"])
            table.settle("carom.scene.objects.get('pane')?.modes")
            page.keyboard.press("Escape")
            page.get_by_role("button", name="Space").click()
            before = table.ask(LAID)
            table.settle("/ glass-ball tune 12.*[^]*edges/.test(localStorage.getItem('carom-table'))")
        (tmp_path / "log.txt").unlink()
        stack.enter_context(served(tmp_path, re.search(r":(\d+)/", url)[1]))
        table.settle("carom.link.isOpen && carom.scene.isKnown")
        made = {line.message.args[0]: line.message.args for line in table.until("/object/new", 8)}
        table.settle("carom.scene.objects.size === 8 && carom.scene.pending.size === 0 && " + KNOWN)
        assert sorted(table.ask(LAID)) == sorted(before)
        assert keys(Message("", made["glass-ball"][2:])) == {"tune": 12.0}
        kept = keys(Message("", made["pane"][2:]))
        assert kept == {"length": 0.3, "edges": ("free", "free", "clamped", "free")}
        assert len({line.message.address for line in table.until("/place", 8)}) == 8
        assert page.locator("#notices .bad").count() == 0


def shelf(table: Table) -> None:
    table.page.get_by_role("button", name="Tables").click()


def test_tables_are_kept_by_their_names(play):
    table = play()
    table.page.locator("summary", has_text="Object").click()
    table.page.get_by_role("slider", name="pan").fill("0")
    shelf(table)
    table.page.get_by_label("Name of the table").fill("Kitchen")
    table.page.get_by_role("button", name="Save", exact=True).click()
    table.page.get_by_role("button", name="Kitchen 6 objects").wait_for()
    before = table.ask(LAID)
    table.page.get_by_role("button", name="Clear the table").click()
    table.until("/free", 6)
    table.page.get_by_role("button", name="Close").click()
    table.page.get_by_text("The table is empty.").wait_for()
    table.page.reload()
    table.settle("window.carom?.scene.isKnown")
    table.page.get_by_text("The table is empty.").wait_for()
    shelf(table)
    table.page.get_by_role("button", name="Kitchen 6 objects").click()
    table.settle("carom.scene.objects.size === 6 && carom.scene.pending.size === 0")
    assert sorted(table.ask(LAID)) == sorted(before)
    again = {line.message.args[0]: line.message.args for line in table.until("/object/new", 12)[6:]}
    assert [len(args) for args in again.values()].count(4) == 1
    assert keys(Message("", again["church-bell"][2:])) == {"pan": -1}
    table.page.get_by_title("Undo (Ctrl+Z)").click()
    table.settle("carom.scene.objects.size === 0")
    shelf(table)
    table.page.get_by_role("button", name="Delete Kitchen").click()
    assert table.page.get_by_role("button", name="Kitchen 6 objects").count() == 0


def test_a_table_is_a_score_that_renders_and_opens_elsewhere(play):
    table = play()
    table.page.get_by_label("Find an object").fill("glass ball")
    table.page.get_by_role("button", name="Add glass ball").click()
    table.settle("carom.scene.objects.get('glass-ball')?.modes")
    with table.server.client() as client:
        client.send("/object/glass-ball/tune", 7.0)
        client.ask("/sync", 1)
    shelf(table)
    table.page.get_by_label("Name of the table").fill("Küche 2")
    with table.page.expect_download() as score:
        table.page.get_by_role("button", name="Download as a score").click()
    assert score.value.suggested_filename == "Küche-2.txt"
    score.value.save_as(path := table.folder / "table.txt")
    before = table.ask(LAID)
    lines = read(path)
    assert [line.message.address for line in lines].count("/object/new") == 7
    sound = render_lines(lines)
    for struck in (line for line in lines if line.message.address.endswith("/impact")):
        first = round(48_000 * struck.time)
        assert np.abs(sound[first : first + 24_000]).max() > 1e-3, struck.message.address
    table.page.get_by_role("button", name="Clear the table").click()
    table.settle("carom.scene.objects.size === 0")
    table.page.locator("#table-file").set_input_files(path)
    table.settle("carom.scene.objects.size === 7 && carom.scene.pending.size === 0 && " + KNOWN)
    assert sorted(table.ask(LAID)) == sorted(before)
    assert table.ask("carom.scene.objects.get('glass-ball').settings.tune") == 7


def test_an_empty_table_says_what_to_do(play):
    table = play()
    table.ask("carom.scene.replace([])")
    table.page.get_by_text("Add an object from the list").wait_for()
    table.page.get_by_role("button", name="Lay six objects to begin with").click()
    table.settle("carom.scene.objects.size === 6")
    assert table.page.get_by_text("The table is empty.").is_hidden()


@pytest.mark.parametrize("size", [(1280, 800), (320, 568), (2560, 1440)])
def test_new_objects_lie_on_no_other(play, size):
    table = play(viewport={"width": size[0], "height": size[1]})
    assert misplaced(table) == []
    count = 20 if size[0] > 1000 else 4
    table.ask(f"carom.scene.catalogue.objects.slice(0, {count}).forEach(({{ name }}) => carom.scene.add(name))")
    table.settle(f"carom.scene.objects.size === {count + 6} && carom.scene.pending.size === 0 && {KNOWN}")
    assert misplaced(table) == []


PICTURE = """(name) => {
  const object = carom.scene.objects.get(name), { image } = carom.table.picture(object);
  const copy = Object.assign(document.createElement("canvas"), { width: image.width, height: image.height });
  const g = copy.getContext("2d", { willReadFrequently: true }), s = carom.table.dense * carom.table.scale;
  g.drawImage(image, 0, 0);
  const at = (x, y) => [...g.getImageData(image.width / 2 + s * x, image.height / 2 + s * y, 1, 1).data];
  const { w, h } = object.body;
  return { w, h, parts: [[0, 0], [0.9, 0], [-0.9, 0], [0, 0.9], [0, -0.9], [0.8, 0.8], [-0.8, -0.8]]
    .map(([x, y]) => at((x * w) / 2, (y * h) / 2)) };
}"""


def test_objects_look_like_their_shape_and_material(play):
    table = play()
    with table.server.client() as client:
        client.new("ball", "glass-ball")
        client.new("steel-ball", "glass-ball", material="steel")
        client.new("long", "wood-board", length=1.2)
    table.settle(f"carom.scene.objects.size === 9 && {KNOWN}")
    ball = table.page.evaluate(PICTURE, "ball")
    assert ball["w"] == ball["h"], "a ball is round"
    alphas = [alpha for *_, alpha in ball["parts"]]
    assert min(alphas[:5]) > 150, "up to its edge on all sides"
    assert max(alphas[5:]) < 150, "and not beyond: but a shadow"
    steel = table.page.evaluate(PICTURE, "steel-ball")
    assert np.abs(np.subtract(ball["parts"][0], steel["parts"][0])).max() > 20
    board, long = (table.page.evaluate(PICTURE, name) for name in ("wood-board", "long"))
    assert long["w"] > 1.3 * board["w"]
