"""The live server, as its clients and its machine meet it."""

import os
import shutil
import socket
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom.clients.client import Client, CommandError
from carom.server.net.network import RECEIVE_BUFFER, Network
from carom.server.osc import wire
from carom.server.osc.score import read
from tests.support import CAROM, Running, serving

EXAMPLES = Path(__file__).parents[2] / "clients" / "examples"


def onsets(path: Path) -> int:
    """Strikes in a recording: rises out of silence, by 20 ms."""
    sound, _ = soundfile.read(path)
    level = np.abs(sound).max(axis=1)
    blocks = level[: len(level) // 960 * 960].reshape(-1, 960).max(axis=1)
    loud = blocks > 1e-3
    return int((loud[1:] & ~loud[:-1]).sum())


def test_a_strike_is_heard_and_recorded(tmp_path):
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        with server.client() as client:
            client.new("a", "wood-block")
            for _ in range(3):
                client.impact("a", 1.0)
                time.sleep(0.4)
            status = client.status()
        code, errors = server.quit()
    assert (code, errors) == (0, "")
    assert onsets(tmp_path / "out.wav") == 3
    assert status.args[0] == 1 and status.args[3] == 1 and status.args[7] == 48_000
    assert status.args[8] == pytest.approx(48_000, rel=0.2)
    values = dict(zip(status.args[9::2], status.args[10::2], strict=True))
    assert values["impacts"] == 3 and values["contacts_dropped"] == 0


def client_programs() -> list[tuple[str, list[str]]]:
    return [
        ("oscsend", ["sh", str(EXAMPLES / "shell" / "strike.sh"), "PORT"]),
        ("pd", ["pd", "-nogui", "-noaudio", "-send", "port PORT", str(EXAMPLES / "puredata" / "strike.pd")]),
        ("sclang", ["sclang", str(EXAMPLES / "supercollider" / "strike.scd"), "PORT"]),
    ]


@pytest.mark.parametrize(("program", "words"), client_programs(), ids=lambda v: v if isinstance(v, str) else "")
def test_other_programs_strike(tmp_path, program, words):
    if not shutil.which(program):
        pytest.skip(f"{program} is not installed")
    # sclang brings a browser for its help, which needs a screen and refuses to be root.
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(tmp_path)}
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        words = [word.replace("PORT", str(server.port)) for word in words]
        subprocess.run(words, env=env, check=True, timeout=60, capture_output=True)
        time.sleep(0.5)
        with server.client() as client:
            status = client.status()
        assert server.quit()[0] == 0
    assert dict(zip(status.args[9::2], status.args[10::2], strict=True))["impacts"] >= 1
    assert onsets(tmp_path / "out.wav") >= 1


PD_HAND = """#N canvas 0 0 400 300 12;
#X obj 20 20 loadbang;
#X obj 20 50 delay 800;
#X msg 20 80 0.5;
#X obj 20 110 s speed;
#X obj 120 50 delay 1300;
#X msg 120 80 0.02;
#X obj 220 50 delay 2000;
#X msg 220 80 \\; pd quit;
#X connect 0 0 1 0;
#X connect 1 0 2 0;
#X connect 2 0 3 0;
#X connect 0 0 4 0;
#X connect 4 0 5 0;
#X connect 5 0 3 0;
#X connect 0 0 6 0;
#X connect 6 0 7 0;
"""


def test_a_slider_in_pd_rolls_a_marble(tmp_path):
    if not shutil.which("pd"):
        pytest.skip("pd is not installed")
    (tmp_path / "hand.pd").write_text(PD_HAND)
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        words = ["pd", "-nogui", "-noaudio", "-send", f"port {server.port}", str(EXAMPLES / "puredata" / "roll.pd")]
        subprocess.run([*words, "hand.pd"], cwd=tmp_path, check=True, timeout=30, capture_output=True)
        with server.client() as client:
            client.roll("pane", 0.0)
        assert server.quit()[0] == 0
    level = np.abs(soundfile.read(tmp_path / "out.wav")[0]).max(axis=1)
    start = int(np.argmax(level > 1e-3))
    fast, slow = level[start : start + 19_200].std(), level[start + 36_000 : start + 48_000].std()
    assert fast > 3 * slow > 0  # steered, not started anew


