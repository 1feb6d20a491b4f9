"""The live server, as its clients meet it."""

import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
import soundfile

from carom.clients.actions import CommandError
from carom.clients.client import Client
from carom.server.options import Options
from carom.server.osc.score import read
from tests.server.support import counted, onsets
from tests.support import Running, limited, serving

pytestmark = pytest.mark.slow


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
    values = counted(status)
    assert values["impacts"] == 3 and values["contacts_dropped"] == 0


def test_manners(server: Running):
    with server.client() as client:
        assert client.ask("/version").args[0] == "carom"
        assert client.ask("/sync", 42).args == (42,)
        assert client.ask("/notify", 1).args == ("/notify",)
        client.new("a", "wood-block", gain=-6)
        with pytest.raises(CommandError, match="there is such an object already"):
            client.new("a", "wood-block")
        for address, reason in (("/nothing", "no such address"), ("/object/a/press", "force is missing")):
            with pytest.raises(CommandError, match=reason):
                client.ask(address)
        with pytest.raises(CommandError, match=r"id = '0\.5'"):
            client.ask("/sync", "0.5")
        with pytest.raises(CommandError, match=r"id = 1\.5: expected a whole number"):
            client.ask("/sync", 1.5)  # /synced 1 would tell somebody else


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


def test_failures_from_elsewhere_are_not_answered(server: Running):
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


def test_files_that_can_not_be_written_on_are_told_for_good(tmp_path):
    """Clients that ask later hear of it, too, even where nobody reads what it says; what is there of the log can be
    rendered."""
    words = [*limited(20_000), "serve", "--port", "0", "--device", "none", "--log", "log.txt"]
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
            status = counted(client.status())
            assert "File too large" in str(status["logging"])
            client.ask("/notify", 1)
            assert any("File too large" in str(reply.args) for reply in client.replies(0.2))
            client.ask("/quit")
        assert process.wait(timeout=10) == 0
    lines = read(tmp_path / "log.txt")
    assert 100 < len(lines) < 800 and lines[len(Options().head)].message.address == "/object/new"


def test_message_an_age_late_counts_an_hour(server: Running):
    with server.client() as client:
        client.new("a", "wood-block")
        client.ask("/sync", 1)
        with client.bundle(at=1.0):
            client.impact("a", 1.0)
        client.ask("/sync", 2)
        status = counted(client.status())
    assert status["late_worst_ms"] == pytest.approx(3.6e6, rel=1e-3)
