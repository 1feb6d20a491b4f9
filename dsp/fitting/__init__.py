"""Objects from recordings of strikes, and how far apart two sounds are. It needs scipy."""

from ..errors import require_scipy

require_scipy("to fit or to compare sounds", "fit")
