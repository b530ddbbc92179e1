"""apps/recording/ and what they stand on: text_file, decimal, spool, step_median.

Expected values come from Python's own float() and NumPy.
"""

import gzip
import os
import random
import resource
import struct
import subprocess
import zlib

import numpy
import pytest
from helper_programs import complaint, helper
from support import BUILD, data, needs_data

LEG = "time_s knee_motor_rad ankle_motor_rad ankle_joint_rad knee_current_A ankle_current_A".split()
SLIDER = "time_s slider_m slider_force_N".split()


def table(rows, columns, step_s=0.001):
    """Rows of numbers as Python writes them, time first."""
    generator = numpy.random.default_rng(rows + columns)
    values = generator.normal(size=(rows, columns)) * 10.0 ** generator.integers(-6, 4, (rows, columns))
    values[:, 0] = step_s * (numpy.arange(rows) + generator.uniform(-0.2, 0.2, rows))
    return values


def csv(names, values, text=repr, newline="\n"):
    lines = [",".join(names)] + [",".join(map(text, row)) for row in values.tolist()]
    return newline.join(lines) + newline


def write(folder, text, name="rec.csv"):
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def read(plant, path, block=1000, *more):
    """(summary of standard error, {column: values}) of a recording."""
    done = helper("recording_read", plant, path, block, *more)
    words = done.stderr.decode().splitlines()[-1].split()
    summary = dict(zip(words[0:8:2], words[1:8:2], strict=True))
    names = [*words[9:], "valid mask"]
    values = numpy.frombuffer(done.stdout).reshape(-1, len(names))
    return summary, dict(zip(names, values.T, strict=True)), done.stderr.decode()


# ---- numbers ---------------------------------------------------------------------


def bits(x):
    return struct.pack(">d", x).hex()


def parsed(texts):
    """What decimal_parse makes of each text."""
    done = helper("decimal_bits", input="".join(t + "\n" for t in texts).encode())
    return done.stdout.decode().split()


def random_decimals(seed, n):
    """Decimal texts of every kind: as printed, many digits, ties, subnormal, huge."""
    generator = random.Random(seed)

    def of_bits():
        x = struct.unpack(">d", generator.randbytes(8))[0]
        return repr(x) if x == x and abs(x) != float("inf") else "0"

    def of_digits():
        digits = "".join(generator.choice("0123456789") for _ in range(generator.randint(1, 30)))
        point = generator.randint(0, len(digits))
        exponent = generator.choice(
            ["", "", f"e{generator.randint(-340, 310)}", f"E+{generator.randint(0, 25)}"]
        )
        return generator.choice(["", "-", "+"]) + digits[:point] + "." + digits[point:] + exponent

    def of_recording():
        return f"%.{generator.randint(1, 17)}{generator.choice('gf')}" % generator.uniform(-1e3, 1e3)

    def of_tie():
        # exactly between two neighbours, or one unit of the 40th digit to a side
        m = generator.getrandbits(53) | 1 << 52
        exact = str((2 * m + 1) * 5**20)  # (m + 1/2) 2^-19
        return exact[:-20] + "." + exact[-20:] + generator.choice(["", "0000001"])

    kinds = [of_bits, of_digits, of_recording, of_recording, of_tie]
    return [generator.choice(kinds)() for _ in range(n)]


@pytest.mark.parametrize("seed", range(4))
def test_decimals_are_rounded_as_python_does(seed):
    texts = random_decimals(seed, 100_000)
    expected = ["inf" if abs(float(t)) == float("inf") else bits(float(t)) for t in texts]
    wrong = [(t, e, g) for t, e, g in zip(texts, expected, parsed(texts), strict=True) if e != g]
    assert wrong == []


