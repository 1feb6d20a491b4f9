"""A touch of the page strikes, or many small blows fall while it lasts."""

import pytest

from tests.clients.page.conftest import Table

pytestmark = pytest.mark.slow


def choose(table: Table, name: str) -> None:
    table.page.locator("#touches").get_by_role("radio", name=name).click()


def test_every_swarm_is_a_touch(play):
    table = play()
    names = table.page.locator("#touches [role=radio]").all_text_contents()
    gestures = "Object.keys(carom.hands.gestures).filter((each) => carom.hands.gestures[each].swarms)"
    assert names == ["strike", *table.ask(gestures)]
    assert "rain" in names and "shatter" in names


def test_rain_falls_where_the_finger_is_while_it_is_held(play):
    table = play()
    choose(table, "rain")
    x, y = table.spot("steel-plate")
    table.page.mouse.move(x, y)
    table.page.mouse.down()
    table.until("/steel-plate/rain", 1)
    table.page.mouse.move(x + 20, y, steps=4)
    (rain,) = table.lines("/steel-plate/rain")
    id = rain.message.args[list(rain.message.args).index("id") + 1]
    table.until(f"/{id}/position", 1)
    assert not table.lines(f"/{id}/stop")
    table.page.mouse.up()
    table.until(f"/{id}/stop", 1)
    choose(table, "strike")
    table.page.mouse.click(x, y)
    table.until("/steel-plate/impact", 1)


def test_a_step_happens_once_and_what_breaks_is_silent_until_its_damp_is_lifted(play):
    table = play()
    for name, target in (("step", "steel-plate"), ("shatter", "wine-glass")):
        choose(table, name)
        table.page.mouse.click(*table.spot(target))
        (begun,) = table.until(f"/{target}/{name}", 1)
        id = begun.message.args[list(begun.message.args).index("id") + 1]
        assert not table.lines(f"/{id}/stop"), "its blows end by themselves"
    assert table.ask("carom.scene.objects.get('wine-glass').settings.damp") == 1
