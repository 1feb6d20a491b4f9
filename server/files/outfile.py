"""Files that a server writes as it goes."""

import os
import stat
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


class OutFile:
    """A file to be written anew, opened beforehand to know that it can be; an older one is left as it is until then.

    OSError, naming it, if it can't be opened, or is being written by this or another process.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.begun = False
        self._new = not path.exists()
        self.descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        self._plain = stat.S_ISREG(os.fstat(self.descriptor).st_mode)
        if self._plain and fcntl:
            try:
                fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                os.close(self.descriptor)
                raise OSError(error.errno, "is being written already", str(path)) from error

    def begin(self) -> None:
        """Empty it; OSError, naming it, where that can't be."""
        try:
            os.ftruncate(self.descriptor, 0)
        except OSError as error:
            raise OSError(error.errno, f"{error.strerror}: expected a plain file", str(self.path)) from error
        self.begun = True

    def write(self, data: bytes) -> None:
        """Add to it, out of this process at once; OSError where not all of it can be, and then nothing is."""
        before = os.lseek(self.descriptor, 0, os.SEEK_CUR) if self._plain else 0
        try:
            while data:
                data = data[os.write(self.descriptor, data) :]
        except OSError:
            if self._plain:
                os.ftruncate(self.descriptor, before)
            raise

    def close(self) -> None:
        """Close it; one that was never begun is taken away again."""
        os.close(self.descriptor)
        if self._new and not self.begun:
            self.path.unlink()
