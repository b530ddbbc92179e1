"""What an encoder's steps leave at the recorded motion itself (tools/talus/diagnosis/calibration/encoder_steps.py)."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import signal
from support import REPOSITORY, run

from talus.diagnosis.calibration import encoder_steps

STEP_RAD, RATE_HZ, LOWPASS_HZ = 2 * math.pi / 2**20, 1000.0, 40.0
pytestmark = pytest.mark.spread


def seen(name, angle, random):
    if name == "ankle_motor_rad":  # exact
        return angle
    offset = STEP_RAD * random.random()
    return np.round((angle - offset) / STEP_RAD) * STEP_RAD + offset


def excess_at(counts_per_sample, rows):
    """(chi-square over its freedom that the steps make of a constant speed, share of white noise that passes the low-pass)."""
    low = signal.butter(4, LOWPASS_HZ, fs=RATE_HZ, output="sos")
    answer = signal.sosfreqz(low, 1 << 16)[1]
    bandwidth = float(np.mean(np.abs(answer) ** 4))  # forth and back
    angle = counts_per_sample * STEP_RAD * np.arange(20000)
    dataset = SimpleNamespace(
        thin=4, channels=[SimpleNamespace(kind="E", record=0, thinned=rows)],
        transmissions=[None, SimpleNamespace(motor_rad=np.asarray, joint_rad=np.asarray)],
        sigma={"E": STEP_RAD / math.sqrt(12)}, freedom=lambda kind: 4 * len(rows) * bandwidth,
        processed_recordings=[SimpleNamespace(q=[None, angle], operate=lambda error: signal.sosfiltfilt(low, error))])  # fmt: skip
    return encoder_steps.excess(dataset, [SimpleNamespace(seen=seen)], np.random.default_rng(3))["E"], bandwidth


def power_at(counts_per_sample):
    """(chi-square a row, over the whole power of rounding; that of white noise)."""
    rows = np.arange(1000, 19000, 4)
    excess, bandwidth = excess_at(counts_per_sample, rows)
    return excess / (4 * len(rows)) + bandwidth, bandwidth


def test_steps_at_a_whole_number_of_counts_a_sample_pass_the_lowpass_whole():
    """6.01 counts a sample: a saw tooth of 10 Hz, whose power is 1/12 step squared less what its harmonics from the fourth on have."""
    power, bandwidth = power_at(6.01)
    below = sum(1 / k**2 for k in range(1, 4)) / (math.pi**2 / 6)
    assert below - 0.02 < power < 1.0
    assert power > 8 * bandwidth


def test_steps_at_another_speed_are_noise():
    """At the golden mean's fraction of a count no low multiple comes near a whole number: less than white noise is left."""
    power, bandwidth = power_at(6 + (math.sqrt(5) - 1) / 2)
    assert power < bandwidth


def test_what_has_no_second_sensor_has_no_steps_to_tell():
    assert encoder_steps.excess(SimpleNamespace(channels=[SimpleNamespace(kind="T0")]), [], None) == {}


def test_where_no_row_counts_nothing_is_left():
    assert excess_at(6.01, np.array([], int))[0] == 0.0


def test_nothing_is_named_where_an_ankle_goes_six_counts_a_sample(tmp_path):
    """Replicates do not go at that speed to a percent: what such steps leave was a gap that no effect explains."""
    t = np.arange(0.0, 24.0, 0.002)
    speed = np.where(t < 0.3, 0.0, np.where(t % 16 < 8, 1.0, -1.0)) * 6.005 * STEP_RAD * RATE_HZ
    window = np.hanning(101)
    speed = np.convolve(np.pad(speed, 50, mode="edge"), window / window.sum(), "valid")
    ankle = np.concatenate([[0.0], np.cumsum(speed[:-1] * 0.002)])
    begun = np.clip(t / 2, 0.0, 1.0) ** 3 * (10 - 15 * np.clip(t / 2, 0.0, 1.0) + 6 * np.clip(t / 2, 0.0, 1.0) ** 2)
    knee = 0.6 + begun * (0.3 * np.sin(0.9 * t) + 0.1 * np.sin(2.3 * t))
    np.savetxt(tmp_path / "ref.csv", np.array([t, knee, ankle - ankle.mean()]).T, "%.9f", ",", header="time_s,knee_rad,ankle_rad", comments="")
    leg = REPOSITORY / "models/leg.yaml"
    run("talus-sim", "--model", leg, "--out", tmp_path / "r.csv", "--reference", tmp_path / "ref.csv", "--rate", RATE_HZ, "--jitter", "0.00002",
        "--encoder-bits", 20, "--ankle-bits", 20, "--duration", 24)  # fmt: skip
    run("talus-gap", "--quiet", "--model", leg, "--report", tmp_path / "r.json", tmp_path / "r.csv")
    verdict = json.loads((tmp_path / "r.json").read_text())["verdict"]
    assert (verdict["effect"], verdict["probability"] > 0.9) == ("none", True)