SCLANG_TCP = """(fork {
    var n = NetAddr("127.0.0.1", PORT);
    n.connect;
    n.sendMsg("/object/new", "a", "wood-block");
    0.2.wait;
    n.sendBundle(0.1, ["/object/a/impact", 1.0]);
    1.wait;
    0.exit;
})"""


@pytest.mark.parametrize("program", ["oscsend", "sclang"])
def test_other_programs_strike_over_tcp(tmp_path, server: Running, program):
    if not shutil.which(program):
        pytest.skip(f"{program} is not installed")
    (tmp_path / "strike.scd").write_text(SCLANG_TCP.replace("PORT", str(server.port)))
    send = ["oscsend", f"osc.tcp://localhost:{server.port}"]
    commands = {
        "oscsend": [[*send, "/object/new", "ss", "a", "wood-block"], [*send, "/object/a/impact", "f", "1"]],
        "sclang": [["sclang", "strike.scd"]],
    }
    env = os.environ | {"QT_QPA_PLATFORM": "offscreen", "QTWEBENGINE_DISABLE_SANDBOX": "1", "HOME": str(tmp_path)}
    for words in commands[program]:
        subprocess.run(words, cwd=tmp_path, env=env, check=True, timeout=60, capture_output=True)
    time.sleep(0.2)
    with server.client() as client:
        assert counted(client.status())["impacts"] == 1


def test_manners(server: Running):
    with server.client() as client:
        assert client.ask("/version").args[0] == "carom"
        assert client.ask("/sync", 42).args == (42,)
        assert client.ask("/notify", 1).args == ("/notify",)
        client.new("a", "wood-block", gain=-6)
        with pytest.raises(CommandError, match="there is such an object already"):
            client.new("a", "wood-block")
        for address, reason in (("/nothing", "no such address"), ("/object/a/impact", "velocity is missing")):
            with pytest.raises(CommandError, match=reason):
                client.ask(address)
        with pytest.raises(CommandError, match=r"id = 0\.5"):
            client.ask("/sync", "0.5")


def test_bundles_with_times_are_kept_apart(tmp_path):
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        with server.client() as client:
            client.new("a", "wood-block")
            now = time.time()
            for i in (2, 0, 1):
                with client.bundle(at=now + 0.3 + 0.25 * i):
                    client.impact("a", 0.5 + i)
            with client.bundle(at=now + 1e5):
                client.impact("a", 1.0)
            (reply,) = [r for r in client.replies(0.5) if r.address == "/fail"]
            assert "ahead; expected at most 3600 s" in str(reply.args[1])
            time.sleep(1.0)
        server.quit()
    sound, rate = soundfile.read(tmp_path / "out.wav")
    level = np.abs(sound).max(axis=1)
    assert onsets(tmp_path / "out.wav") == 3
    first = int(np.argmax(level > 1e-4))
    peaks = [level[first + int(0.25 * i * rate) - 2400 :][:7200].max() for i in range(3)]
    assert peaks[0] < peaks[1] < peaks[2]  # in the order of their times, not of their arrival


HOSTILE = [
    b"",
    b"/",
    b"hello, world",
    b"#bundle\0" + b"\0" * 7 + b"\1" + b"\xff\xff\xff\xfc",  # an element of size -4
    b"#bundle\0" + b"\0" * 7 + b"\1" + (20).to_bytes(4, "big") + b"#bundle\0" + b"\0" * 12,
    wire.encode("/" + "*" * 20 + "!" * 12, 1.0),
    wire.encode("/object/" + "*" * 20 + "!/impact", 1.0),
    b"/object/a/impact\0\0\0\0,f\0\0\0\0",  # a truncated float
    b"/object/a/impact\0\0\0\0,f\0\0\x7f\xc0\0\0",  # NaN
    b"\xff\xfe\xfd\xfc" * 10,
    b"/object/a/impact\0\0\0\0," + b"[" * 19,
    bytes(65_507),
    wire.encode("/object/new", "x", "a" * 300),
    wire.encode("/object/new", "x", "church-bell", "material", "\x01" * 30_000),
    wire.encode("/object/new", "x", "church-bell", "striker", "a" * 300),
    wire.encode("/é\x1b[2J", "ü"),
    wire.encode("/object/a/impact", 5e-324, real="d"),
]


