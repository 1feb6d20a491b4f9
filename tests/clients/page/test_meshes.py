"""Objects of meshes on the page: seen as they are, struck at the very point that is touched, turned to other sides."""

import numpy as np
import pytest

from carom.presets.library import Presets
from carom.server.osc.wire import Message
from tests.clients.page.conftest import Table

pytestmark = pytest.mark.slow

MUG = "carom.scene.objects.get('mug')"


def with_mug(table: Table) -> Table:
    table.page.get_by_label("Find an object").fill("mug")
    table.page.get_by_role("button", name="Add mug").click()
    table.settle(f"{MUG}?.modes?.shapes !== undefined")
    return table


def corner(table: Table) -> tuple[float, float, float]:
    """Return the pixel of the middle of the mug, and pixels per metre."""
    x, y, scale = table.ask(
        f"(() => {{ const b = carom.table.stage.getBoundingClientRect(), [x, y] = carom.table.middle({MUG});"
        f"return [b.left + x, b.top + y, 1 / carom.table.metresPerPixel({MUG})]; }})()"
    )
    return x, y, scale


def point_of(message: Message) -> np.ndarray:
    at = message.args.index("point")
    return np.array(message.args[at + 1 : at + 4], float)


def met_first(table: Table, x: float, y: float) -> np.ndarray:
    """Return the point of the mug's table that is met first by a line of sight, by the view alone."""
    left, top, scale = corner(table)
    view = table.ask(f"{MUG}.body.view")
    c, s, up, out = np.cos(view["turn"]), np.sin(view["turn"]), np.cos(view["tilt"]), np.sin(view["tilt"])
    axes = np.array([[c, -s, 0.0], [-out * s, -out * c, -up], [up * s, up * c, -out]])  # right, down, away
    made = Presets().object("mug").geometry["table"]
    middle = (made.points.min(axis=0) + made.points.max(axis=0)) / 2
    corners = (made.points[made.faces] - middle) @ axes.T
    start = np.array([(x - left) / scale, (y - top) / scale])
    sides = np.stack([corners[:, 1, :2] - corners[:, 0, :2], corners[:, 2, :2] - corners[:, 0, :2]], axis=2)
    some = np.abs(np.linalg.det(sides)) > 1e-12
    shares = np.linalg.solve(sides[some], (start - corners[some, 0, :2])[:, :, None])[:, :, 0]
    inside = (shares >= 0).all(axis=1) & (shares.sum(axis=1) <= 1)
    found = corners[some][inside]
    shares = shares[inside]
    points = found[:, 0] + np.einsum("ns,nsk->nk", shares, found[:, 1:] - found[:, :1])
    return middle + points[points[:, 2].argmin()] @ axes


def test_a_mesh_is_struck_at_the_point_that_is_touched(play):
    table = with_mug(play())
    x, y, scale = corner(table)
    for count, (right, down) in enumerate(((0.0, 0.0), (-0.02, 0.03), (-0.015, -0.044), (0.049, 0.0)), 1):
        place = x + right * scale, y + down * scale
        table.page.mouse.click(*place)
        struck = table.until("/mug/impact", count)[-1].message
        assert struck.args[0] == Presets().object("mug").velocity
        assert point_of(struck) == pytest.approx(met_first(table, *place), abs=1.5 / scale)  # a pixel and a half
    # Where the blow fell, and not on the strike path, the page marks it.
    flashes = "carom.table.marks.flashes.filter(({ object }) => object.name === 'mug')"
    table.settle(f"{flashes}.some(({{ position }}) => position.length === 3)")


def test_a_blow_at_a_position_of_a_mesh_is_shown_too(play):
    table = with_mug(play())
    with table.server.client() as client:
        client.impact("mug", 1.0, 0.3)
    flashes = "carom.table.marks.flashes.filter(({ object }) => object.name === 'mug')"
    table.settle(f"{flashes}.some(({{ position }}) => Math.abs(position - 0.3) < 1e-6)")
    assert table.ask(f"carom.table.pixel({MUG}, 0.3)") == table.ask(f"carom.table.middle({MUG})")


@pytest.mark.parametrize("way", ["mode", "button", "keys"])
def test_a_mesh_is_turned_to_another_side(play, way):
    table = with_mug(play())
    x, y, scale = corner(table)
    before = met_first(table, x, y)
    far = np.pi / 0.01  # rad per pixel: half a turn
    if way == "keys":
        table.page.locator(".pill", has_text="mug").focus()
        for _ in range(12):
            table.page.keyboard.press("Shift+ArrowLeft")
    else:
        if way == "mode":
            table.page.get_by_role("button", name="Turn", exact=True).click()
        table.page.mouse.move(x, y)
        table.page.mouse.down(button="right" if way == "button" else "left")
        table.page.mouse.move(x + far, y, steps=10)
        table.page.mouse.up(button="right" if way == "button" else "left")
        table.page.get_by_role("button", name="Play", exact=True).click()
    assert not table.lines("/mug/impact")
    table.page.mouse.click(x, y)
    (struck,) = table.until("/mug/impact")
    after = point_of(struck.message)
    assert after == pytest.approx(met_first(table, x, y), abs=1.5 / scale)
    middle = np.array([(0.0749 - 0.041) / 2, 0.0])
    assert np.dot(after[:2] - middle, before[:2] - middle) < 0  # the other side


def test_a_drag_leads_a_slide_over_the_surface(play):
    table = with_mug(play())
    x, y, scale = corner(table)
    table.drag_from(x - 0.02 * scale, y)
    for n in range(1, 11):
        table.page.mouse.move(x - 0.02 * scale, y + 0.003 * n * scale)
        table.page.wait_for_timeout(16)
    (slide,) = table.until("/mug/slide")
    last = met_first(table, x - 0.02 * scale, y + 0.03 * scale)
    led = table.until_last("/point", last, near=2 / scale)
    assert point_of(slide.message)[2] > led[-1].message.args[2]
    table.page.mouse.up()
    table.until("/stop")


def test_object_without_a_surface_is_not_turned(play):
    table = play()
    assert not table.page.get_by_role("button", name="Turn", exact=True).is_visible()
    table.page.mouse.click(*table.spot("marimba-bar"), button="right")
    table.page.mouse.click(*table.spot("marimba-bar"))
    (struck,) = table.until("/impact")
    assert struck.message.address == "/object/marimba-bar/impact"
