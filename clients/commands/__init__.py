"""The commands of `carom`: one file for each, with its options and what it does.

The needs of a command are imported when it runs, so that `carom send` does not wait for a compiler to load.
"""