def test_nothing_hostile_disturbs_it(server: Running):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock, server.client() as client:
        client.new("a", "wood-block")
        client.send("/dump", 1)
        for datagram in HOSTILE * 20:
            sock.sendto(datagram, ("127.0.0.1", server.port))
        client.send("/object/a/impact", b"blob", None)
        client.send("/dump", 0)
        started = time.monotonic()
        client.impact("a", 1.0)
        client.ask("/sync", 1)
        assert time.monotonic() - started < 1.0
        assert dict(zip((a := client.status().args)[9::2], a[10::2], strict=True))["impacts"] == 1


def test_each_bad_datagram_is_answered(server: Running):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.settimeout(2)
        sock.sendto(b"hello, world", ("127.0.0.1", server.port))
        (bundle,) = wire.parse(sock.recv(65_507))
        assert bundle.messages[0].address == "/fail" and bundle.messages[0].args[0] == "datagram"


def test_a_burst_is_not_lost(server: Running):
    with server.client() as client:
        client.new("a", "wood-block", gain=-60)
        for _ in range(20):
            with client.bundle():
                for _ in range(250):
                    client.impact("a", 0.01)
        client.ask("/sync", 1)
        status = client.status().args
        assert dict(zip(status[9::2], status[10::2], strict=True))["impacts"] == 5000


def failing(folder: Path, *args: str, env: dict[str, str] | None = None) -> str:
    """What a `serve` that can't start says, in one line, before it exits with 1."""
    run = subprocess.run([*CAROM, "serve", *args], cwd=folder, env=env, capture_output=True, text=True, timeout=60)
    assert run.returncode == 1 and run.stdout == "" and run.stderr.count("\n") == 1
    return run.stderr


def test_what_can_not_be_served_is_told(tmp_path):
    none = ("--port", "0", "--device", "none")
    assert "no/such/out.wav: No such file or directory" in failing(tmp_path, *none, "--record", "no/such/out.wav")
    assert "/dev/full: Invalid argument" in failing(tmp_path, *none, "--record", "/dev/full")
    assert "/dev/full: Invalid argument" in failing(tmp_path, *none, "--log", "/dev/full")
    assert "out.flac: expected a name that ends in .wav" in failing(tmp_path, *none, "--record", "out.flac")
    same = failing(tmp_path, *none, "--record", "same", "--log", "same")
    assert "same: is being written already" in same and not (tmp_path / "same").exists()
    assert "latency = 3: expected 0 to 2 s" in failing(tmp_path, *none, "--latency", "3")
    assert "no/presets: expected a folder" in failing(tmp_path, *none, "--presets", "no/presets")
    assert "rate = 1: expected" in failing(tmp_path, *none, "--rate", "1")
    assert "port = 70000: expected" in failing(tmp_path, "--port", "70000", "--device", "none")


def test_a_server_that_can_not_be_leaves_recordings_alone(tmp_path):
    (tmp_path / "old.wav").write_bytes(b"an earlier session")
    for wrong in (("--contact", "euler"), ("--presets", "none"), ("--device", "no-such-device")):
        args = ("--port", "0", "--device", "none", "--record", "old.wav", *wrong)
        failing(tmp_path, *args)
        failing(tmp_path, *args[:4], "--record", "new.wav", *wrong)
    assert (tmp_path / "old.wav").read_bytes() == b"an earlier session" and not (tmp_path / "new.wav").exists()


def test_no_portaudio_is_told(tmp_path):
    # A sounddevice that finds no library, as on a machine without PortAudio.
    (tmp_path / "sounddevice.py").write_text("raise OSError('PortAudio library not found')\n")
    env = os.environ | {"PYTHONPATH": str(tmp_path)}
    assert "PortAudio library not found: install PortAudio" in failing(tmp_path, "--port", "0", env=env)
    with serving(tmp_path, "--device", "none", env=env) as running:
        assert running.quit()[0] == 0


def test_an_unknown_device_is_told(tmp_path):
    pytest.importorskip("sounddevice", reason="PortAudio is not installed", exc_type=OSError)
    assert "device no-such-device" in failing(tmp_path, "--port", "0", "--device", "no-such-device")


