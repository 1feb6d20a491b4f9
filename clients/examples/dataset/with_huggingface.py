"""The clips of a data set, and its table, for Hugging Face's datasets: `python with_huggingface.py FOLDER`."""

import io
import sys

import datasets
import soundfile

clips = datasets.load_dataset("webdataset", data_files=f"{sys.argv[1]}/*.tar", split="train", streaming=True)
clips = clips.cast_column("flac", datasets.Audio(decode=False))
for clip in clips.take(8):
    sound, rate = soundfile.read(io.BytesIO(clip["flac"]["bytes"]), dtype="float32")
    print(clip["__key__"], sound.shape, rate, clip["json"]["factors"])
table = datasets.load_dataset("parquet", data_files=f"{sys.argv[1]}/*.parquet", split="train")
print(table[0]["contacts"][0]["impulse"], len(table[0]["objects"][0]["modes"]["frequency"]))
