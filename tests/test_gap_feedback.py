"""How a drive answers its encoder, found in recordings, and replicates that do as it does (tools/talus/diagnosis/calibration/feedback)."""

import json
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from gap_in_process import recorded
from scipy import signal
from scipy.integrate import solve_ivp
from support import REPOSITORY, data, needs_data, run

import talus
from talus.diagnosis import noise
from talus.diagnosis.calibration import feedback
from talus.diagnosis.calibration.loops import TICK_S, Loop
from talus.diagnosis.calibration.replicates import Sensors, Source, driven
from talus.diagnosis.motion import plant_of
from talus.diagnosis.search import plain_base
from talus.diagnosis.torque_terms import TorqueTerms

pytestmark = pytest.mark.spread

PENDULUM = REPOSITORY / "models/pendulum.yaml"
BENCH_RAD_S, BENCH_DAMPING, BENCH_SPEED_HZ = 2 * math.pi * 10.0, 0.8, 100.0  # of talus-sim's control (docs/talus-sim.md)


def bench(folder, *options):
    path = folder / "bench.csv"
    run("talus-sim", "--model", PENDULUM, "--out", path, *options)
    return path


def even(n, step_s):
    """A recording on an even grid, all that the law is measured from."""
    part = {"begin": 0, "end": n, "begin_s": 0.0, "n": n}
    return SimpleNamespace(step_s=step_s, t_s=step_s * np.arange(n), parts=[part], inside=np.ones(n, bool), resample=np.asarray)


def waves(t, low_Hz, high_Hz, seed, count=40):
    """Sines at drawn frequencies, and their first two derivatives."""
    random = np.random.default_rng(seed)
    w, phase = 2 * np.pi * random.uniform(low_Hz, high_Hz, count)[:, None], random.uniform(0, 2 * np.pi, count)[:, None]
    return np.array([(w**k * np.sin(w * t + phase + 0.5 * k * np.pi)).sum(0) for k in range(3)])


# ---- the law ---------------------------------------------------------------------------


def test_a_law_beside_a_slow_order_is_found_and_the_order_with_it():
    recording = even(6000, 0.004)
    t = recording.t_s
    s = 1e-3 * waves(t, 0.2, 20.0, 1)
    order = 5.0 * waves(t, 0.1, 1.5, 2)[0]
    torque = order - 120.0 * s[0] - 3.0 * s[1] + 3.0 * 0.002 * s[2]
    law = feedback.law_of([recording], [s[0]], [torque])
    assert (law.stiffness, law.damping, law.delay_s) == pytest.approx((120.0, 3.0, 0.002), rel=0.02)
    assert law.explains > 0.99
    inner = slice(200, -200)  # ticks lie half of one before the samples
    (found,) = feedback.order(recording, law, s[0], torque, TICK_S)
    assert len(found) * TICK_S >= t[-1] and feedback.first_tick_s(t, TICK_S) == pytest.approx(-0.5 * TICK_S)
    assert np.sqrt(np.mean(((found[::4] + found[1::4])[:6000] / 2 - order)[inner] ** 2)) < 0.02 * np.std(order)


def test_a_plant_that_is_driven_without_a_loop_has_none():
    """Its torque goes with speed and acceleration the other way."""
    recording = even(6000, 0.004)
    q = 1e-3 * waves(recording.t_s, 0.2, 20.0, 3)
    assert feedback.law_of([recording], [q[0]], [0.05 * q[2] + 0.2 * q[1] + 3.0 * q[0]]) is None


def test_a_torque_that_has_nothing_to_do_with_the_encoder_has_no_law():
    recording, random = even(6000, 0.004), np.random.default_rng(4)
    q = 1e-3 * waves(recording.t_s, 0.2, 20.0, 5)[0]
    assert feedback.law_of([recording], [q], [waves(recording.t_s, 0.2, 20.0, 6)[0] + 0.1 * random.standard_normal(6000)]) is None


