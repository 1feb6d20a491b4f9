"""The pages as a web site: `python -m tests.documents.site` builds it in build/site, with players and the demo.

Each link to a sound becomes a player, and each score that a page shows gets one, rendered by Carom itself.
"""

import hashlib
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import soundfile

import carom
from tests.documents.pages import PAGES, ROOT

BUILD = ROOT / "build"
STAGED, FILES, SITE, SOUNDS, DEMO = (
    BUILD / name for name in ("site-pages", "site-files", "site", "site-sounds", "site-demo")
)
RATE, LONGEST = 44_100, 12.0  # Hz; s of a score's sound
OTHERS = ("CHANGELOG.md", "SECURITY.md", "clients/examples/README.md")
_GESTURES = ("impact", "bounce", "roll", "slide", "spin", "press", "rest", "rain", "pour", "shake", "crumple", "step",
             "shatter")  # fmt: skip
_THEORY = (
    "rolling",
    "friction",
    "plates",
    "radiation",
    "rests",
    "swarms",
    "breaking",
    "space",
    "simulators",
    "fits",
    "meshes",
    "compiled",
)
NAVIGATION = {
    "Play": ("clients/tutorial", "server/gestures", *(f"server/gestures/{each}" for each in _GESTURES), "server/space",
             "server/midi", "server/macros", "server/sensors", "clients/index", "server/unattended"),
    "Presets": ("presets/index", "presets/built-in", "presets/meshes", "presets/shapes", "presets/object-keys",
                "presets/other-keys", "presets/levels"),
    "Program": ("clients/python", "clients/simulators", "clients/grains", "clients/knocking", "clients/data",
                "clients/export", "clients/examples/index"),
    "Reference": ("server/index", "server/addresses", "server/replies", "server/simulations", "server/accuracy",
                  "clients/command-line", "clients/more-commands"),
    "Theory": ("dsp/index", *(f"dsp/{each}" for each in _THEORY)),
    "Reports": ("tests/index", *(f"tests/{each}" for each in ("speed", "methods", "yielding", "swarms", "meshes"))),
    "Project": ("CHANGELOG", "CONTRIBUTING", "SECURITY"),
}  # fmt: skip
"""The pages of the side bar, by their parts."""

_LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]*)(#[^)\s]*)?\)")
_SCORE = re.compile(r"^```score\n(.*?)^```\n", re.MULTILINE | re.DOTALL)


def audio(source: str) -> str:
    """Return a player."""
    return f'<audio controls preload="none" src="{source}" style="height:2em;vertical-align:middle"></audio>'


def sound_of(score: str) -> Path:
    """Return the sound of a score, rendered unless that was done before."""
    path = SOUNDS / f"{hashlib.sha256(score.encode()).hexdigest()[:16]}.ogg"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        samples = carom.render(score, rate=RATE, seconds=LONGEST).samples
        heard = np.flatnonzero(np.abs(samples).max(axis=1) > 1e-3 * np.abs(samples).max())
        samples = samples[: heard[-1] + 1 if len(heard) else 1]
        soundfile.write(path, samples, RATE, format="OGG", subtype="VORBIS")
    return path


def staged(page: str) -> str:
    """Return the name of a page in the site: READMEs are the first pages of their folders."""
    return page.replace("README.md", "index.md")


def converted(page: str, text: str) -> str:
    """Return a page for the site, and put what it links to beside it."""
    folder = Path(page).parent

    def link(found: re.Match[str]) -> str:
        bang, words, target, anchor = found[1], found[2], found[3], found[4] or ""
        if not target or target.startswith("http"):
            return found[0]
        path = (ROOT / folder / target).resolve()
        name = path.relative_to(ROOT).as_posix()
        if path.suffix == ".ogg":
            _put(name)
            return f"{words} {audio(target)}"
        if path.is_dir():
            return f"{words} (`{name}`)"
        if path.suffix != ".md":
            _put(name)
        return f"{bang}[{words}]({staged(target)}{anchor})"

    def score(found: re.Match[str]) -> str:
        sound = sound_of(found[1])
        _put(f"sounds/{sound.name}", sound)
        depth = "../" * (len(Path(page).parts) - 1)
        listens = text[found.end() :].lstrip().startswith("[Listen]")
        player = "" if listens else f"\n{audio(f'{depth}sounds/{sound.name}')}\n"
        return f"```text\n{found[1]}```\n{player}"

    text = _SCORE.sub(score, text).replace("```recipe\n", "```toml\n")
    text = re.sub(r"^Listen (<audio .*?</audio>)\.? ?", r"\1\n\n", _LINK.sub(link, text), flags=re.MULTILINE)
    return re.sub(r"</audio>[,.](?:\s(?=\S))?", "</audio><br>", text)  # sounds in a sentence: a line for each


def _put(name: str, source: Path | None = None) -> None:
    """Put a file beside the pages: what is played, and what is linked to."""
    for folder in (FILES, STAGED):
        target = folder / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source or ROOT / name, target)


def stage() -> None:
    """Write the pages of the site."""
    for folder in (STAGED, FILES):
        shutil.rmtree(folder, ignore_errors=True)
    for page in dict.fromkeys((*PAGES, *OTHERS)):
        target = STAGED / staged(page)
        target.parent.mkdir(parents=True, exist_ok=True)
        text = converted(page, (ROOT / page).read_text(encoding="utf-8"))
        target.write_text(text + _front() if page == "README.md" else text, encoding="utf-8")


def _front() -> str:
    """Return the end of the first page: the demo, and the table of contents for the side bar."""
    demo = '<iframe src="demo/index.html" allow="autoplay; midi" width="100%" height="560"></iframe>'
    trees = (
        f"```{{toctree}}\n:hidden:\n:caption: {title}\n\n" + "\n".join(names) + "\n```"
        for title, names in NAVIGATION.items()
    )
    return "\n\n".join(["\n## Try it", demo, *trees])


def export_demo() -> None:
    """Export the demo, for the first page; kept while its score is the same."""
    score, mark = ROOT / "presets" / "scores" / "demo.txt", DEMO / ".of"
    if not mark.exists() or mark.read_text() != score.read_text():
        subprocess.run([sys.executable, "-m", "carom", "export", "demo", DEMO], check=True)
        mark.write_text(score.read_text())
    shutil.copytree(DEMO, FILES / "demo", ignore=shutil.ignore_patterns(".of"))


def main() -> None:
    """Build the site."""
    stage()
    export_demo()
    settings = (
        "project=Carom", "extensions=myst_parser", "html_theme=furo", "html_title=Carom", "myst_heading_anchors=4",
        f"html_extra_path={FILES}", "html_copy_source=0", "html_show_sphinx=0",
        "html_show_copyright=0",
    )  # fmt: skip
    words = [word for each in settings for word in ("-D", each)]
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "-C", "-b", "html", *words, STAGED, SITE]
    subprocess.run(command, check=True)
    print(f"{SITE}/index.html")


if __name__ == "__main__":
    main()
