"""python -m talus.diagnosis: talus-gap."""

import gc
import sys

from .command import main

OBJECTS_BETWEEN_COLLECTIONS = 20_000  # candidates are many small objects that stay: Python's 700 looks through them all the time


def run():
    gc.freeze()  # what was imported is never garbage
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)
    sys.exit(main(sys.argv[1:]))


if __name__ == "__main__":
    run()