def test_decimals_of_every_length(tmp_path):
    """The reader's fast way, too: whole parts of 1 to 9 digits with fractions of 0 to 30."""
    generator = random.Random(7)
    texts = []
    for whole in range(1, 10):
        for places in range(31):
            digits = [generator.choice("0123456789") for _ in range(whole + places)]
            for first in "09":
                body = "".join([first, *digits[1:]])
                texts += [f"{sign}{body[:whole]}.{body[whole:]}" for sign in ("", "-")]
    rows = [f"{i},{text},{text}e-3" for i, text in enumerate(texts)]
    _, columns, _ = read("slider", write(tmp_path, "\n".join([",".join(SLIDER), *rows, ""])))
    assert columns["slider_m"].tobytes() == numpy.array([float(t) for t in texts]).tobytes()
    assert columns["slider_force_N"].tobytes() == numpy.array([float(t + "e-3") for t in texts]).tobytes()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "nan"), ("-", "nan"), (".", "nan"), ("e5", "nan"), ("-.e1", "nan"),
        ("abc", "nan"), ("0x10", "rest"),
        ("1e", "rest"), ("1e+", "rest"), ("1_0", "rest"), ("1,5", "rest"), ("1.5.2", "rest"), ("nan", "inf"),
        ("-NaN", "inf"), ("Infinity", "inf"), ("-inf", "inf"), ("1e999", "inf"), (".5", bits(0.5)),
        ("5.", bits(5.0)), ("-0", bits(-0.0)), ("0e999999999999", bits(0.0)), ("1e-999999999999", bits(0.0)),
    ],
)  # fmt: skip
def test_decimal_grammar(text, expected):
    assert parsed([text]) == [expected]


def test_decimals_do_not_depend_on_the_locale():
    """With a locale whose decimal point is a comma, where the machine has one."""
    names = subprocess.run(["locale", "-a"], check=True, capture_output=True, text=True).stdout.split()
    texts = ["1.5", "123456789012345678901234567890.5", "2.2250738585072014e-308"]
    for name in [n for n in names if n.startswith(("de_", "fr_", "sv_", "pl_"))] + ["C"]:
        done = helper(
            "decimal_bits", input="\n".join([*texts, ""]).encode(), env={**os.environ, "LC_ALL": name}
        )
        assert done.stdout.decode().split() == [bits(float(t)) for t in texts]


# ---- what is accepted ------------------------------------------------------------


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("compressed", [False, True])
def test_values_and_summary(tmp_path, newline, compressed):
    values = table(5000, 6)
    content = csv(LEG, values, newline=newline).encode()
    path = write(tmp_path, gzip.compress(content) if compressed else content, "rec.csv.gz")
    summary, columns, errors = read("leg", path)
    assert list(columns) == [*LEG, "valid mask"]
    for name, column in zip(LEG, values.T, strict=True):
        assert columns[name].tobytes() == column.tobytes()
    assert (columns["valid mask"] == 1).all()
    assert int(summary["rows"]) == 5000
    assert float(summary["first_s"]) == values[0, 0] and float(summary["last_s"]) == values[-1, 0]
    assert float(summary["step_s"]) == numpy.median(numpy.diff(values[:, 0]))
    assert len(errors.splitlines()) == 1  # no note


def test_columns_in_any_order_and_unknown_ones(tmp_path):
    values = table(300, 8)
    names = ["knee_current_A", "strange", "ankle_joint_rad", "time_s", "ankle_current_A", "knee_motor_rad",
             "slider_m", "ankle_motor_rad"]  # fmt: skip
    values[:, [0, 3]] = values[:, [3, 0]]
    text = csv(names, values)
    text = text.replace("\n", "\n# a comment, with commas\n", 3)
    lines = text.splitlines()
    # an unknown column is not read: anything may stand there
    for i in range(200, 210):
        fields = lines[i].split(",")
        lines[i] = ",".join([fields[0], "?", *fields[2:]])
    _, columns, errors = read("leg", write(tmp_path, "\n".join([*lines, ""])))
    for name in LEG:
        assert columns[name].tobytes() == values[:, names.index(name)].tobytes()
    notes = errors.splitlines()[:-1]
    assert len(notes) == 1 and "strange, slider_m" in notes[0] and "rec.csv" in notes[0]


def test_optional_columns_and_valid(tmp_path):
    values = table(400, 9)
    values[:, 8] = numpy.arange(400) % 7 > 2
    _, columns, errors = read("leg", write(tmp_path, csv([*LEG, "bus_V", "shank_rad", "valid"], values)), 64)
    assert columns["bus_V"].tobytes() == values[:, 6].tobytes()
    assert columns["shank_rad"].tobytes() == values[:, 7].tobytes()
    assert columns["valid mask"].tobytes() == columns["valid"].tobytes() == values[:, 8].tobytes()
    assert len(errors.splitlines()) == 1


