"""Causes that are in no catalogue (tools/talus/diagnosis/outside), against closed forms that are added to simulated recordings."""

import json
import math
import os
from types import SimpleNamespace

import numpy as np
import pytest
import talus
from support import BUILD, REPOSITORY, run

os.environ.setdefault("TALUS_BUILD", str(BUILD))

from talus.diagnosis import command, words  # noqa: E402
from talus.diagnosis.calibration import gains  # noqa: E402
from talus.diagnosis.calibration.thresholds import NEARLY_HALF  # noqa: E402
from talus.diagnosis.effects import EFFECTS  # noqa: E402
from talus.diagnosis.outside import OUTSIDE, beside, held_reading, hysteresis  # noqa: E402

pytestmark = pytest.mark.spread

PENDULUM, LEG = REPOSITORY / "models/pendulum.yaml", REPOSITORY / "models/leg.yaml"
NM_PER_A = 9 * 0.091  # of the pendulum's drive
KNEE_NM_PER_A = 51 * 0.1031


def dragged(q, travel):
    """Deflection of a spring that slips at `travel` on either side, sample by sample."""
    out = np.zeros(len(q))
    for i in range(1, len(q)):
        out[i] = min(max(out[i - 1] + q[i] - q[i - 1], -travel), travel)
    return out


@pytest.mark.parametrize("seed", range(5))
def test_a_spring_that_slips_is_dragged_along_as_sample_by_sample(seed):
    """On a walk that stands still now and then, and turns at single samples."""
    random = np.random.default_rng(seed)
    q = np.cumsum(random.standard_normal(2000) * (random.random(2000) < 0.7))
    for travel in (0.1, 2.0, 50.0):
        assert hysteresis.deflection(q, travel) == pytest.approx(dragged(q, travel), abs=1e-9)


def test_a_motion_that_never_turns_or_never_moves():
    assert hysteresis.deflection(np.linspace(0, 1, 11), 0.25)[[0, 2, 3, 10]] == pytest.approx([0, 0.2, 0.25, 0.25])
    assert not hysteresis.deflection(np.full(5, 0.3), 0.1).any()


def test_none_has_an_effects_id_and_each_says_what_it_is():
    assert not OUTSIDE.keys() & EFFECTS.keys()
    assert all(entry.outside and entry.words[0].islower() and not entry.words.endswith(".") for entry in OUTSIDE.values())
    assert not any(effect.outside for effect in EFFECTS.values())


def test_readings_that_stay_the_same_for_longer_than_chance_has_it():
    """Noise of one step: each reading is the one before it in a quarter of cases, and some runs have four or five by chance."""
    random = np.random.default_rng(4)
    x = np.round(1.6 * random.standard_normal(4000))
    assert 0.1 < np.mean(np.diff(x) == 0) < 0.3 and held_reading.held(x) == []
    x[1000:1030], x[2000:2015] = x[1000], x[2000]
    x[1030], x[2016] = x[1000] + 3, x[2000] - 2  # and then goes on elsewhere, at once or soon
    (first, _), (second, _) = held_reading.held(x)
    assert abs(first - 1000) <= 2 and abs(second - 2000) <= 2
    assert held_reading.held(random.standard_normal(500)) == []


@pytest.mark.parametrize("noise", [0.05, 0.1, 0.2])
def test_a_slow_torque_within_one_step_of_its_sensor_is_no_reading_that_hangs(noise):
    """Runs at its peaks and where it creeps are far longer than chance has it; one that hangs among them is found alone."""
    random, t = np.random.default_rng(4), np.arange(20000) * 5e-3
    torque = 6 * np.sin(2 * np.pi * 0.3 * t) + 3 * np.sin(2 * np.pi * 1.1 * t)
    x = np.round(torque + noise * random.standard_normal(len(t)))
    assert np.mean(np.diff(x) == 0) > 0.75 and held_reading.held(x) == []
    x[3000:3500] = x[3000]
    assert abs(x[3500] - x[3000]) > 2
    ((first, last),) = held_reading.held(x)
    assert first <= 3000 and last == 3499


