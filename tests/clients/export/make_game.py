"""Export the bodies of a game, for pages and for C: run by a process that has a page's sizes and bits.

python -m tests.clients.export.make_game FOLDER [ENGINE]
"""

import sys
from pathlib import Path

from carom.clients.export import c, web
from carom.clients.export.machines import machine_of
from carom.clients.export.scene import bake_scene
from carom.presets import Presets
from carom.server.osc.score import parse
from carom.server.render import Options
from tests.clients.export.make_scene import use

BODIES = """\
0 /world/body floor plate wood 4 4 0.02 held 1 most_modes 32
0 /world/body ball sphere steel 0.03 most_modes 16
0 /world/body box box glass 0.2 0.15 0.1 most_modes 16
0 /world/body ground box wood 1 1 1 held 1 rings 0
0 /object/new bell church-bell
"""


def main(folder: Path) -> None:
    scene = bake_scene(parse(BODIES.encode(), "score"), BODIES, "game", Presets(), Options(seconds=0.1), print)
    web.write_page(scene, folder)
    c.write_library(scene, folder, machine_of(None))


if __name__ == "__main__":
    for name in sys.argv[2:]:
        use(name)
    main(Path(sys.argv[1]))
