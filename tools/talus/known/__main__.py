"""python -m talus.known nulls|spike|across|camera|gate: see docs/nulls.md, docs/spike.md, docs/across.md, docs/camera.md and docs/gate.md."""

import sys

from .command import main

sys.exit(main(sys.argv[1:]))
