"""status.h: pinned numbers, and a text of its own for each."""

import re

from support import REPOSITORY
from talus import ffi, lib

# what a program compiled against an older talus relies on
PINNED = {
    "TL_OK": 0,
    "TL_ERR_ARGUMENT": -1,
    "TL_ERR_RANGE": -2,
    "TL_ERR_TOO_SHORT": -3,
    "TL_ERR_NOT_FINITE": -4,
    "TL_ERR_SINGULAR": -5,
    "TL_ERR_NO_CONVERGENCE": -6,
    "TL_ERR_WORKSPACE": -7,
    "TL_ERR_UNSUPPORTED": -8,
}


def text(status):
    return ffi.string(lib.tl_status_text(status)).decode()


def enumerators():
    header = (REPOSITORY / "include/talus/status.h").read_text()
    return re.findall(r"^  (TL_\w+) = ", header, re.MULTILINE)


def test_numbers_are_pinned():
    for name, number in PINNED.items():
        assert getattr(lib, name) == number


def test_every_status_has_a_text_of_its_own():
    names = enumerators()
    assert set(PINNED) <= set(names)
    texts = {text(getattr(lib, name)) for name in names}
    assert len(texts) == len(names)
    assert "unknown status" not in texts


def test_other_numbers_are_unknown():
    for number in (1, 99, -99, -(2**31), 2**31 - 1):
        assert text(number) == "unknown status"
