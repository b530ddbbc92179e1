"""python -m talus.exporting: talus-export."""

import sys

from .command import main


def run() -> None:
    sys.exit(main(sys.argv[1:]))


if __name__ == "__main__":
    run()
