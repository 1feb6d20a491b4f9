"""Random scores of all gestures, exported for pages and for C: run by a process that has a page's sizes and bits.

    python -m tests.bench.exported FOLDER COUNT

A folder FOLDER/SEED gets a page of each score, and its scene for C; FOLDER/c gets the library. All of a kind share one
engine's file. Each line that is printed is the digest of a score's render.
"""

import hashlib
import os
import sys
from pathlib import Path

from carom.clients.export import c, web
from carom.clients.export.machines import machine_of
from carom.clients.export.packing import compressed
from carom.presets import Presets
from tests.clients.export.make_scene import random_scene


def main(folder: Path, count: int) -> None:
    presets, pages = Presets(), dict[tuple[str, ...], Path]()
    (folder / "c").mkdir()
    for seed in range(count):
        _, scene = random_scene(seed, presets)
        if not pages:
            c.write_library(scene, folder / "c", machine_of(None))
        page, rooms = folder / str(seed), tuple(web.without(scene.baked))
        page.mkdir()
        if rooms in pages:
            for file in pages[rooms].iterdir():
                if not file.name.startswith("scene.carom"):
                    os.link(file, page / file.name)
            _, engine = web.engine_for(scene.baked)
            (page / "scene.carom.lzma").write_bytes(compressed(scene.file(engine), words=True))
        else:
            web.write_page(scene, page)
            pages[rooms] = page
        (page / "scene.carom").write_bytes(scene.file())
        print(hashlib.sha256(scene.baked.sound.astype("<f4").tobytes()).hexdigest(), flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), int(sys.argv[2]))