# ---- how likely it is ------------------------------------------------------------------


STRENGTHS = {"friction": 2}
SHAPES = {"bumper": (0.3, 0.5)}


def cause(name):
    family = SimpleNamespace(values=SHAPES[name]) if name in SHAPES else None
    return SimpleNamespace(key=(name, "joint"), joint="joint", columns=("column",) * STRENGTHS.get(name, 1), family=family)


def fit(excess, *names):
    """Of the joint's torque, or {kind: excess}."""
    by_kind = excess if isinstance(excess, dict) else {"T0": excess}
    return SimpleNamespace(chosen=[cause(name) for name in names], excess=sum(by_kind.values()), by_kind=by_kind)


def beyond(mine, theirs, sound=True, nothing=0.2, outdone=False, alone=(), off_drawing=None, floor_of=None, temperature=1.0):
    dataset = SimpleNamespace(scopes_at=lambda joint: (list(mine.by_kind), [kind for kind in mine.by_kind if kind != "T1"], ["T0"]))
    search = SimpleNamespace(with_outsiders=theirs, outside_alone=list(alone), off_drawing=off_drawing, temperature_of=lambda one: temperature, chance=14.0, floor_of=floor_of or {"T0": 100.0}, detection_threshold=40.0, is_outside=lambda key: key[0] == "hose", plain=fit(9000.0),
                             nothing=lambda before, after: nothing, calibration=SimpleNamespace(outdone=lambda gain: outdone), fit=lambda chosen: fit(0.0, *(c.key[0] for c in chosen)), dataset=dataset,
                             held_out_excess=lambda chosen: next(one.by_kind for one in (mine, theirs) if one.chosen is chosen))  # fmt: skip
    return beside.Beyond(search, mine, sound)


@pytest.mark.parametrize(("left", "likely"), [(1000.0, 0.0), (750.0, 0.042), (500.0, 0.5), (250.0, 0.958), (100.0, 0.998), (-300.0, 0.998), (1200.0, 0.0)])
def test_half_of_what_the_catalogue_leaves_is_as_likely_as_not(left, likely):
    """1 / (1 + ((1 - x)/x)^(1/0.35)), x the share that is closed of 1000; no less than the floor of 100 is left."""
    found = beyond(fit(1000.0, "spring"), fit(left, "hose", "spring"))
    assert found.probability == pytest.approx(likely, abs=1e-3) and found.instead() == ([(found.probability, found.first)] if likely else [])


ROUGH = 1e12  # forms of which one that leaves half as much is no likelier


def test_a_simpler_set_that_leaves_less_need_not_stand_above_the_floor():
    """A hose alone for a spring and a friction that builds up."""
    assert beyond(fit(90.0, "spring", "presliding"), fit(45.0, "hose"), temperature=ROUGH).probability == pytest.approx(0.5)
    assert beyond(fit(90.0, "spring", "presliding"), fit(10.0, "hose"), temperature=ROUGH).probability == pytest.approx(1 / (1 + 0.8 ** (1 / 0.35)))
    assert beyond(fit(90.0, "spring", "presliding"), fit(45.0, "hose", "delay")).probability == 0.0


@pytest.mark.parametrize(("mine", "likely"), [("friction", 1 / (1 + math.exp(-0.35))), ("bumper", 0.5), ("spring", 0.0)])
def test_the_simpler_set_is_that_with_fewer_strengths_and_shapes(mine, likely):
    """A further strength has its odds, 0.35 of the logarithm."""
    assert beyond(fit(90.0, mine), fit(45.0, "hose"), temperature=ROUGH).probability == pytest.approx(likely)


@pytest.mark.parametrize(("mine", "left", "likely"), [
    ("spring presliding", 900.0, 1 / (1 + math.exp(-1.0))), ("spring presliding", 1000.0, 0.0), ("spring presliding", 1100.0, 0.0),
    ("spring friction", 900.0, 1 / (1 + math.exp(-1.35))), ("spring", 900.0, 0.0), ("", 900.0, 0.8)])  # fmt: skip
