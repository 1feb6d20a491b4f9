"""The picture of the page in the documents: `python -m tests.documents.screenshot` plays a little, and keeps it."""

import re
import shutil
import tempfile
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from tests.support import serving

PICTURE = Path(__file__).parents[2] / "clients" / "page.png"
_SIZE = {"width": 1280, "height": 780}


def _point(page: Page, name: str, position: float) -> tuple[float, float]:
    x, y = page.evaluate(
        f"(() => {{ const b = carom.table.stage.getBoundingClientRect();"
        f"const [x, y] = carom.table.pixel(carom.scene.objects.get('{name}'), {position});"
        "return [b.left + x, b.top + y]; })()"
    )
    return x, y


def _play(page: Page) -> None:
    page.wait_for_timeout(2500)
    page.keyboard.press("1")
    page.mouse.click(*_point(page, "marimba-bar", 0.3))
    page.wait_for_timeout(4500)  # until the hint has gone
    page.keyboard.press("5")
    page.keyboard.press("1")
    page.get_by_text("steel plate", exact=True).last.focus()
    page.keyboard.press("b")
    page.mouse.move(*_point(page, "wood-board", 0.15))
    page.mouse.down()
    for n in range(4, 19):
        page.mouse.move(*_point(page, "wood-board", 0.15 + n / 30))
        page.wait_for_timeout(14)


def main() -> None:
    """Take the picture."""
    with (
        tempfile.TemporaryDirectory() as folder,
        serving(Path(folder), "--device", "page", "--page", "0") as server,
        sync_playwright() as runner,
    ):
        assert server.process.stdout
        match = re.search(r"http://\S+", server.process.stdout.readline())
        assert match
        browser = runner.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_context(viewport=_SIZE, color_scheme="dark").new_page()
        page.goto(match[0])
        _play(page)
        page.screenshot(path=PICTURE)
        browser.close()


if __name__ == "__main__":
    main()
