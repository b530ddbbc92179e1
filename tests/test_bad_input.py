"""Every kind of bad input, given to the programs themselves.

Each case says the exact exit status and the one line on standard error, which names the file, the line (or
column, or key) and what was wrong. After each, nothing was written: every file is what it was, none is new, and
no temporary file stays behind. The readers alone are tested in test_recording_reader.py and test_model_file.py.
"""

import gzip
import json
import os
import re
import resource
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from support import REPOSITORY, program, run

EARLIER = b"what stood here before\n"
OUTPUTS = {"talus-identify": ("--out", "--report", "--html"), "talus-predict": ("--out", "--report", "--html"),
           "talus-sim": ("--out", "--truth", "--motion")}  # fmt: skip
BOTH = ("talus-identify", "talus-predict")


@pytest.fixture(scope="session")
def bench(tmp_path_factory):
    """Sound inputs: a model and a recording of each plant, and a leg of which only the knee moves."""
    folder = tmp_path_factory.mktemp("bench")
    for plant in ("leg", "pendulum", "slider"):
        shutil.copy(REPOSITORY / "models" / f"{plant}.yaml", folder)
        run("talus-sim", "--model", folder / f"{plant}.yaml", "--out", folder / f"{plant}.csv", "--duration", 20)
    shutil.copy(REPOSITORY / "models" / "leg_cad.yaml", folder)
    run("talus-sim", "--model", folder / "leg.yaml", "--out", folder / "knee.csv", "--duration", 20, "--amplitude", "0.3,0")
    return folder


@pytest.fixture
def inputs(bench, tmp_path):
    """A copy of the sound inputs, to be spoiled."""
    for path in bench.iterdir():
        shutil.copy(path, tmp_path)
    return tmp_path


