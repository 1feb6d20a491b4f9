"""carom presets: lists, JSON, and checks of files."""

import json

import pytest

from carom.presets import BUILT_IN, KINDS, Presets

pytestmark = pytest.mark.slow

GLASS = (BUILT_IN / "objects" / "glass-plate.toml").read_text()


@pytest.fixture
def carom(carom_here):
    """Run the command line in this process."""
    return carom_here


def test_json_lists_every_preset(carom):
    listed = json.loads(carom("presets", "--json", check=True).stdout)
    assert list(listed) == list(KINDS)
    for kind, presets in listed.items():
        assert [each["name"] for each in presets] == Presets().names(kind)
        assert all(each["description"] and each["file"].endswith(f"{kind}/{each['name']}.toml") for each in presets)


def test_json_shows_presets_of_every_kind_of_that_name(carom):
    shown = json.loads(carom("presets", "steel", "glass-plate", "--json", check=True).stdout)
    assert [(each["kind"], each["name"]) for each in shown] == [
        ("strikers", "steel"),
        ("surfaces", "steel"),
        ("materials", "steel"),
        ("objects", "glass-plate"),
    ]
    assert shown[-1]["data"]["geometry"]["thickness"] == 0.004


def test_names_alone_are_for_other_programs(carom):
    names = carom("presets", "--names", check=True).stdout.split("\n")
    assert {"glass-plate", "wood", "ice"} <= set(names) and not any(" " in name for name in names)


def test_all_that_is_built_in_passes_the_check(carom):
    files = sorted(BUILT_IN.glob("*/*.toml"))
    lines = carom("presets", "--check", *files, check=True).stdout.splitlines()
    assert len(lines) == len(files) > 70
    count = Presets().object("glass-plate").modes(20_000.0).frequency.size
    glass = next(line for line in lines if "glass-plate" in line)
    assert ": an object: plate of glass, 2.08 kg, " in glass and f" {count} modes from " in glass
    words = {"materials": "a material", "surfaces": "a surface", "strikers": "a striker of ", "recipes": "a recipe of "}
    for kind, word in words.items():
        assert all(f": {word}" in line for line in lines if f"/{kind}/" in line)


@pytest.mark.parametrize(
    ("path", "text", "error"),
    [
        ("objects/x.toml", GLASS.replace("length =", "lenght ="), "[geometry] lenght = 0.5: did you mean length?"),
        ("x.toml", GLASS.replace('"glass"', '"glas"'), "material = 'glas': did you mean glass?"),
        ("x.toml", GLASS.replace("0.004", "4"), "[geometry] thickness = 4: expected a number"),
        ("x.toml", "shape =", "not TOML"),
        ("strikers/x.toml", GLASS, "shape = 'plate': expected one of"),
        ("materials/x.toml", "density = 0", "density = 0: expected a number from 1 to 30000 kg/m3"),
        ("recipes/x.toml", "count = 0\n[object]", "count = 0: expected a whole number"),
        ("x.toml", 'count = 1\n[object]\npreset = "glas"\n[impact]', "[object] no object 'glas': did you mean"),
        ("x.toml", 'description = "d"', "source is missing: expected a text"),
    ],
)
def test_a_wrong_file_is_told_in_one_line(carom, tmp_path, path, text, error):
    (tmp_path / path).parent.mkdir(exist_ok=True)
    (tmp_path / path).write_text(text)
    run = carom("presets", "--check", path)
    assert (run.returncode, run.stdout) == (1, "")
    assert run.stderr.startswith(f"carom presets: {path}: ") and error in run.stderr and run.stderr.count("\n") == 1
    (result,) = json.loads(carom("presets", "--check", path, "--json").stdout)
    assert result["file"] == path and error in result["error"] and result["holds"] == ""


def test_files_of_ones_own_may_name_each_other(carom, tmp_path):
    (tmp_path / "mine" / "materials").mkdir(parents=True)
    (tmp_path / "mine" / "materials" / "jelly.toml").write_text((BUILT_IN / "materials" / "rubber.toml").read_text())
    (tmp_path / "x.toml").write_text(GLASS.replace('"glass"', '"jelly"'))
    assert "material = 'jelly': expected one of" in carom("presets", "--check", "x.toml").stderr
    assert "plate of jelly" in carom("presets", "--check", "x.toml", "--presets", "mine", check=True).stdout


def test_a_missing_file_is_told_with_the_near_one(carom, tmp_path):
    (tmp_path / "plate.toml").write_text(GLASS)
    run = carom("presets", "--check", "plat.toml")
    assert run.stderr == "carom presets: plat.toml: No such file or directory; did you mean plate.toml?\n"
    run = carom("presets", "--check", "glass-plate")
    file = BUILT_IN / "objects" / "glass-plate.toml"
    assert run.stderr == f"carom presets: glass-plate: a preset's name; expected a file, as {file}\n"
    assert carom("presets", "--check").stderr == "carom presets: --check: no file; expected one or more\n"


def test_a_folder_is_checked_whole(carom, tmp_path):
    (tmp_path / "mine" / "objects").mkdir(parents=True)
    (tmp_path / "none").mkdir()
    (tmp_path / "mine" / "objects" / "a.toml").write_text(GLASS)
    (tmp_path / "mine" / "objects" / "b.toml").write_text("shape =")
    run = carom("presets", "--check", "mine")
    assert run.returncode == 1 and run.stdout.startswith("mine/objects/a.toml: an object: plate of glass")
    assert run.stderr.startswith("carom presets: mine/objects/b.toml: not TOML")
    run = carom("presets", "--check", "none")
    assert run.stderr.startswith("carom presets: none: expected a preset, or a folder of presets")
