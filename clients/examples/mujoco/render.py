"""Hear a scene of MuJoCo: python render.py SCENE [OUT.wav [OUT.png]], SCENE one of scenes.py.

Writes its sound in pascals, and a strip of pictures over the sound's spectrogram (which needs carom[plot]).
"""

import sys
from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

import carom
from carom.mujoco import Bridge

sys.path.insert(0, str(Path(__file__).parent))
from scenes import SCENES, shake  # type: ignore[import-not-found]

STEP = 0.002  # s
PICTURES = 6

Outline = NDArray[np.float64]
Pictures = list[tuple[float, list[Outline]]]


def hear(name: str) -> tuple[carom.Sound, list[carom.Hit], Pictures]:
    """Render the sound of a scene, its blows, and outlines of its bodies at times from its beginning to its end."""
    make, seconds = SCENES[name]
    model = mujoco.MjModel.from_xml_string(make(STEP))
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    bridge = Bridge(model, data, microphones=[(0, -0.5, 0.6)], keep=True)
    hits, pictures = [], []
    steps = round(seconds / STEP)
    for n in range(steps):
        shake(name, data)
        bridge.step()
        hits += bridge.world.hits
        if n % (steps // PICTURES) == 0:
            pictures.append((data.time, outlines(model, data)))
    return bridge.world.sound(), hits, pictures


def outlines(model: mujoco.MjModel, data: mujoco.MjData) -> list[Outline]:
    """Return the points (n, 2) of each body that moves, seen from the side: x and z in m."""
    found = []
    for geom in range(model.ngeom):
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_PLANE:
            corners = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T * model.geom_aabb[geom, 3:]
            if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_SPHERE:
                angle = np.linspace(0, 2 * np.pi, 24)
                corners = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1) * model.geom_size[geom, 0]
                found.append((data.geom_xpos[geom] + corners)[:, [0, 2]])
                continue
            found.append((data.geom_xpos[geom] + corners @ data.geom_xmat[geom].reshape(3, 3).T)[:, [0, 2]])
    return found


def draw(sound: carom.Sound, hits: list[carom.Hit], pictures: Pictures, path: str) -> None:
    """Draw the strip of pictures, and the spectrogram with its blows."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from scipy.spatial import ConvexHull

    figure = plt.figure(figsize=(12, 6), layout="constrained")
    grid = figure.add_gridspec(2, PICTURES, height_ratios=(1, 1.4))
    points = np.concatenate([body for _, bodies in pictures for body in bodies])
    (left, low), (right, high) = points.min(axis=0) - 0.02, points.max(axis=0) + 0.02
    for n, (time, bodies) in enumerate(pictures[:PICTURES]):
        axes = figure.add_subplot(grid[0, n])
        for body in bodies:
            axes.fill(*body[ConvexHull(body).vertices].T, alpha=0.5, edgecolor="k")
        axes.set(title=f"{time:.2f} s", aspect="equal", xlim=(left, right), ylim=(low, high), xticks=[], yticks=[])
    axes = figure.add_subplot(grid[1, :])
    axes.specgram(sound.samples[:, 0] + 1e-9, NFFT=1024, Fs=sound.rate, noverlap=768, vmin=-160, vmax=-50)
    axes.vlines([hit.time for hit in hits], 20_000, 23_000, color="r")
    axes.set(xlabel="time in s (red: blows)", ylabel="frequency in Hz", ylim=(0, 24_000))
    figure.savefig(path)


def main(name: str = "drop", wave: str = "", picture: str = "") -> None:
    if name not in SCENES:
        sys.exit(f"{name}: expected one of {', '.join(SCENES)}")
    sound, hits, pictures = hear(name)
    sound.save(wave or f"{name}.wav")
    if picture:
        draw(sound, hits, pictures, picture)
    print(f"{name}: {len(hits)} blows, {abs(sound.samples).max():.3g} Pa at most, carom {carom.__version__}")


if __name__ == "__main__":
    main(*sys.argv[1:])