def test_signals_end_it_well(tmp_path):
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        time.sleep(0.3)
        server.process.terminate()
        assert server.process.wait(timeout=10) == 0
    assert soundfile.info(tmp_path / "out.wav").frames > 4800


def test_it_starts_within_seconds(tmp_path):
    with serving(tmp_path, "--device", "none"):  # so that the compiled code is there
        pass
    started = time.monotonic()
    with serving(tmp_path, "--device", "none"):
        assert time.monotonic() - started < 5.0  # on a machine that does other things too; `make bench` has the figure


def test_python_m_works():
    run = subprocess.run([sys.executable, "-m", "carom", "--version"], capture_output=True, text=True)
    assert run.stdout.startswith("carom ")


def test_tcp_strikes_too(tmp_path):
    with serving(tmp_path, "--device", "none", "--record", "out.wav") as server:
        with Client(port=server.port, tcp=True) as client:
            client.new("a", "wood-block")
            with client.bundle(at=time.time() + 0.2):
                client.impact("a", 1.0)
            client.ask("/notify", 1)
            with pytest.raises(CommandError, match="no such object"):
                client.ask("/object/b/impact", 1.0)
            time.sleep(0.5)
            assert counted(client.status())["connections"] == 1
        time.sleep(0.1)
        with server.client() as client:
            assert counted(client.status())["connections"] == 0
        assert server.quit() == (0, "")
    assert onsets(tmp_path / "out.wav") == 1


def test_what_is_sent_on_one_connection_stays_in_order(server: Running):
    with Client(port=server.port, tcp=True) as client:
        client.new("a", "wood-block", gain=-60)
        for _ in range(20_000):
            client.impact("a", 0.01)
        client.ask("/sync", 1, timeout=20.0)
        assert counted(client.status())["impacts"] == 20_000


def test_a_burst_of_datagrams_is_not_lost(server: Running):
    """10,000 datagrams as fast as they can be sent, behind one that takes its time."""
    with server.client() as client:
        if client_buffer() < RECEIVE_BUFFER:
            pytest.skip("the system gives less than the receive buffer asked for")
        client.new("a", "wood-block", gain=-60)
        client.send("/object/new", "plate", "steel-plate")
        strike = wire.encode("/object/a/impact", 0.01)
        for _ in range(10_000):
            client._socket.send(strike)
        client.ask("/sync", 1, timeout=20.0)
        told = counted(client.status())
        assert told["impacts"] == 10_000 and told["dropped"] == told["dropped_by_system"] == 0


def test_who_sends_too_much_is_told(server: Running):
    with Client(port=server.port, tcp=True) as client, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        client.send("/object/new", "gong", "gong")  # which takes a while
        time.sleep(0.01)
        for number in range(200):
            sock.sendto(bytes(60_000), ("127.0.0.1", server.port))
            if number % 10 == 0:
                time.sleep(0.001)
        client.ask("/sync", 1, timeout=10.0)
        time.sleep(0.5)
        lost = counted(client.status())["dropped"]
        if not lost:
            pytest.skip("the machine was too slow to send too much")
        sock.settimeout(2.0)
        while "were left out" not in (text := wire.parse(sock.recv(2000))[0].messages[0].args[1]):
            assert "expected" in text
        client.impact("gong", 1.0)
        client.ask("/sync", 2)
        assert counted(client.status())["impacts"] == 1


def client_buffer() -> int:
    with closing(Network("127.0.0.1", 0)) as network:
        return network.receive_buffer


def counted(status: wire.Message) -> dict[str, float]:
    return dict(zip(status.args[9::2], status.args[10::2], strict=True))


def test_what_fails_elsewhere_is_not_answered(server: Running):
    """Two servers, or one that is told to answer itself, would go on about it for ever."""
    with server.client() as client:
        client.send("/fail", "/object/a/impact", "no such object")
        client.send("/{fail,done}", "/object/a/impact")
        assert [reply.args[0] for reply in client.replies(0.3)] == ["/{fail,done}"]


def test_patterns_reach_the_server_itself(server: Running):
    with server.client() as client:
        assert [m.address for m in client.ask_all("/{status,version}")] == ["/status.reply", "/version.reply"]
        assert "/status.reply" in [m.address for m in client.ask_all("/*")]
        assert [m.address for m in client.ask_all("/qui?")] == ["/fail"]
    assert server.process.poll() is None


