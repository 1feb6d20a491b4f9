"""`python -m carom` is the command `carom`."""

import sys

from .clients.cli import main

sys.exit(main())
