"""Bad input given to talus-gap: one line that names file and line, column or key; nothing is written, and what stood there
stays. The faults are those of test_bad_input.py; recordings too short or too poor get `unknown` with the reason."""

import json
import re
import shutil

import pytest
from support import REPOSITORY, run
from test_bad_input import EARLIER, FILES, RECORDINGS, bench, contents, inputs, line_of, start  # noqa: F401
from test_page import Page

GAP = "talus-gap"
OUTPUTS = ("--report", "--html", "--save-model")


def refused(folder, arguments, words, status=2):
    """Demands the line; results that were there stay, and none is new, neither a trajectory nor a temporary file."""
    options = []
    for option in OUTPUTS:
        options += [option, f"result{option}"]
        (folder / f"result{option}").write_bytes(EARLIER)
    before = contents(folder)
    line = line_of(start(GAP, folder, [*options, *arguments]), GAP, status)
    assert re.fullmatch(words, line), line
    assert contents(folder) == before


@pytest.mark.parametrize("fault", ["column missing", "not a number", "NaN", "infinity", "time stands still", "time runs back",
                                   "99 samples", "header only"])  # fmt: skip
def test_recording(fault, inputs):
    change, words = RECORDINGS[fault]
    lines = (inputs / "slider.csv").read_text().splitlines()
    change(lines)
    (inputs / "rec.csv").write_text("\n".join(lines) + "\n")
    refused(inputs, ["--model", "slider.yaml", "rec.csv"], words)


@pytest.mark.parametrize("fault", ["empty", "cut within a line", "gzip, cut", "gzip, damaged"])
def test_file_that_is_no_recording(fault, inputs):
    file, change, words = FILES[fault]
    (inputs / file).write_bytes(change((inputs / "slider.csv").read_bytes()))
    refused(inputs, ["--model", "slider.yaml", file], words)


def test_the_second_recording_is_looked_at_too(inputs):
    lines = (inputs / "slider.csv").read_text().splitlines()
    RECORDINGS["NaN"][0](lines)
    (inputs / "rec.csv").write_text("\n".join(lines) + "\n")
    refused(inputs, ["--model", "slider.yaml", "slider.csv", "rec.csv"], RECORDINGS["NaN"][1])


MODELS = {
    "unknown key": ("mass_kg", "mass_g", r"m\.yaml:\d+: .*mass_g.*"),
    "missing key": (r"plant: slider\n", "", r"m\.yaml:?\d*: .*plant.*"),
    "out of range": (r"mass_kg: [\d.]+", "mass_kg: -1", r"m\.yaml:\d+: mass_kg: .*"),
    "not YAML": (r"plant: slider", "plant: [slider", r"m\.yaml:\d+: .*"),
}


@pytest.mark.parametrize("fault", MODELS)
def test_model(fault, inputs):
    old, new, words = MODELS[fault]
    text, count = re.subn(old, new, (inputs / "slider.yaml").read_text(), count=1)
    assert count == 1
    (inputs / "m.yaml").write_text(text)
    refused(inputs, ["--model", "m.yaml", "slider.csv"], words)


def test_files_that_cannot_be_opened(inputs):
    refused(inputs, ["--model", "none.yaml", "slider.csv"], r"none\.yaml: No such file or directory")
    refused(inputs, ["--model", "slider.yaml", "none.csv"], r"none\.csv: No such file or directory")
    refused(inputs, ["--model", "leg.yaml", "slider.csv"], r"slider\.csv:1: missing column: knee_motor_rad, .*")


@pytest.mark.parametrize("option", [*OUTPUTS, "--trajectory"])
def test_folder_that_cannot_be_written(option, inputs):
    """Whichever result cannot be written: none is."""
    lines = (inputs / "slider.csv").read_text().splitlines()
    (inputs / "short.csv").write_text("\n".join(lines[:800]) + "\n")
    options = {o: f"result{o}" for o in OUTPUTS} | {option: "absent/result"}
    given = [part for pair in options.items() for part in pair]
    before = contents(inputs)
    done = start(GAP, inputs, [*given, "--quiet", "--model", "slider.yaml", "short.csv"])
    if option == "--trajectory":  # too short for a diagnosis, so that there is no trajectory to write
        assert done.returncode == 0 and not (inputs / "absent").exists()
        return
    assert done.returncode == 1
    assert done.stderr.decode().splitlines()[-1] == f"{GAP}: absent/result: cannot be written: No such file or directory"
    assert contents(inputs) == before


# ---- too short, too poor -----------------------------------------------------------


def diagnosed(folder, model, recording):
    """GAP.json, and the page's parts."""
    done = start(GAP, folder, ["--model", model, "--report", "gap.json", "--html", "gap.html", "--save-model", "f.yaml", recording])
    assert done.returncode == 0, done.stderr
    return json.loads((folder / "gap.json").read_text()), (folder / "gap.html").read_text(), done.stderr.decode()


def check_poor(report, page, said, reason):
    assert report["verdict"] == {"effect": "unknown", "joint": "none", "probability": 1.0, "withheld": True}
    (finding, *_) = report["findings"]
    assert finding["grave"] and finding["id"] in ("too_short", "too_little_motion")
    assert report["effects"] == [] and report["alternatives"] == []
    why = report["next_experiment"]["why"]
    assert re.search(reason, why) and "Next: " in why
    assert report["next_experiment"]["trajectory"] is None
    for gap in report["gap"].values():
        assert gap["closed_fraction"] == 0.0 and gap["extended_rms"] == gap["identified_rms"]
    lead = Page(page).text["p"][0]
    assert lead == f"No cause is named before this is mended: {finding['evidence']}." and lead in said
    assert any(why in text for text in Page(page).text["p"]) and why in said
    for claim in ("with effects", "closed", "noise floor"):  # nothing was held out, so none of it is known
        assert claim not in page.split("</main>")[0]


def test_too_short(inputs):
    lines = (inputs / "slider.csv").read_text().splitlines()
    (inputs / "short.csv").write_text("\n".join(lines[:800]) + "\n")
    check_poor(*diagnosed(inputs, "slider.yaml", "short.csv"), r"^Only \d\.\d s of usable motion, and a diagnosis needs")


def test_a_joint_that_never_moves(inputs):
    """It has no figure; the other joint has."""
    report, page, said = diagnosed(inputs, "leg.yaml", "knee.csv")
    check_poor(report, page, said, r"^Only \d+ samples of the ankle lie outside standstill")
    assert set(report["gap"]) == {"knee"}


def test_a_load_sensor_at_rest(inputs):
    """Nothing moves, and nothing pulls at the sensor for long enough."""
    shutil.copy(REPOSITORY / "models" / "pendulum.yaml", inputs)
    rows = [f"{0.01 * k:.2f},0.1,{0.2 * (k % 7)},0.5" for k in range(300)]
    (inputs / "still.csv").write_text("\n".join(["time_s,joint_rad,joint_current_A,joint_load_Nm", *rows]) + "\n")
    check_poor(*diagnosed(inputs, "pendulum.yaml", "still.csv"), r"^Only \d\.\d s of usable motion")


def test_nothing_moves(inputs):
    lines = (inputs / "slider.csv").read_text().splitlines()
    still = [lines[0], *(f"{t},0.1,{f}" for t, _, f in (line.split(",") for line in lines[1:]))]
    (inputs / "still.csv").write_text("\n".join(still) + "\n")
    report, page, said = diagnosed(inputs, "slider.yaml", "still.csv")
    check_poor(report, page, said, r"^Only 0 samples of the slider lie outside standstill")
    assert report["gap"] == {}
