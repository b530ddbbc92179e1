"""When the guest itself stood still, so that a limit of time can be held to the program alone.

    with Pauses(tmp_path / "pauses") as pauses:
        ...
    pauses.within(begin_ns, end_ns)

A process of its own wants to wake every millisecond, or as often as is said, before any thread of the program's, whatever those do (SCHED_FIFO, the highest
priority). What it wakes late is time that the machine did not give to the guest, or that one call of the kernel took. Times are monotonic.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

EVERY_NS, LATE_NS = 1_000_000, 200_000


class Pauses:
    def __init__(self, path, every_ns=EVERY_NS, late_ns=LATE_NS):
        self.path = Path(path)
        self.process = subprocess.Popen([sys.executable, __file__, path, str(every_ns), str(late_ns)])
        while not self.path.exists() and self.process.poll() is None:
            time.sleep(0.01)
        assert self.process.poll() is None, "no process of the highest priority here"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        time.sleep(0.1)  # a pause is written down at its end
        self.process.kill()
        self.process.wait()

    def within(self, begin_ns, end_ns):
        """How much of this time the guest stood still [ns]; to be asked when all is over."""
        return sum(self.each_within(begin_ns, end_ns))

    def each_within(self, begin_ns, end_ns):
        """Each pause of this time [ns]."""
        whole_lines = self.path.read_text().splitlines(keepends=True)
        found = [tuple(map(int, line.split())) for line in whole_lines if line.endswith("\n")]
        return [max(min(end_ns, end) - max(begin_ns, begin), 0) for begin, end in found]


def watch(path, every_ns, late_ns):
    """Writes begin and end of each pause, one a line."""
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(os.sched_get_priority_max(os.SCHED_FIFO)))
    with open(path, "w", encoding="ascii", buffering=1) as file:
        while True:
            due = time.monotonic_ns() + every_ns
            time.sleep(every_ns / 1e9)
            now = time.monotonic_ns()
            if now - due > late_ns:
                file.write(f"{due} {now}\n")


if __name__ == "__main__":
    watch(sys.argv[1], *map(int, sys.argv[2:]))
