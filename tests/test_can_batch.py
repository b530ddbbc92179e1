"""What talus-acquire takes from the kernel's control messages: no virtual interface has hardware stamps, so here they are
made by hand, in the kernel's layout."""

import ctypes
import struct
import subprocess

import pytest
from support import REPOSITORY

pytestmark = pytest.mark.release  # compiled here, not from the build

FRAME, ERROR_ITEM, FD = 0, 1, 0x10
CAN, CANFD = 16, 72


class Given(ctypes.Structure):
    _fields_ = [("software_ns", ctypes.c_int64), ("hardware_ns", ctypes.c_int64), ("plain_ns", ctypes.c_int64),
                ("drops", ctypes.c_int64), ("size", ctypes.c_uint32), ("data", ctypes.c_uint8 * 80)]  # fmt: skip


class Item(ctypes.Structure):
    _fields_ = [("kind", ctypes.c_uint8), ("source", ctypes.c_uint8), ("length", ctypes.c_uint8), ("flags", ctypes.c_uint8),
                ("id", ctypes.c_uint32), ("real_ns", ctypes.c_int64), ("hardware_ns", ctypes.c_int64),
                ("data", ctypes.c_uint8 * 64)]  # fmt: skip


@pytest.fixture(scope="module")
def parts(tmp_path_factory):
    library = tmp_path_factory.mktemp("parts") / "parts.so"
    source = REPOSITORY / "tests/can_batch_parts.c"
    subprocess.run(["gcc", "-std=gnu11", "-shared", "-fPIC", f"-I{REPOSITORY}/apps", "-o", library, source], check=True)
    return ctypes.CDLL(str(library))


def take(parts, data, software=-1, hardware=-1, plain=-1, drops=-1):
    """(answer, item, counter) of one message."""
    given = Given(software, hardware, plain, drops, len(data))
    given.data[: len(data)] = data
    item, counter = Item(), ctypes.c_uint32()
    return parts.parts_item(ctypes.byref(given), ctypes.byref(item), ctypes.byref(counter)), item, counter.value


def classic(identifier=0x123, data=b"\1\2\3", length=None):
    return struct.pack("=IB3x8s", identifier, len(data) if length is None else length, data)


def test_both_stamps_of_a_driver_with_a_clock(parts):
    answer, item, drops = take(parts, classic(), software=1_700_000_000_123_456_789, hardware=42_000_000_017, drops=5)
    assert answer == 0 and (item.real_ns, item.hardware_ns, drops) == (1_700_000_000_123_456_789, 42_000_000_017, 5)
    assert (item.kind, item.id, bytes(item.data[: item.length])) == (FRAME, 0x123, b"\1\2\3")


def test_a_driver_without_one(parts):
    _, item, drops = take(parts, classic(), software=1_700_000_000_000_000_001)
    assert (item.real_ns, item.hardware_ns, drops) == (1_700_000_000_000_000_001, 0, 77)


def test_only_hardware(parts):
    """The kernel's stamp stays unknown, and is not 1970."""
    _, item, _ = take(parts, classic(), hardware=9)
    assert (item.real_ns, item.hardware_ns) == (0, 9)


def test_plain_stamps(parts):
    _, item, _ = take(parts, classic(), plain=1_600_000_000_999_999_999)
    assert item.real_ns == 1_600_000_000_999_999_999


def test_fd_frames_keep_their_two_flags(parts):
    data = bytes(range(64))
    answer, item, _ = take(parts, struct.pack("=IBB2x64s", 0x7FF, 64, 0x07, data), software=1)
    assert answer == 0 and item.flags == FD | 3 and bytes(item.data) == data


def test_error_frames_are_told_apart(parts):
    _, item, _ = take(parts, classic(identifier=0x20000040, data=bytes(8)), software=1)
    assert item.kind == ERROR_ITEM


@pytest.mark.parametrize("data", [b"", b"x" * 15, b"x" * 17, classic(length=9), struct.pack("=IB3x64s", 1, 65, b"")])
def test_what_is_no_frame(parts, data):
    assert take(parts, data, software=1)[0] == -1
