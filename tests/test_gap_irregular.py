"""tools/talus/diagnosis/irregular.py: what does not come back with the motion and is no noise of a sensor."""

import json
from types import SimpleNamespace

import numpy as np
import pytest
import talus
import yaml
from scipy.signal import butter, lfilter, sosfiltfilt
from support import REPOSITORY, run
from talus.diagnosis import irregular, noise
from talus.diagnosis.search import Search

pytestmark = pytest.mark.spread

LEG, PENDULUM = (REPOSITORY / f"models/{plant}.yaml" for plant in ("leg", "pendulum"))
RATE_HZ, PERIOD = 100, 700  # rows


def correlated(memory_s, seconds, seed):
    """Noise whose correlation falls by e within `memory_s`."""
    keep = np.exp(-1 / (RATE_HZ * memory_s))
    white = np.random.default_rng(seed).standard_normal(seconds * RATE_HZ)
    return lfilter([np.sqrt(1 - keep**2)], [1, -keep], white)


def share(series, lag_s=1.0, sign=None, turned=False):
    rows, sign = np.arange(len(series) - PERIOD), np.ones(len(series)) if sign is None else sign
    found = noise.differences(series, np.ones(len(series), bool), (rows, rows + PERIOD), round(lag_s * RATE_HZ), sign, turned)
    return noise.lasting_share([found])


@pytest.mark.parametrize("lag_s", noise.LASTING_S)
@pytest.mark.parametrize("memory_s", [0.02, 0.05, 0.1])
def test_noise_of_any_colour_that_a_sensor_has_does_not_last(memory_s, lag_s):
    assert [share(correlated(memory_s, 60, seed), lag_s) for seed in range(40)].count(0.0) >= 39


def test_a_friction_that_wanders_lasts_in_the_direction_of_motion_alone():
    """Of a motion to and fro in 0.7 s, whose direction after half a second is mostly the other one."""
    sign = np.where(np.arange(120 * RATE_HZ) % 70 < 35, 1.0, -1.0)
    wandering = [sign * correlated(3.0, 120, seed) for seed in range(10)]
    assert min(share(one, 0.5, sign) for one in wandering) > 0.3 and max(share(one, 0.5) for one in wandering) == 0.0


TO_AND_FRO = np.where(np.arange(120 * RATE_HZ) % 140 < 70, 1.0, -1.0)


@pytest.mark.parametrize("memory_s", [0.02, 0.1, 0.6, 3.0])
def test_no_noise_of_a_sensor_turns_with_the_motion(memory_s):
    """Whatever its colour: it does not know the direction."""
    assert [share(correlated(memory_s, 120, seed), noise.TURNED_S, TO_AND_FRO, True) for seed in range(40)].count(0.0) >= 39


@pytest.mark.parametrize("lowpass_Hz", [2.0, 8.0])
def test_nor_does_what_a_low_pass_leaves_of_white_noise(lowpass_Hz):
    """A filter swings by itself, but not for two of its periods."""
    lag_s, band = max(noise.TURNED_S, noise.TURNED_PERIODS / lowpass_Hz), butter(4, lowpass_Hz, fs=RATE_HZ, output="sos")
    filtered = [sosfiltfilt(band, correlated(1e-3, 120, seed)) for seed in range(40)]
    assert [share(one, lag_s, TO_AND_FRO, True) for one in filtered].count(0.0) >= 39


def test_a_friction_that_wanders_within_half_a_second_turns_with_the_motion():
    """Its memory after a quarter of a second; after half a second, at which noise of any colour is gone, most of it is."""
    wandering = [TO_AND_FRO * correlated(0.6, 120, seed) for seed in range(10)]
    found = [share(one, noise.TURNED_S, TO_AND_FRO, True) for one in wandering]
    assert np.mean(found) == pytest.approx(np.exp(-noise.TURNED_S / 0.6), abs=0.1) and min(found) > 0.4


