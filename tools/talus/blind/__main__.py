"""python -m talus.blind draw|run|open: see docs/blind.md."""

import sys

from .command import main

sys.exit(main(sys.argv[1:]))
