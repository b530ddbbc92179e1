"""What long work says on a terminal: a line that draws over itself; nothing elsewhere."""

import sys
import time
from collections.abc import Mapping

WIPE = "\r\033[K"


def say(text: str) -> None:
    """A line that stays, where work draws."""
    print(f"{WIPE if sys.stderr.isatty() else ''}{text}", file=sys.stderr)


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
            print(f"{WIPE}{text}", end=end, file=sys.stderr, flush=True)


class Stages(Step):
    """How far the stages of one piece of work are. `begins`: percent of the whole at which each begins, as a rule; what stands
    not there is a part of the stage before it."""

    def __init__(self, name: str, begins: Mapping[str, float], quiet: bool = False) -> None:
        super().__init__(name, quiet)
        self.begins, self.stage, self.percent = begins, 0.0, 0.0

    def __call__(self, text: str, part: float = 0.0) -> None:
        """`part`: how much of the stage is done, 0..1."""
        self.stage = self.begins.get(text, self.stage)
        next_one = min((begin for begin in self.begins.values() if begin > self.stage), default=100.0)
        self.percent = max(self.percent, self.stage + part * (next_one - self.stage))
        self.draw(f"{self.name}: {text} {self.percent:3.0f} %")


class Progress(Step):
    """How much of it is done, and how long the rest will take."""

    def __init__(self, name: str, count: int, quiet: bool = False) -> None:
        super().__init__(name, quiet)
        self.count, self.done, self.begin = count, 0, time.monotonic()

    def __call__(self, text: str) -> None:
        self.done += 1
        left_min = (time.monotonic() - self.begin) / self.done * (self.count - self.done) / 60
        self.draw(f"{self.name}: {self.done} of {self.count}, {left_min:.0f} min to go: {text}", "" if self.done < self.count else "\n")
