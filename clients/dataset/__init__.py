"""Data sets: a recipe declares what is drawn, and items become clips with their ground truth, on any number of workers.

`recipe` reads a TOML file and `check` tries what it may draw; `spread` and `design` make factors of an item's number;
`clip` renders it; `shard` and `table` hold the bytes of files; `plan` is what a worker needs to make a shard, and
`versions` what must be alike for equal bytes; `local` and `dask` are the workers; `run` is the whole, and resumes.
"""