def contents(folder):
    """Every file's bytes; a link counts as what it leads to."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def start(name, folder, arguments, **options):
    """Runs a program in `folder`, with a folder for temporary files whose emptiness can be seen."""
    (folder / "tmp").mkdir(exist_ok=True)
    environment = {**os.environ, "TMPDIR": str(folder / "tmp"), **options.pop("env", {})}
    return subprocess.run([str(program(name)), *map(str, arguments)], cwd=folder, env=environment, check=False,
                          stdin=subprocess.DEVNULL, capture_output=True, timeout=120, **options)  # fmt: skip


def line_of(done, name, status):
    """The one line that a program ended with."""
    text = done.stderr.decode()
    assert done.returncode == status, (done.returncode, text)
    assert done.stdout == b""
    assert text.endswith("\n") and len(text.splitlines()) == 1, text
    assert text.startswith(f"{name}: "), text
    return text.removeprefix(f"{name}: ").rstrip("\n")


def refused(name, folder, arguments, words, status=2, outputs=True):
    """Demands the line (a regular expression for all of it), and that nothing was written; first where no
    result is, then over an earlier one."""
    for earlier in (False, True):
        options = []
        for option in OUTPUTS[name] if outputs else ():
            options += [option, f"result{option}"]
            if earlier:
                (folder / f"result{option}").write_bytes(EARLIER)
        before = contents(folder)
        line = line_of(start(name, folder, [*options, *arguments]), name, status)
        assert re.fullmatch(words, line), line
        assert contents(folder) == before
    return line


# ---- recordings ------------------------------------------------------------------------


def field(line, column, text):
    """Another field in a line of the slider's recording; lines count from 1, the header's."""

    def change(lines):
        fields = lines[line - 1].split(",")
        fields[column] = text
        lines[line - 1] = ",".join(fields)

    return change


def row(line, text):
    def change(lines):
        lines[line - 1] = text

    return change


def keep(count):
    def change(lines):
        del lines[count:]

    return change


def column(number, name):
    """Another name in the header."""
    return field(1, number, name)


def every_line(separator):
    """Another separator in the whole file."""

    def change(lines):
        lines[:] = [line.replace(",", separator) for line in lines]

    return change


IMPORT = r"; try: talus-import --plant slider --suggest --out recording\.csv 'rec\.csv'"
RECORDINGS = {
    "column missing": (column(1, "slider_mm"), r"rec\.csv:1: missing column: slider_m \(a slider's recording needs it\); found time_s, slider_mm, slider_force_N" + IMPORT),
    "time missing": (column(0, "t"), r"rec\.csv:1: missing column: time_s .*"),
    "semicolons": (every_line(";"), r"rec\.csv:1: missing column: time_s, slider_m, slider_force_N \(.*\); found time_s, slider_m, slider_force_N separated by ';', expected ','" + IMPORT),
    "tabs": (every_line("\t"), r"rec\.csv:1: .*; found time_s, slider_m, slider_force_N separated by tabs, expected ','" + IMPORT),
    "bars": (every_line(" | "), r"rec\.csv:1: .*; found time_s, slider_m, slider_force_N separated by '\|', expected ','" + IMPORT),
    "blanks": (every_line("  "), r"rec\.csv:1: .*; found time_s, slider_m, slider_force_N separated by blanks, expected ','" + IMPORT),
    "no name known": (row(1, "a;b"), r"rec\.csv:1: missing column: .*; found a, b separated by ';', expected ','" + IMPORT),
    "German": (row(1, "Zeit [s];Weg [mm];Kraft [N]"), r"rec\.csv:1: missing column: .*; found Zeit \[s\], Weg \[mm\], Kraft \[N\] separated by ';', expected ','" + IMPORT),
    "commas, no name known": (row(1, "t;x,y,z"), r"rec\.csv:1: missing column: .*; found t;x, y, z" + IMPORT),
    "bus log": (row(1, "(1436509052.249713) can0 044#2A366C2BBA"), r"rec\.csv:1: missing column: .*; found \(1436509052\.249713\) can0 044#2A366C2BBA"
                r"; a log of the bus, try: talus-acquire-export --dbc D\.dbc --model M\.yaml --out recording\.csv 'rec\.csv'"),
    "column twice": (column(2, "slider_m"), r"rec\.csv:1: column slider_m stands twice in the header"),
    "not a number": (field(57, 1, "0.1.2"), r"rec\.csv:57: slider_m: '0\.1\.2' is not a number"),
    "decimal comma": (field(57, 1, "0;12"), r"rec\.csv:57: slider_m: '0;12' is not a number"),
    "text": (field(2, 2, "n/a"), r"rec\.csv:2: slider_force_N: 'n/a' is not a number"),
    "empty field": (field(80, 2, ""), r"rec\.csv:80: slider_force_N: the field is empty, expected a number" + IMPORT),
    "NaN": (field(101, 2, "nan"), r"rec\.csv:101: slider_force_N: 'nan' is not a finite number" + IMPORT),
    "NaN in time": (field(101, 0, "NaN"), r"rec\.csv:101: time_s: 'NaN' is not a finite number" + IMPORT),
    "infinity": (field(90, 1, "-inf"), r"rec\.csv:90: slider_m: '-inf' is not a finite number" + IMPORT),
    "absurd": (field(90, 1, "1e150"), r"rec\.csv:90: slider_m: '1e150' is beyond anything physical, expected at most 1e\+09"),
    "beyond a double": (field(90, 1, "1e999"), r"rec\.csv:90: slider_m: '1e999' is not a finite number" + IMPORT),
    "time stands still": (lambda lines: lines.insert(60, lines[59]), r"rec\.csv:61: time_s stands still at [\d.]+, it must rise" + IMPORT),
    "time runs back": (field(61, 0, "0.001"), r"rec\.csv:61: time_s runs back from [\d.]+ to 0\.001, it must rise" + IMPORT),
    "field missing": (row(70, "1.0,2.0"), r"rec\.csv:70: 2 fields, expected 3 as in the header"),
    "field too many": (row(70, "1,2,3,4"), r"rec\.csv:70: 4 fields, expected 3 as in the header"),
    "blank line": (row(70, ""), r"rec\.csv:70: a blank line amid the samples" + IMPORT),
    "99 samples": (keep(100), r"rec\.csv: 99 samples, expected at least 100"),
    "header only": (keep(1), r"rec\.csv: 0 samples, expected at least 100"),
}  # fmt: skip


@pytest.mark.parametrize("name", BOTH)
@pytest.mark.parametrize("fault", RECORDINGS)
def test_recording(name, fault, inputs):
    change, words = RECORDINGS[fault]
    lines = (inputs / "slider.csv").read_text().splitlines()
    change(lines)
    (inputs / "rec.csv").write_text("\n".join(lines) + "\n")
    refused(name, inputs, ["--model", "slider.yaml", "rec.csv"], words)


MENDED = ["empty field", "NaN", "NaN in time", "infinity", "beyond a double", "time stands still", "time runs back", "blank line"]


@pytest.mark.parametrize("fault", MENDED)
def test_the_advice_mends_the_recording(fault, inputs):
    """The line as the message says it, in a shell; what it writes is read, and holds all rows but one at the most."""
    lines = (inputs / "slider.csv").read_text().splitlines()
    count = len(lines) - 1
    RECORDINGS[fault][0](lines)
    (inputs / "rec.csv").write_text("\n".join(lines) + "\n")
    advice = refused("talus-predict", inputs, ["--model", "slider.yaml", "rec.csv"], ".*").split("; try: ")[1]
    path = f"{program('talus-import').parent}:{os.environ['PATH']}"
    subprocess.run(advice, shell=True, cwd=inputs, env={**os.environ, "PATH": path}, check=True, capture_output=True)
    assert count - 1 <= len((inputs / "recording.csv").read_text().splitlines()) - 1 <= count
    run("talus-predict", "--model", inputs / "slider.yaml", inputs / "recording.csv")


FILES = {
    "empty": ("rec.csv", lambda text: b"", r"rec\.csv: the file is empty"),
    "comments only": ("rec.csv", lambda text: b"# nothing\n", r"rec\.csv: no header line in 1 lines"),
    "cut within a line": ("rec.csv", lambda text: text[: text.index(b"\n", 9000) + 4], r"rec\.csv:\d+: truncated: the file ends within this line \(1 of 3 fields\)"),
    "binary": ("rec.csv", lambda text: bytes(range(256)) * 99, r"rec\.csv:1: not text.*" + IMPORT),
    "UTF-16": ("rec.csv", lambda text: text.decode().encode("utf-16"), r"rec\.csv:1: not text: byte 0x00 in the header line" + IMPORT),
    "gzip, cut": ("rec.csv.gz", lambda text: gzip.compress(text)[:-100], r"rec\.csv\.gz: truncated: the compressed data end too early"),
    "gzip, cut early": ("rec.csv.gz", lambda text: gzip.compress(text)[:20], r"rec\.csv\.gz: truncated: .*"),
    "gzip, damaged": ("rec.csv.gz", lambda text: gzip.compress(text)[:-8] + bytes(8), r"rec\.csv\.gz: the compressed data are damaged .*"),
    "gzip of nothing": ("rec.csv.gz", lambda text: gzip.compress(b""), r"rec\.csv\.gz: the file is empty"),
}  # fmt: skip


@pytest.mark.parametrize("name", BOTH)
@pytest.mark.parametrize("fault", FILES)
def test_file_that_is_no_recording(name, fault, inputs):
    file, change, words = FILES[fault]
    (inputs / file).write_bytes(change((inputs / "slider.csv").read_bytes()))
    refused(name, inputs, ["--model", "slider.yaml", file], words)


@pytest.mark.parametrize("name", BOTH)
def test_recording_that_cannot_be_opened(name, inputs):
    refused(name, inputs, ["--model", "slider.yaml", "none.csv"], r"none\.csv: No such file or directory")
    (inputs / "folder").mkdir()
    words = "folder: is a directory, expected a file; try: talus-import --plant slider --suggest --out recording.csv 'folder'"
    refused(name, inputs, ["--model", "slider.yaml", "folder"], words)
    refused(name, inputs, ["--model", "slider.yaml", "slider.csv/x"], "slider.csv/x: Not a directory")


@pytest.mark.parametrize("name", BOTH)
def test_no_valid_rows(name, inputs):
    lines = (inputs / "slider.csv").read_text().splitlines()
    (inputs / "rec.csv").write_text("\n".join([lines[0] + ",valid", *(f"{line},0" for line in lines[1:])]) + "\n")
    refused(name, inputs, ["--model", "slider.yaml", "rec.csv"], r"rec\.csv: no run of more than 20 valid rows without a gap")
    (inputs / "rec.csv").write_text("\n".join([lines[0] + ",valid", *(f"{line},0.5" for line in lines[1:])]) + "\n")
    refused(name, inputs, ["--model", "slider.yaml", "rec.csv"], r"rec\.csv:2: valid: 0\.5, expected 0 or 1")


@pytest.mark.parametrize("name", BOTH)
def test_recording_of_another_plant(name, inputs):
    refused(name, inputs, ["--model", "leg.yaml", "slider.csv"], r"slider\.csv:1: missing column: knee_motor_rad, .* \(a leg's recording needs it\); found time_s, slider_m, .*")
    refused(name, inputs, ["--model", "pendulum.yaml", "leg.csv"],
            r"leg\.csv:1: missing column: joint_rad or joint_velocity_rad_s, joint_current_A or joint_torque_Nm \(a pendulum's .*; found time_s, knee_motor_rad, .*")  # fmt: skip


def test_recordings_of_two_plants(inputs):
    refused("talus-identify", inputs, ["--model", "leg.yaml", "leg.csv", "slider.csv"], r"slider\.csv:1: missing column: .*")
    refused("talus-identify", inputs, ["--model", "slider.yaml", "slider.csv", "pendulum.csv"], r"pendulum\.csv:1: missing column: .*")


@pytest.mark.parametrize("name", BOTH)
def test_model_and_recording_confused(name, inputs):
    refused(name, inputs, ["--model", "leg.yaml", "leg.yaml"], r"leg\.yaml:\d+: missing column: time_s, .*")
    refused(name, inputs, ["--model", "slider.csv", "slider.csv"], r"slider\.csv:1: expected a mapping \(key: value\), found .*")
    (inputs / "long.csv").write_text((inputs / "slider.csv").read_text() * 4)
    refused(name, inputs, ["--model", "long.csv", "slider.csv"], r"long\.csv: longer than 262144 bytes, not a model")


def test_nothing_moves(inputs):
    lines = (inputs / "slider.csv").read_text().splitlines()
    still = [lines[0], *(f"{t},0.1,{f}" for t, _, f in (line.split(",") for line in lines[1:]))]
    (inputs / "rec.csv").write_text("\n".join(still) + "\n")
    refused("talus-identify", inputs, ["--model", "slider.yaml", "rec.csv"], r"rec\.csv: too few samples in motion: .*")


# ---- models ----------------------------------------------------------------------------


def instead(piece, other):
    def change(text):
        assert text.count(piece) == 1, piece
        return text.replace(piece, other)

    return change


def more(line):
    return lambda text: text + line + "\n"


MODELS = {
    "unknown key": (instead("com_m: 0.160", "com_mm: 160"), r"m\.yaml:5: shank\.com_mm: unknown key, expected one of length_m, mass_kg, com_m, inertia_kg_m2"),
    "unknown section": (more("hip: {mass_kg: 2}"), r"m\.yaml:17: hip: unknown key, expected one of plant, .*"),
    "missing key": (instead(", inertia_kg_m2: 0.0420", ""), r"m\.yaml:5: shank\.inertia_kg_m2: missing key"),
    "missing section": (instead("foot: {mass_kg: 0.442, com_m: 0.055, inertia_kg_m2: 0.0021}\n", ""), r"m\.yaml:3: foot: missing key"),
    "key twice": (instead("com_m: 0.055", "com_m: 0.055, com_m: 0.06"), r"m\.yaml:6: foot\.com_m: the key stands twice"),
    "section twice": (more("foot: {}"), r"m\.yaml:17: foot: the key stands twice"),
    "mass of 0": (instead("mass_kg: 1.624", "mass_kg: 0"), r"m\.yaml:5: shank\.mass_kg: expected a number above 0, found '0'"),
    "mass below 0": (instead("mass_kg: 0.442", "mass_kg: -0.442"), r"m\.yaml:6: foot\.mass_kg: expected a number above 0, found '-0\.442'"),
    "friction below 0": (instead("coulomb_Nm: 1.2", "coulomb_Nm: -1.2"), r"m\.yaml:11: knee\.friction\.coulomb_Nm: expected 0 or a number above it, found '-1\.2'"),
    "inertia of 0": (instead("inertia_kg_m2: 0.0021", "inertia_kg_m2: 0"), r"m\.yaml:6: foot\.inertia_kg_m2: expected a number above 0, found '0'"),
    "not a number": (instead("length_m: 0.3615", "length_m: long"), r"m\.yaml:5: shank\.length_m: expected a number, found 'long'"),
    "NaN": (instead("length_m: 0.3615", "length_m: .nan"), r"m\.yaml:5: shank\.length_m: expected a finite number, found '\.nan'"),
    "list for a number": (instead("length_m: 0.3615", "length_m: [1]"), r"m\.yaml:5: shank\.length_m: expected a number, found a list"),
    "unknown plant": (instead("plant: leg", "plant: arm"), r"m\.yaml:3: plant: expected leg, pendulum or slider, found 'arm'"),
    "unknown form": (more("form: newton"), r"m\.yaml:17: form: expected lagrange or paper, found 'newton'"),
    "unknown transmission": (instead("type: fixed", "type: belt"), r"m\.yaml:9: knee\.transmission\.type: expected fixed, screw_linkage or fourier, found 'belt'"),
    "ratio of 0": (instead("ratio: 51", "ratio: 0"), r"m\.yaml:9: knee\.transmission\.ratio: expected a number other than 0, found '0'"),
    "linkage that cannot close": (instead("AB_m: 0.090", "AB_m: 0.004"), r"m\.yaml:13: ankle\.transmission: this linkage does not close, or its ratio changes sign, within \+-30 degrees"),
    "unknown effect": (more("effects: [{effect: magic, joint: knee, parameters: {}}]"), r"m\.yaml:17: effects: the effect 'magic' is not known to this version"),
    "bound on what is known": (more("bounds: {shank.mass_kg: [1, 2]}"), r"m\.yaml:17: bounds\.shank\.mass_kg: not a parameter that is identified"),
    "bounds crossed": (more("bounds: {foot.com_m: [0.1, 0.01]}"), r"m\.yaml:17: bounds\.foot\.com_m: the lower bound 0\.1 is above the upper bound 0\.01"),
    "bounds beside the value": (more("bounds: {foot.com_m: [0.1, 0.2]}"), r"m\.yaml:17: bounds\.foot\.com_m: the model's own value 0\.055 lies outside of \[0\.1, 0\.2\]"),
    "score out of range": (more("score: {lowpass_hz: -30}"), r"m\.yaml:17: score\.lowpass_hz: expected a number above 0, found '-30'"),
    "not YAML": (instead("shank: {", "shank: {{"), r"m\.yaml:6: not YAML: did not find expected ',' or '\}'"),
    "cut": (lambda text: text[: text.index("rotor_inertia")], r"m\.yaml:13: ankle\.rotor_inertia_kg_m2: missing key"),
    "empty": (lambda text: "", r"m\.yaml: the file is empty, expected a model"),
    "a list": (lambda text: "- leg\n", r"m\.yaml:1: expected a mapping \(key: value\), found a list"),
}  # fmt: skip


@pytest.mark.parametrize("name", OUTPUTS)
@pytest.mark.parametrize("fault", MODELS)
def test_model(name, fault, inputs):
    change, words = MODELS[fault]
    (inputs / "m.yaml").write_text(change((inputs / "leg.yaml").read_text()))
    refused(name, inputs, ["--model", "m.yaml", *([] if name == "talus-sim" else ["leg.csv"])], words)


@pytest.mark.parametrize("name", OUTPUTS)
def test_model_that_cannot_be_read(name, inputs):
    recording = [] if name == "talus-sim" else ["leg.csv"]
    refused(name, inputs, ["--model", "none.yaml", *recording], r"none\.yaml: No such file or directory")
    (inputs / "folder").mkdir()
    refused(name, inputs, ["--model", "folder", *recording], "folder: is a directory, expected a file")
    (inputs / "m.yaml").write_bytes(b"plant: \xff\xfe leg\n")
    refused(name, inputs, ["--model", "m.yaml", *recording], r"m\.yaml: not text: .*")


def test_series_whose_ratio_turns(inputs):
    series = "{type: fourier, omega: 1.7, a: [0, 1, 0, 0, 0, 0, 0, 0, 0], b: [0, 0, 0, 0, 0, 0, 0, 0]}"
    text = re.sub(r"\{type: screw_linkage.*\}", series, (inputs / "leg.yaml").read_text())
    (inputs / "m.yaml").write_text(text)
    refused("talus-predict", inputs, ["--model", "m.yaml", "leg.csv"], r"m\.yaml:13: ankle\.transmission: the ratio of this series changes sign.*")


# ---- usage -----------------------------------------------------------------------------

HINT = r" \(talus-\w+ --help tells more\)"
LEG = ["--model", "leg.yaml", "leg.csv"]
USAGE = [
    ("talus-identify", [], r"--model M\.yaml is missing"),
    ("talus-identify", ["--model", "leg.yaml", "leg.csv"], r"--out FITTED\.yaml is missing"),
    ("talus-identify", ["--model", "leg.yaml", "--out", "f.yaml"], r"REC\.csv\.\.\. is missing"),
    ("talus-predict", [], r"--model M\.yaml is missing"),
    ("talus-predict", ["--model", "leg.yaml"], r"REC\.csv is missing"),
    ("talus-predict", ["--model", "leg.yaml", "leg.csv", "knee.csv"], r"more arguments than expected.*"),
    ("talus-sim", [], r"--model TRUTH\.yaml is missing"),
    *((name, ["--wings", *LEG], r"unknown or ambiguous option --wings") for name in OUTPUTS),
    *((name, ["-Z", *LEG], r"unknown option -Z") for name in OUTPUTS),
    *((name, [*LEG, "--model"], r"--model needs a value") for name in OUTPUTS),
]  # fmt: skip


@pytest.mark.parametrize(("name", "arguments", "words"), USAGE, ids=lambda x: " ".join(x) if isinstance(x, list) else None)
def test_usage(name, arguments, words, inputs):
    refused(name, inputs, arguments, words + HINT, outputs=False)


IDENTIFY = [
    (["--seed", "lucky"], r"--seed: expected a whole number, found 'lucky'"),
    (["--seed", "-1"], r"--seed: expected a whole number, found '-1'"),
    (["--seed", "1.5"], r"--seed: expected a whole number, found '1\.5'"),
    (["--seed", "9223372036854775808"], r"--seed is at most 9223372036854775807"),
    (["--window", "wide"], r"--window is ORDER,SECONDS, such as 20,1, not \"wide\""),
    (["--window", "99,1"], r"--window: the order is a whole number from 2 to 24, the length above 0"),
    (["--window", "5,0"], r"--window: the order is .*"),
    (["--loss", "absolute"], r"--loss is \"square\" or \"huber\", not \"absolute\""),
    (["--weights", "none"], r"--weights is \"noise\" or \"equal\", not \"none\""),
    (["--topology", "star"], r"--topology is \"global\" or \"ring\", not \"star\""),
    (["--swarm-form", "bees"], r"--swarm-form is \"constriction\" or \"inertia\", not \"bees\""),
    (["--particles", "1"], r"--particles is a whole number from 2 to 1000000"),
    (["--iterations", "0"], r"--iterations is a whole number from 1 to 1000000"),
    (["--restarts", "0"], r"--restarts is a whole number from 1 to 1000000"),
    (["--threads", "0"], r"--threads is a whole number from 1 to 1000000"),
    (["--threads", "many"], r"--threads: expected a whole number, found 'many'"),
]  # fmt: skip


@pytest.mark.parametrize(("options", "words"), IDENTIFY, ids=lambda x: " ".join(x) if isinstance(x, list) else None)
def test_options_of_identify(options, words, inputs):
    refused("talus-identify", inputs, [*options, *LEG], words + HINT)


def test_results_never_replace_what_is_read(inputs):
    cases = [
        ("talus-identify", ["--out", "leg.csv", *LEG], r"--out: leg\.csv is a recording, it would be lost"),
        ("talus-identify", ["--out", "./leg.csv", *LEG], r"--out: leg\.csv is a recording, it would be lost"),
        ("talus-identify", ["--out", "f.yaml", "--report", "leg.yaml", *LEG], r"--report: leg\.yaml is the model, it would be lost"),
        ("talus-identify", ["--out", "f.yaml", "--report", "f.yaml", *LEG], r"--out and --report are one file, f\.yaml"),
        ("talus-identify", ["--out", "f.yaml", "--html", "f.yaml", *LEG], r"--out and --html are one file, f\.yaml"),
        ("talus-predict", ["--out", "leg.csv", *LEG], r"--out: leg\.csv is the recording, it would be lost"),
        ("talus-predict", ["--out", "leg.yaml", *LEG], r"--out: leg\.yaml is the model, it would be lost"),
        ("talus-sim", ["--out", "leg.yaml", "--model", "leg.yaml"], r"--model and --out are one file, leg\.yaml"),
        ("talus-sim", ["--out", "x", "--truth", "x", "--model", "leg.yaml"], r"--out and --truth are one file, x"),
    ]  # fmt: skip
    for name, arguments, words in cases:
        refused(name, inputs, arguments, words + HINT, outputs=False)
    # the identified model may take the given one's place
    start("talus-identify", inputs, ["--out", "leg.yaml", *LEG]).check_returncode()
    assert b"identified by talus-identify" in (inputs / "leg.yaml").read_bytes()


# ---- results that cannot be written ------------------------------------------------------


def command(name, options):
    given = [part for option, path in options.items() for part in (option, path)]
    return [*given, "--model", "leg.yaml", *(["--duration", "4"] if name == "talus-sim" else ["leg.csv"])]


PLACES = {
    "absent/result": "No such file or directory",
    "leg.csv/result": "Not a directory",  # no right of root's helps here
    "folder": "Is a directory",
}


@pytest.mark.parametrize("name", OUTPUTS)
@pytest.mark.parametrize("place", PLACES)
def test_folder_that_cannot_be_written(name, place, inputs):
    """Whichever of a program's results cannot be written: none is."""
    (inputs / "folder").mkdir()
    for option in OUTPUTS[name]:
        options = {other: f"result{other}" for other in OUTPUTS[name]} | {option: place}
        before = contents(inputs)
        line = line_of(start(name, inputs, command(name, options)), name, 1)
        assert line == f"{place}: cannot be written: {PLACES[place]}"
        assert contents(inputs) == before


