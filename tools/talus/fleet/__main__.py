"""python -m talus.fleet: talus-fleet."""

import sys

from .command import main


def run():
    sys.exit(main(sys.argv[1:]))


if __name__ == "__main__":
    run()
