"""python -m talus.known nulls|spike: see docs/nulls.md and docs/spike.md."""

import sys

from .command import main

sys.exit(main(sys.argv[1:]))