@pytest.mark.parametrize("names", [
    ["time_s", "joint_rad", "joint_current_A"],
    ["time_s", "joint_velocity_rad_s", "joint_torque_Nm"],
    ["joint_torque_Nm", "joint_load_Nm", "time_s", "joint_velocity_rad_s", "joint_rad", "joint_temp_C"],
])  # fmt: skip
def test_pendulum_needs_one_of_each_pair(tmp_path, names):
    values = table(150, len(names))
    values[:, [0, names.index("time_s")]] = values[:, [names.index("time_s"), 0]]
    _, columns, _ = read("pendulum", write(tmp_path, csv(names, values)))
    for i, name in enumerate(names):
        assert columns[name].tobytes() == values[:, i].tobytes()


def test_blanks_mark_and_comments(tmp_path):
    values = table(120, 3)
    lines = csv(SLIDER, values).splitlines()
    rows = ["\t" + line.replace(",", " , ") + "  " for line in lines[1:]]
    text = (
        "\ufeff# made by hand\n\n"
        + " time_s ,slider_m,\tslider_force_N\n"
        + "\n".join(rows)
        + "\n# end\n\n \t\n"
    )
    _, columns, _ = read("slider", write(tmp_path, text))
    for name, column in zip(SLIDER, values.T, strict=True):
        assert columns[name].tobytes() == column.tobytes()


def test_last_line_without_newline(tmp_path):
    values = table(100, 3)
    _, columns, errors = read("slider", write(tmp_path, csv(SLIDER, values).rstrip("\n")))
    assert columns["slider_force_N"].tobytes() == values[:, 2].tobytes()
    assert "newline" in errors.splitlines()[0] and len(errors.splitlines()) == 2


def test_long_files_cross_blocks(tmp_path):
    """Comments, blanks and plain rows over many blocks of text, read back in both directions."""
    values = table(120_000, 6)
    lines = csv(LEG, values).splitlines()
    for i in range(1, len(lines), 977):
        lines[i] += "\n# remark"
    for i in range(1, len(lines), 1013):
        lines[i] = lines[i].replace(",", ", ", 1)
    path = write(tmp_path, "\n".join(lines) + "\n")
    assert path.stat().st_size > 20 * 262144
    for block, backwards in ((997, []), (120_000, []), (50_001, ["backwards"])):
        _, columns, _ = read("leg", path, block, *backwards)
        for name, column in zip(LEG, values.T, strict=True):
            got = columns[name]
            if backwards:
                parts = numpy.array_split(got, [len(got) - 2 * block, len(got) - block])
                edges = [len(values) % block, len(values) % block + block]
                parts = [got[: edges[0]], got[edges[0] : edges[1]], got[edges[1] :]]
                got = numpy.concatenate(parts[::-1])
            assert got.tobytes() == column.tobytes()


def test_concatenated_gzip_members(tmp_path):
    content = csv(SLIDER, table(3000, 3)).encode()
    path = write(tmp_path, gzip.compress(content[:10_000]) + gzip.compress(content[10_000:]))
    assert read("slider", path)[0]["rows"] == "3000"


