"""Wrong usage, as it happens: one line that names the culprit and, where there is a near one, the right word."""

import signal
from collections.abc import Iterator

import pytest

import carom
from carom.clients.cli import main

GOOD = "0 /object/new block wood-block\n0 /object/block/roll 0.1 striker glass-marble id marble\n"

COMMANDS = [
    # what is typed, what the line names, what it asks for or expects
    ("", "no command", "expected one of serve, render, strike"),
    ("rendre s.txt x.wav", "rendre: no such command", "did you mean render?"),
    ("lisen", "lisen: no such command", "did you mean listen?"),
    ("--verison", "--verison: no such option", "did you mean --version?"),
    ("xyz", "xyz: no such command", "expected one of serve, render"),
    ("render", "SCORE, OUT", "usage: carom render [options] SCORE [SCORE ...] OUT"),
    ("render s.txt", "OUT", "usage: carom render [options]"),
    ("render --fromat 24 s.txt x.wav", "--fromat: no such option", "did you mean --format?"),
    ("render s.txt x.wav --zzz", "--zzz: no such option", "expected -h, --help, --jobs, --rate"),
    ("render s.txt x.wav --rate", "--rate", "expected one argument"),
    ("render s.txt x.wav --rate fast", "--rate: 'fast'", "expected a whole number"),
    ("render s.txt x.wav --rate 5", "rate = 5", "expected 8000 to 192000 Hz"),
    ("render s.txt x.wav --format 17", "--format: '17'", "expected one of 16, 24, float"),
    ("render s.txt x.wav --format flaot", "--format: 'flaot'", "did you mean float?"),
    ("render s.txt x.flac --format float", "format = float", "FLAC holds 16 or 24"),
    ("render s.txt x.wav --seconds soon", "--seconds: 'soon'", "expected a number"),
    ("render s.txt x.wav --seconds -1e0", "seconds = -1", "expected at least a frame"),
    ("render s.tx x.wav", "s.tx: No such file", "did you mean s.txt?"),
    ("render dmo x.wav", "no score 'dmo'", "did you mean demo?"),
    ("render empt x.wav", "no score 'empt'", "did you mean empty.txt?"),
    ("render cannon x.wav", "no score 'cannon'", "expected a file, or one of ball-bearing, bell"),
    ("render far-off.txt x.wav", "far-off.txt: No such file", ""),
    ("render s.txt x.mp3", "x.mp3", "expected a name that ends in .wav or .flac"),
    ("render s.txt no/x.wav", "no/x.wav", "there is no folder no"),
    ("render s.txt x.wav --plot x.bmp", "x.bmp", "expected a name that ends in .png, .svg or .pdf"),
    ("render s.txt x.wav --presets nowhere", "nowhere", "expected a folder with objects, strikers"),
    *(
        (f"{command} {option} heun", f"{option}: no such option", "the sampled methods are in `carom chart`")
        for command in ("serve", "render s.txt x.wav")
        for option in ("--contact", "--correction", "--oversampling")
    ),
    ("render s.txt x.wav --normalize loud", "--normalize: 'loud'", "expected a number"),
    ("render --normalize s.tx x.wav", "s.tx: No such file", "did you mean s.txt?"),
    ("render x.wav y.wav", "x.wav: it is a sound", "expected a score"),
    ("render s.txt x.wav --stems empty.txt", "empty.txt", "expected a folder"),
    ("render s.txt s.txt x.wav", "OUT = x.wav", "expected a folder, or a name with {}"),
    ("render s.txt s.txt {}.wav --jobs 0", "s.txt", "rename one of the two"),
    ("render empty.txt x.wav", "the score is empty", "expected lines of time, address and arguments"),
    ("strike church-bel", "no object 'church-bel'", "did you mean church-bell?"),
    ("strike bell x.wav", "no object 'bell'", "did you mean church-bell or tubular-bell?"),
    ("strike wood-block x.wav --striker wod", "no striker 'wod'", "did you mean wood?"),
    ("strike wood-block x.wav --velocity -1", "velocity = -1", "expected a number from 0 to 1000 m/s"),
    ("strike wood-block x.wav --velocity 0", "velocity = 0: nothing would sound", "expected more than 0 m/s"),
    ("strike cannon", "no object 'cannon'", "expected one of aluminium-pipe, bass-string"),
    ("strike wood-block x.wav --position 2", "position = 2", "expected a number from 0 to 1"),
    ("strike wood-block x.wav y.wav", "y.wav: one argument too many", "usage: carom strike"),
    ("presets striker", "no preset 'striker'", "did you mean strikers?"),
    ("presets objects cannon", "objects", "expected names of presets, or kinds alone"),
    ("presets cannon", "no preset 'cannon'", "or one of objects, strikers, surfaces, materials"),
    ("dataset wrlds x", "no recipe 'wrlds'", "did you mean worlds?"),
    ("presets stel", "no preset 'stel'", "did you mean steel?"),
    ("presets --chek x.toml", "--chek: no such option", "did you mean --check?"),
    ("presets --check x.tml", "x.tml: No such file", "did you mean x.toml?"),
    ("presets --check x.toml", "x.toml: [geometry] lenght = 0.3", "did you mean length?"),
    ("presets --check", "--check", "expected one or more"),
    ("completion bsh", "'bsh'", "did you mean bash?"),
    ("send", "required: ADDRESS (", "usage: carom send [options] ADDRESS [ARG ...]"),
    ("send object/block/impact --port 9", "object/block/impact", "expected it to start with /"),
    ("send /status --host no.invalid", "no.invalid:57140: ", ""),
    ("send --prot 9 /status", "--prot: no such option", "did you mean --port?"),
    ("send /status --port 99999", "--port: 99999", "expected 1 to 65535"),
    ("send /object/block/gain -x", "-x: no such option", "-- before an argument that begins with -"),
    ("send /status --port 9", "127.0.0.1:9", "expected a running `carom serve`"),
    ("play s.tx", "s.tx: No such file", "did you mean s.txt?"),
    ("listen --port 9", "127.0.0.1:9", "expected a running `carom serve`"),
    ("top now", "now: one argument too many", "usage: carom top"),
    ("serve --devcie none", "--devcie: no such option", "did you mean --device?"),
    ("serve --port 70000", "port = 70000", "expected 0 to 65535"),
    ("serve --rate 1", "rate = 1", "expected 8000 to 192000"),
    ("serve --latency 9", "latency = 9", "expected 0 to 2 s"),
    ("serve --log -", "--log: -", "expected the name of a file"),
    ("serve --log no/log.txt --device none --port 0", "no/log.txt", "No such file"),
    ("chart", "FOLDER", "usage: carom chart [options] FOLDER"),
    ("chart s.txt", "s.txt", "expected a folder, and a file is there"),
]

