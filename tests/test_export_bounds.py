"""Numbers of a DBC that cantools would make lists of: refused before it reads them, the line named."""

import pytest
from talus.acquire_export.layout import Database
from talus.refused import Refused

TEXT = """VERSION ""
BU_: A
BO_ 100 M: BYTES A
 SG_ S M : 0|16@1+ (1,0) [0|0] "BO_ 1 M : 9999" A
 // a comment: 99999|99999@
 SG_ a m0 : START|BITS@1+ (1,0) [0|99999] "" A
CM_ "99999|99999@, and
SG_MUL_VAL_ 1 0-99999;";
SG_MUL_VAL_ 100 a S 0-3, 7-LAST;
"""


def read(folder, **changes):
    text = TEXT
    for word, number in {"BYTES": 8, "START": 16, "BITS": 8, "LAST": 9, **changes}.items():
        text = text.replace(word, str(number))
    (folder / "x.dbc").write_text(text)
    return Database.read(folder / "x.dbc")


@pytest.mark.parametrize("changes", [{}, {"BYTES": 1785, "START": 14272}, {"LAST": 10_002}], ids=str)
def test_what_is_within_is_read(tmp_path, changes):
    message = read(tmp_path, **changes).by_name("M")
    assert message.length == changes.get("BYTES", 8) and message.fields["a"].bytes == changes.get("START", 16) // 8 + 1
    assert message.fields["a"].selected_by.tolist() == [*range(4), *range(7, changes.get("LAST", 9) + 1)]


@pytest.mark.parametrize(("changes", "words"), [
    ({"START": 2**31}, "line 6: a signal's bits 2147483648|8; expected numbers up to 14280"),
    ({"BITS": 2**31}, "line 6: a signal's bits 16|2147483648; expected numbers up to 14280"),
    ({"BYTES": 1786}, "line 3: a message of 1786 bytes; expected at most 1785"),
    ({"LAST": 2**31}, "line 9: 2147483646 values of multiplexers up to here; expected at most 10000 in a file"),
    ({"LAST": 10_003}, "line 9: 10001 values of multiplexers up to here; expected at most 10000 in a file"),
], ids=str)  # fmt: skip
def test_what_is_beyond_is_refused(tmp_path, changes, words):
    with pytest.raises(Refused) as refused:
        read(tmp_path, **changes)
    assert refused.value.status == 2 and refused.value.text == f"{tmp_path / 'x.dbc'}: {words}"
