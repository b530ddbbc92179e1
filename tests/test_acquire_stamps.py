"""The two stamps of a frame that an adapter with a clock has stamped. No virtual interface has such stamps: how the pair goes from the
reader to who looks at it is gone through in a model (tests/stamp_pair_model.c), and for the log the `fd:` source is given a clock."""

import re
import subprocess

import pytest
from frame_source import FrameSource
from support import REPOSITORY
from uncured import uncured

pytestmark = pytest.mark.release  # compiled here, not from the build

PAIR = REPOSITORY / "apps/acquire/host/stamp_pair.c"
SOURCE = PAIR.read_text(encoding="utf-8")
ORDERS = [m.start() for m in re.finditer("__ATOMIC_(ACQUIRE|RELEASE)", SOURCE)]
BEGIN, END = (f"  __atomic_store_n(&pair->sequence, sequence + {n}, __ATOMIC_{order});\n" for n, order in ((1, "RELAXED"), (2, "RELEASE")))
FAULTS = {
    "not counted as begun": (BEGIN, BEGIN.replace("+ 1", "+ 0")),
    "begun with the end": (BEGIN, END),
    "no second look": ("before != after || ", ""),
    "a pair that is being written": (" || before % 2", ""),
    "the count of the end is that of the beginning": (END, END.replace("+ 2", "+ 0")),
}  # fmt: skip


@pytest.fixture
def model(tmp_path):
    """A function (text of stamp_pair.c) -> (status, what the model printed)."""

    def run(text):
        (tmp_path / "stamp_pair.c").write_text(text, encoding="utf-8")
        command = ["gcc", "-std=gnu11", "-O1", f"-I{PAIR.parent}", f'-DPART="{tmp_path / "stamp_pair.c"}"']
        subprocess.run([*command, "-o", tmp_path / "model", REPOSITORY / "tests/stamp_pair_model.c"], check=True)
        done = subprocess.run([tmp_path / "model"], check=False, capture_output=True, text=True, timeout=120)
        return done.returncode, done.stdout

    return run


def test_both_stamps_are_of_one_frame(model):
    status, printed = model(SOURCE)
    assert status == 0, printed
    executions, again, none = (int(n) for n in re.findall(r" (\d+)", printed))
    assert executions > 1000 and 0 < again < executions and 0 < none < executions


@pytest.mark.parametrize("at", ORDERS)
def test_no_order_can_be_weaker(model, at):
    weaker = SOURCE[:at] + re.sub("__ATOMIC_[A-Z]+", "__ATOMIC_RELAXED", SOURCE[at:], count=1)
    status, printed = model(weaker)
    assert status == 1 and printed.startswith("violation: stamps of two frames"), printed


def test_every_order_is_tried():
    assert len(ORDERS) == 6 and SOURCE.count("__atomic_") == 9  # three more need none


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_found(model, name):
    right, wrong = FAULTS[name]
    assert SOURCE.count(right) == 1, f"stamp_pair.c no longer has {right!r}"
    status, printed = model(SOURCE.replace(right, wrong))
    assert status == 1 and printed.startswith("violation: "), printed


# ---- frames that the adapter did not stamp ------------------------------------------------------------

START_NS = 1_700_000_000 * 10**9
AHEAD_NS, DRIFT = 5 * 10**9, 1000  # the adapter's clock: 5 s ahead, and faster by a 1000th

# An adapter that stamps frames with even identifiers, as one does that stamps no frame which this machine has sent
ADAPTER = (("source/source_can.c", "  s->takes_fd_frames = 1;\n", "  s->takes_fd_frames = s->hardware_stamps = 1;\n"),
           ("source/source_can.c", "  if (item.real_ns == 0) item.real_ns = clock_real_ns();\n",
            f"  if (item.id % 2 == 0) item.hardware_ns = item.real_ns + {AHEAD_NS} + (item.real_ns - {START_NS}) / {DRIFT};\n"))  # fmt: skip
# and a program that forgets how far apart the clocks are
REALTIME_AMONG_THEM = (("record/writer.c", "s->to_hardware_ns = (int64_t)(", "s->to_hardware_ns = 0 * (int64_t)("),)


def moved(frames):
    """[ns] as the log must have them, of frames (identifier, realtime)."""
    apart, stamps = 0, []
    for identifier, real_ns in frames:
        if identifier % 2 == 0:
            apart = AHEAD_NS + (real_ns - START_NS) // DRIFT
        stamps.append(real_ns + apart)
    return stamps


@pytest.mark.parametrize("cured", [True, False], ids=["cured", "uncured"])
def test_frames_without_the_adapters_stamp_stand_on_its_clock(tmp_path, cured):
    """As far from the kernel's stamp as the last frame that had both; and they are counted."""
    frames = [(0x100 + (k % 5 > 1), START_NS + k * 10**6) for k in range(1000)]
    path = uncured(tmp_path / "adapter", ADAPTER if cured else (*ADAPTER, *REALTIME_AMONG_THEM))
    with FrameSource(tmp_path / "r", path=path) as source:
        for k, (identifier, real_ns) in enumerate(frames):
            source.send(identifier, k.to_bytes(4, "little"), stamp_ns=real_ns)
    assert source.status == 0, source.printed
    (end,) = source.events("end")[0]["sources"]
    assert source.events("header")[0]["sources"][0]["stamps"] == "hardware" and end["stamps_estimated"] == 600
    stamps_us = [int(line[1:18].replace(".", "")) for line in source.lines()]
    right = stamps_us == [ns // 1000 for ns in moved(frames)]
    assert right and end["stamps_backwards"] == 0 if cured else not right and end["stamps_backwards"] > 0
