"""talus-sim: its files, its refusals, and that its truth is the truth."""

import csv
import gzip
import json
import os
import re
import subprocess

import numpy as np
import pytest
from support import REPOSITORY, program, run

LEG, PENDULUM, SLIDER = (REPOSITORY / "models" / f"{plant}.yaml" for plant in ("leg", "pendulum", "slider"))
COLUMNS = {
    LEG: "time_s,knee_motor_rad,ankle_motor_rad,ankle_joint_rad,knee_current_A,ankle_current_A",
    PENDULUM: "time_s,joint_rad,joint_current_A",
    SLIDER: "time_s,slider_m,slider_force_N",
}


def sim(model, out, *options, **more):
    return run("talus-sim", "--model", model, "--out", out, *options, **more)


def read(path):
    """The columns of a CSV file."""
    text = gzip.open(path, "rt") if str(path).endswith(".gz") else open(path)
    with text:
        rows = list(csv.reader(text))
    return dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))


@pytest.fixture(scope="module")
def leg(tmp_path_factory):
    """A minute of the leg with all that can be written."""
    folder = tmp_path_factory.mktemp("leg")
    sim(LEG, folder / "r.csv", "--truth", folder / "t.json", "--motion", folder / "m.csv", "--duration", 60, "--camera")
    return read(folder / "r.csv"), json.loads((folder / "t.json").read_text()), read(folder / "m.csv")


# ---- what it writes ---------------------------------------------------------------


@pytest.mark.parametrize("model", COLUMNS)
@pytest.mark.parametrize("excitation", ["multisine", "ramps"])
def test_columns_of_the_recording_format(model, excitation, tmp_path):
    sim(model, tmp_path / "r.csv", "--excitation", excitation, "--rate", 200)
    recording = read(tmp_path / "r.csv")
    assert ",".join(recording) == COLUMNS[model]
    t = recording["time_s"]
    assert (np.diff(t) > 0).all() and len(t) == pytest.approx(200 * t[-1], abs=2)
    assert len(t) == 24000 if excitation == "multisine" else 15 < t[-1] < 70
    for column in recording.values():
        assert np.isfinite(column).all() and np.ptp(column) > 0


def test_compressed_is_the_same_text(tmp_path):
    for name in ("a.csv", "b.csv.gz"):
        sim(LEG, tmp_path / name, "--duration", 10)
    packed = (tmp_path / "b.csv.gz").read_bytes()
    assert gzip.decompress(packed) == (tmp_path / "a.csv").read_bytes()
    assert packed[4:8] == bytes(4)  # no time of writing in it


def test_the_same_seed_is_the_same_bytes(tmp_path):
    def files(name, *options):
        paths = [tmp_path / f"{name}.{kind}" for kind in ("csv", "json", "motion")]
        sim(LEG, paths[0], "--truth", paths[1], "--motion", paths[2], "--duration", 5, *options)
        return [path.read_bytes() for path in paths]

    one, again, other = files("a"), files("b"), files("c", "--seed", 2)
    assert one == again and all(x != y for x, y in zip(one, other, strict=True))
    # the phases alone, and the noise alone
    phases, noise = files("d", "--phase-seed", 2), files("e", "--seed", 2, "--phase-seed", 1)
    assert phases[0] != one[0] and noise[0] != one[0]
    excitation = [json.loads(x[1])["excitation"] for x in (one, noise, phases, other)]
    assert excitation[0] == excitation[1] != excitation[2] == excitation[3]


def test_truth_has_the_models_parameters(leg):
    _, truth, _ = leg
    given = {k: float(v) for k, v in re.findall(r"(\w+): (-?[\d.]+(?:e-?\d+)?)[,}\n]", LEG.read_text())}
    assert truth["schema"] == "talus-sim/1" and truth["plant"] == "leg" and truth["seed"] == 1
    p = truth["parameters"]
    assert len(p) == 10 and p["ankle_rotor_inertia_kg_m2"] == given["rotor_inertia_kg_m2"]
    assert (p["shank_com_m"], p["foot_com_m"], p["ankle_motor_com_m"]) == (0.160, 0.055, 0.120)
    assert (p["knee_coulomb_Nm"], p["ankle_viscous_Nms_rad"]) == (1.2, 0.30)
    assert truth["base_parameters"]["shank_moment"] == pytest.approx(1.624 * 0.160 + 0.4112 * 0.120)
    assert truth["base_parameters"]["foot_inertia"] == pytest.approx(0.0021 + 0.442 * 0.055**2)


