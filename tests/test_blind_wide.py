"""The wide protocol of the check on withheld effects (tools/talus/blind): the bench's one-joint plants against SciPy, closed forms
and the balance of energy, its draws, noise and files, and the table by strata on cases made by hand.

The bench shares no code with the library, so that each proves the other."""

import json

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import welch
from support import run
from test_blind import label, result

import talus
from talus.blind import bench, cases, effects, motions, scores, sensors, strata, unknowns, wide
from talus.blind.command import main
from talus.blind.plants import G, Leg, Single

NONE = {"none": 1.0}
TIMES = np.arange(1, 4000) * 1e-3
PENDULUM = Single(0.2, 0.05, 0.8, 0.9, 0.1, 0.0, 0.04, 30.0, 0.1)
SLIDER = Single(12.0, 3.0, 0.0, 0.0, -40.0, 6.0, 25.0, 1.0, 1.0, "slider")
NO_DRIVE = {"settle_s": 0.0, "knee.current_limit": 0.0, "knee.bandwidth": 5.0, "knee.zeta": 0.8, "range": 50.0}


@pytest.fixture(scope="module")
def benches():
    """A bench of each plant, without effect."""
    found, number = {}, 0
    while len(found) < len(wide.PLANTS):
        case = cases.Case(21, number, NONE, "wide")
        found.setdefault(case.plant.kind, case)
        number += 1
    return {kind: (case, case.simulate([])) for kind, case in found.items()}


# ---- one joint alone -------------------------------------------------------------------


def test_a_pendulum_swings_as_the_integrator_says():
    """Let go where it does not hang: inertia, gravity about its zero, constant torque and viscous friction."""
    p = PENDULUM
    rows = bench.simulate({**p.job(), **NO_DRIVE}, TIMES)
    law = lambda t, y: [y[1], (-p.offset - G * p.gravity_moment_kg_m * np.sin(y[0] - p.gravity_zero_rad) - p.viscous * y[1]) / p.inertia_]  # noqa: E731
    truth = solve_ivp(law, (0, 4), [0, 0], t_eval=TIMES, rtol=1e-10, atol=1e-12).y
    assert np.ptp(truth[0]) > 1.0
    assert np.abs(rows["shank"] - truth[0]).max() < 1e-3 * np.ptp(truth[0])
    assert np.abs(rows["shank_v"] - truth[1]).max() < 2e-3 * np.ptp(truth[1])
    assert rows["knee_motor"] == pytest.approx(p.gear * rows["shank"])


def test_a_spring_in_the_joint_twists_as_the_integrator_says():
    """Rotor and link are two bodies then: the rotor's share of the inertia turns with the motor."""
    p, k, damping = PENDULUM, 60.0, 0.002
    spring = effects.of("knee", elastic_form=1, stiffness=k, damping=damping)
    rows = bench.simulate({**p.job(), **NO_DRIVE, **spring}, TIMES)

    def law(t, y):
        torque = k * (y[2] - y[0]) + damping * k * (y[3] - y[1])
        link = -p.offset - G * p.gravity_moment_kg_m * np.sin(y[0] - p.gravity_zero_rad) + torque
        return [y[1], link / (p.inertia_ - p.rotor_), y[3], (-torque - p.viscous * y[3]) / p.rotor_]

    truth = solve_ivp(law, (0, 4), [0, 0, 0, 0], t_eval=TIMES, rtol=1e-10, atol=1e-12).y
    assert np.ptp(truth[2] - truth[0]) > 0.01
    assert np.abs(rows["shank"] - truth[0]).max() < 3e-3 * np.ptp(truth[0])
    assert np.abs(rows["knee_motor"] / p.gear - truth[2]).max() < 3e-3 * np.ptp(truth[2])


def test_a_slider_slides_by_the_closed_form():
    """A constant force against dry and viscous friction: v = (F - C) / d (1 - exp(-d t / m))."""
    s = SLIDER
    rows = bench.simulate({**s.job(), **NO_DRIVE}, TIMES)
    v = (-s.offset - s.coulomb) / s.viscous * (1 - np.exp(-s.viscous * TIMES / s.inertia_))
    assert np.abs(rows["knee_motor_v"] - v).max() < 1e-3 * v.max()
    held = bench.simulate({**s.job(), **NO_DRIVE, "knee.offset": 0.9 * s.coulomb}, TIMES)
    assert np.abs(held["knee_motor"]).max() < 1e-15  # dry friction holds what is less than it


