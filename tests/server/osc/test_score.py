"""Scores: text that reads back as it was written, scsynth's binary form, and errors that say where."""

import math
import random
import struct
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from carom.server.osc import score, wire
from carom.server.osc.score import Line, ScoreError, sample_at
from carom.server.osc.wire import Message

# Written by sclang 3.13: Score([[0.0, ["/object/new", "bell", "church-bell"]],
# [0.5, ["/object/bell/impact", 1.0]], [1.25, [\panic]]]).writeOSCFile(...), without the group it puts first.
SCLANG = (
    b"\0\0\x008#bundle\0\0\0\0\0\0\0\0\0\0\0\0$/object/new\0,ss\0bell\0\0\0\0church-bell\0"
    b"\0\0\x000#bundle\0\0\0\0\0\x80\0\0\0\0\0\0\x1c/object/bell/impact\0,f\0\0?\x80\0\0"
    b"\0\0\0 #bundle\0\0\0\0\1@\0\0\0\0\0\0\x0c/panic\0\0,\0\0\0"
)


def written(folder: Path, data: bytes | str) -> Path:
    path = folder / "score"
    path.write_bytes(data if isinstance(data, bytes) else data.encode())
    return path


def test_text(tmp_path: Path) -> None:
    path = written(
        tmp_path,
        "\ufeff# a scene\r\n"
        "\n"
        "0 /object/new bell church-bell  # its name and preset\n"
        "  .5\t/object/bell/impact 1 -2. +3e-2 '4' \"5\" hit felt#1 # hard\n"
        """1e1 /b "a \\"b\\" \\n\\u00e9" 'c "d" \\' '' "\t" -7\n"""
        "0.25 '/object/*/damp' 1",
    )
    assert score.read(path) == [
        Line(0.0, Message("/object/new", ("bell", "church-bell")), f"{path}:3"),
        Line(0.5, Message("/object/bell/impact", (1, -2.0, 0.03, "4", "5", "hit", "felt#1")), f"{path}:4"),
        Line(10.0, Message("/b", ('a "b" \n\xe9', 'c "d" \\', "", "\t", -7)), f"{path}:5"),
        Line(0.25, Message("/object/*/damp", (1,)), f"{path}:6"),
    ]
    assert [type(arg) for arg in score.read(path)[1].message.args] == [int, float, float, str, str, str, str]


@pytest.mark.parametrize(
    "word",
    ["nan", "inf", "Infinity", "1_000", "0x10", "-", "+", ".", "1.2.3", "1e", "1e+", "\u0661", "f#1"],
)
def test_words_that_are_no_numbers(tmp_path: Path, word: str) -> None:
    (line,) = score.read(written(tmp_path, f"0 /a {word}"))
    assert line.message.args == (word,)


@pytest.mark.parametrize(
    ("text", "items"),
    [
        ("[free clamped free clamped]", ("free", "clamped", "free", "clamped")),
        ("[free,clamped, free ,clamped]", ("free", "clamped", "free", "clamped")),
        ("[440 881.5, 1e3]", (440, 881.5, 1000.0)),
        ("[ 440\t881.5, ]", (440, 881.5)),
        ("[]", ()),
        ("[ , ]", ()),
        ("[7]", (7,)),
        ("""["a b" 'c]',"d,", '1']""", ("a b", "c]", "d,", "1")),
        ("[[1 2][3,4] [] a]", ((1, 2), (3, 4), (), "a")),
        ("[f#1 a-b]", ("f#1", "a-b")),
        ("[" * 8 + "]" * 8, ((((((((),),),),),),),)),
    ],
)
def test_lists(tmp_path: Path, text: str, items: wire.Argument) -> None:
    (line,) = score.read(written(tmp_path, f"0 /a edges {text} 2 # end"))
    assert repr(line.message.args) == repr(("edges", items, 2))
    assert score.value(text) == items