def test_the_law_is_that_of_the_recording_which_shows_it_best():
    recording, random = even(6000, 0.004), np.random.default_rng(7)
    s = 1e-3 * waves(recording.t_s, 0.2, 20.0, 8)
    torque = -120.0 * s[0] - 3.0 * s[1]
    disturbed = torque + 0.3 * waves(recording.t_s, 4.0, 15.0, 9)[0] * np.std(torque) / 4.0
    law = feedback.law_of([recording] * 2, [s[0]] * 2, [disturbed + 1e-3 * random.standard_normal(6000), torque])
    assert law.stiffness == pytest.approx(120.0, rel=0.01)


def test_order_of_a_motion_that_repeats_is_the_mean_of_its_periods():
    recording, random = even(8000, 0.004), np.random.default_rng(10)
    t, law = recording.t_s, feedback.Law(0.0, 0.0, 0.001, 1.0)
    clean, inner, left = np.sin(2 * np.pi * t / 2.0), slice(200, -200), []
    for _ in range(40):  # of one noise few lines are left
        noisy = clean + random.standard_normal(8000)
        once, mean = (feedback.order(recording, law, 0.0 * t, noisy, TICK_S, period_s)[0] for period_s in (None, 2.0))
        assert mean[500:20000] == pytest.approx(mean[2500:22000], abs=1e-9)
        left.append([np.mean((x[::4][:8000] - clean)[inner] ** 2) for x in (once, mean)])
    once, mean = np.sqrt(np.mean(left, axis=0))
    assert mean < 1.2 * once / math.sqrt(15)


@pytest.mark.parametrize("white", [0.0, 0.1, 1.0])
def test_what_the_steps_make_of_the_torque_is_no_order(white):
    """A motion's order stands in its own frequencies; of noise beside it an eighth of the power is left, and without any all of the order."""
    recording, random = even(12000, 0.004), np.random.default_rng(12)
    t, law = recording.t_s, feedback.Law(0.0, 0.0, 0.001, 1.0)
    clean = np.sin(2 * np.pi * 0.5 * t) + 0.3 * np.sin(2 * np.pi * 4.5 * t)
    (found,) = feedback.order(recording, law, 0.0 * t, clean + white * random.standard_normal(12000), TICK_S)
    seen = 0.5 * (found[::4][:12000] + found[1::4][:12000])  # ticks lie amid the samples
    error = (seen - clean)[500:-500]
    passed = white**2 * 30.0 * 2 * 0.004  # of the noise by a filter of 30 Hz
    assert np.mean(error**2) < passed / 8 + 1e-4


def test_pieces_too_short_or_too_slow_for_the_band_have_no_law_and_short_ones_an_order():
    for n, step_s in ((300, 0.004), (6000, 0.03)):
        recording = even(n, step_s)
        s = 1e-3 * waves(recording.t_s, 0.2, 15.0, 11)
        assert feedback.law_of([recording], [s[0]], [-120.0 * s[0] - 3.0 * s[1]]) is None
    for n in (5, 40):
        recording = even(n, 0.004)
        (found,) = feedback.order(recording, feedback.Law(2.0, 0.0, 0.001, 1.0), np.full(n, 1.5), np.full(n, 4.0), TICK_S, 0.008)
        assert found == pytest.approx(7.0)
    assert noise.roughness(np.zeros(3)) == 0.0


@pytest.mark.parametrize(("rate", "bits"), [(1000, 14), (500, 16), (250, 16)])
def test_a_bench_drives_as_talus_sim_does(rate, bits, tmp_path):
    """10 Hz and a damping of 0.8 on the pendulum's inertia; the slower a recording, the more of the encoder's steps is folded into it."""
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, "--duration", "40", "--rate", str(rate), "--encoder-bits", str(bits)))
    processed = dataset.processed_recordings[0]
    law = feedback.law_of([processed], [processed.columns["joint_rad"]], [dataset.effort(0, 0)])
    inertia = dataset.model.parameters["inertia_kg_m2"]
    assert law.stiffness == pytest.approx(inertia * BENCH_RAD_S**2, rel=0.2)
    assert law.damping == pytest.approx(2.0 * BENCH_DAMPING * inertia * BENCH_RAD_S, rel=0.2)


# ---- the plant under it ----------------------------------------------------------------


