"""Pages of exported scenes: plain files on a plain server, and what they are asked."""

import functools
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from carom.dsp import sizes
from carom.dsp.native import targets

ENGINE = {**os.environ, sizes.VARIABLE: "small", targets.VARIABLE: targets.PORTABLE}
"""The environment of a process that has a page's engine."""

RENDER = """async () => {
  const { Carom } = await import("./carom.js");
  const files = await Carom.fetch();
  const context = new OfflineAudioContext(files.map.channels, files.map.frames, files.map.rate);
  const carom = await Carom.open(context, { files, live: false });
  const begun = performance.now();
  const sound = await context.startRendering();
  const load = (performance.now() - begun) / (1000 * sound.duration);
  const width = sound.numberOfChannels;
  const frames = new Float32Array(sound.length * width);
  for (let c = 0; c < width; c++) sound.getChannelData(c).forEach((x, n) => (frames[n * width + c] = x));
  const digest = [...new Uint8Array(await crypto.subtle.digest("SHA-256", frames))];
  const { megabytes } = await carom.ready;
  const hex = digest.map((x) => x.toString(16).padStart(2, "0")).join("");
  return { isolated: crossOriginIsolated, digest: hex, load, megabytes };
}"""
"""A script that renders a page's score in a worklet, for the SHA-256 of its frames."""


class _Quiet(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing."""


@contextmanager
def served(folder: Path, handler: type[SimpleHTTPRequestHandler] = _Quiet) -> Iterator[str]:
    """Serve the files of a folder; yield the address, which ends in a slash."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(handler, directory=str(folder)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/"
    server.shutdown()
    server.server_close()
