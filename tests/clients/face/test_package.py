"""The package `carom` from outside: what it costs to import, what it says of itself, what type checkers see."""

import os
import pydoc
import subprocess
import sys
from pathlib import Path

import pytest

import carom

ROOT = Path(__file__).parents[3]

USER = """
import carom
import numpy as np

with carom.Scene(44_100, limiter=True) as scene:
    bar = scene.new("bar", "marimba-bar", length=np.float64(0.3))
    bar.impact(1.0, at=0.1, striker="yarn")
    frequencies, decays, gains, click, relief = bar.modes(0.3)
    sound: carom.Sound = scene.render(seconds=0.5)
level: float = float(np.abs(sound.samples).max()) * float(frequencies[0])
try:
    carom.render([(0.0, "/object/new", "a", "wood-block")], seconds=1).save("x.wav")
except (carom.ScoreError, carom.RenderError, carom.PresetError, carom.CommandError) as error:
    print(error, carom.__version__, sound.report.limited_db)
reveal_type(carom.Client)
carom.Scene(rate="fast")
bar.impact(1.0, strikr="yarn")
bar.roll(speed=0.3, friction=np.float64(0.2), travel="far")
scene.new("pane", "glass-plate", thicknes=0.002)
scene.new("bowl", "ceramic-bowl", densty=3)
bar.damp(0.5, ovr=0.1)
scene.room(3, 3, 3, absorbtion=0.3)
scene.steer("ball", speeed=0.3)
bar.sensor("tip", presett="mems")
with carom.World() as world:
    world.body("ball", "sphere", 0.02, "steel", densty=3)
    world.pair("ball", "ball", surfce="wood")
carom.Client().new("pane", "glass-plate", densty=3)
carom.render_mny
reveal_type(carom.mujoco.Bridge)
"""


def test_importing_it_loads_nothing_else():
    code = "import sys; before = set(sys.modules); import carom; print(*(set(sys.modules) - before))"
    loaded = subprocess.check_output([sys.executable, "-c", code], text=True).split()
    assert {name.partition(".")[0] for name in loaded} <= {"carom", *sys.stdlib_module_names}
    assert "carom.clients" not in loaded


def test_a_name_that_it_lacks_is_an_attribute_error():
    with pytest.raises(AttributeError, match="module 'carom' has no attribute 'Scenery'"):
        carom.Scenery  # noqa: B018


def test_help_lists_every_public_name():
    page = pydoc.plain(pydoc.render_doc(carom)).replace(" (package)", "")  # as the installed package says
    assert 'plate = scene.new("plate", "steel-plate"' in page
    functions = ("compare", "fit", "mesh", "rebuild", "render", "render_many")
    for name in carom.__all__:
        assert name in dir(carom) and hasattr(carom, name)
        listed = {"dsp": "\n    dsp\n", "__version__": "VERSION\n"}.get(name, f"    class {name}(")
        assert (f"    {name}(" if name in functions else listed) in page


def test_methods_list_their_keys_from_the_registry():
    assert "friction : 0 to 10, default 0" in pydoc.plain(pydoc.render_doc(carom.Scene.roll))


def test_python_m_carom_is_the_command(carom):
    assert carom("--version", check=True).stdout.startswith("carom ")


@pytest.mark.slow
def test_user_code_type_checks_against_the_wheel(tmp_path):
    (tmp_path / "user.py").write_text(USER)
    (tmp_path / "build.cfg").write_text(f"[build]\nbuild_base = {tmp_path / 'build'}\n")
    run = [sys.executable, "-m"]
    wheel = [*run, "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation", "--wheel-dir", str(tmp_path), "."]
    built = os.environ | {"DIST_EXTRA_CONFIG": str(tmp_path / "build.cfg"), "CAROM_WHEEL": "source"}
    subprocess.run(wheel, cwd=ROOT, env=built, check=True)
    (file,) = tmp_path.glob("*.whl")
    subprocess.run([*run, "zipfile", "-e", str(file), str(tmp_path / "site")], check=True)
    mypy = [*run, "mypy", "--strict", "--config-file=", "--follow-imports=silent", "user.py"]
    env = os.environ | {"MYPYPATH": "site"}
    checked = subprocess.run(mypy, cwd=tmp_path, env=env, capture_output=True, text=True)
    lines = [line for line in checked.stdout.splitlines() if " defined in " not in line]
    unknown = ("thicknes", "densty", "ovr", "absorbtion", "speeed", "presett", "densty", "surfce", "densty")
    assert len(lines) == 7 + len(unknown), checked.stdout
    assert 'Revealed type is "def (host: str' in lines[0] and lines[0].endswith('-> carom.clients.client.Client"')
    assert 'Argument "rate" to "Scene" has incompatible type "str"; expected "int"' in lines[1]
    assert 'Unexpected keyword argument "strikr"' in lines[2] and 'did you mean "striker"?' in lines[2]
    assert 'Argument "travel"' in lines[3] and 'expected "SupportsFloat"' in lines[3]
    for line, key in zip(lines[4:], unknown, strict=False):
        assert f'Unexpected keyword argument "{key}"' in line
    assert 'did you mean "thickness"?' in lines[4] and 'did you mean "density"?' in lines[10]
    assert 'has no attribute "render_mny"' in lines[13] and lines[14].endswith('-> carom.mujoco.Bridge"')