def test_a_torque_that_swings_is_seen_after_half_a_second_or_one():
    """Within 4 s, as the cosine of what it swings in between, less what one period changes: the wave of other phase there."""
    t = np.arange(120 * RATE_HZ) / RATE_HZ
    swing = np.sin(2 * np.pi * t / 4.0)
    assert share(swing, 1.0) == 0.0 and share(swing, 0.5) == pytest.approx(np.cos(np.pi / 4), abs=0.02)


@pytest.mark.parametrize("memory_s", [3.0, 6.0])
def test_what_lasts_is_the_correlation_a_second_later(memory_s):
    """Of differences over a period: 2 c(1 s) - c(1 s + period) - c(period - 1 s), over 2 - 2 c(period)."""
    c = [np.exp(-abs(t) / memory_s) for t in (1, PERIOD / RATE_HZ + 1, PERIOD / RATE_HZ - 1, PERIOD / RATE_HZ)]
    expected = (2 * c[0] - c[1] - c[2]) / (2 - 2 * c[3])
    found = [share(correlated(memory_s, 400, seed)) for seed in range(20)]
    assert np.mean(found) == pytest.approx(expected, abs=3 * np.std(found) / np.sqrt(len(found)) + 0.02)


# ---- what differs from period to period --------------------------------------------


def repeated(periods, added, seed=0):
    """(recording on a grid, its values) of white noise with a standard deviation of 1, over so many periods and a bit, with something else."""
    n = round(periods * PERIOD + 0.3 * PERIOD)
    t_s = np.arange(n) / RATE_HZ
    values = np.random.default_rng(seed).standard_normal(n) + added(t_s, np.sign(np.sin(2 * np.pi * np.arange(n) / (PERIOD / 5))))
    return SimpleNamespace(grid_t_s=t_s, step_s=1 / RATE_HZ), values


def deviation(periods, added, seed=0):
    processed, values = repeated(periods, added, seed)
    return noise.repeat_deviation(processed, values, np.ones(len(values), bool), PERIOD / RATE_HZ)


def lines(periods, added):
    processed, values = repeated(periods, added)
    return noise.concentration(processed, values, np.ones(len(values), bool), PERIOD / RATE_HZ)


def drifting(t_s, direction):
    return 2.0 * t_s / 7.0 * direction  # by twice the noise a period


@pytest.mark.parametrize("periods", [3, 4, 7])
def test_friction_that_drifts_evenly_is_neither_noise_nor_a_vibration(periods):
    """As few periods as three have one second difference at each phase, whose square has a mean of 6 of the noise's."""
    found = [deviation(periods, drifting, seed) for seed in range(20)]
    assert np.mean(found) == pytest.approx(1.0, abs=0.03)
    assert lines(periods, drifting) < 0.1 and lines(periods, lambda t_s, direction: 0.0 * t_s) < 0.1


def test_a_vibration_that_does_not_come_back_with_the_motion_stands_at_one_frequency():
    assert lines(3, lambda t_s, direction: 3.0 * np.sin(2 * np.pi * 9.48 * t_s)) > 0.5


def test_two_periods_tell_no_noise_from_drift():
    assert deviation(2, drifting) is None and lines(1.6, drifting) == 0.0


def pairs_of(drift, seed, seconds=60):
    """What differs between instants with the same direction, of white noise of 1 and a friction: (change, instants, direction)."""
    rng = np.random.default_rng(seed)
    instants = rng.uniform(0, seconds, (2, 600))
    direction = np.broadcast_to(rng.choice([-1.0, 1.0], 600), instants.shape)
    return np.diff(rng.standard_normal(instants.shape) + direction * drift(instants / seconds), axis=0)[0], instants, direction