LINES = [
    # a score's line, what the error names, what it asks for or expects
    ("0 /object/nwe a wood-block", "/object/nwe: no such address", "did you mean /object/new?"),
    ("0 /objct/block/impact 1", "/objct/block/impact: no such address", "did you mean /object/block/impact?"),
    ("0 /block/impact 1", "/block/impact: no such address", "did you mean /object/block/impact?"),
    ("0 /object/block/impcat 1", "/object/block/impcat: no such address", "did you mean /object/block/impact?"),
    ("0 /object/block/kick 1", "unknown action 'kick'", "expected impact, bounce, roll"),
    ("0 /object/marble/stop", "/object/marble/stop: no such address", "did you mean /gesture/marble/stop?"),
    ("0 /acuracy -80", "/acuracy: no such address", "did you mean /accuracy?"),
    ("0 object/block/impact 1", "'object/block/impact'", "expected it to start with /"),
    ("0 /object/new pan", "preset is missing", "expected /object/new name preset"),
    ("0 /object/new block wood-block", "name = block", "free it first"),
    ("0 /object/new pan iron-pna", "no object 'iron-pna'", "did you mean iron-pan?"),
    ("0 /object/new b wood-block lenght 0.2", "lenght = 0.2", "did you mean length?"),
    ("0 /object/new b wood-block length long", "length = 'long'", "expected a number from 0.001 to 20 m"),
    ("0 /object/new b wood-block material wod", "material = 'wod'", "did you mean wood?"),
    ("0 /object/blok/impact 1", "blok: no such object", "did you mean block?"),
    ("0 /object/zzz/impact 1", "zzz: no such object", "there is block"),
    ("0 /object/block/press", "force is missing", "expected /object/NAME/press [force] [position]"),
    ("0 /object/block/impact fast", "velocity = fast", "expected a number from 0 to 1000 m/s"),
    ("0 /object/block/impact 1 2", "position = 2", "expected a number from 0 to 1"),
    ("0 /object/block/impact 1 strikr wood", "strikr: no such key", "did you mean striker?"),
    ("0 /object/block/impact 1 striker wod", "no striker 'wod'", "did you mean wood?"),
    ("0 /object/block/impact 1 by blok", "by = blok", "expected another object"),
    ("0 /object/block/roll 1 striker glass-marble surface icee", "no surface 'icee'", "did you mean ice?"),
    ("0 /gesture/marbel/stop", "marbel: no such gesture is running", "did you mean marble?"),
    ("0 /gesture/marble/sped 1", "/gesture/marble/sped: no such address", "did you mean /gesture/marble/speed?"),
    ("0 /accuracy exac", "accuracy = exac", "did you mean exact?"),
    ("0 /quality 9", "quality = 9", "expected a number from 0 to 8"),
    ("0 /contact heun 2 correction both", "/contact", "the sampled methods are in `carom chart`"),
    ("0 /status", "/status: server-only message", "not allowed in a score"),
    ("soon /panic", "time 'soon'", "expected seconds from 0"),
    ("-1 /panic", "time -1", "expected seconds from 0"),
    ("0", "no address after the time", ""),
    ('0 /object/new "b wood-block', "a quote that is not closed", "column"),
]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Iterator[None]:
    """A folder with a good score, an empty one and a wrong preset. Signals do afterwards what they did."""
    handlers = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    monkeypatch.chdir(tmp_path)
    (tmp_path / "s.txt").write_text(GOOD)
    (tmp_path / "empty.txt").write_text("")
    (tmp_path / "x.wav").write_bytes(b"RIFF" + bytes(40))
    text = (carom.presets.BUILT_IN / "objects" / "xylophone-bar.toml").read_text()
    (tmp_path / "x.toml").write_text(text.replace("[geometry]", "[geometry]\nlenght = 0.3"))
    yield
    for each, handler in handlers.items():
        signal.signal(each, handler)


