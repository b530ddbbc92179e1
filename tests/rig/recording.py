"""Starts talus-acquire, and reads what it wrote with nothing of its own: text, JSON, struct.

    with Recording(tmp_path / "r", "can0", "can1") as recording:
        ...
    recording.finish()
    frames, events = read_log(recording.log), recording.events("drop")
"""

import fcntl
import json
import re
import signal
import socket
import struct
import subprocess
import time
from array import array
from collections import defaultdict
from pathlib import Path

from support import BUILD, program

SIOCGIFFLAGS, SIOCSIFFLAGS, IFF_UP = 0x8913, 0x8914, 1
SOURCE = BUILD / "tests" / "can_source"
LINE = re.compile(r"\((\d{10}\.\d{6})\) (\S+) ([0-9A-F]+)#(.*)\n")


def lines_of(path):
    """(seconds as text, interface, id, payload) of each line of a log; each must be whole."""
    with open(path, encoding="ascii") as file:
        for line in file:
            match = LINE.fullmatch(line)
            assert match, line
            yield match.groups()


def read_lines(path):
    return list(lines_of(path))


def counters(path):
    """{interface: (microseconds, counters)} of a log of can_source's frames; arrays, for there are many."""
    found = defaultdict(lambda: (array("q"), array("q")))
    for seconds, interface, _, payload in lines_of(path):
        stamps, numbers = found[interface]
        stamps.append(int(seconds.replace(".", "")))
        numbers.append(int.from_bytes(bytes.fromhex(payload[:8]), "little"))
    return found


class Recording:
    """A talus-acquire that runs; `arguments` are sources and options."""

    def __init__(self, out, *arguments, pass_fds=(), path=None):
        self.log, self.side = Path(f"{out}.log"), Path(f"{out}.jsonl")
        command = [str(path or program("talus-acquire")), "--out", str(out), *map(str, arguments)]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, pass_fds=pass_fds)
        deadline = time.monotonic() + 120  # under the sanitizer in a guest without a processor of its own it takes its time
        while not (self.side.exists() and self.side.stat().st_size) and self.process.poll() is None:
            assert time.monotonic() < deadline, "the recording does not begin"
            time.sleep(0.01)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()

    def kill(self):
        """SIGKILL, if it is still there."""
        self.process.kill()
        self.process.wait()

    def stop(self, status=0):
        """Ctrl-C, and the exit status that is expected (None: any); returns what was printed."""
        self.process.send_signal(signal.SIGINT)
        return self.wait(status)

    def wait(self, status=0, timeout=120):
        _, printed = self.process.communicate(timeout=timeout)
        assert status is None or self.process.returncode == status, printed
        return printed

    def events(self, kind=None):
        found = [json.loads(line) for line in self.side.read_text().splitlines()]
        return [event for event in found if kind in (None, event["type"])]

    def end(self):
        (event,) = self.events("end")
        return event

    def at_end(self, source):
        return next(one for one in self.end()["sources"] if one["name"] == source)


def ip(*arguments):
    subprocess.run(["ip", "link", *map(str, arguments)], check=True)


def flags_of(any_socket, name):
    return struct.unpack_from("16xH", fcntl.ioctl(any_socket, SIOCGIFFLAGS, struct.pack("16sH22x", name.encode(), 0)))[0]


class Plug:
    """A virtual interface out and in, by one process of `ip` that stays: a new one for each change took most of a second under load."""

    def __init__(self, name):
        self.name, self.ip = name, subprocess.Popen(["ip", "-batch", "-"], stdin=subprocess.PIPE, text=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.ip.communicate()

    def say(self, *lines):
        self.ip.stdin.write("".join(line + "\n" for line in lines))
        self.ip.stdin.flush()

    def out(self):
        self.say(f"link del {self.name}")

    def back(self):
        """In, and waits until it is up."""
        self.say(f"link add dev {self.name} type vcan", f"link set {self.name} up")
        with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as any_socket:
            until = time.monotonic() + 30
            while not self.is_up(any_socket):
                assert time.monotonic() < until and self.ip.poll() is None, f"{self.name} does not come back"
                time.sleep(0.002)

    def is_up(self, any_socket):
        try:
            return flags_of(any_socket, self.name) & IFF_UP
        except OSError:  # not there
            return False


def switch(name, up):
    """Up or down at once, where `ip` needs a process and its time."""
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as any_socket:
        flags = flags_of(any_socket, name)
        fcntl.ioctl(any_socket, SIOCSIFFLAGS, struct.pack("16sH22x", name.encode(), flags | IFF_UP if up else flags & ~IFF_UP))


def send(*arguments, timeout=300):
    """can_source with these arguments; {interface: frames sent}."""
    done = subprocess.run([SOURCE, *map(str, arguments)], check=True, capture_output=True, text=True, timeout=timeout)
    return {name: int(sent) for name, sent, _ in map(str.split, done.stdout.splitlines())}


def hold_up(process):
    """SIGSTOP, and every thread has come to a stop."""
    process.send_signal(signal.SIGSTOP)
    tasks = list(Path(f"/proc/{process.pid}/task").iterdir())
    while not all(") T " in (task / "stat").read_text() for task in tasks):
        time.sleep(0.01)