@pytest.mark.parametrize("text", ["[1", "[1]x", "[1] 2", "[", "]", "[a # b]", "[" * 9 + "]" * 9, "a[1]", "a]", ""])
def test_texts_that_are_no_list(text: str) -> None:
    assert score.value(text) == text


def test_line_ends_of_every_system(tmp_path: Path) -> None:
    lines = score.read(written(tmp_path, "0 /a\r\n1 /b\r2 /c\n3 /d '\N{LINE SEPARATOR}'"))
    assert [line.message.address for line in lines] == ["/a", "/b", "/c", "/d"]


def test_empty(tmp_path: Path) -> None:
    assert score.read(written(tmp_path, "")) == []
    assert score.read(written(tmp_path, "# nothing\n")) == []


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("-1 /a", 1, "time -1: expected seconds from 0 to 2678400"),
        ("0,5 /a", 1, "time '0,5': expected seconds from 0 to 2678400, with a decimal point"),
        ("0 /a\n\n-0.5 /a", 3, "time -0.5"),
        ("nan /a", 1, "time 'nan'"),
        ("inf /a", 1, "time 'inf'"),
        ("1e400 /a", 1, "time '1e400': expected seconds"),
        ("9" * 400 + " /a", 1, "expected seconds from 0 to 2678400"),
        ("'0' /a", 1, "time '0'"),
        ("/a 1", 1, "time '/a'"),
        ("0", 1, "no address"),
        ("0 # /a", 1, "no address"),
        ("0 a", 1, "address 'a'"),
        ("0 5 /a", 1, "address 5"),
        ("0 ''", 1, "address ''"),
        ("0 /a 'b", 1, "column 5: a quote"),
        ('0 /a "b', 1, "column 5: a quote"),
        ('0 /a "b\\"', 1, "column 5: a quote"),
        ("0 /a it's", 1, "column 5: a quote"),
        ("0 /a 'b'c", 1, "column 5: a quote"),
        ('0 /a "\\q"', 1, "escape"),
        ('0 /a "\\u0000"', 1, "zero character"),
        ('0 /a "\\ud800"', 1, "cannot send"),
        ("0 /a 9223372036854775808", 1, "cannot send"),
        ("0 /a [1 9223372036854775808]", 1, "cannot send"),
        ("0 /a [free clamped", 1, "column 6: a list that is not closed"),
        ("0 /a [free # clamped]", 1, "column 6: a list that is not closed"),
        ("0 /a [free]clamped", 1, "column 12: expected a blank after a list"),
        ("0 /a ]", 1, "] that is not between blanks"),
        ("0 /a " + "[" * 9 + "]" * 9, 1, "column 14: lists nested deeper than 8"),
        ("0 [/a]", 1, "address ('/a',): expected"),
        ("[0] /a", 1, "time (0,): expected"),
        ("0 /a " + "9" * 5000, 1, "4300"),
    ],
)
def test_errors_say_where(tmp_path: Path, text: str, line: int, reason: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ScoreError) as refused:
        score.read(path)
    assert str(refused.value).startswith(f"{path}:{line}: ")
    assert reason in str(refused.value)


def test_not_utf8(tmp_path: Path) -> None:
    path = written(tmp_path, b"0 /a\n1 /b caf\xe9\n")
    with pytest.raises(ScoreError, match=r":2: byte 0xe9 is not UTF-8"):
        score.read(path)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        score.read(tmp_path / "none")


@pytest.mark.parametrize(
    "word",
    [
        "1" * 50_000 + ".x",
        "a" * 50_000 + "'",
        "'" + '"' * 50_000,
        '"' + "\\" * 50_000,
        "[" * 50_000,
        "[" + "1 " * 25_000,
        "[" + "[]," * 20_000,
    ],
)
def test_long_lines_take_no_time(tmp_path: Path, word: str) -> None:
    start = time.process_time()
    with pytest.raises(ScoreError):
        score.read(written(tmp_path, f"-1 /a {word}"))
    assert time.process_time() - start < 1.0


