"""talus-gap: the report's form, the causes it names on simulated benches, and what it refuses.

The benches are talus-sim's: a plant and an effect that the diagnosis is not told. The forms of effects there are the
model file's; other forms stand in the labelled recordings (test_gap_cases.py)."""

import json
import math

import numpy
import pytest
import yaml
from support import REPOSITORY, run

import talus

LEG, PENDULUM = REPOSITORY / "models/leg.yaml", REPOSITORY / "models/pendulum.yaml"
EFFECTS = {
    ("nonlinear_viscous", "knee"): {"size_Nm": 0.25, "exponent": 2.0},
    ("parallel_spring", "ankle"): {"stiffness_Nm_rad": 4.0, "stiffening_Nm_rad3": 0.0, "preload_Nm": 0.3},
}
COORDINATES = {"nonlinear_viscous": "velocity", "parallel_spring": "position"}


def write_model(path, effects=()):
    """The leg with effects {(effect, joint): parameters}, for simulation."""
    tree = yaml.safe_load(LEG.read_text())
    if effects:
        tree["effects"] = [{"effect": e, "joint": j, "parameters": p} for (e, j), p in effects.items()]
    path.write_text(yaml.safe_dump(tree))
    return path


def simulate(folder, effects=(), seed=1, duration_s=40, name="leg.csv"):
    """A recording of the leg."""
    model = write_model(folder / "truth.yaml", effects)
    run("talus-sim", "--model", model, "--out", folder / name, "--seed", seed, "--duration", duration_s)
    return folder / name


def columns_of(path):
    table = numpy.genfromtxt(path, delimiter=",", names=True, comments="#")
    return {name: table[name] for name in table.dtype.names}


def write_columns(path, columns):
    numpy.savetxt(path, numpy.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="",
                  fmt="%.9g")  # fmt: skip


def diagnose(folder, *recordings, model=LEG, more=()):
    """GAP.json of recordings."""
    report = folder / "gap.json"
    run("talus-gap", "--model", model, "--report", report, *more, *recordings)
    return json.loads(report.read_text())


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """(folder, report) of the leg without any effect."""
    folder = tmp_path_factory.mktemp("plain")
    recording = simulate(folder)
    return folder, diagnose(folder, recording, more=("--html", folder / "gap.html", "--save-model", folder / "f.yaml"))


def check_form(report):
    """What the contract asks of every report."""
    assert report["schema"] == "talus-gap/1"
    assert set(report) == {"schema", "verdict", "alternatives", "effects", "gap", "motion", "where", "confusable",
                           "next_experiment", "not_observable", "findings", "lowpass", "selection", "nearest", "resembles", "irregular",
                           "calibrated", "replicates"}  # fmt: skip
    every = [report["verdict"], *report["alternatives"]]
    assert math.isclose(sum(e["probability"] for e in every), 1.0, abs_tol=1e-9)
    assert all(e["probability"] <= report["verdict"]["probability"] for e in every)
    if report["verdict"]["effect"] in ("none", "unknown"):
        assert report["verdict"]["joint"] == "none"
        assert report["verdict"]["effect"] == "unknown" or not report["effects"]
    else:
        assert report["effects"][0]["effect"] == report["verdict"]["effect"]
    for gap in report["gap"].values():
        floor, before, after = gap["noise_floor_rms"], gap["identified_rms"], gap["extended_rms"]
        closed = 0.0 if before <= floor else (before**2 - after**2) / (before**2 - floor**2)
        assert math.isclose(gap["closed_fraction"], min(max(closed, 0.0), 1.0), abs_tol=1e-12)
    shares = [w["share"] for w in report["where"]]
    assert shares == sorted(shares, reverse=True)
    assert all(len(w["range"]) == 2 and w["range"][0] <= w["range"][1] for w in report["where"])
    assert report["next_experiment"]["why"]


def test_no_effect_is_none(plain):
    folder, report = plain
    check_form(report)
    assert report["verdict"]["effect"] == "none"
    assert report["effects"] == []
    assert report["next_experiment"]["trajectory"] is None and not (folder / "gap.next.csv").exists()
    for gap in report["gap"].values():
        assert 0.9 * gap["noise_floor_rms"] < gap["identified_rms"] < 1.2 * gap["noise_floor_rms"]


@pytest.mark.long
def test_the_same_seed_gives_the_same_bytes(plain):
    folder, _ = plain
    first = (folder / "gap.json").read_bytes(), (folder / "f.yaml").read_bytes()
    diagnose(folder, folder / "leg.csv", more=("--save-model", folder / "f.yaml"))
    assert first == ((folder / "gap.json").read_bytes(), (folder / "f.yaml").read_bytes())


