"""apps/common/output.c, number.c, json_file.c and envelope.c: what the programs write."""

import json
import math
import os
import random
import resource
import signal
import stat
import struct
import subprocess
import time

import numpy
import pytest
from helper_programs import complaint, helper
from support import BUILD

EARLIER = "what stood here before\n"


def small_files():
    """In the child: no file may grow beyond 100 kB, as on a disk that is full."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))


# ---- a file appears whole or not at all ------------------------------------------


def test_rows(tmp_path):
    path = tmp_path / "out.csv"
    helper("output_write", "rows", path, 20_000)
    lines = path.read_text().splitlines()
    assert lines[0] == "time_s,a,b"
    rows = numpy.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    t = 0.001 * numpy.arange(20_000)
    assert rows[:, 0].tobytes() == t.tobytes()  # times come back to the last bit
    assert numpy.allclose(rows[:, 1], numpy.sin(t), rtol=1e-11, atol=0)
    assert numpy.allclose(rows[:, 2], -1e-7 / (1 + t), rtol=1e-11, atol=0)
    assert os.listdir(tmp_path) == ["out.csv"]


@pytest.mark.parametrize("kind", ["rows", "json"])
def test_an_earlier_file_is_replaced(tmp_path, kind):
    path = tmp_path / "out"
    path.write_text(EARLIER)
    path.chmod(0o640)
    helper("output_write", kind, path, 10)
    assert path.read_text() != EARLIER
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert os.listdir(tmp_path) == ["out"]


def test_a_new_file_has_the_usual_mode(tmp_path):
    helper("output_write", "rows", tmp_path / "out", 1, umask=0o027)
    assert stat.S_IMODE((tmp_path / "out").stat().st_mode) == 0o640


def test_full_disk(tmp_path):
    path = tmp_path / "out.csv"
    path.write_text(EARLIER)
    options = {"preexec_fn": small_files, "restore_signals": False, "status": 1}
    message = complaint("output_write", "rows", path, 100_000, **options)
    assert message == f"{path}: cannot be written: File too large"
    assert path.read_text() == EARLIER and os.listdir(tmp_path) == ["out.csv"]
    helper("output_write", "rows", path, 1000, **options | {"status": 0})
    assert len(path.read_text().splitlines()) == 1001


def test_device_that_is_full():
    assert complaint("output_write", "rows", "/dev/full", 10, status=1) == (
        "/dev/full: cannot be written: No space left on device"
    )
    assert stat.S_ISCHR(os.stat("/dev/full").st_mode)  # written, not replaced


def test_standard_output_and_devices(tmp_path):
    expected = helper("output_write", "rows", "-", 1000).stdout
    assert expected.count(b"\n") == 1001
    assert helper("output_write", "rows", "/dev/stdout", 1000).stdout == expected
    helper("output_write", "rows", "/dev/null", 10)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    with open("/dev/full", "wb") as full:
        message = complaint("output_write", "rows", "-", 10, status=1, capture_output=False, stdout=full,
                            stderr=subprocess.PIPE)  # fmt: skip
    assert message == "standard output: cannot be written: No space left on device"


def test_targets_that_cannot_be_written(tmp_path):
    for path, reason in ((tmp_path, "Is a directory"), (tmp_path / "none/out", "No such file or directory")):
        assert complaint("output_write", "rows", path, 1, status=1) == f"{path}: cannot be written: {reason}"
    (tmp_path / "file").write_text(EARLIER)
    assert complaint("output_write", "rows", tmp_path / "file/out", 1, status=1).endswith("Not a directory")


def test_links_are_followed(tmp_path):
    (tmp_path / "folder").mkdir()
    target = tmp_path / "folder/real.csv"
    target.write_text(EARLIER)
    (tmp_path / "link.csv").symlink_to(target)
    helper("output_write", "rows", tmp_path / "link.csv", 5)
    assert (tmp_path / "link.csv").is_symlink()
    assert len(target.read_text().splitlines()) == 6
    assert os.listdir(tmp_path / "folder") == ["real.csv"]


def test_abandoned_output_leaves_nothing(tmp_path):
    (tmp_path / "out").write_text(EARLIER)
    helper("output_write", "abandon", tmp_path / "out", 100_000)
    assert (tmp_path / "out").read_text() == EARLIER and os.listdir(tmp_path) == ["out"]


def test_a_reader_never_sees_half_a_file(tmp_path):
    """Killed at any moment, the file is the earlier one or the whole new one."""
    path = tmp_path / "out.csv"
    helper("output_write", "rows", path, 200_000)
    whole = path.read_bytes()
    generator = random.Random(1)
    seen = set()
    for _ in range(20):
        path.write_text(EARLIER)
        writer = subprocess.Popen([BUILD / "tests" / "output_write", "rows", path, "200000"])
        time.sleep(generator.uniform(0, 0.15))
        writer.send_signal(signal.SIGKILL)
        writer.wait()
        content = path.read_bytes()
        assert content in (EARLIER.encode(), whole)
        seen.add(len(content))
    assert len(EARLIER) in seen


# ---- numbers ---------------------------------------------------------------------


def random_doubles(n):
    generator = random.Random(n)
    kinds = [
        lambda: struct.unpack(">d", generator.randbytes(8))[0],
        lambda: generator.uniform(-1, 1) * 10.0 ** generator.randint(-8, 14),
        lambda: round(generator.uniform(-100, 100), generator.randint(0, 14)),
        lambda: float(generator.randint(-(10**12), 10**12)),
    ]
    values = [generator.choice(kinds)() for _ in range(n)]
    edges = [0.0, -0.0, 1e-5, 9.9999999999949e-6, 1e12, 999999999999.5, 99999999999.95, 5e-324,
             1.7976931348623157e308,             0.1, 1 / 3, 2 / 3, 123456789012.0, 1e22, 1e23]  # fmt: skip
    return [x for x in values + edges if math.isfinite(x)]


def test_numbers_as_text():
    values = random_doubles(50_000)
    lines = "".join(struct.pack(">d", x).hex() + "\n" for x in values).encode()
    answers = helper("output_write", "numbers", "-", input=lines).stdout.decode().splitlines()
    assert len(answers) == len(values)
    for x, answer in zip(values, answers, strict=True):
        exact, rounded = answer.split()
        assert float(exact) == x
        assert len(exact) <= max(len(repr(x)), 24)
        nearest = float(f"{x:.12g}")
        # the right digits, or one unit of the twelfth where x is as good as in the middle
        unit = 10.0 ** (math.floor(math.log10(abs(nearest))) - 11) if nearest else 0.0
        assert float(rounded) == nearest or (
            abs(float(rounded) - nearest) <= 1.001 * unit and abs(float(rounded) - x) <= 0.5001 * unit
        ), (x, rounded)
        assert not rounded.rstrip("0").endswith(".") or "e" in rounded


def test_numbers_do_not_depend_on_the_locale():
    names = subprocess.run(["locale", "-a"], check=True, capture_output=True, text=True).stdout.split()
    lines = "".join(struct.pack(">d", x).hex() + "\n" for x in (0.1, 1e-9 / 3, 1e300)).encode()
    expected = helper("output_write", "numbers", "-", input=lines).stdout
    for name in names:
        assert helper("output_write", "numbers", "-", input=lines, env={"LC_ALL": name}).stdout == expected


def test_json(tmp_path):
    path = tmp_path / "r.json"
    helper("output_write", "json", path)
    text = path.read_text()
    assert text.startswith('{\n "z": 0.333') and text.endswith("}\n")
    said = json.loads(text, parse_constant=lambda name: pytest.fail(name))
    assert list(said) == ["z", "a", "text", "foreign", "list"]
    assert said["z"] == 1 / 3 and said["a"] is None and said["list"] == [0.1, None, 1e300]
    assert said["text"] == "café </script>" and said["foreign"] == "a?b"


# ---- envelopes -------------------------------------------------------------------


@pytest.mark.parametrize("n", [0, 1, 999, 1000, 1001, 2000, 2001, 50_000, 1_234_567])
def test_envelope(n):
    """The extremes of every stretch, in order of time, whatever the length."""
    done = helper("output_write", "envelope", "-", n).stdout.decode()
    points = [tuple(map(float, line.split(","))) for line in done.splitlines()]
    i = numpy.arange(n, dtype=numpy.uint64)
    y = i * numpy.uint64(2654435761) % numpy.uint64(1000003) / 1000003.0
    y[i % 1000 > 900] = numpy.nan
    width = 1
    while n > 1000 * width:
        width *= 2
    expected = []
    for start in range(0, n, width):
        stretch = y[start : start + width]
        if numpy.isnan(stretch).all():
            expected.append((float(start), math.nan))
            continue
        low, high = start + int(numpy.nanargmin(stretch)), start + int(numpy.nanargmax(stretch))
        expected += [(float(k), float(y[k])) for k in sorted({low, high})]
    assert len(points) == len(expected) <= 2000
    for (t, value), (t0, value0) in zip(points, expected, strict=True):
        # 12 digits were printed; a gap stands at the first of its samples
        assert t == t0
        assert (math.isnan(value) and math.isnan(value0)) or math.isclose(value, value0, rel_tol=1e-11)
