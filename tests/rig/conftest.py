"""Interfaces, a button and files for the tests that need a real kernel; docs/rig.md says how `make rig` has one. And what fails in a
guest that stood still is tried again."""

import os
import socket
import subprocess
import time
from pathlib import Path

import pytest
from _pytest.runner import runtestprotocol
from button import Button
from pauses import Pauses
from support import REPOSITORY

TRIES = 3
EVERY_NS, STOOD_STILL_NS = 20_000_000, 100_000_000
WATCH, AGAIN = pytest.StashKey(), pytest.StashKey()


def pytest_runtest_protocol(item, nextitem):
    """A test that fails while the guest stood still for a tenth of a second says nothing of programs that work every millisecond: it is
    tried again, up to three times in all, and named at the end. One that fails in a guest that ran fails."""
    stash, hook = item.config.stash, item.ihook
    hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for left in reversed(range(TRIES)):
        watch, begin_ns = watch_of(stash), time.monotonic_ns()
        reports = runtestprotocol(item, log=False, nextitem=nextitem)
        failed = [report for report in reports if report.failed]
        longest_ns = longest_pause_ns(watch, begin_ns) if failed else 0
        if longest_ns < STOOD_STILL_NS or not left:
            break
        stash.setdefault(AGAIN, []).append((item.nodeid, longest_ns, failed[0].longreprtext.splitlines()[-1]))
    for report in reports:
        hook.pytest_runtest_logreport(report=report)
    hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def watch_of(stash):
    """One for all tests, begun with the first; None where nobody may have the highest priority."""
    if WATCH not in stash:
        folder = Path("/dev/shm" if Path("/dev/shm").is_dir() else "/tmp")
        stash[WATCH] = Pauses(folder / f"pauses-{os.getpid()}", EVERY_NS, STOOD_STILL_NS) if os.geteuid() == 0 and has_can() else None
    return stash[WATCH]


def longest_pause_ns(watch, begin_ns):
    if not watch:
        return 0
    time.sleep(2 * EVERY_NS / 1e9)  # a pause is written down at its end
    return max(watch.each_within(begin_ns, time.monotonic_ns()), default=0)


def pytest_terminal_summary(terminalreporter, config):
    again = config.stash.get(AGAIN, [])
    if again:
        terminalreporter.section(f"tried again, for the guest stood still: {len(again)}")
    for name, longest_ns, why in again:
        terminalreporter.write_line(f"{name}: {longest_ns / 1e6:.0f} ms at a time; {why}")


def pytest_unconfigure(config):
    watch = config.stash.get(WATCH, None)
    if watch:
        watch.__exit__()
        watch.path.unlink(missing_ok=True)


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
