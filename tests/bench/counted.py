"""The one argument of scripts that try so many random cases."""

import argparse


def counted(about: str | None, default: int) -> int:
    """Return how many cases the command line asks for; about: the script's docstring, for --help."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("count", type=int, nargs="?", default=default, help="cases (%(default)s)")
    return int(parser.parse_args().count)