def test_a_pipe_can_be_read(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    content = csv(SLIDER, table(30_000, 3))
    writer = subprocess.Popen(["sh", "-c", f"cat > {pipe}"], stdin=subprocess.PIPE)
    reader = subprocess.Popen(
        [BUILD / "tests" / "recording_read", "slider", pipe], stderr=subprocess.PIPE, text=True
    )
    writer.communicate(content.encode())
    assert "rows 30000 " in reader.communicate()[1] and reader.returncode == 0


@pytest.mark.parametrize("rows", [100, 101, 131_072, 131_073])
def test_median_step_is_exact_up_to_131072_steps(tmp_path, rows):
    generator = numpy.random.default_rng(rows)
    t = numpy.cumsum(generator.choice([0.001, 0.00125, 0.002, 0.5], rows) * generator.uniform(0.9, 1.1, rows))
    values = numpy.column_stack([t, t, t])
    summary, _, _ = read("slider", write(tmp_path, csv(SLIDER, values)))
    assert float(summary["step_s"]) == numpy.median(numpy.diff(t))


def test_median_step_beyond_is_that_of_an_even_sample(tmp_path):
    rows = 300_001
    generator = numpy.random.default_rng(3)
    t = numpy.cumsum(generator.uniform(0.0005, 0.0015, rows))
    summary, _, _ = read("slider", write(tmp_path, csv(SLIDER, numpy.column_stack([t, t, t]))))
    # 300,000 steps are more than 2 * 131,072: every fourth is kept
    assert float(summary["step_s"]) == numpy.median(numpy.diff(t)[::4])


# ---- what is refused -------------------------------------------------------------


def slider_lines(rows=120):
    return csv(SLIDER, table(rows, 3)).splitlines()


def refused(folder, lines, plant="slider", end="\n"):
    text = lines if isinstance(lines, bytes) else "\n".join(lines) + end
    message = complaint("recording_read", plant, write(folder, text))
    return message.removeprefix(f"{folder}/")


@pytest.mark.parametrize("line", [1, 57, 120])
@pytest.mark.parametrize(("field", "words"), [
    ("abc", "'abc' is not a number"), ("", "the field is empty"), ("  ", "the field is empty"),
    ("nan", "'nan' is not a finite number"),
    ("-inf", "not a finite number"), ("1e999", "not a finite number"),
    ("1.2.3", "'1.2.3' is not a number"), ("0x12", "not a number"), ('"1.5"', "not a number"),
    ("1;5", "'1;5' is not a number"), ("1\x01", "'1?' is not a number"), ("9" * 2000, "not a number"),
], ids=lambda text: text[:12].replace("\x01", "?"))  # fmt: skip
def test_bad_fields_are_named(tmp_path, line, field, words):
    lines = slider_lines()
    fields = lines[line].split(",")
    lines[line] = f"{fields[0]},{field},{fields[2]}"
    message = refused(tmp_path, lines)
    assert message.startswith(f"rec.csv:{line + 1}: slider_m: ") and words in message


def test_bad_fields_far_into_a_file(tmp_path):
    """The first fault of the file is told, with its line, though blocks are read side by side."""
    lines = slider_lines(100_000)
    lines[60_000] = lines[60_000].replace(",", ",x", 1)
    for i in range(60_001, 100_001, 500):
        lines[i] = "wrong"
    for _ in range(5):
        assert refused(tmp_path, lines).startswith("rec.csv:60001: slider_m: 'x")


@pytest.mark.parametrize("number", [1, 60, 119])
def test_wrong_number_of_fields(tmp_path, number):
    lines = slider_lines()
    lines[number] += ",1"
    assert refused(tmp_path, lines) == f"rec.csv:{number + 1}: 4 fields, expected 3 as in the header"
    lines[number] = "1,2"
    assert refused(tmp_path, lines) == f"rec.csv:{number + 1}: 2 fields, expected 3 as in the header"


def test_time_must_rise(tmp_path):
    lines = slider_lines()
    lines[50] = "1.5,0,0"
    lines[51] = "1.5,0,0"
    assert refused(tmp_path, lines).startswith("rec.csv:52: time_s stands still at 1.5")
    lines[51] = "1.25,0,0"
    assert refused(tmp_path, lines).startswith("rec.csv:52: time_s runs back from 1.5 to 1.25")


@pytest.mark.parametrize("row", [8190, 8191, 8192, 16383, 16384])
def test_time_must_rise_from_block_to_block(tmp_path, row):
    """Lines of 32 bytes: a block of 262,144 bytes holds 8,192 of them, the first begins with the header."""
    lines = ["time_s,slider_m, slider_force_N"]
    lines += [f"{0.001 * i:013.6f},{i % 7:+.5f},{i % 5:+.5f}" for i in range(40_000)]
    assert {len(line) for line in lines} == {31}
    lines[row + 1] = lines[row]
    assert refused(tmp_path, lines).startswith(
        f"rec.csv:{row + 2}: time_s stands still at {0.001 * (row - 1):.6g}"
    )


def test_valid_is_0_or_1(tmp_path):
    values = table(120, 4)
    values[:, 3] = 1
    values[70, 3] = 2
    assert (
        refused(tmp_path, csv([*SLIDER, "valid"], values).encode()) == "rec.csv:72: valid: 2, expected 0 or 1"
    )


@pytest.mark.parametrize(("plant", "names", "words"), [
    ("leg", [n for n in LEG if n != "knee_current_A"], "missing column: knee_current_A (a leg's recording"),
    ("leg", LEG[:3], "missing column: ankle_joint_rad, knee_current_A, ankle_current_A (a leg's"),
    ("slider", ["time", "slider_m", "slider_force_N"], "missing column: time_s"),
    ("slider", ["Time_s", "slider_m", "slider_force_N"], "missing column: time_s"),
    ("pendulum", ["time_s", "joint_current_A"], "missing column: joint_rad or joint_velocity_rad_s (a"),
    ("pendulum", ["time_s", "joint_rad"], "missing column: joint_current_A or joint_torque_Nm"),
    ("slider", [*SLIDER, "slider_m"], "column slider_m stands twice"),
])  # fmt: skip
def test_header_faults(tmp_path, plant, names, words):
    message = refused(tmp_path, csv(names, table(120, len(names))).encode(), plant)
    assert message.startswith("rec.csv:1: ") and words in message


@pytest.mark.parametrize("rows", [0, 1, 99])
def test_too_few_samples(tmp_path, rows):
    assert refused(tmp_path, slider_lines(rows) if rows else [",".join(SLIDER)]) == (
        f"rec.csv: {rows} samples, expected at least 100"
    )
    assert read("slider", write(tmp_path, "\n".join([*slider_lines(100), ""])))[0]["rows"] == "100"


NO_RECORDING = {
    "empty": (b"", "the file is empty"),
    "empty gzip": (gzip.compress(b""), "the file is empty"),
    "blank": (b"\n", "no header line in 1 lines"),
    "comments": (b"# only\n# comments\n", "no header line in 2 lines"),
    "zeros": (b"\x00\x01\x02" * 500, "not text"),
    "program": (b"\x7fELF\x02\x01\x01\x00" + bytes(range(256)) * 40, "not text"),
    "endless header": (b"a" * 3_000_000, "rec.csv:1: longer than"),
    "endless line": (b"time_s,slider_m,slider_force_N\n" + b"1" * 3_000_000, "rec.csv:2: longer than"),
    "columns": ((",".join(f"c{i}" for i in range(2000)) + "\n").encode(), "more than 1024 columns"),
}


@pytest.mark.parametrize("kind", NO_RECORDING)
def test_files_that_are_no_recording(tmp_path, kind):
    content, words = NO_RECORDING[kind]
    assert words in refused(tmp_path, content)


def test_blank_line_amid_the_samples(tmp_path):
    lines = slider_lines()
    lines[40] = ""
    assert refused(tmp_path, lines).startswith("rec.csv:41: a blank line amid the samples; try: ")
    lines = slider_lines(20_000)  # ... and where the next block of text begins with plain rows
    lines.insert(15_000, " ")
    assert refused(tmp_path, lines).startswith("rec.csv:15001: a blank line amid the samples; try: ")


def test_truncated_text(tmp_path):
    """Cut at every place of the last line but its last field: said to be truncated, with the line."""
    text = csv(SLIDER, table(150, 3))
    start = text.rindex("\n", 0, len(text) - 1) + 1
    for cut in range(start + 1, text.rindex(",") + 2):
        message = refused(tmp_path, text[:cut].encode())
        assert message.startswith("rec.csv:151: ")
        assert "truncated" in message or "the field is empty" in message


def test_truncated_or_damaged_gzip(tmp_path):
    content = gzip.compress(csv(SLIDER, table(20_000, 3)).encode())
    for length in (5, 11, 300, len(content) // 2, len(content) - 9, len(content) - 8, len(content) - 1):
        message = refused(tmp_path, content[:length])
        assert "truncated" in message, (length, message)
    damaged = bytearray(content)
    damaged[-6] ^= 1  # within the checksum
    assert "damaged" in refused(tmp_path, bytes(damaged))
    # a block of an illegal type behind a sound beginning
    deflate = zlib.compressobj(wbits=31)
    head = deflate.compress(csv(SLIDER, table(500, 3)).encode()) + deflate.flush(zlib.Z_FULL_FLUSH)
    assert "damaged" in refused(tmp_path, head + b"\x07\xff\xff\xff" * 10)


def test_unreadable_files(tmp_path):
    assert complaint("recording_read", "slider", tmp_path / "none.csv").endswith(
        "none.csv: No such file or directory"
    )
    advice = f"; try: talus-import --plant slider --suggest --out recording.csv '{tmp_path}'"
    assert complaint("recording_read", "slider", tmp_path).endswith(f": is a directory, expected a file{advice}")
    odd = tmp_path / "a\nb.csv"
    odd.write_text("x\n")
    assert "a?b.csv:1: missing column" in complaint("recording_read", "slider", odd)


def test_no_room_for_the_temporary_file(tmp_path):
    path = write(tmp_path, csv(SLIDER, table(50_000, 3)))
    for environment in ({"TMPDIR": str(tmp_path / "none")}, {"TMPDIR": str(tmp_path)}):
        done = helper("recording_read", "slider", path, env={**os.environ, **environment})
        assert b"rows 50000" in done.stderr
    assert os.listdir(tmp_path) == ["rec.csv"]  # nothing stays behind

    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))

    message = complaint(
        "recording_read", "slider", path, status=1, preexec_fn=small_files, restore_signals=False
    )
    assert message.startswith("cannot write a temporary file in ")


