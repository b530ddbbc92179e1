"""talus-predict --report and --html: the errors against the scoring rule in SciPy, from the columns that it writes."""

import json
from html.parser import HTMLParser

import numpy as np
import pytest
import talus
import yaml
from scoring_reference import score
from support import REPOSITORY, data, needs_data, run

MODELS = REPOSITORY / "models"
SHOWN = {  # what each plant's recording shows of a joint, in the prediction's unit: (column, factor)
    "leg": {"knee": ("knee_current_A", 0.1031), "ankle": ("ankle_current_A", 0.1031)},
    "pendulum": {"joint": ("joint_current_A", 0.091 * 9)},
    "slider": {"slider": ("slider_force_N", 1.0)},
}


def columns(path):
    with open(path, encoding="utf-8") as file:
        return np.genfromtxt((line for line in file if not line.startswith("#")), delimiter=",", names=True)


def predict(folder, model, recording, *more):
    """(report, prediction, what was said)."""
    done = run("talus-predict", "--model", model, "--report", folder / "p.json", "--out", folder / "p.csv", *more, recording)
    return json.loads((folder / "p.json").read_text()), columns(folder / "p.csv"), done.stderr


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """A leg, an arm and a slider, 20 s each, as talus-sim records them, and their true motion beside them."""
    folder = tmp_path_factory.mktemp("recordings")
    for plant in SHOWN:
        run("talus-sim", "--model", MODELS / f"{plant}.yaml", "--out", folder / f"{plant}.csv",
            "--motion", folder / f"{plant}_motion.csv", "--duration", 20, "--rate", 500)  # fmt: skip
    return folder


def off(model, text, folder):
    """The model with other friction, so that there is an error to be measured."""
    old, new = text
    changed = folder / "off.yaml"
    assert old in model.read_text()
    changed.write_text(model.read_text().replace(old, new))
    return changed


CHANGES = {"leg": ("coulomb_Nm: 0.8", "coulomb_Nm: 0.6"), "pendulum": ("viscous_Nms_rad: ", "viscous_Nms_rad: 1"),
           "slider": ("viscous_Ns_m: ", "viscous_Ns_m: 1")}  # fmt: skip


@pytest.mark.parametrize("plant", SHOWN)
def test_errors_are_those_of_the_rule(plant, recordings, tmp_path):
    """The samples near standstill are found from the true speed here and from windows over the recorded angle there: a
    few at the threshold may differ."""
    model, recording = off(MODELS / f"{plant}.yaml", CHANGES[plant], tmp_path), columns(recordings / f"{plant}.csv")
    motion = columns(recordings / f"{plant}_motion.csv")
    report, prediction, said = predict(tmp_path, model, recordings / f"{plant}.csv")
    assert report["schema"] == "talus-predict/1" and list(report["error"]) == list(SHOWN[plant])
    for name, (joint, found) in zip(prediction.dtype.names[1:], report["error"].items(), strict=True):
        column, factor = SHOWN[plant][joint]
        speed = motion[f"{joint}_velocity_{'m' if plant == 'slider' else 'rad'}_s"]
        rms, measured, relative, *_ = score(recording["time_s"], factor * recording[column], prediction[name], speed)
        assert found["unit"] == ("N" if plant == "slider" else "Nm")
        assert found["rms"] == pytest.approx(rms, rel=0.01), joint
        assert found["measured_rms"] == pytest.approx(measured, rel=0.01), joint
        assert found["relative_percent"] == pytest.approx(relative, rel=0.01), joint
        assert f"{joint}: error {found['relative_percent']:.1f} % of the measured {'force' if plant == 'slider' else 'torque'}" in said


def test_an_exact_rule_without_standstill(tmp_path, recordings):
    """With no sample left out for its speed the two must agree to the last digits that the prediction is written with."""
    model = tmp_path / "m.yaml"
    model.write_text((MODELS / "slider.yaml").read_text() + "score: {lowpass_hz: 20, order: 4, standstill: 0, guard_s: 0, trim_s: 0.5}\n")
    recording = columns(recordings / "slider.csv")
    report, prediction, _ = predict(tmp_path, off(model, CHANGES["slider"], tmp_path), recordings / "slider.csv")
    rms, measured, relative, *_ = score(recording["time_s"], recording["slider_force_N"], prediction["slider_force_N"],
                                    np.ones(len(recording)), lowpass_hz=20, standstill=0, guard_s=0, trim_s=0.5)  # fmt: skip
    found = report["error"]["slider"]
    assert (found["rms"], found["measured_rms"], found["relative_percent"]) == pytest.approx((rms, measured, relative), rel=1e-6)
    assert found["samples_left_out"] == 0 and found["reversal_rms"] is None


def test_the_error_is_what_identification_reports(tmp_path, recordings):
    run("talus-identify", "--model", MODELS / "leg_cad.yaml", "--out", tmp_path / "f.yaml", "--report", tmp_path / "r.json",
        recordings / "leg.csv")  # fmt: skip
    identified = json.loads((tmp_path / "r.json").read_text())["error"]
    report, _, _ = predict(tmp_path, tmp_path / "f.yaml", recordings / "leg.csv")
    for joint, found in report["error"].items():
        assert found["rms"] == pytest.approx(identified[joint]["identified_rms"], rel=1e-12)
        assert found["measured_rms"] == pytest.approx(identified[joint]["measured_rms"], rel=1e-12)
        assert found["samples"] == identified[joint]["samples"]


