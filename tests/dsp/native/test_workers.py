"""Units are compiled by several processes, and are all there whatever becomes of these."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import llvmlite.binding as llvm
import pytest

from carom.dsp.native.digests import digest
from carom.dsp.native.store import Store
from carom.dsp.native.targets import targets
from carom.dsp.native.workers import Workers
from tests import needs

COUNT = 6


def source(number: int, called: str = "") -> bytes:
    """Return the bitcode of a function, as a unit's source."""
    call = f"call void @{called}()\n" if called else ""
    declared = f"declare void @{called}()\n" if called else ""
    text = (
        f"{declared}define double @unit{number}(double %x) {{\n{call}%y = fadd double %x, {number}.0\nret double %y\n}}"
    )
    content: bytes = llvm.parse_assembly(text).as_bitcode()
    return content


@pytest.fixture
def kept(tmp_path):
    store = Store(tmp_path)
    for number in range(COUNT):
        store.write_unit(f"key{number}", "source", "bc", source(number))
    return store


def make_all(store: Store, count: int) -> int:
    """Make all units' machine code with some processes beside this one; return how often progress was told."""
    told = []
    with Workers(store, lambda key: told.append(key), count) as workers:
        for number in range(COUNT):
            workers.submit(f"key{number}", targets()[0])
        workers.finish()
    assert all(store.read_object(f"key{number}", targets()[0]) for number in range(COUNT))
    return len(told)


def test_process_without_workers_compiles_all_units(kept):
    assert make_all(kept, 0) == COUNT


@pytest.mark.slow
def test_several_processes_make_the_same_bytes_as_one(kept, tmp_path):
    alone = Store(tmp_path / "alone")
    for number in range(COUNT):
        alone.write_unit(f"key{number}", "source", "bc", source(number))
    assert make_all(kept, 2) == make_all(alone, 0) == COUNT
    for number in range(COUNT):
        assert kept.read_object(f"key{number}", targets()[0]) == alone.read_object(f"key{number}", targets()[0])


@pytest.mark.parametrize(
    "program",
    ["#!/bin/sh\nexit 1\n", "#!/bin/sh\necho hello\ncat >/dev/null\n", "#!/bin/sh\nread line\nkill -9 $$\n", "", None],
    ids=["ends at once", "talks", "is killed", "cannot be run", "is not there"],
)
def test_a_process_that_is_no_worker_leaves_the_work_to_this_one(kept, tmp_path, monkeypatch, program):
    path = tmp_path / "python3"
    if program is not None:
        path.write_text(program)
        path.chmod(0o755 if program else 0o644)
    monkeypatch.setattr(sys, "executable", str(path))
    assert make_all(kept, 2) == COUNT
    assert not [each for each in threading.enumerate() if each.name == "carom-compiling-units"]


@pytest.mark.slow
@pytest.mark.parametrize("where", [0, 1, 3])
def test_code_that_needs_python_is_refused_whoever_makes_it(kept, where):
    kept.write_unit(f"key{where}", "source", "bc", source(where, "PyErr_Clear"))
    for file in (kept.root / "units" / f"key{where}").glob("source.*"):
        if file.suffixes[-2] != f".{digest(source(where, 'PyErr_Clear'))}":
            file.unlink()
    with pytest.raises(TypeError, match=f"unit{where}: this code needs Python: PyErr_Clear"):
        make_all(kept, 2)


@pytest.mark.slow
def test_processes_end_where_the_work_is_given_up(kept):
    with pytest.raises(KeyboardInterrupt), Workers(kept, count=2) as workers:
        for number in range(COUNT):
            workers.submit(f"key{number}", targets()[0])
        raise KeyboardInterrupt
    for thread in [each for each in threading.enumerate() if each.name == "carom-compiling-units"]:
        thread.join(10.0)
        assert not thread.is_alive()


@pytest.mark.slow
@needs.linux("/proc")
@pytest.mark.parametrize("name", ["SIGINT", "SIGKILL"])
def test_workers_end_without_a_word_when_their_parent_does(tmp_path, name):
    """Nothing is left running, and nothing stands on the terminal but what the parent says."""
    script = f"""
import os, signal, subprocess, sys, time
worker = subprocess.Popen(
    [sys.executable, "-c", "from carom.dsp.native.workers import serve; print(1, flush=True); serve()"],
    stdin=subprocess.PIPE, stdout=subprocess.PIPE,
)
worker.stdout.readline()
print(worker.pid, flush=True)
if {name!r} == "SIGINT":
    time.sleep(0.5)  # by then it serves
    worker.send_signal(signal.SIGINT)
    worker.wait()
else:
    os.kill(os.getpid(), signal.SIGKILL)
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert run.stderr == ""
    _wait_for_the_end_of(int(run.stdout))


def _wait_for_the_end_of(process: int) -> None:
    for _ in range(100):
        if not Path(f"/proc/{process}").exists() or "Z" in Path(f"/proc/{process}/stat").read_text().split()[2]:
            return
        time.sleep(0.05)
    os.kill(process, 9)
    raise AssertionError(f"process {process} is still there")
