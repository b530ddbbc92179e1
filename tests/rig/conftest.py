"""Interfaces and files for the tests that need a real kernel; docs/rig.md says how `make rig` has one."""

import socket
import subprocess

import pytest


def has_can():
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        return False
    return True


@pytest.fixture
def vcan():
    """Makes virtual CAN interfaces, as many as asked for, and takes them away again."""
    made = []

    def make(count=1):
        if not has_can():
            pytest.skip("this kernel has no SocketCAN: `make rig` brings one")
        names = [f"tlcan{len(made) + i}" for i in range(count)]
        for name in names:
            subprocess.run(["ip", "link", "add", "dev", name, "type", "vcan"], check=True)
            made.append(name)
            subprocess.run(["ip", "link", "set", name, "mtu", "72", "up"], check=True)
        return names

    yield make
    for name in made:
        subprocess.run(["ip", "link", "del", "dev", name], check=False, stderr=subprocess.DEVNULL)