def told(words: list[str], capsys) -> str:
    """Return the line that a command ends with."""
    try:
        code = main(words)
    except SystemExit as end:
        code = end.code
    out, errors = capsys.readouterr()
    assert code in (1, 2) and out == "" and errors.count("\n") == 1, errors
    return errors


@pytest.mark.slow
@pytest.mark.parametrize(("words", "culprit", "right"), COMMANDS, ids=[words for words, _, _ in COMMANDS])
def test_a_wrong_command_is_told_in_one_line(folder, capsys, words, culprit, right):
    line = told(words.split(), capsys)
    assert culprit in line and right in line
    assert line.startswith(("carom: ", f"carom {words.split(' ')[0]}: "))


@pytest.mark.slow
@pytest.mark.parametrize(("line", "culprit", "right"), LINES, ids=[line for line, _, _ in LINES])
def test_a_wrong_line_of_a_score_is_told_in_one_line(folder, tmp_path, capsys, line, culprit, right):
    (tmp_path / "s.txt").write_text(GOOD + line + "\n")
    error = told(["render", "s.txt", "x.wav"], capsys)
    assert error.startswith("carom render: s.txt:3: ") and culprit in error and right in error
    assert not list(tmp_path.glob("x.wav.*"))


@pytest.mark.parametrize(
    ("call", "error", "right"),
    [
        (lambda: carom.Scnee, AttributeError, "did you mean Scene?"),
        (lambda: carom.Presets().names("object"), ValueError, "did you mean objects?"),
        (lambda: carom.Presets().object("cymbl"), carom.PresetError, "did you mean cymbal?"),
        (lambda: carom.Scene().new("b", "wood-block", lenght=1), carom.CommandError, "did you mean length?"),
        (lambda: carom.Scene(presets=5), carom.PresetError, "presets = 5: expected a folder"),
        (lambda: carom.Scene(presets=[5]), carom.PresetError, "5: expected a folder"),
        (lambda: carom.Scene(limiter="no"), carom.RenderError, "limiter = 'no': expected True or False"),
        (lambda: carom.Scene(channels="2"), carom.RenderError, "channels = '2': expected a number"),
        (lambda: carom.Scene().limiter("no"), carom.CommandError, "/limiter: on = 'no': expected True or False"),
        (lambda: carom.Scene().free("b", "no"), carom.CommandError, "at_once = 'no': expected True or False"),
        (lambda: carom.Scene().impact(1, 2, 3, 4, 5), TypeError, "impact(): 5: one argument without a name too many"),
        (lambda: carom.render(5), carom.ScoreError, "score = 5: expected a score's text"),
        (lambda: carom.render([5]), carom.ScoreError, "line 1: 5: expected a time"),
        (lambda: carom.Client(port="57140"), carom.CommandError, "port = '57140': expected 1 to 65535"),
        (lambda: carom.World("fast"), carom.WorldError, "rate = 'fast': expected a number from 1 to 1e+06 Hz"),
        (lambda: carom.World(hearing="all"), carom.WorldError, "hearing = 'all': expected a carom.Hearing"),
        (lambda: carom.World(listener="me"), carom.WorldError, "listener = 'me': expected a carom.Listener"),
        (lambda: carom.World(client="me"), carom.WorldError, "client = 'me': expected a carom.Client"),
        (
            lambda: carom.Hearing(faintest="0"),
            carom.WorldError,
            "faintest = '0': expected a number from -1000",
        ),
        (lambda: carom.Hearing([carom.Microphone("abc")]), carom.WorldError, "microphone 0: position = 'abc'"),
        (lambda: carom.Hearing([carom.Microphone((0, 0, 1), pattern="x")]), carom.WorldError, "pattern = 'x'"),
        (lambda: carom.Hearing([carom.Microphone((0, 0, 1), (0, 0, 0))]), carom.WorldError, "direction = (0, 0, 0)"),
        (lambda: carom.Scene().impact("b", 1), carom.CommandError, "there is none"),
        (lambda: carom.render("0 /panic\n1 /gain '\ud800'"), carom.ScoreError, "score:2: '\\ud800' is half"),
        (lambda: carom.render('1 /gain "\\ud800"'), carom.ScoreError, "score:1: "),
        (lambda: carom.render("strike.txt"), carom.ScoreError, "pathlib.Path('strike.txt')"),
    ],
)
def test_wrong_python_is_told_in_one_line(call, error, right):
    with pytest.raises(error) as caught:
        call()
    assert right in str(caught.value) and "\n" not in str(caught.value)