def test_a_simpler_set_has_the_odds_of_a_rival(mine, left, likely):
    """exp(-E/2T - 0.35 (columns - 1)) of each with E of chi-square; one as simple closes but a tenth of 1000, and none is a rival of nothing."""
    assert beyond(fit(1000.0, *mine.split()), fit(left, "hose"), temperature=50.0).probability == pytest.approx(likely, abs=2e-3)


@pytest.mark.parametrize(("mine", "theirs", "likely"), [
    ({"T0": 500.0, "T1": 0.0, "K": 0.0}, {"T0": 250.0, "T1": 0.0, "K": 0.0}, 0.5),  # the torque alone
    ({"T0": 0.0, "T1": 0.0, "K": 4000.0}, {"T0": 0.0, "T1": 0.0, "K": 2000.0}, 0.5),  # what the joint's encoder shows, too
    ({"T0": 0.0, "T1": 6000.0, "K": 0.0}, {"T0": 0.0, "T1": 3000.0, "K": 0.0}, 0.5),  # all channels: another joint's torque
    ({"T0": 90.0, "T1": 0.0, "K": 1000.0}, {"T0": 45.0, "T1": 0.0, "K": 500.0}, 0.0)])  # below the floors
def test_the_largest_share_counts_of_all_channels_those_at_the_joint_and_its_torque(mine, theirs, likely):
    """What the other channels leave, and their floors, do not hide what the torque shows."""
    found = beyond(fit(mine, "spring"), fit(theirs, "hose"), floor_of={"T0": 100.0, "T1": 100.0, "K": 1500.0})
    assert found.probability == pytest.approx(likely)


def test_what_may_be_the_sensors_work_is_no_likelier_than_not():
    assert beyond(fit(1000.0, "spring"), fit(100.0, "hose"), sound=False).probability == NEARLY_HALF
    assert beyond(fit(1000.0), fit(100.0, "hose"), outdone=True).probability == NEARLY_HALF


def test_without_an_effect_replicates_decide_and_without_a_cause_there_is_none():
    assert beyond(fit(1000.0), fit(900.0, "hose"), nothing=0.3).probability == pytest.approx(0.7)
    assert beyond(fit(1000.0), None).probability == beyond(fit(1000.0, "spring"), None).probability == 0.0


def test_the_effect_in_front_of_both_stays_and_one_that_the_cause_replaces_loses():
    found = beyond(fit(1000.0, "spring", "delay"), fit(500.0, "spring", "hose"))
    verdict = SimpleNamespace(further={("delay", "joint"): 0.8}, known=0.9, resembles=[])
    found.add_to(verdict)
    assert found.probability == 0.0 and verdict.further == {("delay", "joint"): pytest.approx(0.4)}
    ((probability, told),) = verdict.resembles
    assert probability == pytest.approx(0.45) and told.key == ("hose", "joint")


@pytest.mark.parametrize(("mine", "theirs", "excess", "likely"), [
    (80.0, 2.0, 90.0, 1.0),  # as good a fit, at a machine that is the one drawn
    (20.0, 2.0, 90.0, 1 / (1 + math.exp(-2.0))), (16.0, 2.0, 90.0, 0.5), (6.0, 2.0, 90.0, 1 / (1 + math.exp(5.0))),
    (80.0, 2.0, 400.0, 0.0),  # it leaves more than the floor, and than the effect
])  # fmt: skip
def test_a_cause_that_fits_as_well_and_leaves_the_machine_as_it_is_drawn(mine, theirs, excess, likely):
    """exp(-x/2) for each, x chi-square off the drawing, over what one of so many causes gains by chance (14)."""
    off = {"spring": mine, "hose": theirs}
    found = beyond(fit(-50.0, "spring"), None, alone=[fit(excess, "hose")], off_drawing=lambda one, temperature: off[one.chosen[0].key[0]])
    assert found.probability == pytest.approx(likely, abs=1e-9)
    assert [candidate.key for _, candidate in found.instead()] == ([("hose", "joint")] if likely else [])
    assert found.by_drawing == bool(likely)
    found.add_to(SimpleNamespace(further={}, known=1.0))  # it stands beside nothing
    worse = beyond(fit(112.0, "spring"), None, alone=[fit(excess, "hose")], off_drawing=lambda one, temperature: off[one.chosen[0].key[0]])
    odds = found.probability / max(1 - found.probability, 1e-12)  # what the effect leaves above the floor counts as well
    assert likely in (0.0, 1.0) or worse.probability == pytest.approx(odds * math.exp(6.0) / (1 + odds * math.exp(6.0)), rel=1e-6)
    assert beyond(fit(-50.0), None, alone=[fit(excess, "hose")], off_drawing=None).probability == 0.0