@pytest.mark.parametrize("kind", [pytest.param("pendulum", marks=pytest.mark.long), "slider"])
def test_energy_balances(benches, kind):
    """What the motor puts in and friction takes away is what the joint gains."""
    case, _ = benches[kind]
    job = {**case.job([]), "knee.offset": 0.0, **case.runs["train1"]["job"]}
    rows = bench.simulate(job, case.runs["train1"]["times"])
    energy, work = rows["energy"] - rows["energy"][0], rows["work"] - rows["work"][0]
    assert np.ptp(energy) > 0
    assert np.abs(energy - work).max() < 0.01 * np.ptp(energy)


@pytest.mark.parametrize("kind", list(wide.PLANTS))
def test_the_librarys_mechanics_explain_every_plant(benches, kind, tmp_path):
    """talus-predict with the true parameters leaves the current's noise, and of the torque less than 1 %, which smoothing
    costs: two derivations, two programs."""
    case, _ = benches[kind]
    times = np.arange(1, 10000) * 2e-3  # faster than some of the draws: at 100 Hz smoothing costs more
    runs = {"train1": bench.simulate({**case.job([]), **case.runs["train1"]["job"]}, times)}
    currents, sensor = {"train1": sensors.shown_currents(runs["train1"], {})}, {}
    exact = {**case.noise, "converter": 0.0, "coloured_part": 0.0, **{k: 0.0 for k in case.noise if k.endswith("lsb_rad")}}
    shown = sensors.recording(runs["train1"], currents["train1"], sensor, exact, {**case.options, "camera": False}, {}, 0.0,
                              np.random.default_rng(1), case.plant)  # fmt: skip
    sensors.write(tmp_path / "r.csv.gz", shown, None)
    (tmp_path / "true.yaml").write_text(case.plant.model_text(case.plant.parameters()))
    run("talus-predict", "--model", tmp_path / "true.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv.gz")
    model, data = talus.Model.read(tmp_path / "true.yaml"), talus.Recording.read(tmp_path / "r.csv.gz")
    torque = np.ascontiguousarray(np.loadtxt(tmp_path / "p.csv", delimiter=",", skiprows=1)[:, 1:].T)
    gear = case.plant.ratio("knee") if "joint_torque_Nm" in shown else 1.0
    truth = np.array([gear * case.plant.torque_constant(j) * currents["train1"][j] for j in case.plant.joints])
    error, alone = talus.score(model, data, torque), talus.score(model, data, truth)
    for joint in model.joints:
        measured, noise = error[joint]["measured_rms"], alone[joint]["rms"]
        assert measured > 5 * noise
        assert 0.9 * noise < error[joint]["rms"] < np.hypot(1.05 * noise, 0.01 * measured)


def test_nothing_survives_where_nothing_is_hidden(benches):
    for case, simulated in benches.values():
        ratios, _ = case.ratios(simulated, [])
        assert max(value for one in ratios.values() for value in one.values()) < 0.05, case.plant.kind


# ---- motions and noise -----------------------------------------------------------------


@pytest.mark.parametrize("kind", list(motions.KINDS))
def test_motions_keep_their_range_and_begin_at_rest(kind):
    """The twin follows every kind within the half range, and the joint really moves."""
    plant = Single(0.1, 0.03, 0.0, 0.0, 0.0, 0.3, 0.1, 50.0, 0.1)
    control = {"range": 3.0, "knee.bandwidth": 12.0, "knee.zeta": 1.0, "knee.current_limit": 1e9, "knee.control_inertia": 0.1}
    job = motions.KINDS[kind](np.random.default_rng(4), {"knee": 0.8}, 0.7, 30.0)
    rows = bench.simulate({**plant.job(), **control, **job}, np.arange(0.005, 30, 0.01))
    assert 0.3 < np.abs(rows["shank"]).max() < 1.2 * 0.8
    late = rows["t"] > 15
    assert np.std(rows["shank"][late]) > 0.1  # it does not end early
    early = bench.simulate({**plant.job(), **control, **job}, np.array([-job["settle_s"] + 0.02, 0.0]))
    assert abs(early["shank"][0]) < 1e-3


