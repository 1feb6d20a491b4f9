"""Batches of a data set's clips for TensorFlow, by tf.data: `python with_tensorflow.py FOLDER`."""

import io
import json
import sys
import tarfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import soundfile
import tensorflow as tf


def clips() -> Iterator[tuple[Any, float]]:
    """Yield each clip's sound (Pa) and the speed of its first contact (m/s)."""
    for shard in sorted(Path(sys.argv[1]).glob("*.tar")):
        with tarfile.open(shard) as tar:
            files = {each.name: tar.extractfile(each).read() for each in tar}  # type: ignore[union-attr]
        for name in (name for name in files if name.endswith(".json")):
            truth = json.loads(files[name])
            sound = soundfile.read(io.BytesIO(files[name.replace(".json", ".flac")]), dtype="float32")[0]
            yield sound * truth["full_scale"], truth["contacts"][0]["speed"]


signature = (tf.TensorSpec((None,), tf.float32), tf.TensorSpec((), tf.float32))
for sound, speed in tf.data.Dataset.from_generator(clips, output_signature=signature).batch(8).prefetch(2):
    print(sound.shape, speed.numpy())