# ---- found for what it is --------------------------------------------------------------


def pendulum(added, truth=None):
    """30 s of the pendulum; `added(t, q, v, torque)` more torque than its own, for the same motion."""
    columns = dict(talus.simulate(truth or talus.read(PENDULUM), duration_s=30, seed=5).columns)
    t, q, torque = columns["time_s"], columns["joint_rad"], NM_PER_A * columns["joint_current_A"]
    smooth = np.convolve(np.gradient(q, t), np.full(9, 1 / 9), "same")
    columns["joint_current_A"] = np.round(columns["joint_current_A"] + added(t, q, smooth, torque) / NM_PER_A, 9)
    return talus.Recording(columns)


def frozen(x):
    """Readings that hang for a tenth of a second, once in a second or so."""
    out, random = x.copy(), np.random.default_rng(8)
    for begin in np.cumsum(random.integers(100, 400, 25)):
        out[begin:begin + 25] = x[begin]
    return out[:len(x)]


ADDED = {
    "hysteresis": lambda t, q, v, torque: 0.4 * dragged(q, 0.35) / 0.35,
    "changed_load": lambda t, q, v, torque: 0.5 * np.sin(q) * (t >= 13.0),
    "power_loss": lambda t, q, v, torque: 0.06 * torque * np.abs(v),
    "gain_by_sign": lambda t, q, v, torque: 0.15 * np.abs(torque),
    "dead_zone": lambda t, q, v, torque: 0.15 * np.tanh(torque / 0.1),
    "held_reading": lambda t, q, v, torque: frozen(torque) - torque,
    "vibration": lambda t, q, v, torque: 0.15 * np.sin(2 * np.pi * 3.37 * t + 1.0),
}  # fmt: skip
SLOW = ("hysteresis", "changed_load", "power_loss", "gain_by_sign", "dead_zone")
SIZES = {
    "hysteresis": {"size_Nm": (0.4, 0.05), "travel_rad": (0.35, 0.05)},
    "changed_load": {"at_s": (13.0, 0.2)},
    "power_loss": {"size_Nm": (0.06, 0.009)},  # of a torque that holds the loss itself
    "gain_by_sign": {"size_Nm": (0.15, 0.02)},
    "dead_zone": {},
    "held_reading": {"share": (1.0, 0.1)},
    "vibration": {"frequency_Hz": (3.37, 0.005)},
}


@pytest.mark.parametrize("kind", [pytest.param(kind, marks=pytest.mark.long) if kind in SLOW else kind for kind in ADDED])
def test_a_gap_that_no_effect_makes_is_unknown_and_looks_like_what_it_is(kind):
    found = talus.diagnose(PENDULUM, pendulum(ADDED[kind]))
    assert found.verdict["effect"] == "unknown" and found.verdict["probability"] > 0.8 and not found.effects
    first = found.report["resembles"][0]
    assert (first["id"], first["joint"]) == (kind, "joint") and first["probability"] > 0.5
    assert first["closes"] is None if kind == "vibration" else first["closes"] > 0.5  # what does not repeat is the noise of what does
    for name, (size, within) in SIZES[kind].items():
        assert abs(first["parameters"][name]) == pytest.approx(size, abs=within), name
    assert f"It looks like {first['title']}" in str(found) and first["size"] in str(found)
    assert kind not in {one["effect"] for one in [*found.report["nearest"], *found.report["not_observable"], *found.report["alternatives"]]}


