"""Machine code is loaded whatever a process has mapped (Linux)."""

import subprocess
import sys

import pytest

CROWDED = """
import mmap
from carom.dsp.native import code
from carom.dsp.native.together import together
from carom.dsp.runtime import callback

gaps = [mmap.mmap(-1, pages * mmap.PAGESIZE) for pages in (4, 8, 16, 32, 64, 100)]
unreserved = 0x4000
large = mmap.mmap(-1, 5 << 30, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS | unreserved)
del gaps  # small sections fit in there, the code does not
before = open("/proc/self/maps").read().count("---p")
with together(1 << 20):
    assert open("/proc/self/maps").read().count("---p") > before
assert open("/proc/self/maps").read().count("---p") == before
code.load(callback.__name__)
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="other systems map in other ways")
def test_code_is_loaded_beside_gigabytes_with_small_gaps_above():
    done = subprocess.run([sys.executable, "-c", CROWDED], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
