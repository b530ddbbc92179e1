"""What long work says on a terminal: a line that draws over itself; nothing elsewhere."""

import sys
import time


class Step:
    """What is being done."""

    def __init__(self, name: str, quiet: bool = False) -> None:
        self.name, self.shown = name, sys.stderr.isatty() and not quiet

    def __call__(self, text: str) -> None:
        self.draw(f"{self.name}: {text}")

    def end(self) -> None:
        """The line is gone."""
        self.draw("")

    def draw(self, text: str, end: str = "") -> None:
        if self.shown:
            print(f"\r\033[K{text}", end=end, file=sys.stderr, flush=True)


class Progress(Step):
    """How much of it is done, and how long the rest will take."""

    def __init__(self, name: str, count: int, quiet: bool = False) -> None:
        super().__init__(name, quiet)
        self.count, self.done, self.begin = count, 0, time.monotonic()

    def __call__(self, text: str) -> None:
        self.done += 1
        left_min = (time.monotonic() - self.begin) / self.done * (self.count - self.done) / 60
        self.draw(f"{self.name}: {self.done} of {self.count}, {left_min:.0f} min to go: {text}", "" if self.done < self.count else "\n")
