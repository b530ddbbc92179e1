"""What long work says on a terminal: how much of it is done, and how long the rest will take."""

import sys
import time


class Progress:
    """A line that draws over itself on a terminal; nothing elsewhere."""

    def __init__(self, name: str, count: int, quiet: bool = False) -> None:
        self.name, self.count, self.done, self.begin = name, count, 0, time.monotonic()
        self.shown = sys.stderr.isatty() and not quiet

    def __call__(self, text: str) -> None:
        self.done += 1
        if self.shown:
            left_min = (time.monotonic() - self.begin) / self.done * (self.count - self.done) / 60
            print(f"\r\033[K{self.name}: {self.done} of {self.count}, {left_min:.0f} min to go: {text}",
                  end="" if self.done < self.count else "\n", file=sys.stderr, flush=True)  # fmt: skip