def test_a_drives_loop_is_the_one_of_its_equations(tmp_path):
    """Tick by tick with SciPy's integrator between: the encoder's grid, the low-passed speed, the torque that is held."""
    model = tmp_path / "smooth.yaml"  # without dry friction the equations are smooth
    model.write_text(PENDULUM.read_text().replace("coulomb_Nm: 0.25", "coulomb_Nm: 0"))
    path = tmp_path / "bench.csv"
    run("talus-sim", "--model", model, "--out", path, "--duration", "12", "--seed", "4")
    dataset, identified = recorded(model, tmp_path, path)
    terms = TorqueTerms(dataset, 0, np.array(list(identified.base.values())))
    processed, p, m = dataset.processed_recordings[0], terms.model.parameters, terms.model
    law, step, offset = feedback.Law(150.0, 3.0, 0.002, 1.0), 0.002, 0.0007
    first = feedback.first_tick_s(processed.t_s, TICK_S)
    ticks = np.arange(0.0, processed.t_s[-1] - processed.t_s[0] + 2 * TICK_S, TICK_S) + processed.t_s[0] + first
    order = 150.0 * np.interp(ticks, processed.t_s, processed.q[0]) + 3.0 * np.interp(ticks, processed.t_s, processed.v[0])
    motion = driven(dataset, 0, plant_of(terms), (), {0: Loop(law, [order], step, offset)})
    t, inertia = processed.t_s - processed.t_s[0], m.inverse(0.0, 0.0, 1.0)[0] - m.inverse(0.0, 0.0, 0.0)[0]

    def grid(q):
        return math.floor((q - offset) / step + 0.5) * step + offset

    def rate(_, x, torque):
        gravity = 9.81 * p["gravity_moment_kg_m"] * np.sin(x[0] - p["gravity_zero_rad"])
        return [x[1], (torque - p["torque_offset_Nm"] - gravity - max(p["viscous_Nms_rad"], 0.0) * x[1]) / inertia]

    x, now, shown = np.array([processed.q[0][0], processed.v[0][0]]), 0.0, []
    seen, speed, rows = grid(x[0]), x[1], iter(range(1, 120))
    row = next(rows)
    for tick in range(600):
        new = grid(x[0])
        speed += (1 - math.exp(-2 * math.pi * law.velocity_hz(TICK_S) * TICK_S)) * ((new - seen) / TICK_S - speed)
        seen = new
        torque = order[tick] - law.stiffness * seen - law.damping * speed
        until = first + (tick + 1) * TICK_S
        while row is not None and t[row] <= until:
            x = solve_ivp(rate, (now, t[row]), x, args=(torque,), rtol=1e-9, atol=1e-12).y[:, -1] if t[row] > now else x
            now = t[row]
            shown.append((row, x[0], torque))
            row = next(rows, None)
        x = solve_ivp(rate, (now, until), x, args=(torque,), rtol=1e-9, atol=1e-12).y[:, -1]
        now = until
    rows, q, torque = np.array(shown).T
    rows = rows.astype(int)
    assert len(rows) > 100
    assert np.abs(motion.q[0][rows] - q).max() < 1e-6
    assert np.abs(motion.torque[0][rows] - torque).max() < 1e-3 * np.ptp(torque)


def test_a_drive_that_ticks_first_after_its_first_sample_is_refused(tmp_path, monkeypatch):
    dataset, identified = recorded(PENDULUM, tmp_path, bench(tmp_path, "--duration", "12"))
    terms = TorqueTerms(dataset, 0, np.array(list(identified.base.values())))
    loops = {0: Loop(feedback.Law(150.0, 3.0, 0.002, 1.0), [np.zeros(12001)], 0.001)}
    assert driven(dataset, 0, plant_of(terms), (), loops)
    for first_s in (1e-6, -TICK_S):
        monkeypatch.setattr(feedback, "first_tick_s", lambda *_: first_s)  # noqa: B023
        assert driven(dataset, 0, plant_of(terms), (), loops) is None


# ---- replicates ------------------------------------------------------------------------


