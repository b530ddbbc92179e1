"""python -m talus.known nulls|spike|camera: see docs/nulls.md, docs/spike.md and docs/camera.md."""

import sys

from .command import main

sys.exit(main(sys.argv[1:]))