def test_random_damage_never_crashes(tmp_path):
    """Bytes changed, removed or doubled at random: read, or refused in one line."""
    generator = random.Random(11)
    original = csv(SLIDER, table(130, 3)).encode()
    refusals = 0
    for _ in range(300):
        content = bytearray(original)
        for _ in range(generator.randint(1, 4)):
            at = generator.randrange(len(content))
            kind = generator.randrange(3)
            if kind == 0:
                content[at] = generator.choice(b'0,.-e\n\r#" \x00\xff9')
            elif kind == 1:
                del content[at : at + generator.randint(1, 40)]
            else:
                content[at:at] = content[at : at + generator.randint(1, 40)]
        path = write(tmp_path, bytes(content))
        done = subprocess.run(
            [BUILD / "tests" / "recording_read", "slider", path], check=False, capture_output=True
        )
        assert done.returncode in (0, 2), (done.returncode, done.stderr)
        if done.returncode == 2:
            refusals += 1
            lines = done.stderr.decode().splitlines()
            assert len(lines) == 1 and lines[0].startswith("recording_read: ")
    assert refusals > 100


# ---- memory ----------------------------------------------------------------------


def peak_kib(path):
    """Largest resident memory of the reader, from a process of its own that waits for it."""
    script = "import os,sys,subprocess;p=subprocess.Popen(sys.argv[1:]);print(os.wait4(p.pid,0)[2].ru_maxrss)"
    command = ["python3", "-c", script, BUILD / "tests" / "recording_read", "leg", path]
    return int(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


@pytest.mark.long
@pytest.mark.release
def test_memory_does_not_grow_with_the_recording(tmp_path):
    """The program itself, with its buffers, at 20 s and ten times that: the same within a tenth."""
    small = write(tmp_path, csv(LEG, table(60_000, 6), "{:.9g}".format), "small.csv")
    large = write(tmp_path, csv(LEG, table(600_000, 6), "{:.9g}".format), "large.csv")
    few, many = peak_kib(small), peak_kib(large)
    assert many < 1.1 * few and many < 16 * 1024, (few, many)


@needs_data
@pytest.mark.parametrize(("plant", "path"), [
    ("slider", "emps/emps_identification.csv"), ("pendulum", "ur10e_joints/ur10e_joint_2.csv"),
    ("pendulum", "ak80_9_dyno/ak80_A_comp_full.csv"), ("leg", "leg_cases/case_000/train1.csv.gz"),
])  # fmt: skip
def test_recordings_at_hand(plant, path):
    source = data(path)
    _, columns, _ = read(plant, source)
    opened = gzip.open if source.suffix == ".gz" else open
    with opened(source, "rt") as file:
        rows = [line.rstrip("\n").split(",") for line in file if not line.startswith("#")]
    assert len(columns["time_s"]) == len(rows) - 1
    for name in set(columns) & set(rows[0]):
        at = rows[0].index(name)
        assert columns[name].tobytes() == numpy.array([float(row[at]) for row in rows[1:]]).tobytes()
