"""Interfaces, a button and files for the tests that need a real kernel; docs/rig.md says how `make rig` has one."""

import os
import socket
import subprocess
from pathlib import Path

import pytest
from button import Button
from support import REPOSITORY


def has_can():
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        return False
    return True


def need_can():
    if not has_can():
        pytest.skip("this kernel has no SocketCAN: `make rig` brings one")


@pytest.fixture
def deep_backlog():
    """Room for a whole burst between interface and socket. Where the kernel leaves receiving to a process of its own, which waits
    for its turn, a thousand frames are soon full: whenever the guest has stood still, senders make up for it. The loss is then the
    interface's and has no place in the log, while these tests are about what the programs do."""
    need_can()
    limit = Path("/proc/sys/net/core/netdev_max_backlog")
    before = limit.read_text(encoding="ascii")
    limit.write_text("300000", encoding="ascii")
    yield
    limit.write_text(before, encoding="ascii")


@pytest.fixture
def vcan(deep_backlog):
    """Makes virtual CAN interfaces, as many as asked for, and takes them away again."""
    made = []

    def make(count=1):
        names = [f"tlcan{len(made) + i}" for i in range(count)]
        for name in names:
            subprocess.run(["ip", "link", "add", "dev", name, "type", "vcan"], check=True)
            made.append(name)
            subprocess.run(["ip", "link", "set", name, "mtu", "72", "up"], check=True)
        return names

    yield make
    for name in made:
        subprocess.run(["ip", "link", "del", "dev", name], check=False, stderr=subprocess.DEVNULL)


@pytest.fixture(scope="session")
def fake_gpio(tmp_path_factory):
    library = tmp_path_factory.mktemp("gpio") / "fake_gpio.so"
    subprocess.run(["gcc", "-O1", "-shared", "-fPIC", "-o", library, REPOSITORY / "tests/rig/fake_gpio.c"], check=True)
    return library


@pytest.fixture
def button(tmp_path, fake_gpio):
    folder = tmp_path / "gpio"
    folder.mkdir()
    button = Button(folder, fake_gpio)
    yield button
    os.close(button.fifo)