@needs_data
def test_a_real_recording_by_its_own_rule(tmp_path):
    """EMPS, whose model file has a score of its own: the contract's formula in SciPy, with speeds by differences."""
    model, path = data("emps/model.yaml"), data("emps/emps_identification.csv")
    report, prediction, _ = predict(tmp_path, model, path)
    recording, rule = columns(path), yaml.safe_load(model.read_text())["score"]
    speed = np.gradient(recording["slider_m"], recording["time_s"])
    expected = score(recording["time_s"], recording["slider_force_N"], prediction["slider_force_N"], speed, **rule)
    found = report["error"]["slider"]
    assert (found["rms"], found["measured_rms"], found["relative_percent"]) == pytest.approx(expected[:3], rel=1e-3)


class Text(HTMLParser):
    """The page's words and what it asks of a network."""

    def __init__(self, text):
        super().__init__()
        self.words, self.links = "", []
        self.feed(text)

    def handle_data(self, data):
        self.words += data

    def handle_starttag(self, tag, attrs):
        self.links += [value for name, value in attrs if name in ("src", "href") and not value.startswith("data:")]


def test_report_and_page_without_the_prediction(tmp_path, recordings):
    """Nothing is printed on standard output where only the error was asked for, and --out - prints it."""
    options = ("--model", MODELS / "leg_cad.yaml", "--report", tmp_path / "p.json", "--html", tmp_path / "p.html")
    done = run("talus-predict", *options, recordings / "leg.csv")
    assert done.stdout == ""
    page = Text((tmp_path / "p.html").read_text())
    error = json.loads((tmp_path / "p.json").read_text())["error"]
    sentence = (f"Error {error['knee']['relative_percent']:.1f} % of the measured torque at the knee and "
                f"{error['ankle']['relative_percent']:.1f} % at the ankle.")  # fmt: skip
    assert sentence in page.words and page.links == []
    assert run("talus-predict", *options, "--out", "-", recordings / "leg.csv").stdout.startswith("time_s,knee_motor_torque_Nm")


def test_nothing_moves(tmp_path, recordings):
    lines = (recordings / "slider.csv").read_text().splitlines()
    (tmp_path / "still.csv").write_text("\n".join([lines[0], *(f"{line.split(',')[0]},0.1,{line.split(',')[2]}" for line in lines[1:])]) + "\n")
    report, _, said = predict(tmp_path, MODELS / "slider.yaml", tmp_path / "still.csv")
    assert report["error"]["slider"]["rms"] is None and report["error"]["slider"]["samples"] == 0
    assert "slider: no samples in motion, nothing to score" in said


def uneven(path):
    """An arm's recording with stretches three times as dense and four times as sparse as its median step, gaps, and rows
    that are not valid: margins of a block hold more rows, and fewer, than even steps would need."""
    generator = np.random.default_rng(3)
    steps = np.concatenate([np.full(6000, 1e-3), np.full(9000, 3e-4), np.full(2500, 4e-3), np.full(8000, 1e-3), [0.5],
                            np.full(40, 1e-3), [2.0], np.full(5000, 1e-3)]) * generator.uniform(0.9, 1.1, 30542)  # fmt: skip
    t = np.concatenate([[0.0], np.cumsum(steps)])
    q = 0.5 * np.sin(2 * np.pi * 0.7 * t) + 0.2 * np.sin(2 * np.pi * 1.9 * t + 1)
    v = np.gradient(q, t)
    torque = 0.045 * np.gradient(v, t) + 0.15 * 9.81 * np.sin(q) + 0.25 * np.sign(v) + 0.02 * v
    current = torque / (9 * 0.091) + generator.normal(0, 0.02, len(t))
    valid = np.ones(len(t))
    valid[20000:20100] = 0
    np.savetxt(path, np.column_stack([t, q, current, valid]), delimiter=",", header="time_s,joint_rad,joint_current_A,valid",
               comments="", fmt="%.9g")  # fmt: skip
    return path


def test_blocks_of_uneven_rows_give_what_the_whole_recording_gives(tmp_path):
    """The program goes block by block on several processors; Python takes each segment whole."""
    path, model = uneven(tmp_path / "u.csv"), MODELS / "pendulum.yaml"
    report, prediction, _ = predict(tmp_path, model, path)
    whole, recording = talus.Model.read(model), talus.Recording.read(path)
    assert np.max(np.abs(prediction["joint_torque_Nm"] - talus.predict(whole, recording)[0])) < 1e-9
    expected = talus.score(whole, recording, talus.predict(whole, recording))["joint"]
    found = report["error"]["joint"]
    assert found["samples"] == expected["samples"] and found["samples_left_out"] == expected["samples_left_out"]
    assert (found["rms"], found["reversal_rms"]) == pytest.approx((expected["rms"], expected["reversal_rms"]), rel=1e-6)


def test_any_number_of_threads_identifies_uneven_rows_alike(tmp_path):
    path, outputs = uneven(tmp_path / "u.csv"), set()
    for threads in (1, 2, 3, 4):
        run("talus-identify", "--model", MODELS / "pendulum.yaml", "--out", tmp_path / "f.yaml", "--report", tmp_path / "r.json",
            "--threads", threads, path)  # fmt: skip
        outputs.add((tmp_path / "f.yaml").read_bytes() + (tmp_path / "r.json").read_bytes())
    assert len(outputs) == 1
