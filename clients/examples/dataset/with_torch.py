"""Batches of a data set's clips for PyTorch, by webdataset: `python with_torch.py FOLDER`."""

import io
import sys
from pathlib import Path

import soundfile
import torch
import webdataset

shards = [str(path) for path in sorted(Path(sys.argv[1]).glob("*.tar"))]
flac = webdataset.handle_extension("flac", lambda data: soundfile.read(io.BytesIO(data), dtype="float32")[0])
clips = webdataset.WebDataset(shards, shardshuffle=False).decode(flac).to_tuple("flac", "json")
for batch in torch.utils.data.DataLoader(clips, batch_size=8, collate_fn=list):
    pascals = torch.stack([torch.from_numpy(sound) * truth["full_scale"] for sound, truth in batch])
    print(pascals.shape, batch[0][1]["factors"])
