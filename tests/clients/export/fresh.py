"""Compare the memory that an engine begins for a host without Python with that of `new_state`, and what a scene holds
with what may be in one: run by a process that has a page's sizes.

    python -m tests.clients.export.fresh
"""

import numpy as np

from carom.clients.export.mapping import rules
from carom.dsp.engine.memory.state import STATE, new_state
from carom.dsp.native.pages import own_zeros
from carom.dsp.runtime.admission import BEGIN, MAY_WRITE
from tests.clients.export import tiny


def main() -> None:
    memory = np.frombuffer(own_zeros(STATE.itemsize), np.uint64)
    tiny.ask(memory.ctypes.data, BEGIN, 0, 0)
    assert (memory == new_state(0.0, 0).view(np.uint64)).all()
    state = rules()["state"]
    for name in ("rate", "channels", "written", "entries", "position", "values"):  # no scene writes these
        assert tiny.ask(memory.ctypes.data, MAY_WRITE, state[name] // 8, 1) == state[name] // 8, name
    for name in ("frequency", "sigma", "weight", "balance", "plates"):
        assert tiny.ask(memory.ctypes.data, MAY_WRITE, state[name] // 8, 1) == -1, name


if __name__ == "__main__":
    main()