def repeats(dataset, record=0):
    """Share of a torque's power beyond the motion that comes back with it."""
    processed, n = dataset.processed_recordings[record], round(dataset.periods_s[record] / dataset.processed_recordings[record].step_s)
    band = signal.butter(6, (15.0, 60.0), "bandpass", fs=1.0 / processed.step_s, output="sos")
    torque = signal.sosfiltfilt(band, processed.resample(dataset.effort(record, 0)))
    every = torque[: len(torque) // n * n].reshape(-1, n)[1:-1]
    return 1.0 - np.var(every - every.mean(0)) * len(every) / (len(every) - 1) / np.var(every)


def test_a_replicate_has_the_torque_that_its_encoders_steps_make(tmp_path, monkeypatch):
    """As much of it, and as far as a bench does the same in every period. Noise of the torque's own sensor would not come back."""
    options = ("--excitation", "multisine", "--fit", "--duration", "60", "--rate", "200", "--encoder-bits", "16")
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, *options))
    source = Source.of(dataset, plain_base(dataset))
    assert source.loops.of[0] and repeats(dataset) > 0.5
    for one in (source.replicate(1, number) for number in range(3)):
        assert repeats(one) == pytest.approx(repeats(dataset), abs=0.15)
        assert noise.roughness(one.effort(0, 0)) == pytest.approx(noise.roughness(dataset.effort(0, 0)), rel=0.1)
    monkeypatch.setattr(feedback, "law_of", lambda *_: None)
    assert repeats(Source.of(dataset, plain_base(dataset)).replicate(1, 0)) < repeats(dataset) - 0.15


def test_a_drive_that_follows_a_finer_encoder_than_the_recorded_one_keeps_the_recorded_torque(tmp_path):
    """The loop of such steps would make a torque many times as rough as this one."""
    path = bench(tmp_path, "--duration", "20", "--rate", "500", "--encoder-bits", "16")
    lines = path.read_text().splitlines()
    at, rows = lines[0].split(",").index("joint_rad"), [line.split(",") for line in lines[1:]]
    for row in rows:
        row[at] = repr(round(float(row[at]) / 0.002) * 0.002)
    path.write_text("\n".join([lines[0], *map(",".join, rows)]) + "\n")
    dataset, _ = recorded(PENDULUM, tmp_path, path)
    source = Source.of(dataset, plain_base(dataset))
    assert not source.loops
    assert np.array_equal(source.motions[0].torque, Source.of(dataset, plain_base(dataset)).motions[0].torque)


def test_where_no_plant_can_be_driven_by_a_loop_the_recorded_torque_does(tmp_path, monkeypatch):
    """Once a law that no plant stands, found by mistake; once a replicate that runs away later."""
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, "--duration", "12", "--rate", "500", "--encoder-bits", "14"))
    base, law = plain_base(dataset), feedback.Law(1e9, 1e7, 0.002, 1.0)
    sound = Source.of(dataset, base)
    with monkeypatch.context() as patch:
        patch.setattr(feedback, "law_of", lambda *_: law)
        source = Source.of(dataset, base)
    assert source.motions and not source.loops and source.replicate(1, 0)
    torque = dataset.effort(0, 0)
    assert np.std(source.motions[0].torque[0] - torque) < 0.2 * np.std(torque)
    sound.loops.of[0][0].law = law
    assert sound.replicate(1, 0) is None


def test_a_loop_that_its_replicate_does_not_show_is_none(tmp_path, monkeypatch):
    """A current's noise that was taken for steps: the position tells a third of it, and hardly any of what such a loop makes."""
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, "--duration", "20", "--rate", "500", "--encoder-bits", "14"))
    base = plain_base(dataset)
    sound = Source.of(dataset, base)
    law = sound.loops.of[0][0].law
    positions = [processed.columns["joint_rad"] for processed in dataset.processed_recordings]
    told = feedback.explained(dataset.processed_recordings, positions, [dataset.effort(0, 0)])
    assert told == pytest.approx(law.explains)
    again = sound.replicate(1, 0)
    assert feedback.explained(again.processed_recordings, [again.processed_recordings[0].columns["joint_rad"]], [again.effort(0, 0)]) == pytest.approx(told, abs=0.15)
    before = list(Source.of(dataset, base).sensors[0].torque[0])
    monkeypatch.setattr(feedback, "explained", lambda *_: 0.4 * law.explains)
    source = Source.of(dataset, base)
    assert not source.loops and source.motions and np.std(source.motions[0].torque[0] - dataset.effort(0, 0)) < 0.2 * np.std(dataset.effort(0, 0))
    assert np.sum(source.sensors[0].torque[0]) > np.sum(before)  # noise that the loop would have made is noise again