def test_truth_has_the_sensors(leg):
    recording, truth, motion = leg
    sensors = truth["sensors"]
    for j, joint in enumerate(("knee", "ankle")):
        noise = recording[f"{joint}_current_A"] - motion[f"{joint}_torque_Nm"] / 0.1031
        assert noise.std() == pytest.approx(sensors["current_noise_A"][j], rel=0.03)
        assert abs(noise.mean()) < 4 * noise.std() / len(noise) ** 0.5
    assert np.all(recording["time_s"] == motion["time_s"])
    error = recording["knee_motor_rad"] - 51 * motion["knee_position_rad"]
    step = sensors["encoder_step_rad"][0]
    assert step == pytest.approx(2 * np.pi / 2**14) and np.abs(error).max() < 0.51 * step
    error = recording["ankle_joint_rad"] - motion["ankle_position_rad"]
    assert np.abs(error).max() < 0.51 * sensors["ankle_joint_step_rad"]
    camera = recording["foot_rad"] - motion["knee_position_rad"] - motion["ankle_position_rad"]
    assert camera.std() == pytest.approx(sensors["camera_noise_rad"], rel=0.03)


def test_truth_has_the_excitation(leg):
    recording, truth, motion = leg
    e = truth["excitation"]
    w = 2 * np.pi * e["base_hz"] * np.arange(1, 9)[:, None] * (recording["time_s"] + e["settle_s"])
    for j, joint in enumerate(("knee", "ankle")):
        sine, cosine = (np.array(e[joint][kind])[:, None] for kind in ("sine", "cosine"))
        reference = e["offset"][j] + (sine * np.sin(w) + cosine * np.cos(w)).sum(0)
        assert motion[f"{joint}_reference_rad"] == pytest.approx(reference, abs=1e-9)
        assert np.abs(motion[f"{joint}_position_rad"] - reference).max() < 0.03


def test_motion_is_the_motion(leg):
    _, _, motion = leg
    t = motion["time_s"]
    for joint in ("knee", "ankle"):
        q, v, a, slip = (motion[f"{joint}_{x}"] for x in ("position_rad", "velocity_rad_s", "acceleration_rad_s2", "slip"))
        assert np.abs(np.diff(q) - np.diff(t) * (v[1:] + v[:-1]) / 2).max() < 2e-4  # the trapezoidal rule
        sticks = v == 0
        assert np.all(slip[~sticks] == np.sign(v[~sticks])) and np.abs(slip[sticks]).max() <= 1
        assert sticks.sum() > 10 and np.all(a[sticks] == 0)


def test_what_is_asked_for_is_done(tmp_path):
    out, truth = tmp_path / "r.csv", tmp_path / "t.json"
    sim(LEG, out, "--truth", truth, "--rate", 100, "--jitter", 0, "--noise", "0.1,0.2", "--encoder-bits", "10,12",
        "--ankle-bits", 9, "--duration", 20, "--period", 5, "--harmonics", 3, "--amplitude", "0.4,0.2")  # fmt: skip
    told, recording = json.loads(truth.read_text()), read(out)
    assert np.diff(recording["time_s"]) == pytest.approx(0.01, abs=1e-12) and len(recording["time_s"]) == 2000
    assert told["sensors"]["current_noise_A"] == [0.1, 0.2]
    assert told["sensors"]["encoder_step_rad"] == pytest.approx([2 * np.pi / 2**10, 2 * np.pi / 2**12])
    assert told["sensors"]["ankle_joint_step_rad"] == pytest.approx(2 * np.pi / 2**9)
    assert told["excitation"]["base_hz"] == pytest.approx(0.2) and len(told["excitation"]["knee"]["sine"]) == 3
    assert np.ptp(recording["knee_motor_rad"]) / 51 == pytest.approx(0.8, abs=0.05)
    faster = tmp_path / "f.json"
    sim(LEG, out, "--truth", faster, "--period", 5, "--speed", 1.5, "--duration", 4)
    assert json.loads(faster.read_text())["excitation"]["base_hz"] == pytest.approx(0.3)


