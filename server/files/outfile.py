"""Files that a server writes as it goes."""

import errno
import os
import stat
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]


def write_whole(descriptor: int, data: bytes) -> None:
    """Write all data at a file's position. OSError where that fails; a file that had grown is cut to its old size."""
    size = os.fstat(descriptor).st_size
    try:
        while data:
            data = data[os.write(descriptor, data) :]
    except OSError:
        if stat.S_ISREG(os.fstat(descriptor).st_mode):
            os.ftruncate(descriptor, size)
            os.lseek(descriptor, 0, os.SEEK_END)
        raise


class OutFile:
    """A file that will be written anew. It is opened at once, to know that it can be, and keeps its content until then.

    OSError, naming the file, if it cannot be opened, or if this or another process is writing it.
    """

    def __init__(self, path: Path, anew: bool = False) -> None:
        """Open the file to write; if `anew`, raise OSError where something of that name is there already."""
        self.path = path
        self.begun = False
        self._target = path.resolve()  # what a symbolic link leads to
        self._new = not path.exists()
        binary = getattr(os, "O_BINARY", 0)  # or else Windows writes 0x0A as 0x0D 0x0A
        self.descriptor = os.open(path, os.O_RDWR | os.O_CREAT | binary | (os.O_EXCL if anew else 0), 0o666)
        if fcntl and stat.S_ISREG(os.fstat(self.descriptor).st_mode):
            try:
                fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                os.close(self.descriptor)
                raise OSError(error.errno, "is being written already", str(path)) from error

    @property
    def is_closed(self) -> bool:
        """True once it was closed: its descriptor may be another file's then."""
        return self.descriptor < 0

    def begin(self) -> None:
        """Empty the file. OSError, naming it, where that fails."""
        try:
            os.ftruncate(self.descriptor, 0)
        except OSError as error:
            raise OSError(error.errno, f"{error.strerror}: expected a plain file", str(self.path)) from error
        self.begun = True

    def require_room(self, size: int) -> None:
        """Raise OSError if an empty file cannot grow to so many bytes now. Who writes next may still find no room."""
        if size and stat.S_ISREG(os.fstat(self.descriptor).st_mode):
            write_whole(self.descriptor, bytes(size))
            os.ftruncate(self.descriptor, 0)
            os.lseek(self.descriptor, 0, os.SEEK_SET)

    def write(self, data: bytes) -> None:
        """Append data, which leaves this process at once. OSError where not all can be written, and then none is."""
        write_whole(self.descriptor, data)

    def require_name(self) -> None:
        """Raise OSError if the file has been removed, so that what is written to it is lost."""
        status = os.fstat(self.descriptor)
        if stat.S_ISREG(status.st_mode) and status.st_nlink == 0:
            raise OSError(errno.ENOENT, "it was removed", str(self.path))

    def close(self) -> None:
        """Close the file, if it is not, and remove it if it is new and was never begun."""
        if self.is_closed:
            return
        os.close(self.descriptor)
        self.descriptor = -1
        if self._new and not self.begun:
            self._target.unlink(missing_ok=True)