def test_presets_outside_the_folders_are_out_of_reach(tmp_path):
    (tmp_path / "mine" / "objects").mkdir(parents=True)
    secret = (Path(__file__).parents[2] / "presets" / "objects" / "wood-block.toml").read_text()
    (tmp_path / "secret.toml").write_text(secret)
    with serving(tmp_path, "--device", "none", "--presets", "mine") as server, server.client() as client:
        for path in ("../../secret", "../secret", str(tmp_path / "secret"), "objects/wood-block", "..", "", "secret\0"):
            for args in ((path,), ("wood-block", "material", path), ("wood-block", "striker", path)):
                with pytest.raises(CommandError, match=r"expected|zero character"):
                    client.ask("/object/new", "x", *args)
        assert client.status().args[3] == 0


def test_a_second_server_says_so(tmp_path, server: Running):
    assert f"port {server.port} on 127.0.0.1: Address already in use" in failing(tmp_path, "--port", str(server.port))
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as taken:  # by another program, for TCP alone
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert f"port {port} on 127.0.0.1: Address already in use" in failing(tmp_path, "--port", port)
    with server.client() as client:
        assert client.status().args[0] == 1


def test_listening_to_others_is_warned_of(tmp_path):
    with serving(tmp_path, "--device", "none", "--bind", "0.0.0.0") as server:
        code, errors = server.quit()
    assert code == 0 and errors == "carom serve: whoever reaches this machine can play on it: it listens on 0.0.0.0\n"


def test_dump_on_and_off_leaves_nothing_behind(server: Running):
    tasks = Path(f"/proc/{server.process.pid}/task")
    if not tasks.is_dir():
        pytest.skip("threads can't be counted here")
    with server.client() as client:
        for on in (1, 0):
            client.send("/dump", on)
        client.ask("/sync", 1)
        before = len(list(tasks.iterdir()))
        for n in range(100):
            client.send("/dump", n % 2)
        client.ask("/sync", 2)
        assert len(list(tasks.iterdir())) == before


def test_two_thousand_impacts_a_second_and_32_rolls(server: Running):
    from tests.bench.soak import RATE, ROLLS, soak

    seen = soak(server.port, server.process.pid, 3.0)
    assert seen.sent >= 3 * RATE and seen.carried_out >= seen.sent + 100 * ROLLS and seen.growth < 5.0
    assert seen.rolling >= ROLLS and seen.dropped["dropped"] == seen.dropped["dropped_by_system"] == 0
    assert seen.dropped["contacts_dropped"] == seen.dropped["faults"] == seen.dropped["tap_lost"] == 0


def test_files_that_can_not_be_written_on_are_told_for_good(tmp_path):
    """Also to those who ask later, and where nobody reads what it says; what is there of the log can be rendered."""
    limits = "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000)); "
    limits += "from carom.clients.cli import main; sys.exit(main())"
    words = [sys.executable, "-c", limits, "serve", "--port", "0", "--device", "none", "--log", "log.txt"]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout and process.stderr
        port = int(process.stdout.readline().split(":")[1].split(",")[0])
        process.stderr.close()
        with Client(port=port) as client:
            client.new("a", "wood-block")
            for _ in range(40):
                with client.bundle():
                    for _ in range(20):
                        client.impact("a", 1e-3)
            client.ask("/sync", 1)
            time.sleep(0.3)
            status = client.status().args
            assert "File too large" in str(dict(zip(status[9::2], status[10::2], strict=True))["logging"])
            client.ask("/notify", 1)
            assert any("File too large" in str(reply.args) for reply in client.replies(0.2))
            client.ask("/quit")
        assert process.wait(timeout=10) == 0
    lines = read(tmp_path / "log.txt")
    assert 100 < len(lines) < 800 and lines[0].message.address == "/object/new"


def test_what_is_an_age_late_counts_an_hour(server: Running):
    with server.client() as client:
        client.new("a", "wood-block")
        client.ask("/sync", 1)
        with client.bundle(at=1.0):
            client.impact("a", 1.0)
        client.ask("/sync", 2)
        status = client.status().args
    assert dict(zip(status[9::2], status[10::2], strict=True))["late_worst_ms"] == pytest.approx(3.6e6, rel=1e-3)