@pytest.mark.parametrize("name", OUTPUTS)
def test_folder_without_permission(name, bench):
    """Root may write anywhere, so as root the program runs as nobody, from where nobody can reach it."""
    nobody = {"user": 65534, "group": 65534, "extra_groups": []} if os.geteuid() == 0 else {}
    with tempfile.TemporaryDirectory() as base:
        folder = Path(base)
        folder.chmod(0o755)
        for file in (*bench.iterdir(), program(name)):
            shutil.copy(file, folder)
        (folder / "closed").mkdir(mode=0o555)
        arguments = [folder / name, *command(name, {"--out": "closed/result"})]
        try:
            done = subprocess.run(arguments, cwd=folder, check=False, capture_output=True, timeout=120, **nobody)
        except (OSError, subprocess.SubprocessError) as error:
            pytest.skip(f"cannot run as another user here: {error}")
        assert line_of(done, name, 1) == "closed/result: cannot be written: Permission denied"
        assert list((folder / "closed").iterdir()) == []
        (folder / "closed").chmod(0o755)


@pytest.mark.parametrize("name", OUTPUTS)
def test_device_that_is_full(name, inputs):
    """A link to /dev/full, where every write fails as on a full disk."""
    (inputs / "result").symlink_to("/dev/full")
    for option in OUTPUTS[name]:
        options = {"--out": "out"} | {option: "result"}
        before = contents_without_links(inputs)
        line = line_of(start(name, inputs, command(name, options)), name, 1)
        assert line == "result: cannot be written: No space left on device"
        assert contents_without_links(inputs) == before


