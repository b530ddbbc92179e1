"""python -m talus.known nulls|spike|camera|gate: see docs/nulls.md, docs/spike.md, docs/camera.md and docs/gate.md."""

import sys

from .command import main

sys.exit(main(sys.argv[1:]))
