"""Files that a server writes as it goes."""

import os
from pathlib import Path


class OutFile:
    """A file to be written anew, opened beforehand to know that it can be; an older one is left as it is until then.

    OSError, naming it, if it can't be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.begun = False
        self._new = not path.exists()
        self.descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)

    def begin(self) -> None:
        """Empty it; OSError, naming it, where that can't be."""
        try:
            os.ftruncate(self.descriptor, 0)
        except OSError as error:
            raise OSError(error.errno, f"{error.strerror}: expected a plain file", str(self.path)) from error
        self.begun = True

    def write(self, data: bytes) -> None:
        """Add to it, out of this process at once."""
        while data:
            data = data[os.write(self.descriptor, data) :]

    def close(self) -> None:
        """Close it; one that was never begun is taken away again."""
        os.close(self.descriptor)
        if self._new and not self.begun:
            self.path.unlink()