def test_page_needs_nothing_besides_itself(plain):
    page = (plain[0] / "gap.html").read_text()
    assert "http://" not in page.split("<script>")[0]
    assert "src=" not in page.split("</main>")[0]
    assert "talus-gap " + talus.constants.TL_VERSION in page


def friction_at(tree, speed, effect):
    """The knee's friction with nonlinear viscous friction."""
    plain = tree["knee"]["friction"]
    curved = effect["size_Nm"] * speed ** effect["exponent"]
    return plain["coulomb_Nm"] + plain["viscous_Nms_rad"] * speed + curved


@pytest.mark.parametrize(("effect", "joint"), [
    ("nonlinear_viscous", "knee"), pytest.param("parallel_spring", "ankle", marks=pytest.mark.long)])
def test_a_simulated_effect_is_named(tmp_path, effect, joint):
    hidden = EFFECTS[effect, joint]
    recording = simulate(tmp_path, {(effect, joint): hidden})
    report = diagnose(tmp_path, recording, more=("--save-model", tmp_path / "fitted.yaml"))
    check_form(report)
    assert (report["verdict"]["effect"], report["verdict"]["joint"]) == (effect, joint)
    assert report["gap"][joint]["closed_fraction"] > 0.9
    assert (report["where"][0]["joint"], report["where"][0]["coordinate"]) == (joint, COORDINATES[effect])
    fitted = yaml.safe_load((tmp_path / "fitted.yaml").read_text())
    if effect == "nonlinear_viscous":  # size, exponent and the plain viscous friction are known together, not each
        for speed in (0.5, 1.0, 2.0, 3.0):
            got = friction_at(fitted, speed, report["effects"][0]["parameters"])
            assert got == pytest.approx(friction_at(yaml.safe_load(LEG.read_text()), speed, hidden), rel=0.02), speed
    else:
        for name, value in report["effects"][0]["parameters"].items():
            assert math.isclose(value, hidden[name], rel_tol=0.05), name
    check_saved_model(tmp_path, hidden_in={(effect, joint): hidden}, report=report)


def check_saved_model(folder, hidden_in, report):
    """The model that was saved predicts what another seed of the same bench records, nearly down to the noise."""
    other = simulate(folder, hidden_in, seed=7, duration_s=20, name="other.csv")
    run("talus-predict", "--model", folder / "fitted.yaml", "--out", folder / "p.csv", other)
    predicted = numpy.loadtxt(folder / "p.csv", delimiter=",", skiprows=1)[:, 1:].T
    model = talus.Model.read(folder / "fitted.yaml")
    for joint, error in talus.score(model, talus.Recording.read(str(other)), predicted).items():
        assert error["rms"] < 1.3 * report["gap"][joint]["noise_floor_rms"]


@pytest.mark.long
def test_a_cause_outside_the_catalogue_is_unknown(tmp_path):
    columns = columns_of(simulate(tmp_path))
    # a torque that repeats with the motion's period (4 s) and otherwise follows nothing that is recorded
    random, order = numpy.random.default_rng(5), numpy.arange(1, 11)
    phase = 2 * numpy.pi * (order * columns["time_s"][:, None] / 4.0 + random.random(10))
    columns["knee_current_A"] += 0.03 * (random.standard_normal(10) * numpy.sin(phase)).sum(1)
    write_columns(tmp_path / "odd.csv", columns)
    report = diagnose(tmp_path, tmp_path / "odd.csv")
    check_form(report)
    assert report["verdict"]["effect"] == "unknown"


def test_too_short_is_unknown_with_the_reason(tmp_path):
    lines = simulate(tmp_path).read_text().splitlines(keepends=True)
    (tmp_path / "short.csv").write_text("".join(lines[:1500]))
    report = diagnose(tmp_path, tmp_path / "short.csv")
    check_form(report)
    assert report["verdict"] == {"effect": "unknown", "joint": "none", "probability": 1.0, "withheld": True}
    assert "usable motion" in report["next_experiment"]["why"]


# ---- what is refused ---------------------------------------------------------------


def refused(folder, *arguments, status=2):
    """The one line of a refusal; nothing is written."""
    report = folder / "gap.json"
    report.write_text("earlier")
    done = run("talus-gap", *arguments, status=status)
    assert report.read_text() == "earlier"
    assert done.stderr.startswith("talus-gap: ")
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_bad_input_is_refused_as_by_identify(tmp_path):
    model, bad = LEG, tmp_path / "bad.csv"
    bad.write_text("time_s,knee_motor_rad\n0,0\n0.01,x\n")
    line = refused(tmp_path, "--model", model, "--report", tmp_path / "gap.json", bad)
    assert "bad.csv" in line
    assert "identify" not in line
    missing = refused(tmp_path, "--model", model, "--report", tmp_path / "gap.json", tmp_path / "no.csv")
    assert "no.csv" in missing


