"""Frames for talus-acquire without a CAN interface: its `fd:` source, which takes them from a socket pair.

    with FrameSource(tmp_path / "r", "bench") as source:
        source.send(0x201, bytes(8), stamp_ns=...)
    source.events("error"), source.log

A message is what the kernel's SocketCAN gives, struct can_frame or canfd_frame, and a realtime stamp behind it. The
socket holds back the sender when it is full, so nothing is lost on this way.
"""

import json
import socket
import struct
import subprocess
from pathlib import Path

from support import program

EXTENDED, REMOTE, ERROR = 1 << 31, 1 << 30, 1 << 29
BRS, ESI = 1, 2


def frame(identifier, data=b"", stamp_ns=0, fd=False, flags=0, length=None):
    """The bytes of one message."""
    size = 64 if fd else 8
    head = struct.pack("=IBBBB", identifier, len(data) if length is None else length, flags if fd else 0, 0, 0)
    stamp = struct.pack("=q", stamp_ns) if stamp_ns else b""
    return head + data.ljust(size, b"\0") + stamp


class FrameSource:
    def __init__(self, out, *names, options=(), sources=(), stderr=subprocess.PIPE, path=None):
        self.log, self.side = Path(f"{out}.log"), Path(f"{out}.jsonl")
        pairs = {name: socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET) for name in names or ("bench",)}
        self.socket = {name: mine for name, (mine, _) in pairs.items()}
        given = [f"fd:{name}={theirs.fileno()}" for name, (_, theirs) in pairs.items()]
        command = [str(path or program("talus-acquire")), "--out", str(out), *map(str, options), *sources, *given]
        theirs = [end for _, end in pairs.values()]
        self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=stderr,
                                        text=True, pass_fds=[end.fileno() for end in theirs])  # fmt: skip
        for end in theirs:
            end.close()
        self.first = next(iter(self.socket))

    def send(self, *arguments, to=None, **more):
        self.socket[to or self.first].send(frame(*arguments, **more))

    def close(self):
        """The sources end, and with them the recording; what it printed."""
        for end in self.socket.values():
            end.close()
        self.printed = self.process.communicate(timeout=60)[1]
        self.status = self.process.returncode
        return self.printed

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind:
            self.process.kill()
        if not self.process.stdout.closed:
            self.close()

    def events(self, kind=None):
        found = [json.loads(line) for line in self.side.read_text().splitlines()]
        return [event for event in found if kind in (None, event["type"])]

    def lines(self):
        return self.log.read_text().splitlines()
