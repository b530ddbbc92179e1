"""What an interface that vanished has not handed over: the figures against frames that are followed one by one. On a real kernel
tests/rig/test_acquire_plugging.py does it."""

import ctypes
import random
import subprocess

import pytest
from support import REPOSITORY

pytestmark = pytest.mark.release  # compiled here, not from the build


@pytest.fixture(scope="module")
def missing(tmp_path_factory):
    library = tmp_path_factory.mktemp("parts") / "parts.so"
    source = REPOSITORY / "tests/tally_parts.c"
    subprocess.run(["gcc", "-std=gnu11", "-shared", "-fPIC", f"-I{REPOSITORY}/apps", "-o", library, source], check=True)
    call = ctypes.CDLL(str(library)).parts_missing

    def ask(driver, begin, end, read, spread=0):
        """(received, lost, more, unknown); begin, end: (received, dropped); read: (of others, own, lost in the socket)."""
        answer = (ctypes.c_uint64 * 4)()
        call(driver.encode(), (ctypes.c_uint64 * 2)(*begin), (ctypes.c_uint64 * 2)(*end), (ctypes.c_uint64 * 3)(*read),
             ctypes.c_uint64(spread), answer)  # fmt: skip
        return tuple(answer)

    return ask


def test_each_frame_followed(missing):
    """A virtual interface: each frame is read, or lost in one of the four places; only two of them at once cannot be told apart."""
    generator = random.Random(1)
    exact = 0
    for _ in range(2000):
        places = generator.choices(("read", "backlog", "full", "closing", "socket"), (90, *generator.choices((0, 0, 3), k=4)), k=200)
        n = {place: places.count(place) for place in ("read", "backlog", "full", "closing", "socket")}
        received = n["read"] + n["backlog"] + n["full"] + n["socket"]  # "closing": the driver never had it
        dropped = n["full"] + n["closing"]
        told, lost, more, unknown = missing("vcan", (1000, 10), (1000 + received, 10 + dropped), (0, n["read"], n["socket"]))
        truth = n["backlog"] + n["full"] + n["closing"]
        assert told == received and not unknown
        assert dropped + lost <= truth <= dropped + lost + more  # the counter of dropped frames tells the first
        exact += more == 0
        if not dropped or not n["backlog"] + n["full"]:
            assert more == 0
    assert 200 < exact < 2000


def test_a_beginning_under_load(missing):
    """Frames between the two readings of the counters may have been before the beginning: at most so many more."""
    assert missing("vcan", (100, 0), (150, 0), (0, 45, 0), spread=3) == (50, 2, 3, 0)
    assert missing("vcan", (100, 0), (150, 0), (0, 49, 0), spread=3) == (50, 0, 1, 0)


def test_what_stands_before_a_real_interface_is_in_no_count(missing):
    assert missing("can", (0, 0), (50, 0), (50, 0, 0)) == (50, 0, 0, 1)
    assert missing("", (0, 0), (50, 0), (40, 9, 0)) == (50, 10, 0, 1)


def test_only_its_peers_frames_are_counted_by_a_vxcan(missing):
    assert missing("vxcan", (0, 0), (50, 0), (48, 0, 0)) == (50, 2, 0, 0)
    assert missing("vxcan", (0, 0), (50, 0), (50, 9, 0)) == (50, 0, 0, 1)