def contents_without_links(folder):
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file() and not p.is_symlink()}


GROWING = {  # a result that is larger than the limit, which is above the temporary file of the recording's rows
    "talus-identify": (["--out", "f.yaml", "--html", "result", "--model", "leg.yaml", "leg.csv"], 400_000),
    "talus-predict": (["--out", "result", "--model", "slider.yaml", "late.csv"], 130_000),
    "talus-sim": (["--out", "r.csv", "--motion", "result", "--model", "leg.yaml", "--duration", "20"], 400_000),
}


@pytest.mark.parametrize("name", GROWING)
def test_limit_on_the_size_of_files(name, inputs):
    """The system itself lets no file grow further, and the earlier one survives."""
    arguments, limit = GROWING[name]
    lines = (inputs / "slider.csv").read_text().splitlines()  # with longer times: 29 bytes a row of the result
    late = [re.sub(r"^(\d+)", lambda m: str(int(m[1]) + 1_000_000), line) for line in lines[1:]]
    (inputs / "late.csv").write_text("\n".join([lines[0], *late]) + "\n")
    (inputs / "result").write_bytes(EARLIER)
    (inputs / "tmp").mkdir()
    before = contents(inputs)
    done = start(name, inputs, arguments, restore_signals=False,
                 preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))  # fmt: skip
    assert line_of(done, name, 1) == "result: cannot be written: File too large"
    assert contents(inputs) == before
    start(name, inputs, arguments).check_returncode()
    assert len((inputs / "result").read_bytes()) > limit