@pytest.mark.long
def test_beside_an_effect_it_is_told_and_is_none_of_the_effects():
    stribeck = "effects: [{effect: stribeck, joint: joint, parameters: {extra_Nm: 0.3, speed_rad_s: 0.2, exponent: 1}}]"
    truth = talus.Model.from_text(PENDULUM.read_text() + stribeck)
    found = talus.diagnose(PENDULUM, pendulum(lambda *x: 0.1 * ADDED["hysteresis"](*x), truth))
    assert [one["effect"] for one in found.effects] == ["stribeck"] and "hysteresis" not in found.model_text
    assert "hysteresis" in {one["id"] for one in found.report["resembles"]} and "beyond the catalogue: a force with hysteresis" in str(found)


def test_a_sliders_hose_on_the_terminal_and_the_page(tmp_path):
    """In N and m."""
    model = REPOSITORY / "models" / "slider.yaml"
    columns = dict(talus.simulate(talus.read(model), duration_s=20, seed=5, encoder_bits=20).columns)
    q, travel_m = columns["slider_m"], 0.2 * np.ptp(columns["slider_m"])
    columns["slider_force_N"] = columns["slider_force_N"] + 30.0 * dragged(q, travel_m) / travel_m
    talus.Recording(columns).write(tmp_path / "run.csv")
    said = run("talus-gap", "--model", model, "--report", tmp_path / "gap.json", "--html", tmp_path / "gap.html", tmp_path / "run.csv").stderr
    assert "It looks like a force with hysteresis" in said and " N, which slips after " in said and " Nm" not in said
    (like,) = json.loads((tmp_path / "gap.json").read_text())["resembles"]
    assert like["parameters"] == pytest.approx({"size_Nm": 30.0, "travel_rad": travel_m}, rel=0.1)
    page = (tmp_path / "gap.html").read_text()
    assert "What it looks like beyond the catalogue" in page and words.linear(like["size"]) in page


def test_where_no_replicate_can_be_made_none_is_tried(tmp_path, monkeypatch):
    """A plant that cannot be simulated, say: with rough forms beside the catalogue's there would be nothing to hold them against."""
    pendulum(ADDED["hysteresis"]).write(tmp_path / "run.csv")
    monkeypatch.setattr(gains.Replicator, "beside", lambda *_: None)
    command.main(["-q", "--model", str(PENDULUM), "--report", str(tmp_path / "gap.json"), str(tmp_path / "run.csv")])
    report = json.loads((tmp_path / "gap.json").read_text())
    assert not report["calibrated"] and not report["resembles"] and report["verdict"]["effect"]


def test_where_nothing_is_added_nothing_is_resembled():
    found = talus.diagnose(PENDULUM, pendulum(lambda t, q, v, torque: 0 * t))
    assert found.verdict["effect"] == "none" and not found.report["resembles"]


@pytest.mark.long
@pytest.mark.parametrize("kind, added", [
    ("cross_talk", lambda c: 0.2 * c["ankle_current_A"]),
    ("coupled_speeds", lambda c: 0.4 * np.gradient(c["ankle_joint_rad"], c["time_s"]) / KNEE_NM_PER_A)])  # fmt: skip
def test_a_knee_that_follows_the_ankle(kind, added):
    columns = dict(talus.simulate(talus.read(LEG), duration_s=20, seed=5).columns)
    columns["knee_current_A"] = columns["knee_current_A"] + added(columns)
    found = talus.diagnose(LEG, talus.Recording(columns))
    assert found.verdict["effect"] == "unknown" and found.report["resembles"][0]["id"] == kind
    assert found.report["resembles"][0]["joint"] == "knee"