def test_coloured_noise_has_the_spectrum_it_says():
    """A part of the variance lies below the corner, the sum is what is told."""
    noise = {"knee_current_A": 0.2, "coloured_part": 0.7, "corner_Hz": 5.0}
    shown = sensors.current_noise(noise, "knee", 400000, 500.0, np.random.default_rng(2))
    assert shown.std() == pytest.approx(0.2, rel=0.05)
    f, power = welch(shown, 500.0, nperseg=8192)
    keep = np.exp(-2 * np.pi * 5.0 / 500)
    slow = (1 - keep**2) / np.abs(1 - keep * np.exp(-2j * np.pi * f / 500)) ** 2
    truth = 2 * 0.04 / 500 * (0.3 + 0.7 * slow)  # one-sided
    inside = (f > 0.5) & (f < 240)
    assert np.median(power[inside] / truth[inside]) == pytest.approx(1.0, rel=0.05)
    assert power[(f > 0.5) & (f < 3)].mean() / truth[(f > 0.5) & (f < 3)].mean() == pytest.approx(1.0, rel=0.15)


def test_a_bands_noise_is_that_of_white_noise_as_strong():
    """White noise counts the same in every band, and as the narrow protocol's at its rate."""
    plant, n = Single(0.1, 0.03, 0.0, 0.0, 0.0, 0.3, 0.1, 50.0, 0.1), 200000
    t = np.arange(n) / 250.0
    noise = {"knee_current_A": 0.3, "knee_motor_lsb_rad": 0.0}
    sensors.weigh_noise(noise, plant, {"train1": {"t": t, "knee_motor": np.sin(t)}})
    assert noise["bands_Nm"]["knee"] == pytest.approx([0.1 * 0.3] * len(sensors.BANDS_HZ), rel=0.03)


# ---- draws -----------------------------------------------------------------------------


def test_a_case_does_not_depend_on_the_count_and_every_axis_varies():
    drawn = [np.random.default_rng([5, k]) for k in range(200)]
    plants = [wide.draw_plant(rng) for rng in drawn]
    kinds = [plant.kind for plant in plants]
    for kind, share in wide.PLANTS.items():
        assert kinds.count(kind) / 200 == pytest.approx(share, abs=0.1)
    protocols = [wide.draw_runs(rng, {"knee": 0.4})[1] for rng in drawn[:40]]
    assert {p["recordings"] for p in protocols} == {1, 2, 3, 4} and len({p["rate_Hz"] for p in protocols}) >= 6
    assert {kind for p in protocols for kind in p["motions"]} == set(motions.KINDS)
    assert all(any(kind != p["held_out"] for kind in p["motions"]) for p in protocols)
    assert min(p["total_s"] for p in protocols) >= 20 and max(p["total_s"] for p in protocols) <= 300
    one, again = (cases.Case(21, 2, NONE, "wide") for _ in range(2))
    assert one.protocol == again.protocol and one.plant == again.plant and one.noise == again.noise


def test_every_drawn_leg_can_be_read_and_its_ratio_is_the_librarys(tmp_path):
    """Geometry and drive of any leg make a model that the programs take; the ratio about the middle is theirs."""
    for k in range(20):
        leg = Leg.draw_any(np.random.default_rng(k))
        (tmp_path / "leg.yaml").write_text(leg.cad(np.random.default_rng(0)))
        assert talus.Model.read(tmp_path / "leg.yaml").joints == ["knee", "ankle"]
        d = 1e-5
        ab, bo, ac = (leg.linkage[f"{n}_m"] for n in ("AB", "BO", "AC"))
        phi = np.pi - np.radians(leg.linkage["BOF_deg"]) + np.array([d, -d])
        nut = bo * np.cos(phi) + np.sqrt(ab**2 - (ac - bo * np.sin(phi)) ** 2)
        assert leg.ratio("ankle") == pytest.approx(2 * np.pi / leg.linkage["lead_m"] * (nut[1] - nut[0]) / (2 * d), rel=1e-6)


def test_every_name_of_a_draw_is_one_of_the_twin(benches):
    for case, _ in benches.values():
        short = {**case.runs["train1"]["job"], "settle_s": 0.01}
        rng, n = np.random.default_rng(3), len(effects.OF_PLANT[case.plant.kind])
        drawn = [effects.draw(rng, case.plant, k / n + 1e-9) for k in range(2 * n)]
        drawn += [unknowns.draw(rng, case.plant, k / 13 + 1e-9) for k in range(26)]
        assert {one.effect for one in drawn} == {*effects.OF_PLANT[case.plant.kind], "unknown"}
        for one in drawn:
            assert bench.simulate({**case.job([one]), **short}, np.array([0.001, 0.002])) is not None, one
            assert all(np.isfinite(v) for v in one.job.values()), one