@pytest.fixture(scope="session")
def failing_calls(tmp_path_factory):
    library = tmp_path_factory.mktemp("failing") / "failing_calls.so"
    source = Path(__file__).with_name("failing_calls.c")
    subprocess.run(["cc", "-std=c99", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True,
                   env={k: v for k, v in os.environ.items() if k != "LD_PRELOAD"})  # fmt: skip
    return " ".join(filter(None, [os.environ.get("LD_PRELOAD"), str(library)]))


@pytest.mark.parametrize("name", OUTPUTS)
def test_disk_full_at_any_moment(name, inputs, failing_calls):
    """Each call that makes, fills, syncs or names a result fails once. Every result is then what it was, or
    whole and new; the last one, --out, always what it was."""
    results = [f"result{option}" for option in OUTPUTS[name]]
    arguments = command(name, {option: f"result{option}" for option in OUTPUTS[name]})
    start(name, inputs, arguments).check_returncode()
    whole = contents(inputs)
    for failing in range(1, 1000):
        for result in results:
            (inputs / result).write_bytes(EARLIER)
        done = start(name, inputs, arguments, env={"LD_PRELOAD": failing_calls, "FAILING_CALL": str(failing)})
        now = contents(inputs)
        if done.returncode == 0:
            break
        line = line_of(done, name, 1)
        assert re.fullmatch(r"result--\w+: cannot be written: No space left on device", line)
        assert now.keys() == whole.keys() and now["result--out"] == EARLIER
        assert all(now[path] in (EARLIER, whole[path]) for path in results)
    assert now == whole
    # at least: make, fill, sync and name each result
    assert failing - 1 >= 4 * len(results)


# ---- recordings that tell too little -----------------------------------------------------


@pytest.mark.parametrize("quiet", [[], ["--quiet"]], ids=["words", "quiet"])
def test_only_the_knee_moves(quiet, inputs):
    """What the ankle alone would tell is not identified, and said by name; the rest is."""
    done = start("talus-identify", inputs, ["--model", "leg_cad.yaml", "--out", "f.yaml", "--report", "r.json", *quiet, "knee.csv"])
    assert done.returncode == 0, done.stderr
    report, said = json.loads((inputs / "r.json").read_text()), done.stderr.decode()
    unseen = {"ankle_rotor_inertia_kg_m2", "ankle_coulomb_Nm", "ankle_viscous_Nms_rad"}
    for name in unseen:
        assert f"{name} is not excited by these recordings: the given value is kept" in said
        parameter = report["parameters"][name]
        assert not parameter["identifiable"] and parameter["sigma"] is None
        assert parameter["value"] == pytest.approx(parameter["prior"], rel=1e-12)
    for name, parameter in report["parameters"].items():
        if not parameter["identifiable"]:  # every one is named, alone or among those it is mixed with
            assert re.search(rf"note: not identifiable \(\*\): .*\b{name}\b", said)
    for name, truth in (("knee_coulomb_Nm", 1.2), ("knee_viscous_Nms_rad", 0.45)):
        assert report["parameters"][name]["identifiable"]
        assert report["parameters"][name]["value"] == pytest.approx(truth, rel=0.03)
    assert report["error"]["ankle"]["samples"] == 0
    assert "ankle: no samples in motion" in said or quiet


def test_hardly_excited_parameters_are_named(inputs):
    """Slow ramps hardly show the foot's inertia: its standard deviation is honest, and a warning names it."""
    run("talus-sim", "--model", inputs / "leg.yaml", "--out", inputs / "ramps.csv", "--excitation", "ramps")
    arguments = ["--model", "leg_cad.yaml", "--out", "f.yaml", "--report", "r.json", "--quiet", "ramps.csv"]
    done = start("talus-identify", inputs, arguments)
    assert done.returncode == 0
    parameter = json.loads((inputs / "r.json").read_text())["parameters"]["foot_inertia_kg_m2"]
    assert parameter["identifiable"] and parameter["sigma"] > 0.5 * parameter["prior"]
    assert abs(parameter["value"] - 0.0021) < 3 * parameter["sigma"]
    assert "note: foot_inertia_kg_m2 is hardly excited: its standard deviation is " in done.stderr.decode()


def test_too_short_for_standard_deviations(inputs):
    lines = (inputs / "leg.csv").read_text().splitlines()
    (inputs / "rec.csv").write_text("\n".join(lines[:501]) + "\n")
    done = start("talus-identify", inputs, ["--model", "leg_cad.yaml", "--out", "f.yaml", "--report", "r.json", "rec.csv"])
    assert done.returncode == 0 and "note: too little data for standard deviations" in done.stderr.decode()
    report = json.loads((inputs / "r.json").read_text())
    assert {p["sigma"] for p in report["parameters"].values()} == {None}