@pytest.mark.parametrize("arguments", [(), ("--model", "m.yaml"), ("--report", "g.json"), ("--nonsense",),
                                       ("--model", "m", "--report", "r", "--seed", "-1", "x.csv"),
                                       ("--model", "m", "--report", "r", "--html", "r", "x.csv"),
                                       ("--model", "m", "--report", "m", "x.csv")])  # fmt: skip
def test_bad_usage(tmp_path, arguments):
    refused(tmp_path, *arguments)


def test_help_and_version():
    assert "--save-model" in run("talus-gap", "--help").stdout
    assert run("talus-gap", "--version").stdout == f"talus-gap {talus.constants.TL_VERSION}\n"


# ---- what tells causes apart ---------------------------------------------------------


@pytest.mark.long
def test_the_saved_model_predicts_what_the_report_says(tmp_path):
    """A law that hangs on load and friction is fitted at the parameters that are saved with it."""
    hidden = {("load_friction", "knee"): {"coefficient": 0.25, "rotor_share": 1.0, "friction_share": 1.0}}
    recording, fitted = simulate(tmp_path, hidden), tmp_path / "fitted.yaml"
    report = diagnose(tmp_path, recording, more=("--save-model", fitted))
    run("talus-predict", "--model", fitted, "--out", tmp_path / "predicted.csv", recording)
    shown = numpy.loadtxt(tmp_path / "predicted.csv", delimiter=",", skiprows=1)[:, 1:].T
    left = talus.score(talus.Model.read(LEG), talus.Recording.read(recording), numpy.ascontiguousarray(shown))
    assert left["knee"]["rms"] < 1.15 * report["gap"]["knee"]["extended_rms"]
    found = yaml.safe_load(fitted.read_text())["effects"][0]["parameters"]
    assert found["coefficient"] == pytest.approx(0.25, rel=0.03)


@pytest.mark.long
@pytest.mark.parametrize("effect, parameters", [
    ("directional_efficiency", {"driving": 0.25, "back_driving": 0.1}),
    ("load_friction", {"coefficient": 0.2}),
    ("load_friction", {"coefficient": 0.2, "friction_share": 1.0}),
    ("directional_efficiency", {"driving": 0.1, "back_driving": 0.25}),
    ("directional_efficiency", {"driving": 0.15, "back_driving": 0.0}),
    ("directional_efficiency", {"driving": 0.0, "back_driving": 0.15}),
])  # fmt: skip
def test_the_scale_on_the_load_tells_an_efficiency_from_load_friction(tmp_path, effect, parameters):
    """Both have the same half difference between driving and driven back; the sum of the two is a scale."""
    report = diagnose(tmp_path, simulate(tmp_path, {(effect, "knee"): parameters}))
    assert (report["verdict"]["effect"], report["verdict"]["joint"]) == (effect, "knee")


@pytest.mark.long
def test_load_friction_of_a_gear_that_is_hardly_driven_back_has_its_size(tmp_path):
    report = diagnose(tmp_path, simulate(tmp_path, {("load_friction", "knee"): {"coefficient": 0.7}}))
    first = report["effects"][0]
    assert (first["effect"], first["joint"]) == ("load_friction", "knee")
    assert first["parameters"]["coefficient"] == pytest.approx(0.7, rel=0.03) and first["closes"]["knee"] > 0.95


@pytest.mark.parametrize("effect, parameters, other", [
    ("load_friction", {"coefficient": 0.1}, "directional_efficiency"),
    *(pytest.param("directional_efficiency", {"driving": driving, "back_driving": back}, "load_friction", marks=pytest.mark.long)
      for driving, back in ((0.5, 0.3), (0.3, 0.5))),
])  # fmt: skip
def test_of_a_single_joint_only_the_size_tells_an_efficiency_from_load_friction(tmp_path, effect, parameters, other):
    """Inertia and gravity take up the scale: of friction more than a quarter of the load is not usual."""
    entry = {"effect": effect, "joint": "joint", "parameters": parameters}
    (tmp_path / "truth.yaml").write_text(f"{PENDULUM.read_text()}\neffects: {json.dumps([entry])}\n")
    run("talus-sim", "--model", tmp_path / "truth.yaml", "--out", tmp_path / "arm.csv", "--duration", 40)
    report = diagnose(tmp_path, tmp_path / "arm.csv", model=PENDULUM)
    assert report["verdict"]["effect"] == effect and report["verdict"]["probability"] < 0.9
    assert [group["effects"] for group in report["confusable"]] == [[effect, other]]