def test_ideal_sensors(tmp_path):
    out, motion = tmp_path / "r.csv", tmp_path / "m.csv"
    sim(LEG, out, "--motion", motion, "--ideal", "--duration", 4)
    recording, true = read(out), read(motion)
    assert recording["knee_motor_rad"] == pytest.approx(51 * true["knee_position_rad"], abs=1e-9)
    assert recording["ankle_current_A"] == pytest.approx(true["ankle_torque_Nm"] / 0.1031, abs=1e-11)
    sim(LEG, out, "--motion", motion, "--ideal", "--noise", "0.5", "--duration", 4)  # but for what is given
    noise = read(out)["knee_current_A"] - read(motion)["knee_torque_Nm"] / 0.1031
    assert noise.std() == pytest.approx(0.5, rel=0.1)


def test_memory_does_not_grow_with_time(tmp_path):
    def peak(seconds):
        command = [program("talus-sim"), "--model", LEG, "--out", tmp_path / "r.csv", "--duration", str(seconds)]
        process = subprocess.Popen([*map(str, command)], env={**os.environ, "ASAN_OPTIONS": "quarantine_size_mb=1"})
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        assert process.returncode == 0
        return usage.ru_maxrss

    assert peak(900) < 1.1 * peak(20)


# ---- limits -------------------------------------------------------------------------


def test_a_broken_limit_is_named_and_the_earlier_file_survives(tmp_path):
    out = tmp_path / "r.csv"
    out.write_text("what was there\n")
    done = sim(LEG, out, "--excitation", "paper", "--truth", tmp_path / "t.json", status=2)
    line, *rest = done.stderr.splitlines()
    assert not rest and line.startswith("talus-sim: the excitation breaks 6 limits: knee speed ")
    # the peaks that equations.md names, each with its limit
    assert re.search(r"knee acceleration -2926 rad/s\^2 at \d+\.\d+ s \(limit -100, 2\.83e\+03 beyond\)", line)
    assert re.search(r"ankle acceleration -1463 rad/s\^2 at ", line) and "ankle torque" in line and "--fit" in line
    assert out.read_text() == "what was there\n" and [*tmp_path.iterdir()] == [out]


@pytest.mark.parametrize("joint,quantity,limit", [("knee", "speed", 2.0), ("ankle", "acceleration", 10.0),
                                                  ("knee", "torque", 0.08), ("ankle", "position", "-0.2:0.3")])  # fmt: skip
def test_limits_given_by_hand(joint, quantity, limit, tmp_path):
    limits = f"{joint}.{quantity}={limit}"
    line = sim(LEG, tmp_path / "r.csv", "--limits", limits, status=2).stderr
    assert f": {joint} {quantity} " in line
    done = sim(LEG, tmp_path / "r.csv", "--limits", limits, "--fit", "--truth", tmp_path / "t.json", "--duration", 4)
    assert "note: " in done.stderr
    e = json.loads((tmp_path / "t.json").read_text())["excitation"]
    assert min(*e["scaled_amplitude"], e["scaled_speed"]) < 1
    assert f"{min(*e['scaled_amplitude'], e['scaled_speed']):.4f}" in done.stderr


def test_papers_excitation_made_to_fit(tmp_path):
    motion = tmp_path / "m.csv"
    done = sim(LEG, tmp_path / "r.csv", "--excitation", "paper", "--fit", "--motion", motion, "--duration", 20)
    assert re.search(r"note: speed times 0\.1\d+ to fit the limits on speed, acceleration and torque", done.stderr)
    true = read(motion)
    for joint in ("knee", "ankle"):
        assert np.abs(np.gradient(true[f"{joint}_reference_rad"], true["time_s"])).max() < 8


# ---- refusals -------------------------------------------------------------------------