@pytest.mark.parametrize("drift", [lambda u: 0.0 * u, lambda u: 8.0 * u, lambda u: 8.0 * np.exp(-3.0 * u)])
def test_friction_that_drifts_is_no_noise_where_the_motion_does_not_repeat_either(drift):
    """Of 600 pairs each of 20 times; the noise has 1, by which the drift is eight times as large."""
    found = [noise.pair_deviation(noise.steady(*pairs_of(drift, seed))) for seed in range(20)]
    assert np.mean(found) == pytest.approx(1.0, abs=0.06)
    assert drift(1.0) == drift(0.0) or noise.pair_deviation(pairs_of(drift, 0)[0]) > 1.5


def test_a_drift_that_is_not_significant_is_left_as_it_is():
    """Two terms fit any noise a little: left to that, they would make it smaller."""
    every = [pairs_of(lambda u: 0.0 * u, seed) for seed in range(200)]
    assert sum(noise.steady(*one) is one[0] for one in every) >= 199


def test_what_wanders_from_second_to_second_stays_noise():
    wander = lambda u: 3.0 * np.sin(2 * np.pi * 15 * u)
    found = [noise.pair_deviation(noise.steady(*pairs_of(wander, seed))) for seed in range(20)]
    assert np.mean(found) == pytest.approx(np.mean([noise.pair_deviation(pairs_of(wander, seed)[0]) for seed in range(20)]), rel=0.02)


SPRING_AND_DRIFT = """effects:
- effect: parallel_spring
  joint: joint
  parameters: {stiffness_Nm_rad: 1.0, stiffening_Nm_rad3: 2.0, preload_Nm: 0.0, bend_Nm_rad2: 0.5, bumper_Nm_rad: 0.0, bumper_rad: 0.0, bumper_side: 0}
- effect: friction_drift
  joint: joint
  parameters: {coulomb_Nm: 0.16, viscous_Nms_rad: 0.013, cold_coulomb_Nm: 0, cold_viscous_Nms_rad: 0, coulomb_Nm_10K: 0, viscous_Nms_rad_10K: 0,
               time_constant_s: 30, middle_C: 20}
"""


@pytest.mark.long
def test_a_drift_and_a_spring_are_named_on_ramps(tmp_path):
    """The drift does not come back with a motion, and the spring is less than it."""
    (tmp_path / "model.yaml").write_text(PENDULUM.read_text() + SPRING_AND_DRIFT)
    recording = talus.simulate(talus.read(tmp_path / "model.yaml"), duration_s=90, rate_hz=500, encoder_bits=18, excitation="ramps")
    found = {one["effect"]: one["probability"] for one in talus.diagnose(PENDULUM, recording).effects}
    assert set(found) == {"parallel_spring", "friction_drift"} and min(found.values()) > 0.9


@pytest.mark.parametrize(("memory_s", "verdict"), [pytest.param(0.05, "none", marks=pytest.mark.long), (2.0, "unknown")])
def test_a_torque_that_wanders_is_unknown_and_coloured_noise_is_none(tmp_path, memory_s, verdict):
    """Nothing else is hidden: all of the gap is what wanders."""
    paths = []
    for seed in (1, 2):
        run("talus-sim", "--model", PENDULUM, "--out", tmp_path / "sound.csv", "--duration", 40, "--rate", RATE_HZ, "--seed", seed)
        columns = dict(talus.Recording.read(tmp_path / "sound.csv").columns)
        columns["joint_current_A"] = columns["joint_current_A"] + 0.1 * correlated(memory_s, 41, seed)[:len(columns["time_s"])]
        paths.append(tmp_path / f"{seed}.csv")
        np.savetxt(paths[-1], np.column_stack(list(columns.values())), "%.12g", ",", header=",".join(columns), comments="")
    run("talus-gap", "--quiet", "--model", PENDULUM, "--report", tmp_path / "gap.json", *paths)
    report = json.loads((tmp_path / "gap.json").read_text())
    assert report["verdict"]["effect"] == verdict
    shares = [one["share"] for one in report["irregular"] if one["joint"] == "joint"]
    assert len(shares) == (verdict == "unknown") and min(shares, default=1.0) > 0.8


