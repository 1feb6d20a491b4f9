"""The house, drawn from its imports: the rooms of the engine, the arrows between them, and no circle anywhere."""

import shutil
import sys
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[1]
ENGINE, LABORATORY, BRIDGE = "carom.dsp.engine", "carom.dsp.lab", "carom.server.bridge"
MOST_ROOMS, MOST_ARROWS = 9, 40

Graph = dict[str, set[str]]


def lay_out(folder: Path) -> None:
    """Copy the sources as they are installed: the face is the package, and the other folders lie in it."""
    ignore = shutil.ignore_patterns("__pycache__", "face")
    shutil.copytree(ROOT / "clients" / "face", folder / "carom", ignore=ignore)
    for name in ("dsp", "server", "presets", "clients"):
        shutil.copytree(ROOT / name, folder / "carom" / name, ignore=ignore)


@pytest.fixture(scope="module")
def imports(tmp_path_factory) -> Graph:
    """The modules that each module imports, of Carom's own."""
    folder = tmp_path_factory.mktemp("house")
    lay_out(folder)
    with pytest.MonkeyPatch.context() as patch:  # the reader finds a package as an import would, and imports nothing
        patch.syspath_prepend(folder)
        for name in [name for name in sys.modules if name.partition(".")[0] == "carom"]:
            patch.delitem(sys.modules, name)
        graph = grimp.build_graph("carom", cache_dir=None)
    return {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}


def children(imports: Graph, package: str) -> Graph:
    """Return which of a package's modules and packages import which, all that is in one of them taken as one."""

    def child(module: str) -> str:
        inside = module.startswith(f"{package}.")
        return ".".join(module.split(".")[: package.count(".") + 2]) if inside else ""

    found: Graph = {}
    for module, others in imports.items():
        if child(module):
            found.setdefault(child(module), set()).update(map(child, others))
    return {one: others - {one, ""} for one, others in found.items()}


def circles(graph: Graph) -> list[set[str]]:
    """Return the sets of nodes that all lead to each other: what stays when the ends are taken away, over and over."""
    left = {one: set(others) for one, others in graph.items()}
    while ends := {one for one, others in left.items() if not others}:
        left = {one: others - ends for one, others in left.items() if one not in ends}
    reached = {one: reach(left, one) for one in left}
    found = [{one, *(other for other in reached[one] if one in reached[other])} for one in left if one in reached[one]]
    return [each for n, each in enumerate(found) if each not in found[:n]]


def reach(graph: Graph, start: str) -> set[str]:
    """Return all nodes that arrows lead to."""
    seen: set[str] = set()
    waiting = [start]
    while waiting:
        new = graph.get(waiting.pop(), set()) - seen
        seen |= new
        waiting += new
    return seen


def test_circles_are_found():
    assert circles({"a": {"b"}, "b": {"c"}, "c": set()}) == []
    assert circles({"a": {"b"}, "b": {"c", "d"}, "c": {"b"}, "d": set()}) == [{"b", "c"}]


@pytest.mark.slow
def test_no_module_is_in_a_circle(imports):
    assert len(imports) > 300
    assert circles(imports) == []


def test_no_package_is_in_a_circle(imports):
    """Modules and packages of one package lead in no circle, each package taken with all that is in it."""
    packages = {module.rpartition(".")[0] for module in imports} - {""}
    assert {name: found for name in packages if (found := circles(children(imports, name)))} == {}


def test_the_engine_has_few_rooms_and_few_arrows_between_them(imports):
    rooms = children(imports, ENGINE)
    assert 2 < len(rooms) <= MOST_ROOMS, sorted(rooms)
    assert sum(map(len, rooms.values())) <= MOST_ARROWS, rooms


@pytest.mark.parametrize("room", [LABORATORY, BRIDGE])
def test_the_engine_knows_neither_the_laboratory_nor_the_bridge(imports, room):
    assert room in imports
    for module in imports:
        if module.startswith(ENGINE):
            assert not [other for other in reach(imports, module) if other.startswith(room)], module


def test_dsp_knows_no_simulator():
    """The structs and functions of a simulator are the bridge's."""
    for path in (ROOT / "dsp").rglob("*.py"):
        assert "mujoco" not in path.read_text().lower(), path
