"""A server that is killed loses little, and one that is told to end does so soon, whatever it is doing."""

import signal

import pytest

from tests.bench import ends

pytestmark = pytest.mark.slow


def test_a_killed_server_loses_little(tmp_path):
    recording, log = ends.lost(tmp_path, 1.0)
    assert recording < 2 * ends.RECORDING and log < 2 * ends.LOG  # others are at work on the machine, too


@pytest.mark.parametrize(
    ("state", "number"),
    [
        ("every address", signal.SIGTERM),
        ("objects in the making", signal.SIGTERM),
        ("questions over HTTP", signal.SIGHUP),
        ("clients that never read", signal.SIGINT),
    ],
)
def test_a_busy_server_ends_at_once(tmp_path, state, number):
    seconds, code, errors = ends.end_in(tmp_path, state, number)
    assert (code, errors) == (0, "") and seconds < 2 * ends.END
