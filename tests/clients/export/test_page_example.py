"""The example in JavaScript of the page on exports."""

import re
from pathlib import Path

import pytest

from carom.clients.cli import main
from tests import needs
from tests.clients.export.pages import served
from tests.documents.pages import ROOT

playwright = needs.module("playwright.sync_api")

pytestmark = [pytest.mark.slow, needs.without("chromium")]


def test_its_module_strikes_and_rolls(tmp_path: Path) -> None:
    """It runs in Chromium, on a scene with its two objects."""
    ((text),) = re.findall(r"```js\n(.*?)```", (ROOT / "clients" / "export.md").read_text(), re.DOTALL)
    begin, rest = text.split("\n", 1)
    assert begin == 'import { Carom } from "./carom.js";'
    (tmp_path / "score.txt").write_text("0 /object/new bell church-bell\n0 /object/new pane glass-plate\n")
    assert main(["export", str(tmp_path / "score.txt"), str(tmp_path / "page")]) == 0
    with served(tmp_path / "page") as address, playwright.sync_playwright() as runner:
        browser = runner.chromium.launch(executable_path=needs.program("chromium"), args=["--no-sandbox"])
        opened = browser.new_page()
        opened.goto(f"{address}index.html")
        first = 'const { Carom } = await import("./carom.js");'
        assert opened.evaluate(f"async () => {{ {first} {rest} return [id, context.state]; }}") == ["pane", "running"]
        browser.close()