def test_binary(tmp_path: Path) -> None:
    path = written(tmp_path, SCLANG)
    assert score.read(path) == [
        Line(0.0, Message("/object/new", ("bell", "church-bell")), f"{path}:1"),
        Line(0.5, Message("/object/bell/impact", (1.0,)), f"{path}:2"),
        Line(1.25, Message("/panic"), f"{path}:3"),
    ]


def test_binary_at_once_is_the_start(tmp_path: Path) -> None:
    packet = wire.encode_bundle(wire.IMMEDIATELY, [Message("/a")])
    (line,) = score.read(written(tmp_path, struct.pack(">i", len(packet)) + packet))
    assert line.time == 0.0


def test_binary_cut_anywhere(tmp_path: Path) -> None:
    ends = {60: 1, 112: 2}  # after the first and the second packet
    for size in range(1, len(SCLANG)):
        path = written(tmp_path, SCLANG[:size])
        if size in ends:
            assert len(score.read(path)) == ends[size]
        else:
            number = 1 + sum(size > end for end in ends)
            with pytest.raises(ScoreError, match=f":{number}: the file ends inside the packet"):
                score.read(path)


def test_binary_bad_packet(tmp_path: Path) -> None:
    with pytest.raises(ScoreError, match=":1: bundle element of -4 bytes"):
        score.read(written(tmp_path, b"\0\0\0\x14#bundle\0\0\0\0\0\0\0\0\0\xff\xff\xff\xfc"))


@pytest.mark.slow
@given(st.binary(max_size=60), st.sampled_from([b"", b"0 /a ", b"\0\0\0\x14", SCLANG]))
def test_random_bytes(tmp_path_factory: pytest.TempPathFactory, tail: bytes, head: bytes) -> None:
    path = written(tmp_path_factory.getbasetemp(), head + tail)
    try:
        lines = score.read(path)
    except ScoreError:
        return
    assert all(0 <= line.time < math.inf and line.message.address.startswith("/") for line in lines)


texts = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=9)
scalars = st.one_of(
    st.integers(-(2**63), 2**63 - 1),
    st.floats(allow_nan=False, allow_infinity=False),
    texts,
    st.text("0123456789.eE+-'\"#\\ \n/[],", max_size=9),
    st.booleans(),
)
arguments = scalars | st.recursive(scalars, lambda items: st.lists(items, max_size=4).map(tuple), max_leaves=8)
messages = st.builds(Message, texts.map("/".__add__), st.lists(arguments, max_size=6).map(tuple))


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0, 86_400), messages), max_size=4))
def test_score_reads_as_written(tmp_path_factory: pytest.TempPathFactory, events: list[tuple[float, Message]]) -> None:
    text = "".join(score.format_line(at, message) + "\n" for at, message in events)
    lines = score.read(written(tmp_path_factory.getbasetemp(), text))
    assert [(line.time, line.message) for line in lines] == events
    for line, (_, message) in zip(lines, events, strict=True):
        for read, sent in zip(line.message.args, message.args, strict=True):
            assert repr(read) == repr(as_numbers(sent))  # -0.0, and 1 is not 1.0


def as_numbers(sent: wire.Argument) -> wire.Argument:
    if isinstance(sent, tuple):
        return tuple(map(as_numbers, sent))
    return int(sent) if isinstance(sent, bool) else sent


def test_lines_are_plain_where_they_can_be() -> None:
    message = Message("/object/bell/impact", (1, 0.1, "striker", "felt-2", "1", "", "a é", True))
    assert score.format_line(2, message) == '2.0 /object/bell/impact 1 0.1 striker felt-2 "1" "" "a é" 1'


