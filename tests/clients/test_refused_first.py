"""Commands refuse what cannot be before they compile the engine, which may take minutes at a first start."""

from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom.dsp.runtime import engine
from carom.server import compiling

BELL = "0 /object/new bell church-bell\n0 /object/bell/impact 1\n"
FILES = {
    "good.txt": BELL,
    "line.txt": "x /object/new bell church-bell\n",
    "preset.txt": "0 /object/new bell church-bel\n",
    "empty.txt": "# nothing\n",
    "good.stl": "solid\n",
    "bad.toml": "count = 2\n[object]\npreset = 'church-bel'\n[impact]\nvelocity = 1\n",
}

SERVE = "serve --port 0 --device none"
REFUSED = {
    "render nope.txt out.wav": "nope.txt: No such file",
    "render nope out.wav": "no score 'nope'",
    "render line.txt out.wav": "line.txt:1: time 'x'",
    "render empty.txt out.wav": "the score is empty",
    "render preset.txt out.wav": "preset.txt:1: /object/new: no object 'church-bel': did you mean church-bell",
    "render good.txt out.mp3": "out.mp3: expected a name that ends in .wav or .flac",
    "render good.txt nowhere/out.wav": "there is no folder nowhere",
    "render good.txt out.wav --plot out.bmp": "out.bmp: expected a name that ends in .png",
    "strike church-bell out.mp3": "out.mp3: expected a name that ends in .wav or .flac",
    "mesh good.stl mine --name cup --material steel": "good.stl",
    "mesh nope.stl mine --name cup --material steel": "nope.stl",
    "mesh good.stl mine --name cup --material stel": "no material 'stel': did you mean steel",
    "fit nope.wav mine --name bar": "nope.wav: No such file",
    "fit silence.wav good.txt --name bar": "good.txt: expected a folder",
    "render nope.txt line.txt out/": "line.txt:1: time 'x'",
    "dataset impacts good.txt": "good.txt: File exists",
    "dataset impacts .": "bad.toml is there: expected a new or empty folder",
    "dataset bad.toml new": "no object 'church-bel': did you mean church-bell",
    f"{SERVE} --record nowhere/out.wav": "nowhere/out.wav: No such file",
    f"{SERVE} --record out.flac": "out.flac: expected a name that ends in .wav",
    f"{SERVE} --log nowhere/out.txt": "nowhere/out.txt: No such file",
    f"{SERVE} --recordings good.txt": "good.txt: File exists",
    f"{SERVE} --oscquery 0 --record good.flac": "good.flac: expected a name that ends in .wav",
    f"{SERVE} --midi no-such-input": "midi",
    "page --port 0 --device none --page 0 --certificate nope.pem": "nope.pem: No such file",
    "serve --port 0 --device no-such-device": "device",
}


@pytest.fixture
def compiles_nothing(tmp_path, monkeypatch):
    """A folder of files, and an engine that may not be compiled."""

    def compiled():
        raise AssertionError("the engine was compiled")

    for name, text in FILES.items():
        Path(tmp_path, name).write_text(text)
    soundfile.write(tmp_path / "silence.wav", np.zeros(4800), 48_000)
    for module in (engine, compiling):
        monkeypatch.setattr(module, "prepare", compiled)


@pytest.mark.parametrize("words", REFUSED)
def test_bad_input_is_refused_before_the_engine_is_compiled(compiles_nothing, carom_here, words):
    done = carom_here(*words.split())
    assert done.returncode == 1 and REFUSED[words] in done.stderr


def test_a_line_after_the_end_of_a_render_refuses_nothing(tmp_path, carom_here):
    Path(tmp_path, "late.txt").write_text(BELL + "3 /object/new other church-bel\n")
    assert carom_here("render", "late.txt", "late.wav", "--seconds", "1").returncode == 0
    assert "no object" in carom_here("render", "late.txt", "late.wav").stderr
