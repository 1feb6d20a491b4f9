"""The listener on the page's table: objects are heard from where they lie."""

import numpy as np
import pytest

from carom.server.osc.score import Line
from carom.server.osc.wire import Message
from tests.clients.page.conftest import Table
from tests.support import render_lines

pytestmark = pytest.mark.slow

LISTENS = "carom.listener.on && carom.listener.told.size"


def spot(table: Table) -> tuple[float, float]:
    """Return the pixel of the listener's middle."""
    box = table.page.locator("#listener").bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def levels(lines: list[Line]) -> np.ndarray:
    """Return the RMS level (dB) of each channel of what messages sound like."""
    sound = render_lines(lines)
    return 10.0 * np.log10(np.mean(np.square(sound, dtype=float), axis=0))


def test_objects_are_heard_from_where_they_lie(play):
    table = play()
    page = table.page
    page.get_by_role("button", name="Space").click()
    table.settle(LISTENS)
    page.mouse.click(*table.spot("wine-glass"))
    page.mouse.click(*table.spot("steel-plate"))
    table.until("/impact", 2)
    places = {line.message.address.split("/")[2]: line.message.args for line in table.lines("/place")}
    assert len(places) == 6 and places["wine-glass"][1] > 0 > places["steel-plate"][1], "to the left, and to the right"
    for name, louder in (("wine-glass", 0), ("steel-plate", 1)):
        one = [
            line
            for line in table.lines()
            if {name, "listener"} & {*line.message.address.split("/"), *line.message.args}
        ]
        heard = levels(one)
        assert heard[louder] > heard[1 - louder] + 3.0
    page.get_by_role("button", name="Space").click()
    gone = table.until("/place", 12)[6:]
    assert {line.message.args for line in gone} == {()}, "all are heard by their pans again"


def test_the_listener_is_dragged_and_steps_by_the_arrows(play):
    table = play()
    page = table.page
    page.get_by_role("button", name="Space").click()
    table.settle(LISTENS)
    x, y = spot(table)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 100, y - 150, steps=5)
    page.mouse.up()
    assert np.allclose(spot(table), (x - 100, y - 150), atol=1.0)
    metres = 3.0 / table.ask("carom.table.w")
    moved = table.until_last("/listener", table.lines("/listener")[0].message.args[0] + 150 * metres, 0.01)[-1].message
    assert moved.args[1] == pytest.approx(100 * metres, abs=0.01) and moved.args[3:] == ("over", 0.05, "layout", "pan")
    page.keyboard.press("ArrowRight")
    assert spot(table)[0] == pytest.approx(x - 100 + 0.02 * table.ask("carom.table.w"), abs=1.0)
    before = len(table.lines("/church-bell/place"))
    page.locator(".pill[data-name=church-bell]").focus()
    page.keyboard.press("ArrowLeft")
    assert table.until("/church-bell/place", before + 1)[-1].message.args[3:] == ("over", 0.05)


def test_a_table_is_kept_with_its_listener(play):
    table = play()
    table.page.get_by_role("button", name="Space").click()
    table.settle(LISTENS)
    text = table.ask("carom.scene.text('two')")
    assert "# listener at 0.5 0.93\n0.0 /listener" in text and text.count("/place ") == 6
    table.page.get_by_role("button", name="Space").click()
    kept = {"name": "two.txt", "mimeType": "text/plain", "buffer": text.replace("at 0.5 0.93", "at 0.25 9").encode()}
    table.page.set_input_files("#table-file", kept)
    table.settle("carom.listener.on && carom.listener.x === 0.25 && carom.listener.y === 0.5")
    table.settle("carom.listener.told.size === 6")


def test_a_note_on_an_object_in_space_comes_from_there(play):
    table = play()
    table.page.get_by_role("button", name="Space").click()
    table.settle(LISTENS)
    table.page.keyboard.press("a")
    (struck,) = table.until(".60/impact")
    assert struck.message.address == "/object/church-bell.60/impact"
    place = Message("/object/church-bell.60/place", tuple(table.lines("/church-bell/place")[-1].message.args))
    assert [line.message for line in table.lines("church-bell.60/place")] == [place]