BEHIND_THE_GEAR = {
    "backlash": {"share": 1.0, "gap_rad": 0.004, "stiffness_Nm_rad": 8000.0},
    "elasticity": {"share": 1.0, "stiffness_Nm_rad": 900.0, "damping_s": 0.001},
}


@pytest.mark.long
@pytest.mark.parametrize("effect", BEHIND_THE_GEAR)
def test_what_lies_behind_the_knees_gear_is_named_without_an_encoder_there(tmp_path, effect):
    """Forward in time motor and link are two bodies; the diagnosis steps the link alone, along the recorded motor."""
    recording = simulate(tmp_path, {(effect, "knee"): BEHIND_THE_GEAR[effect]})
    report = diagnose(tmp_path, recording)
    check_form(report)
    assert (report["verdict"]["effect"], report["verdict"]["joint"]) == (effect, "knee")
    assert report["gap"]["knee"]["closed_fraction"] > 0.9


@pytest.mark.long
def test_recordings_need_not_have_the_same_sensors(tmp_path):
    """A camera that only the second recording had: its channels count there, and the next experiment does without."""
    hidden = {("nonlinear_viscous", "knee"): EFFECTS["nonlinear_viscous", "knee"]}
    first = simulate(tmp_path, hidden, duration_s=30)
    run("talus-sim", "--model", tmp_path / "truth.yaml", "--out", tmp_path / "seen.csv", "--seed", 2, "--duration", 30, "--camera")
    for recordings in ((first, tmp_path / "seen.csv"), (tmp_path / "seen.csv", first)):
        report = diagnose(tmp_path, *recordings)
        check_form(report)
        assert report["verdict"]["effect"] == "nonlinear_viscous"


@pytest.mark.long
def test_a_rough_model_file_does_not_hide_an_effect(tmp_path):
    """A foot with a shoe that the file does not know, three times its moment: identification finds it, and so the effect."""
    recording = simulate(tmp_path, {("nonlinear_viscous", "knee"): EFFECTS["nonlinear_viscous", "knee"]})
    rough = yaml.safe_load(LEG.read_text())
    rough["foot"]["com_m"] /= 3
    rough["foot"]["inertia_kg_m2"] /= 2
    (tmp_path / "rough.yaml").write_text(yaml.safe_dump(rough))
    report = diagnose(tmp_path, recording, model=tmp_path / "rough.yaml")
    check_form(report)
    assert (report["verdict"]["effect"], report["verdict"]["joint"]) == ("nonlinear_viscous", "knee")


@pytest.mark.long
def test_what_no_trajectory_parts_comes_without_one(tmp_path):
    for effect, needs, word in (
        (("current_offset", "knee", {"torque_Nm": 0.012}), "rest", "unpowered"),
        (("load_friction", "knee", {"coefficient": 0.25, "rotor_share": 1.0, "friction_share": 0.0}), "known mass", "mass"),
    ):
        name, joint, parameters = effect
        report = diagnose(tmp_path, simulate(tmp_path, {(name, joint): parameters}))
        assert name in [e["effect"] for e in (report["verdict"], *report["alternatives"])] and report["confusable"]
        proposed = report["next_experiment"]
        assert word in proposed["why"] and proposed["needs"] == needs
        assert proposed["trajectory"] is None and proposed["parts"] == []


@pytest.mark.long
def test_a_camera_parts_the_linkage_from_its_encoder(tmp_path):
    """The proposal is followed: the twin runs the trajectory before a camera, and the verdict stands alone."""
    hidden = {("linkage_error", "ankle"): {"AB_m": 0.0, "BO_m": 0.0, "AC_m": -0.0015, "BOF_rad": 0.0}}
    old = simulate(tmp_path, hidden)
    report = diagnose(tmp_path, old)
    assert report["verdict"]["effect"] == "linkage_error" and report["confusable"]
    proposed = report["next_experiment"]
    assert proposed["needs"] == "camera" and "camera" in proposed["why"]
    assert proposed["parts"] == [{"effect": "encoder_eccentricity", "joint": "ankle"}]
    run("talus-sim", "--model", tmp_path / "truth.yaml", "--out", tmp_path / "new.csv", "--seed", 5, "--camera",
        "--reference", tmp_path / proposed["trajectory"])  # fmt: skip
    report = diagnose(tmp_path, old, tmp_path / "new.csv")
    assert report["verdict"]["effect"] == "linkage_error" and not report["confusable"]
