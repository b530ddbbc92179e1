"""python -m talus.acquire_export: talus-acquire-export."""

import sys

from .command import main

sys.exit(main(sys.argv[1:]))
