"""tools/talus/acquire_export/layout: every field of DBCs that are drawn here, against cantools' own decode."""

import warnings

import cantools
import numpy as np
import pytest
from random_dbc import WHOLE, random_dbc
from talus.acquire_export.layout import Database
from talus.refused import Refused

FRAMES = 12  # of each message, of random bytes
FEW, MANY = range(20), range(20, 520)


def is_same(got, expected):
    return got == float(expected) or np.isnan(got) and np.isnan(expected)


def compare_message(message, mine, data):
    """Values, and which frames have which signals; how many values were compared."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # the export's errors are one line
        columns = {name: (mine.decode(name, data), mine.holds(name, data)) for name in mine.fields}
    compared = 0
    for i, row in enumerate(data):
        try:
            expected = message.decode(row[:message.length].tobytes(), decode_choices=False)
        except cantools.database.DecodeError:
            continue  # a multiplexer's value that selects nothing
        assert {name for name, (_, there) in columns.items() if there[i]} == set(expected), message.name
        for name, value in expected.items():
            assert is_same(columns[name][0][i], value), (message.name, name, value, columns[name][0][i])
            compared += 1
    return compared


def compare_with_cantools(text, folder, seed):
    """How many values were compared."""
    path = folder / "x.dbc"
    path.write_text(text)
    ours, theirs = Database.read(path), cantools.database.load_string(text, "dbc")
    assert len(ours.messages) == len(theirs.messages)
    data = np.random.default_rng(seed).integers(0, 256, (FRAMES, 64), np.uint8)
    data[0], data[1] = 0, 255
    return sum(compare_message(message, ours.by_name(message.name), data) for message in theirs.messages)


@pytest.mark.parametrize("seeds", [FEW, pytest.param(MANY, marks=pytest.mark.long)], ids=["few", "many"])
def test_random_dbcs_are_decoded_as_cantools_does(tmp_path, seeds):
    drawn, compared = [], 0
    for seed in seeds:
        text, signals = random_dbc(seed)
        compared += compare_with_cantools(text, tmp_path, seed)
        drawn += signals
    print(f"{len(seeds)} DBCs, {len(drawn)} signals, {compared} values")
    assert compared > 3 * len(drawn)
    of_whole = {(one.width, one.motorola, one.kind) for one in drawn if one.kind != "f"}
    assert of_whole == set(WHOLE)  # each width, either byte order, signed and not
    assert {(one.width, one.motorola) for one in drawn if one.kind == "f"} == {(32, False), (32, True), (64, False), (64, True)}


@pytest.mark.parametrize(("scale", "offset"), [("3", "0.25"), ("3", "-0.1"), ("3.0", "7"), ("0.1", "3"), ("1000000007", "1e-9"), ("1", "0.5")])
@pytest.mark.parametrize("sign", "+-")
@pytest.mark.parametrize("values", ["", 'VAL_ 1 W 0 "off" 1 "on" ;\n'], ids=["plain", "named"])
def test_a_wide_value_keeps_its_last_digit(tmp_path, sign, scale, offset, values):
    """64 bits are more than a double holds: the product is made of whole numbers where the scale is one."""
    text = f'VERSION ""\nBU_: N\nBO_ 1 M: 8 N\n SG_ W : 0|64@1{sign} ({scale},{offset}) [0|0] "" N\n{values}'
    assert compare_with_cantools(text, tmp_path, 1) == FRAMES


WORDS = {32: (0x7F800001, 0xFFBFFFFF, 0x7FC00000, 0x7F800000, 0xFF800000, 0x80000000, 1, 0x7F7FFFFF),
         64: (0x7FF0000000000001, 0xFFF7FFFFFFFFFFFF, 0x7FF8000000000000, 0x7FF0000000000000, 0xFFF0000000000000, 1 << 63, 1,
              0x7FEFFFFFFFFFFFFF)}  # fmt: skip


@pytest.mark.parametrize(("scale", "offset"), [("1", "0"), ("0", "0"), ("1e300", "0"), ("-2", "0.25")])
@pytest.mark.parametrize("bits", [32, 64])
def test_floating_point_words_that_are_no_number(tmp_path, bits, scale, offset):
    """Signalling and quiet NaN, infinities, the smallest and the largest: as cantools has them, and no word of NumPy's."""
    text = (f'VERSION ""\nBU_: N\nBO_ 1 M: 8 N\n SG_ F : 0|{bits}@1- ({scale},{offset}) [0|0] "" N\n'
            f'SIG_VALTYPE_ 1 F : {1 if bits == 32 else 2};\n')  # fmt: skip
    (tmp_path / "f.dbc").write_text(text)
    data = np.array([list(word.to_bytes(8, "little")) for word in WORDS[bits]], np.uint8)
    ours, theirs = Database.read(tmp_path / "f.dbc").by_name("M"), cantools.database.load_string(text, "dbc").messages[0]
    assert compare_message(theirs, ours, data) == len(data)


HUGE = "9" * 400


@pytest.mark.parametrize(("scale", "offset"), [(HUGE, "0"), (HUGE, "0.5"), ("1", HUGE), ("0.5", f"-{HUGE}")], ids=range(4))
def test_numbers_beyond_all_doubles_are_refused(tmp_path, scale, offset):
    (tmp_path / "x.dbc").write_text(f'VERSION ""\nBU_: N\nBO_ 1 M: 8 N\n SG_ W : 0|64@1+ ({scale},{offset}) [0|0] "" N\n')
    with pytest.raises(Refused, match=r"x\.dbc: does not parse as a DBC: .*too large"):
        Database.read(tmp_path / "x.dbc")