@needs_data
def test_a_real_currents_noise_is_no_loop(tmp_path):
    """Of ur10e's joint 1 a law of 1.9 kNm/rad tells 36 %; its angle is a file's four decimals, and its current noisy."""
    model = tmp_path / "model.yaml"
    model.write_text(re.sub(r"(?m)^score:.*\n", "", data("ur10e_joints/model.yaml").read_text(encoding="utf-8")))
    dataset, _ = recorded(model, tmp_path, data("ur10e_joints/ur10e_joint_1.csv"))
    source = Source.of(dataset, plain_base(dataset))
    assert source.loops.measured[0][0].law.explains < 0.5 and not source.loops and source.motions
    assert source.sensors[0].torque[0] == pytest.approx(Sensors(dataset, 0).torque[0])


def test_the_same_replicate_is_the_same_and_another_has_its_grid_elsewhere(tmp_path):
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, "--duration", "12", "--rate", "500", "--encoder-bits", "14"))
    source = Source.of(dataset, plain_base(dataset))
    first, again, other = (source.replicate(1, number).processed_recordings[0].columns for number in (0, 0, 1))
    assert all(np.array_equal(first[name], again[name]) for name in first)
    assert not np.array_equal(first["joint_current_A"], other["joint_current_A"])
    step = source.loops.of[0][0].step
    assert step == pytest.approx(2 * math.pi / 2**14, rel=0.01)
    grids = [float(np.median((columns["joint_rad"] / step) % 1.0)) for columns in (first, other)]
    assert abs(grids[0] - grids[1]) > 1e-3


def diagnosed(folder, *options):
    path, report = bench(folder, "--fit", *options), folder / "gap.json"
    run("talus-gap", "--quiet", "--model", PENDULUM, "--report", report, path)
    return json.loads(report.read_text())


@pytest.mark.long
@pytest.mark.parametrize(("rate", "bits", "duration", "seed"), [
    ("125", "0", "300", "1"), ("125", "14", "120", "1"), ("250", "16", "60", "5")])
def test_a_bench_whose_drive_turns_its_encoders_steps_into_torque_hides_nothing(rate, bits, duration, seed, tmp_path):
    """Presliding, or viscous friction of another form, at 0.45 while replicates had noise that is independent of the angle's; presliding
    at 1.00, of exact angles, while their loop's low-pass was quicker than it was measured."""
    options = ("--excitation", "multisine", "--duration", duration, "--rate", rate, "--encoder-bits", bits, "--seed", seed)
    verdict = diagnosed(tmp_path, *options)["verdict"]
    assert verdict["effect"] == "none" and verdict["probability"] > 0.9


def test_a_loop_that_ticks_is_as_late_as_the_law_that_was_measured():
    """A drive of 100 Hz at 1 kHz: half a tick for its difference, half for its held torque, and (1 - x) / x of the low-pass, by its sum."""
    share = 1.0 - math.exp(-2 * math.pi * 100.0 * 0.001)
    late = sum((1.0 - share) ** k * share * k for k in range(1, 200)) + 1.0
    assert feedback.Law(1.0, 1.0, late * 0.001, 1.0).velocity_hz(0.001) == pytest.approx(100.0, rel=1e-9)


def test_a_fine_encoders_step_is_found_where_no_sample_is_the_next_step(tmp_path):
    """At 100 Hz 20 bits pass by some at a time; an exact encoder has none to speak of."""
    options, twenty = ("--excitation", "multisine", "--fit", "--duration", "60", "--rate", "100", "--encoder-bits"), 2 * math.pi / 2**20
    for bits, low, high in (("20", 0.99 * twenty, 1.01 * twenty), ("0", 0.0, 0.1 * twenty)):
        dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, *options, bits))
        (sensors,) = Source.of(dataset, plain_base(dataset)).sensors
        assert low < sensors.step["joint_rad"] < high and sensors.noise["joint_rad"] == 0.0