@pytest.mark.long
def test_a_cable_over_both_joints_and_its_stiffness():
    """Torques of the energy 1.5 k a + 2 k^2 a, of knee and ankle angles k and a, by each drive's ratio and torque constant."""
    columns = dict(talus.simulate(talus.read(LEG), duration_s=20, seed=5).columns)
    k, a = columns["knee_motor_rad"] / 51, columns["ankle_joint_rad"]
    columns["knee_current_A"] = columns["knee_current_A"] + (1.5 * a + 4.0 * k * a) / KNEE_NM_PER_A
    columns["ankle_current_A"] = columns["ankle_current_A"] + (1.5 * k + 2.0 * k**2) / 0.1031 / talus.read(LEG).transmission(1).ratio(a)
    found = talus.diagnose(LEG, talus.Recording(columns))
    assert found.verdict["effect"] == "unknown" and not found.effects
    first = found.report["resembles"][0]
    assert first["id"] == "shared_energy" and first["size"] == "1.5 Nm/rad"
    assert first["parameters"] == pytest.approx({"product_Nm_rad": 1.5, "first_Nm_rad2": 2.0, "second_Nm_rad2": 0.0}, abs=0.05)


@pytest.mark.long
def test_a_cable_that_a_spring_and_a_heavier_foot_imitate_is_told_by_the_drawing():
    """-0.6 k a at 100 Hz: an ankle's spring closes as much of it, beside a foot that is not the model file's."""
    columns = dict(talus.simulate(talus.read(LEG), duration_s=20, seed=5, rate_hz=100).columns)
    k, a = columns["knee_motor_rad"] / 51, columns["ankle_joint_rad"]
    columns["knee_current_A"] = columns["knee_current_A"] - 0.6 * a / KNEE_NM_PER_A
    columns["ankle_current_A"] = columns["ankle_current_A"] - 0.6 * k / 0.1031 / talus.read(LEG).transmission(1).ratio(a)
    found = talus.diagnose(LEG, talus.Recording(columns))
    first = found.report["resembles"][0]
    assert found.verdict["effect"] == "unknown" and first["id"] == "shared_energy" and first["closes"] > 0.7
    assert first["rival"]["effects"][0] == {"effect": "parallel_spring", "joint": "ankle"} and first["rival"]["times"] > 2.5
    assert "so would parallel spring at the ankle" in str(found) and "foot inertia were" in str(found)


# ---- what an effect of the catalogue imitates ---------------------------------------------


@pytest.mark.long
@pytest.mark.parametrize(("seed", "bits"), [(5, 14), (6, 16)])
def test_a_gain_by_sign_that_asymmetric_friction_imitates_in_the_torque_alone(seed, bits):
    """Friction closes nine tenths of it. The other channels, which neither touches, may leave more than that."""
    columns = dict(talus.simulate(talus.read(LEG), duration_s=60, seed=seed, rate_hz=200, encoder_bits=bits).columns)
    columns["ankle_current_A"] *= 1 - 0.08 * (columns["ankle_current_A"] > 0)
    found = talus.diagnose(LEG, talus.Recording(columns))
    assert found.verdict["effect"] == "unknown" and found.report["resembles"][0]["id"] == "gain_by_sign"


@pytest.mark.long
@pytest.mark.parametrize(("seed", "bits"), [(5, 14), (6, 16)])
def test_asymmetric_friction_that_a_gain_by_sign_imitates_is_named(seed, bits, tmp_path):
    effect = "{effect: asymmetric_friction, joint: ankle, parameters: {coulomb_Nm: 0.4, viscous_Nms_rad: 0.2}}"
    (tmp_path / "truth.yaml").write_text(f"{LEG.read_text()}effects:\n  - {effect}\n")
    recording = talus.simulate(talus.read(tmp_path / "truth.yaml"), duration_s=60, seed=seed, rate_hz=200, encoder_bits=bits)
    verdict = talus.diagnose(LEG, recording).verdict
    assert verdict["effect"] == "asymmetric_friction" and verdict["joint"] == "ankle" and verdict["probability"] > 0.9
