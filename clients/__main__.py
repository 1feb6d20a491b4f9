"""`python -m carom.clients` is the command `carom`."""

import sys

from .cli import main

sys.exit(main())
