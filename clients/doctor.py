"""Checks of this machine: the engine, presets, devices, network and priority, and remedies."""

import os
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from importlib.util import find_spec

from ..dsp.errors import COMPILER
from ..dsp.native import targets
from ..dsp.native.store import user_cache, usual_cache
from ..dsp.runtime.engine import Engine
from ..presets import PresetError, Presets
from ..server.audio.portaudio import NONE_FOUND, AudioError, devices
from ..server.net.network import Network
from ..server.net.udp import RECEIVE_BUFFER
from ..server.options import ServeError
from ..server.osc.wire import DEFAULT_PORT

Finding = tuple[bool | None, str, str]
"""Well (True), worse than it could be (None) or broken (False); the finding; the remedy."""


def examine() -> Iterator[Finding]:
    """Yield findings, one by one: engine, presets, devices, port, receive buffer, priority, MIDI, matplotlib, scipy."""
    yield _engine()
    yield _presets()
    yield _sound()
    yield _port()
    yield _burst()
    yield _priority()
    yield _midi()
    if find_spec("matplotlib"):
        yield True, "matplotlib: --plot, carom chart and pictures of fits work", ""
    else:
        yield None, "no matplotlib: no --plot, no carom chart, no pictures of fits", "pip install 'carom[plot]'"
    if not find_spec("scipy"):
        yield None, "no scipy: no carom fit, carom compare, carom mesh", "pip install 'carom[fit,mesh]'"


def _engine() -> Finding:
    started = time.perf_counter()
    engine = Engine(48_000)
    seconds = time.perf_counter() - started
    origin, runs, wanted = engine.code.origin, engine.code.processor, targets.processors()[0]
    words = {"package": "came with the package", "cache": "is in the cache", "compiled": "was compiled now"}
    asked = f", as {targets.VARIABLE} asks," if targets.VARIABLE in os.environ else ""
    where = f" in {user_cache()}" if origin != "package" and user_cache() != usual_cache() else ""
    code = f"code {engine.code.key} for {runs}{asked} {words[origin]}{where}"
    said = f"engine: {code}, ready in {seconds:.2f} s (Python {sys.version.split()[0]})"
    if runs == wanted or wanted.startswith(targets.PORTABLE):
        return True, said, ""
    helps = {"cache": COMPILER, "package": "pip install . in a checkout, which compiles for this processor"}
    return None, f"{said}; this processor can do {wanted}", helps[origin]


def _presets() -> Finding:
    presets = Presets()
    try:
        for name in presets.names("objects"):
            presets.object(name)
    except PresetError as error:
        return False, f"presets: {error}", "reinstall carom"
    return True, f"presets: {len(presets.names('objects'))} objects, {len(presets.names('strikers'))} strikers", ""


def _sound() -> Finding:
    try:
        found = devices()
    except AudioError as error:
        return None, "no PortAudio: `carom serve` works with --device none only", str(error)
    if not found:
        what, _, remedy = NONE_FOUND.partition(": ")
        return None, f"sound: {what}", remedy
    default = next((d["name"] for d in found if d["default"]), found[0]["name"])
    return True, f"sound: {len(found)} devices, default {default}", ""


def _midi() -> Finding:
    if not find_spec("mido"):
        return None, "no mido: no --midi", "pip install 'carom[midi]'"
    from ..server.midi.ports import inputs

    try:
        return True, f"MIDI: {len(inputs())} inputs", ""
    except ServeError as error:
        what, _, remedy = str(error).removeprefix("midi: ").partition(": ")
        return None, f"MIDI: {what}", remedy


def _port() -> Finding:
    try:
        network = Network("127.0.0.1", DEFAULT_PORT)
    except OSError as error:
        return (
            None,
            f"port {DEFAULT_PORT}: {error.strerror}",
            "a server may be running already; for a second one: `carom serve --port 0`",
        )
    network.close()
    return True, f"port {DEFAULT_PORT} is free", ""


def _burst() -> Finding:
    with closing(Network("127.0.0.1", 0)) as network:
        given = network.receive_buffer
    if given >= RECEIVE_BUFFER:
        return True, f"receive buffer: {given >> 10} KiB of datagrams can arrive while the server is busy", ""
    remedy = f"as root: sysctl -w net.core.rmem_max={RECEIVE_BUFFER}" if sys.platform == "linux" else ""
    what = f"receive buffer: {given >> 10} KiB: a burst of datagrams may be lost while the server is busy"
    return None, what, remedy or f"let the system grant a UDP socket {RECEIVE_BUFFER >> 10} KiB, or send over TCP"


def _priority() -> Finding:
    if not hasattr(os, "sched_setscheduler"):
        return True, "priority: the system's audio threads have their own", ""
    import resource

    soft, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
    if soft > 0 or os.geteuid() == 0:
        return True, "priority: audio threads may run in real time", ""
    remedy = "as root: put '@audio - rtprio 95' into /etc/security/limits.d/audio.conf, join audio, log in again"
    return None, "priority: audio threads may not run in real time", remedy