@pytest.mark.parametrize("options,text", [
    (["--speed", "fast"], "--speed: expected a number, found 'fast'"),
    (["--speed", "0"], "--speed: 0 is not within"),
    (["--speed", "nan"], "--speed: expected a number"),
    (["--excitation", "chirp"], "--excitation: expected multisine, paper or ramps, found 'chirp'"),
    (["--noise", "0.1,"], "--noise: expected a number, or two with a comma"),
    (["--noise", "-1"], "--noise: -1 is not within"),
    (["--encoder-bits", "60"], "--encoder-bits: 60 is not within"),
    (["--harmonics", "33"], "--harmonics: more than 32"),
    (["--limits", "hip.speed=3"], "--limits: expected for instance"),
    (["--limits", "knee.speed=0"], "--limits: expected for instance"),
    (["--limits", "knee.position=1:-1"], "--limits: expected for instance"),
    (["--limits", "slider.speed=3"], "--limits: expected for instance knee.position=-0.9:0.1 or ankle.speed=4, found 'slider.speed=3'"),
    (["--limits", "knee.position=0.4:0.5", "--fit"], "lies outside the position limits"),
    (["--limits", "knee.torque=0.001", "--fit"], "gravity and friction alone break the torque limit"),
    (["--rate", "2000"], "--rate: 2000 Hz is above the control's 1000 Hz"),
    (["--jitter", "0.002"], "--jitter: 0.002 s is more than 0.45 of a sample's step"),
    (["--duration", "0.3"], "--duration: 0.3 s are fewer than 100 samples"),
    (["--excitation", "ramps", "--period", "3"], "--period: ramps have none"),
    (["--excitation", "paper", "--harmonics", "3"], "--harmonics: for the multisine only"),
    (["--excitation", "paper", "--amplitude", "0.3"], "--amplitude: the paper's series has its own"),
    (["--seed", "-1"], "--seed: expected a whole number"),
    (["stray"], "more arguments than expected"),
    (["--wind", "3"], "unknown or ambiguous option"),
])  # fmt: skip
def test_bad_usage(options, text, tmp_path):
    out = tmp_path / "r.csv"
    out.write_text("what was there\n")
    done = sim(LEG, out, *options, status=2)
    assert text in done.stderr and len(done.stderr.splitlines()) == 1 and done.stdout == ""
    assert out.read_text() == "what was there\n" and [*tmp_path.iterdir()] == [out]


def test_bad_models(tmp_path):
    out, model = tmp_path / "r.csv", tmp_path / "m.yaml"
    assert "no.yaml" in sim(tmp_path / "no.yaml", out, status=2).stderr
    model.write_text(LEG.read_text() + "form: paper\n")
    assert "form: paper" in sim(model, out, status=2).stderr
    model.write_text(LEG.read_text() + "wings: 2\n")
    assert re.search(r"m\.yaml:\d+: wings", sim(model, out, status=2).stderr)
    assert "--camera: only a leg" in sim(SLIDER, out, "--camera", status=2).stderr
    assert "--model" in run("talus-sim", "--out", out, status=2).stderr
    assert "--out" in run("talus-sim", "--model", LEG, status=2).stderr
    assert not out.exists()


def test_what_cannot_be_written(tmp_path):
    out = tmp_path / "r.csv"
    for options in (["/dev/full"], [tmp_path / "none" / "r.csv"], [out, "--truth", "/dev/full"],
                    [out, "--motion", "/dev/full"]):  # fmt: skip
        done = sim(LEG, *options, "--duration", 2, status=1)
        assert len(done.stderr.splitlines()) == 1
    assert [*tmp_path.iterdir()] == []


def test_current_limit_is_told(tmp_path):
    far = ",".join(f"{joint}.{what}=9999" for joint in ("knee", "ankle") for what in ("speed", "acceleration", "torque"))
    done = sim(LEG, tmp_path / "r.csv", "--duration", 4, "--speed", 4, "--limits", far, "--ideal")
    share = float(re.fullmatch(r"talus-sim: note: a drive was at its current limit in (.*) % of the samples\n", done.stderr)[1])
    recording = read(tmp_path / "r.csv")
    at_limit = [np.abs(recording[c]) >= np.abs(recording[c]).max() - 1e-9 for c in ("knee_current_A", "ankle_current_A")]
    assert share == pytest.approx(100 * (at_limit[0] | at_limit[1]).mean(), abs=0.2) and share > 1
    assert sim(LEG, tmp_path / "r.csv", "--duration", 4).stderr == ""


def test_help_and_version():
    text = run("talus-sim", "--help").stdout
    for option in ("--model", "--out", "--excitation", "--fit", "--limits", "--seed"):
        assert option in text
    assert re.fullmatch(r"talus-sim \d+\.\d+\.\d+\n", run("talus-sim", "--version").stdout)