@pytest.mark.long
@pytest.mark.parametrize(("wanders", "verdict"), [(0.3, "unknown"), (0.0, "none")])
def test_a_friction_that_varies_erratically_is_unknown(wanders, verdict):
    """By 30 % within 0.6 s, gone after a second."""
    recording = talus.simulate(talus.read(PENDULUM), duration_s=80, rate_hz=RATE_HZ, encoder_bits=18)
    columns, joint = dict(recording.columns), yaml.safe_load(PENDULUM.read_text())["joint"]
    friction_A = joint["friction"]["coulomb_Nm"] / joint["transmission"]["ratio"] / joint["torque_constant_Nm_A"]
    erratic = correlated(0.6, 82, 5)[:len(columns["time_s"])] * np.tanh(np.gradient(columns["joint_rad"], columns["time_s"]) / 0.05)
    columns["joint_current_A"] = columns["joint_current_A"] + wanders * friction_A * erratic
    assert talus.diagnose(PENDULUM, talus.Recording(columns)).verdict["effect"] == verdict


class Channels(Search):
    """A search of a leg's five kinds of channel, in each of which reconstruction may leave 300; the plain model leaves so much of the
    ankle's torque, of which so much lasts, and nothing of the others."""

    floor_of, plain = dict.fromkeys(("T0", "T1", "E", "K", "F"), 300.0), SimpleNamespace(chosen=[])
    dataset = SimpleNamespace(model=SimpleNamespace(joints=["knee", "ankle"]))

    def __init__(self, left, lasting):
        self.left, self.lasting = left, lasting

    def held_out_excess(self, chosen):
        return dict.fromkeys(self.floor_of, 0.0) | {"T1": self.left - self.lasting}

    def irregular(self, fit):
        return {"T0": 0.0, "T1": self.lasting}


@pytest.mark.parametrize(("left", "lasting", "times"), [
    (250.0, 0.0, 1.0),
    (250.0, 100.0, 1.0),  # it lasts, but there is no gap
    (2100.0, 0.0, (2100 + 4 * 300) / 1500),
    (2100.0, 100.0, 2100 / 300),
])  # fmt: skip
def test_what_lasts_in_one_kind_of_channel_is_not_hidden_by_the_others(left, lasting, times):
    assert Channels(left, lasting).gap_over_floor() == pytest.approx(times)


@pytest.mark.parametrize(("left", "lasting", "told"), [(250.0, 0.0, []), (2000.0, 500.0, [("ankle", 0.25)]), (-50.0, 100.0, [("ankle", 1.0)])])
def test_the_report_tells_what_share_of_the_gap_does_not_come_back(left, lasting, told):
    """Of what the plain model leaves above the noise, what is below it in some kind of channel not counted against the rest."""
    assert [(one["joint"], one["share"]) for one in irregular.shares(Channels(left, lasting))] == told


@pytest.mark.long
@pytest.mark.parametrize(("wanders", "verdict"), [(0.25, "unknown"), (0.0, "none")])
def test_an_ankles_friction_that_varies_erratically_is_unknown(wanders, verdict):
    """It is a tenth of all that a leg's channels may leave."""
    model = talus.read(LEG)
    columns = dict(talus.simulate(model, duration_s=64, rate_hz=125, encoder_bits=18).columns)
    angle, drive = columns["ankle_joint_rad"], yaml.safe_load(LEG.read_text())["ankle"]
    erratic = correlated(0.6, 82, 5)[:len(angle)] * np.tanh(np.gradient(angle, columns["time_s"]) / 0.05)
    friction_A = drive["friction"]["coulomb_Nm"] / model.transmission(1).ratio(angle) / drive["torque_constant_Nm_A"]
    columns["ankle_current_A"] = columns["ankle_current_A"] + wanders * friction_A * erratic
    assert talus.diagnose(LEG, talus.Recording(columns)).verdict["effect"] == verdict