@pytest.mark.long
def test_draw_writes_what_a_user_has(tmp_path):
    """The same seed, the same bytes; the programs read model and recordings; the answer names joints as the files do."""
    for folder in ("a", "b"):
        assert main(["draw", "--wide", "--seed", "4", "--count", "2", "--mix", "single:1", "--out", str(tmp_path / folder)]) == 0
    names = sorted(p.relative_to(tmp_path / "a") for p in (tmp_path / "a").rglob("*") if p.is_file())
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    for one in json.loads((tmp_path / "a/sealed/labels.json").read_text())["cases"]:
        place = tmp_path / "a" / one["case"]
        model = talus.Model.read(place / "model.yaml")
        found = sorted(p.name for p in place.glob("*.csv.gz"))
        assert found == ["test.csv.gz", *(f"train{i + 1}.csv.gz" for i in range(one["protocol"]["recordings"]))]
        for name in found:
            step = talus.Recording.read(place / name).step_s
            assert step == pytest.approx(1 / one["protocol"]["rate_Hz"], rel=0.02)
        assert {*model.joints, "base"} >= {effect["joint"] for effect in one["effects"]}
        assert set(one["surviving_over_noise"]["test"]) >= set(model.joints)


# ---- the table by strata ---------------------------------------------------------------


def protocol(**more):
    return {"plant": "leg", "rate_Hz": 250, "bits": 14, "total_s": 60.0, "motions": ["gait", "gait", "ramps"], "recordings": 3,
            "noise": "white", **more}  # fmt: skip


def test_strata_count_their_own_cases():
    right = scores.judge({**label("none"), "protocol": protocol()}, result("none"))
    wrong = scores.judge({**label("none"), "protocol": protocol(plant="slider", rate_Hz=1000, bits=0)}, result("delay", "slider"))
    wrong["wrong_listed"] = True
    rows = {(r["axis"], r["stratum"]): r for r in strata.table([right, right, wrong])}
    of = lambda axis, name, figure: rows[axis, name]["figures"][figure]["value"]  # noqa: E731
    assert of("all", "", "none") == pytest.approx(2 / 3) and of("all", "", "wrong") == pytest.approx(1 / 3)
    assert (of("plant", "leg", "none"), of("plant", "slider", "none")) == (1, 0)
    assert (of("rate", "125 to 250 Hz", "wrong"), of("rate", "above 500 Hz", "wrong")) == (0, 1)
    assert (rows["encoder", "exact"]["cases"], rows["motion", "gait"]["cases"]) == (1, 3)  # twice in a case is once
    assert of("plant", "leg", "Brier") == pytest.approx(0.01) and of("plant", "leg", "ECE") == pytest.approx(0.1)
    assert "plant slider" in strata.words(list(rows.values()))


def test_a_further_effect_counts_like_the_first_and_intervals_are_held_against_what_was_closed():
    hidden = label("single", ("stribeck", "knee"))
    report = result("stribeck", "knee", 0.9)
    report["report"]["effects"] = [{"effect": "stribeck", "joint": "knee", "probability": 0.9},
                                   {"effect": "delay", "joint": "ankle", "probability": 0.6}]  # fmt: skip
    assert scores.judge(hidden, report)["wrong_listed"] and not scores.judge(hidden, report)["wrong"]
    report["report"]["effects"][1]["probability"] = 0.4
    assert not scores.judge(hidden, report)["wrong_listed"]
    gap = lambda low, high: {"identified_rms": 3, "noise_floor_rms": 1, "closed_fraction": 0.6, "closed_interval": [low, high]}  # noqa: E731
    report["unseen"] = {"identified": {"knee": 3.0, "ankle": 1.0}, "extended": {"knee": 2.0, "ankle": 1.0},
                        "unit_noise": dict.fromkeys(("knee", "ankle"), 1.0)}  # fmt: skip
    for interval, held in (((0.5, 0.7), True), ((0.7, 0.9), False)):
        report["report"]["gap"] = {"knee": gap(*interval)}  # 5 / 8 was closed
        assert scores.judge(hidden, report)["covered"] == [held]
    report["report"]["gap"] = {"knee": gap(0.9, 1.0)}
    report["unseen"]["extended"]["knee"] = 0.9  # more than all
    assert scores.judge(hidden, report)["covered"] == [True]
