"""A line of a chip that fake_gpio.c is, for tests whose subject is what an edge does on a CAN interface."""

import os
import struct
import time


class Button:
    """It falls when it is pressed; `environment` is for the program that looks at fakechip:4."""

    def __init__(self, folder, library):
        self.folder, self.pressed_times = folder, 0
        os.mkfifo(folder / "events")
        self.level(1)
        self.fifo = os.open(folder / "events", os.O_RDWR)
        self.environment = {"LD_PRELOAD": str(library), "FAKE_GPIO": str(folder)}

    def level(self, value):
        (self.folder / "level").write_text(str(value))

    def press(self):
        """The edge; its time."""
        self.pressed_times += 1
        now = time.monotonic_ns()
        os.write(self.fifo, struct.pack("=QIIII24x", now, 2, 4, self.pressed_times, self.pressed_times))
        return now
