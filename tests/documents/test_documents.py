"""The documents say what the program says: their tables and links."""

import os
import re

import pytest

from carom.dsp.contact.accuracy import LEVELS
from carom.server.osc.wire import Message
from carom.server.status import FIELDS, FIRST
from tests.documents import methods, records, site
from tests.documents.pages import PAGES, PARTS, ROOT, parts, written
from tests.support import serving

OTHERS = ("CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "clients/examples/README.md")
NAMES = set(re.findall(r"\w+", "".join(
    each.read_text(encoding="utf-8") for folder in ("clients", "dsp", "presets", "server", "tests")
    for ending in ("py", "c", "js", "toml") for each in (ROOT / folder).rglob(f"*.{ending}")
)))  # fmt: skip
TEXTS = {page: (ROOT / page).read_text(encoding="utf-8") for page in (*PAGES, *OTHERS)}


@pytest.mark.parametrize("part", [records, methods])
def test_a_stub_is_what_the_schema_declares(part):
    assert part.STUB.read_text(encoding="utf-8") == part.stub(), "run `make documents`"


@pytest.mark.parametrize("page", PAGES)
def test_a_pages_tables_are_the_programs(page):
    assert written(TEXTS[page]) == TEXTS[page], "run `make documents`"


def test_every_part_stands_in_one_page():
    assert sorted(name for page in PAGES for name in parts(TEXTS[page])) == sorted(PARTS)
    for text in TEXTS.values():
        assert text.count("<!-- begin ") == text.count("<!-- end ") == len(parts(text))


def test_every_page_is_linked_to():
    """A reader who follows links from the README comes to each page."""
    found, left = {"README.md"}, ["README.md"]
    while left:
        page = left.pop()
        for link in re.findall(r"\]\(([^)#\s]+\.md)(?:#[^)]*)?\)", TEXTS[page]):
            name = os.path.normpath(os.path.join(os.path.dirname(page), link))
            if name in TEXTS and name not in found:
                found.add(name)
                left.append(name)
    assert found >= set(PAGES)


def test_the_side_bar_of_the_site_has_each_page_once():
    listed = [name for names in site.NAVIGATION.values() for name in names]
    assert sorted([*listed, "index"]) == sorted(site.staged(page).removesuffix(".md") for page in TEXTS)


FOR_DEVELOPERS = ("CONTRIBUTING.md", "SECURITY.md", *(page for page in PAGES if page.startswith(("dsp/", "tests/"))))
_PATH = re.compile(r"`((?:[a-z_]+/)+[a-zA-Z_]*(?:\.[a-z]+)*)(?:::(\w+))?`|`(\w+)`")


@pytest.mark.parametrize("page", FOR_DEVELOPERS)
def test_code_that_a_page_names_exists(page):
    """Files, tests in them, functions of a module (`rolling/body.fill_roll`), and names of two words (`ring_on`)."""
    prose = re.sub(r"```.*?```", "", TEXTS[page], flags=re.DOTALL)
    for path, test, name in _PATH.findall(prose):
        if name:
            assert "_" not in name.strip("_") or name in NAMES, name
            continue
        file, module, function = path, f"{path.rpartition('.')[0]}.py", path.rpartition(".")[2]
        beside = ROOT, (ROOT / page).parent, ROOT / "dsp" / "engine"
        within = [place for place in beside if (place / file).exists()]
        if not within:
            found = [place / module for place in beside if (place / module).exists()]
            assert found and f"def {function}(" in found[0].read_text(encoding="utf-8"), path
        assert not test or f"def {test}(" in (within[0] / file).read_text(encoding="utf-8"), test


@pytest.mark.parametrize("page", TEXTS)
def test_its_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", TEXTS[page]):
        name, _, section = link.partition("#")
        if not name.startswith("http"):
            target = (ROOT / page).parent / name if name else ROOT / page
            assert target.exists(), link
            heads = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.M) if section else []
            assert not section or section in {_anchor(head) for head in heads}, link


def _anchor(head: str) -> str:
    return re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-")


def test_accuracy_page_has_the_dial_and_the_expert_settings():
    dial, expert = (
        re.findall(r"^\| `(\S+?)[` ]", part, re.M) for part in TEXTS["server/accuracy.md"].split("## Expert")
    )
    assert dial == ["/accuracy", *LEVELS]
    assert expert == ["/quality", "/budget", "/bank"]


@pytest.mark.slow
def test_the_fields_of_a_status_are_those_that_are_documented(tmp_path):
    with serving(tmp_path, "--device", "none") as server, server.client() as client:
        status: Message = client.status()
    assert len(FIRST) == 9 and status.args[9::2] == tuple(FIELDS)
