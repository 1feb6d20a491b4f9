"""Messages that are played in a process of their own: what was refused, what sounded, and what it took."""

import math
import os
import time
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from carom.dsp.native import CHECKED
from carom.dsp.runtime.engine import Engine
from carom.presets import Presets
from carom.server.costs import CostWatch
from carom.server.options import BUDGET
from carom.server.osc.score import format_line
from carom.server.osc.wire import Message
from carom.server.scene.session import Session
from tests.attack import Tried
from tests.attack.children import Child, Died, least

RATE = 48_000
LOUDEST = 1e30
"""Of a sample without a limiter: more is taken for a sound that grows without bounds."""
MOST_CPU = 1.0
"""s of a processor for a second of sound, with the budget that a server begins with; twice as many where others share
the processor. The checked build takes more of all."""
MOST_TOLD = 4.0
"""The same of a sound that says what it took: many blows a second on a plate that swells take 2."""
_WARM = 0.1  # s of a processor that any sound may take: what takes more is told (server/costs.py)
_MAKING = 30  # s of a processor for all that is made
_PRESETS = Presets()


class Played(NamedTuple):
    """What messages led to: the reasons why some were refused, the loudest sample, and the time (s) of a processor that
    the sound took, and whether a render would say so."""

    refusals: list[str]
    loudest: float
    cpu: float
    told: bool


def play(messages: Sequence[Message], seconds: float) -> Played:
    """Play messages at once, and so many seconds after the last one."""
    session = Session(Engine(RATE, 2, 65_536, 64, sensors=2), _PRESETS)
    session.perform([Message("/budget", BUDGET)], 0.0)
    refusals = []
    for message in messages:
        replies = session.perform([message], 0.0)
        refusals += [str(reply.args[-1]) for reply in replies if reply.address == "/fail"]
    begun = time.process_time()
    watch = CostWatch(session.engine, session.objects.slots)
    sound = watch.process(round(seconds * RATE))
    took = time.process_time() - begun
    loudest = float(np.abs(sound).max(initial=0.0)) if np.isfinite(sound).all() else np.nan
    loudest = np.nan if session.engine.stats.faults else loudest  # an object was silenced in time
    return Played(refusals, loudest, took, bool(watch.warning()))


def tried(child: Child, messages: Sequence[Message], seconds: float) -> Tried:
    """Play messages in a process; a fault names the fewest of them that lead to it."""
    try:
        played = child.run(play, messages, seconds, cpu=_MAKING)
    except Died as died:
        return Tried(faults=(_told(child, messages, seconds, str(died)),))
    fault = _fault(played, seconds)
    if fault:
        return Tried(faults=(_told(child, messages, seconds, fault),))
    silent = [each for each in played.refusals if ": expected" not in each and len(each.split()) < 3]
    faults = tuple(f"a refusal that says nothing: {each}" for each in silent)
    return Tried(len(played.refusals), len(messages) - len(played.refusals), faults)


def _fault(played: Played, seconds: float) -> str:
    if not played.loudest < LOUDEST:
        return f"a sample of {played.loudest:g}"
    usual = MOST_TOLD if played.told else MOST_CPU
    most = math.inf if CHECKED else _WARM + usual * seconds * (1.0 + _is_shared())
    return f"{played.cpu:.2f} s of a processor for {seconds:g} s of sound" if played.cpu > most else ""


def _is_shared() -> bool:
    """True if other processes are at work on this machine, so that a processor does half as much in its time."""
    return hasattr(os, "getloadavg") and os.getloadavg()[0] > 0.75 * (os.cpu_count() or 1)


def _told(child: Child, messages: Sequence[Message], seconds: float, fault: str) -> str:
    """Say what happens by which messages."""

    def fails(fewer: Sequence[Message]) -> bool:
        try:
            return bool(_fault(child.run(play, fewer, seconds, cpu=_MAKING), seconds))
        except Died:
            return True

    return f"{fault}: {'; '.join(map(_shown, least(messages, fails)))}"


def _shown(message: Message) -> str:
    try:
        return format_line(0.0, message)[:400]
    except (ValueError, TypeError):
        return repr(message)[:400]