@pytest.mark.parametrize("value", [b"x", None, math.nan, math.inf, (1, (math.inf,)), (None,)])
def test_values_that_text_has_no_word_for_are_refused(value: wire.Argument) -> None:
    with pytest.raises(ValueError, match="cannot stand in a score"):
        score.format_line(0.0, Message("/a", (value,)))


@pytest.mark.parametrize("moment", [-1.0, math.nan, math.inf])
def test_times_that_are_none(moment: float) -> None:
    with pytest.raises(ValueError, match="expected seconds from 0 to 2678400"):
        score.format_line(moment, Message("/a"))


@pytest.mark.parametrize("rate", [8_000, 44_100, 48_000, 192_000])
def test_seconds_name_every_sample_that_the_engine_lets_live_events_fall_on(rate):
    rng = random.Random(3)
    for _ in range(5_000):
        sample = rng.randrange(31 * 86_400 * rate * 256) / 256
        assert sample_at(float(repr(sample / rate)), rate) == sample
        whole = rng.randrange(10**6) * 64
        assert sample_at(whole / rate, rate) == whole
    assert sample_at(0.1234567, 48_000) == 0.1234567 * 48_000  # other times stay as they are


@pytest.mark.slow
def test_long_scores_are_read_in_a_fraction_of_a_minute():
    """Two million lines in a minute, and as many again as the machine may be slow."""
    text = "".join(f"{n * 5e-4:.4f} /object/x/impact {0.1 + n % 7}\n" for n in range(50_000)).encode()
    begun = time.process_time()
    lines = score.parse(text, "score")
    assert len(lines) == 50_000 and (time.process_time() - begun) * 40 < 60.0


@given(st.text(st.sampled_from("01.eE+-ax/ \t\u2003\x1f#[]'\""), max_size=12))
def test_lines_with_and_without_signs_are_read_alike(text):
    """A line that has no quote, list or comment is split at its blanks: as if it had a comment."""
    if not set(text) & set("#[]'\""):
        assert score._words(text) == score._words(f"{text} # so")


@pytest.mark.parametrize("mark", [wire.encode("/c_set", 0, 0), wire.encode("/none"), b"\0\0\0\0,\0\0\0"])
def test_an_end_mark_of_SuperCollider_is_the_length(tmp_path: Path, mark: bytes) -> None:
    strike = wire.encode("/object/a/impact", 1.0)
    packets = [b"#bundle\0" + struct.pack(">II", second, 1 << 30) + struct.pack(">i", len(each)) + each
               for second, each in ((0, strike), (1, mark))]  # fmt: skip
    (tmp_path / "a.osc").write_bytes(b"".join(struct.pack(">i", len(each)) + each for each in packets))
    lines = score.read(tmp_path / "a.osc")
    assert [(line.time, line.message.address) for line in lines] == [(0.25, "/object/a/impact"), (1.25, "/end")]


def test_only_the_last_end_mark_of_SuperCollider_with_nothing_later_is_the_length(tmp_path: Path) -> None:
    """A mark amid a score does nothing, as in scsynth; one may share its bundle with the last message."""
    strike, mark = wire.Message("/object/a/impact", (1.0,)), wire.Message("/c_set", (0, 0))

    def read(*bundles: tuple[int, list[wire.Message]]) -> list[tuple[float, str]]:
        packets = [wire.encode_bundle((second << 32) + 2, messages) for second, messages in bundles]
        (tmp_path / "a.osc").write_bytes(b"".join(struct.pack(">i", len(each)) + each for each in packets))
        return [(round(line.time, 6), line.message.address) for line in score.read(tmp_path / "a.osc")]

    hits = [(0.0, strike.address), (2.0, strike.address)]
    assert read((0, [strike]), (1, [mark]), (2, [strike])) == hits
    assert read((0, [strike]), (1, [mark]), (2, [strike]), (3, [mark])) == [*hits, (3.0, "/end")]
    assert read((0, [strike]), (2, [strike, mark])) == [*hits, (2.0, "/end")]
