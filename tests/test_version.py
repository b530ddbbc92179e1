"""version.h, the library, the Makefile and the changelog name the same version."""

import re

from support import REPOSITORY, make_variable
from talus import constants, ffi, lib


def test_library_and_headers_agree():
    parts = [constants.TL_VERSION_MAJOR, constants.TL_VERSION_MINOR, constants.TL_VERSION_PATCH]
    version = ".".join(map(str, parts))
    assert ffi.string(lib.tl_version()).decode() == version
    assert make_variable("VERSION") == [version]


def test_changelog_has_a_place_for_the_next_change():
    headings = re.findall(r"^## \[(.*?)\]", (REPOSITORY / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert headings[0] == "Unreleased"