def test_a_step_bears_values_that_lie_between_two_in_the_place_of_lost_ones():
    random = np.random.default_rng(12)
    values = 1e-3 * random.integers(0, 40000, 6000)
    values[10:14] += 1e-3 * random.random(4)
    assert noise.finest_step(values) == pytest.approx(1e-3) and noise.finest_step(np.full(9, 0.3)) == 0.0


def test_a_delay_that_no_loop_can_do_with_is_no_law():
    recording = even(6000, 0.004)
    s = 1e-3 * waves(recording.t_s, 0.2, 20.0, 13)
    for delay_s, is_one in ((0.015, True), (0.025, False), (-0.015, True), (-0.025, False)):
        law = feedback.law_of([recording], [s[0]], [-120.0 * s[0] - 3.0 * s[1] + 3.0 * delay_s * s[2]])
        assert (law is not None) == is_one
        assert not is_one or not law.is_sure and law.delay_s in feedback.DELAY_S


def test_a_lag_that_no_steps_ask_for_stays_as_it_was_measured(tmp_path):
    """The current's own noise makes the torque rough, and hides the law so far that its lag is not sure."""
    path = bench(tmp_path, "--excitation", "multisine", "--fit", "--duration", "60", "--rate", "250", "--encoder-bits", "16")
    columns = talus.Recording.read(path).columns
    columns["joint_current_A"] += 0.3 * np.random.default_rng(14).standard_normal(len(columns["time_s"]))
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="", fmt="%.9g")
    dataset, _ = recorded(PENDULUM, tmp_path, path)
    source = Source.of(dataset, plain_base(dataset))
    (loop,), (law,) = source.loops.of[0].values(), [one.law for one in source.loops.measured[0].values()]
    assert not law.is_sure and loop.law is law and source.loops.are_doubtful(source.motions)


@pytest.mark.long
@pytest.mark.parametrize("seed", ["1", "2"])
def test_a_law_that_folded_steps_nearly_hide_is_believed_and_its_lag_found(seed, tmp_path):
    """At 125 Hz and 14 bits two thirds of the torque's power in the band are steps that the recording folds: position friction (0.45)."""
    path, report = bench(tmp_path, "--rate", "125", "--encoder-bits", "14", "--seed", seed), tmp_path / "gap.json"
    run("talus-gap", "--quiet", "--model", PENDULUM, "--report", report, path)
    verdict = json.loads(report.read_text())["verdict"]
    assert verdict["effect"] == "none" and verdict["probability"] > 0.9


def test_replicates_gain_what_a_bench_that_hides_nothing_gains(tmp_path):
    """By each effect of some size, at exact angles: a slow recording's reversals give them all something."""
    found = diagnosed(tmp_path, "--excitation", "paper", "--duration", "20", "--rate", "100", "--encoder-bits", "0")
    gained = [(one["gain"], one["replicates"]) for one in found["nearest"] if one["gain"] > 100.0]
    assert len(gained) >= 5 and found["verdict"]["effect"] == "none"
    for own, replicates in gained:
        assert replicates == pytest.approx(own, rel=0.4)


@pytest.mark.long
@pytest.mark.parametrize(("later_s", "named"), [(0.0003, []), (0.003, ["delay"])])
def test_a_torque_that_is_held_between_ticks_is_no_delay(later_s, named, tmp_path):
    """Any recording sees it as much as half a tick early or late; with no least size this one was named for 0.3 ms."""
    columns = talus.Recording.read(bench(tmp_path, "--duration", "120", "--rate", "250", "--encoder-bits", "0")).columns
    current, t = columns["joint_current_A"], columns["time_s"]
    columns["joint_current_A"] = np.interp(t - later_s, t, current)
    found = talus.diagnose(talus.read(PENDULUM), [talus.Recording(columns)])
    assert [one["effect"] for one in found.effects] == named
