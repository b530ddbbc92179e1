"""Does talus-gap's calibration by null replicates keep what it promises? Against SciPy, closed forms, and benches that hide nothing."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from gap_in_process import recorded
from scipy.integrate import solve_ivp
from scipy.stats import norm
from support import REPOSITORY, run

import talus
from talus.diagnosis import command, nearest, verdict
from talus.diagnosis.calibration import gains, lowpass, thresholds
from talus.diagnosis.calibration.gains import Calibration
from talus.diagnosis.calibration.replicates import Source, driven
from talus.diagnosis.effects import EFFECTS
from talus.diagnosis.motion import plant_of
from talus.diagnosis.search import Search, plain_base
from talus.diagnosis.torque_terms import TorqueTerms

pytestmark = pytest.mark.spread

LOOP_HZ = 3.0
PENDULUM, LEG, SLIDER = (REPOSITORY / f"models/{plant}.yaml" for plant in ("pendulum", "leg", "slider"))
KEY = ("stribeck", "joint")
CHANCE = 8.0
ONE, WITH_EFFECTS = SimpleNamespace(key=KEY, effect=KEY[0]), SimpleNamespace(effects=EFFECTS)


def bench(folder, model, *options):
    path = folder / "bench.csv"
    run("talus-sim", "--model", model, "--out", path, *options)
    return path


def diagnosed(folder, model, path, *options):
    report = folder / "gap.json"
    run("talus-gap", "--quiet", "--model", model, "--report", report, *options, path)
    return json.loads(report.read_text())


# ---- the statistic ---------------------------------------------------------------------


def test_the_probability_is_the_formula_of_the_docs():
    nulls, own = [12.0, 30.0, 18.0], 400.0
    found = Calibration({KEY: own}, [{KEY: x} for x in nulls], {"T0": 0.0}, CHANCE)
    for added, probability in ((CHANCE, found.nothing(KEY, own)), (thresholds.TIMES_AS_MUCH * CHANCE, found.nothing_at_all())):
        logs = np.log(np.array(nulls) + added)
        width = math.sqrt(np.var(logs, ddof=1) * (1 + 1 / 3) + thresholds.MISFIT**2)
        z = (math.log(own + added) - logs.mean()) / width
        null, other = norm.pdf(z) / width, norm.cdf(z - thresholds.DEVIATIONS) / thresholds.RANGE
        assert probability == pytest.approx(null / (null + other), rel=1e-9)


def test_what_an_effect_gains_alone_is_no_bound_beside_another():
    """A spring hides what a late current does; beside it the delay closes nearly all."""
    delay = "delay", "joint"
    found = Calibration({KEY: 4000.0, delay: 3.0}, [{KEY: 10.0, delay: 12.0}, {KEY: 20.0, delay: 9.0}], {"T0": 0.0}, CHANCE)

    def fit(excess, *keys):
        return SimpleNamespace(chosen=[SimpleNamespace(key=key) for key in keys], excess=excess)

    assert found.nothing_of(fit(5000.0), fit(4100.0, delay)) == found.nothing(delay, 3.0) > 0.5
    assert found.nothing_of(fit(1000.0, KEY), fit(100.0, KEY, delay)) == found.nothing(delay, 900.0) < 0.01


def test_a_gap_no_larger_than_the_floor_is_none_and_one_of_many_times_is_not():
    found = Calibration({}, [{}, {}], {"T0": 0.0}, CHANCE)
    for times in (1.0, 2.0, 3.5, 10.0):
        z = math.log(times) / thresholds.MISFIT
        null, gap = norm.pdf(z) / thresholds.MISFIT, norm.cdf(z - thresholds.DEVIATIONS) / thresholds.RANGE
        assert found.nothing_left(math.log(times)) == pytest.approx(null / (null + gap), rel=1e-9)
    assert found.nothing_left(0.0) > 0.99 and found.nothing_left(math.log(10.0)) < 0.01
    assert found.nothing_left(math.log(3.5)) == pytest.approx(0.5, abs=0.02)


def test_what_replicates_gain_is_their_middle_and_nothing_where_none_gains():
    found = Calibration({KEY: 9.0}, [{KEY: 10.0}, {KEY: 40.0}], {"T0": 0.0}, CHANCE)
    assert nearest.replicates_gain(found, KEY) == pytest.approx(math.sqrt(18.0 * 48.0) - CHANCE)
    assert nearest.replicates_gain(Calibration({KEY: 9.0}, [{KEY: -3.0}, {}], {"T0": 0.0}, CHANCE), KEY) == 0.0


def left_of(repeats):
    return SimpleNamespace(chance=2 * math.log(300), freedom=400.0 * repeats, dataset=SimpleNamespace(repeats=lambda: repeats))


@pytest.mark.parametrize("repeats", [1, 6])
def test_what_chance_gains_is_measured_in_what_is_left(repeats):
    """The best of n unit columns gains about 2 ln n times the variance of what it is fitted to, here 4: against draws. Extreme-value
    theory has a little less, 2 ln n - ln(pi ln n) + 2 gamma in the mean. What is left again in every period is gained as often."""
    random, columns, rows, left = np.random.default_rng(8), 300, 400, left_of(repeats)
    basis = np.tile(np.linalg.qr(random.normal(size=(rows, columns)))[0], (repeats, 1)) / math.sqrt(repeats)
    draw = lambda: np.tile(math.sqrt(3.0) * random.normal(size=rows), repeats) + random.normal(size=rows * repeats)
    best = [np.max((basis.T @ draw()) ** 2) for _ in range(300)]
    told = gains.by_chance_again(left, 1e9, 3.0 * left.freedom + 50.0, 50.0)
    less = (1.0 + 3.0 * repeats) * (math.log(math.pi * math.log(columns)) - 2 * np.euler_gamma)
    assert told - less == pytest.approx(np.mean(best), rel=0.05)
    assert repeats > 1 or told == pytest.approx(gains.by_chance(left, 3.0 * left.freedom))


def test_chance_has_no_more_than_replicates_leave_and_nothing_of_what_a_gain_takes():
    left = left_of(6)
    assert gains.by_chance(left, -4.0) == gains.by_chance_again(left, 900.0, 500.0, 600.0) == left.chance
    assert gains.by_chance_again(left, 200.0, 5000.0, 100.0) == pytest.approx(gains.by_chance(left, 6 * 200.0))
    found = Calibration({KEY: 400.0}, [{KEY: 12.0}, {KEY: 30.0}], {"T0": 0.0}, CHANCE, again=lambda gain: 0.1 * (1000.0 - gain))
    logs = np.log(np.array([12.0, 30.0]) + 60.0)
    width = math.sqrt(np.var(logs, ddof=1) * 1.5 + thresholds.MISFIT**2)
    assert found.most_widths() == pytest.approx((math.log(460.0) - logs.mean()) / width)
    assert found.nothing(KEY, 400.0) > Calibration({KEY: 400.0}, [{KEY: 12.0}, {KEY: 30.0}], {"T0": 0.0}, CHANCE).nothing(KEY, 400.0)
    assert found.nothing(KEY, 990.0) == Calibration({KEY: 990.0}, [{KEY: 12.0}, {KEY: 30.0}], {"T0": 0.0}, CHANCE).nothing(KEY, 990.0)


def test_where_nothing_is_hidden_an_effect_is_seldom_likely():
    """2,000 toy recordings: gains of nulls and of the recording itself from one lognormal distribution, as wide as any bench here
    showed."""
    random, wrong, claimed = np.random.default_rng(3), 0, []
    for _ in range(2000):
        draws = np.exp(random.normal(4.0, 0.3, 10))
        own = float(draws[0] * np.exp(random.normal(0.0, thresholds.MISFIT)))
        found = Calibration({KEY: own}, [{KEY: float(x)} for x in draws[1:]], {"T0": 0.0}, CHANCE)
        claimed.append(found.nothing(KEY, own))
        wrong += claimed[-1] < 0.5
    assert wrong < 0.06 * 2000  # one side of a normal distribution beyond 1.6 widths
    assert np.mean(np.array(claimed) < 0.1) < 0.006  # beyond 2.6


def test_where_nothing_is_hidden_a_gap_is_seldom_likely_however_many_effects_are_tried():
    """The same of twenty effects, of which each has a level of its own."""
    random, wrong, middle = np.random.default_rng(4), 0, np.linspace(1.0, 7.0, 20)
    for _ in range(600):
        draws = np.exp(random.normal(middle, 0.3, (10, 20)))
        draws[0] *= np.exp(random.normal(0.0, thresholds.MISFIT, 20))
        own, *nulls = [{(f"effect {k}", "joint"): x for k, x in enumerate(row)} for row in draws]
        wrong += Calibration(own, nulls, {"T0": 0.0}, CHANCE).nothing_at_all() < 0.5
    assert wrong < 0.06 * 600


def test_an_effect_well_above_its_nulls_is_kept_whatever_others_gain():
    nulls = [{KEY: 10.0, ("elasticity", "joint"): 1500.0}, {KEY: 4.0, ("elasticity", "joint"): 700.0}]
    found = Calibration({KEY: 1800.0, ("elasticity", "joint"): 900.0}, nulls, {"T0": 0.0}, CHANCE)
    assert found.nothing(KEY, 1800.0) < 0.01 and found.nothing(("elasticity", "joint"), 900.0) > 0.9
    assert found.nothing_at_all() < 0.01  # though that is hardly more than what elasticity gains anyhow


def test_what_the_replicates_gain_by_another_effect_is_no_gap():
    """The readings may do to one effect here what they do to the other there."""
    nulls = [{("elasticity", "joint"): 1500.0}, {("elasticity", "joint"): 1400.0}]
    found = Calibration({KEY: 1400.0}, nulls, {"T0": 0.0}, CHANCE)
    assert found.nothing(KEY, 1400.0) < 0.01 and found.nothing_at_all() > 0.5


def test_an_effect_is_doubted_where_the_replicates_gain_nearly_as_much_by_another(monkeypatch):
    """What the readings do to the one there they may do to the other here."""
    other, nulls = ("elasticity", "joint"), (3700.0, 3500.0, 4000.0)
    surely = [(0.99, *KEY), (0.01, "none", "none")]
    monkeypatch.setattr(verdict, "first_judgement", lambda search, fit, sound: verdict.Verdict(surely, fit, 0.1))
    for own, doubted in ((3300.0, True), (4500.0, True), (40_000.0, False)):
        found = Calibration({KEY: 2800.0, other: own}, [{other: gain} for gain in nulls], {"T0": 0.0}, CHANCE)
        judged = verdict.judge(SimpleNamespace(calibration=found, is_within_noise=lambda: False, dataset=WITH_EFFECTS), SimpleNamespace(chosen=[ONE]))
        assert found.nothing(KEY, 2800.0) < 0.01 and found.outdone() == doubted
        assert judged.effect == KEY[0] and judged.probabilities[0][0] == pytest.approx(thresholds.NEARLY_HALF if doubted else 0.99)


def test_where_the_inertia_is_not_known_an_effect_must_gain_more_than_anything_in_replicates():
    other = ("elasticity", "joint")
    calibration = Calibration({KEY: 9e4, other: 500.0}, [{other: gain} for gain in (400.0, 500.0, 450.0)], {"T0": 0.0}, 16.0)

    def limit(gain, fixed, within=False):
        search = SimpleNamespace(calibration=calibration, fit=lambda chosen: SimpleNamespace(excess=gain), is_within_noise=lambda: within,
                                 dataset=WITH_EFFECTS)  # fmt: skip
        return verdict.at_most(search, SimpleNamespace(chosen=[ONE], excess=0.0), ONE, fixed)

    at_most = lambda *given, **options: limit(*given, **options)[0]
    assert limit(600.0, fixed=True) == (1.0, None) and limit(9e4, fixed=True, within=True)[1] == "noise"
    assert limit(600.0, fixed=False)[1] == limit(9e4, fixed=None)[1] == "inertia"
    assert at_most(9e4, fixed=True, within=True) == thresholds.NEARLY_HALF  # the model without it leaves no more than the noise
    assert at_most(9e4, fixed=False) > 0.99 and at_most(600.0, fixed=False) < 0.1
    assert at_most(-100.0, fixed=False) < 0.1  # an effect that opens more than it closes
    assert at_most(9e4, fixed=None) == thresholds.NEARLY_HALF  # the sensors take more of the inertia than they leave


@pytest.mark.parametrize("kept, fixes", [(1.0, True), (0.92, True), (1.3, False), (0.6, False), (0.4, None), (0.05, None)])
def test_an_inertia_is_known_within_a_tenth_and_mostly_lost_beyond_half(kept, fixes):
    assert lowpass.Lowpass(30.0, "data", kept - 1.0).fixes_inertia is fixes


def test_an_effect_that_opens_more_than_it_closes_does_not_outdo_the_replicates():
    assert Calibration({KEY: 900.0}, [{KEY: 9.0}, {KEY: 20.0}], {"T0": 0.0}, 16.0).outdone(-1000.0)


# ---- replicates ------------------------------------------------------------------------


def test_a_replicate_moves_as_the_equations_say(tmp_path):
    """The pendulum under the recorded torque and the loop, by SciPy's integrator."""
    model = tmp_path / "smooth.yaml"  # without dry friction the equations are smooth
    model.write_text(PENDULUM.read_text().replace("coulomb_Nm: 0.25", "coulomb_Nm: 0"))
    path = bench(tmp_path, model, "--duration", "12", "--seed", "4")
    dataset, identified = recorded(model, tmp_path, path)
    base = np.array(list(identified.base.values()))
    terms = TorqueTerms(dataset, 0, base)
    motion, processed, m = driven(dataset, 0, plant_of(terms)), dataset.processed_recordings[0], terms.model
    t, w = processed.t_s, 2 * np.pi * LOOP_HZ
    inertia, p = m.inverse(0.0, 0.0, 1.0)[0] - m.inverse(0.0, 0.0, 0.0)[0], m.parameters
    effort = dataset.effort(0, 0)

    def rate(now, x):
        reference, speed = np.interp(now, t, processed.q[0]), np.interp(now, t, processed.v[0])
        torque = np.interp(now, t, effort) + inertia * (w * w * (reference - x[0]) + 2 * w * (speed - x[1]))
        gravity = 9.81 * p["gravity_moment_kg_m"] * np.sin(x[0] - p["gravity_zero_rad"])
        return [x[1], (torque - p["torque_offset_Nm"] - gravity - max(p["viscous_Nms_rad"], 0.0) * x[1]) / inertia]

    until = slice(0, 500)
    exact = solve_ivp(rate, (t[0], t[499]), [processed.q[0][0], processed.v[0][0]], t_eval=t[until], rtol=1e-9, atol=1e-11,
                      max_step=0.004)  # fmt: skip
    assert np.abs(exact.y[0] - motion.q[0][until]).max() < 2e-4 * np.ptp(motion.q[0])


def test_a_motion_is_repeated_as_often_as_it_fits_into_its_recordings(tmp_path):
    """A multisine of 4 s in a recording of 60 s, and in one of 6 s, which does not show that it repeats."""
    long, short = bench(tmp_path, PENDULUM, "--duration", "60", "--rate", "200"), tmp_path / "short.csv"
    run("talus-sim", "--model", PENDULUM, "--out", short, "--duration", "6", "--rate", "200")
    (once, _), (both, _) = recorded(PENDULUM, tmp_path, long), recorded(PENDULUM, tmp_path, long, short)
    assert once.periods_s[0] == pytest.approx(4.0, rel=1e-3) and once.repeats() == pytest.approx(15.0, rel=0.02)
    assert both.periods_s[1] is None and both.repeats() == pytest.approx((60 * 15.0 + 6 * 1.0) / 66, rel=0.02)


def test_what_runs_away_is_no_replicate(tmp_path):
    """Friction that grows against the speed one way drives a pendulum from its recorded motion: the loop is too weak to hold it."""
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, PENDULUM, "--duration", "20", "--rate", "200", "--encoder-bits", "20"))
    search = Search(dataset, plain_base(dataset))
    one = next(c for c in search.gram.candidates if c.effect == "asymmetric_friction" and c.shape == "viscous")
    of = lambda strength: Source.of(dataset, plain_base(dataset), [one], [[strength]])
    viscous = plain_base(dataset)[list(dataset.model.base).index("viscous")]
    assert of(0.5 * viscous) is not None and of(1000.0 * viscous) is None


def test_replicates_show_the_sensors_steps_and_differ(tmp_path):
    path = bench(tmp_path, PENDULUM, "--duration", "12", "--encoder-bits", "14")
    dataset, _ = recorded(PENDULUM, tmp_path, path)
    source = Source.of(dataset, plain_base(dataset))
    first, again, second = (source.replicate(1, number) for number in (0, 0, 1))
    angles = [one.processed_recordings[0].columns["joint_rad"] for one in (first, again, second)]
    assert np.array_equal(angles[0], angles[1]) and not np.array_equal(angles[0], angles[2])
    step = source.sensors[0].step["joint_rad"]
    assert step == pytest.approx(2 * math.pi / 2**14, rel=0.01)
    steps = np.diff(angles[0]) / step
    assert np.abs(steps - np.round(steps)).max() < 1e-6
    assert first.sigma == dataset.sigma


# ---- the low-pass ----------------------------------------------------------------------


def test_noise_gains_an_effect_whatever_its_strength(tmp_path):
    """A lost motion of a third of its own size is none in the recordings; what a replicate gains by it does not end there."""
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, PENDULUM, "--duration", "20", "--rate", "250", "--encoder-bits", "16"))
    search = Search(dataset, plain_base(dataset))
    bound, free = (gains.gains_beside(search, [], limits) for limits in (True, False))
    every = [(fit.chosen[0].key, search.plain.excess - fit.excess) for fit in search.beside([], search.gram.candidates, limits=False)]
    for key in {key for key, _ in every}:
        assert free[key] >= max(gain for other, gain in every if other == key) - 1e-6  # more where it is found downhill
        assert free[key] >= bound.get(key, -math.inf) - 1e-6
    assert {key for key, _ in every} - set(bound)


@pytest.mark.parametrize(("hz", "source", "other"), [(9.9, "data", None), (10.0, "data", 5.0), (10.0, "model", 5.0), (6.0, "model", 12.0),
                                                     (3.0, "option", 6.0)])  # fmt: skip
def test_a_verdict_must_hold_at_half_a_low_pass_or_at_twice_of_one_below_10_hz(hz, source, other):
    """Not where the data ask for it, for at twice of that the sensors show."""
    assert lowpass.Lowpass(hz, source).other_hz == other


@pytest.mark.parametrize(("machine", "own", "given", "bias"), [(True, 0.05, -0.9, 0.05), (False, -0.07, -0.85, -0.85), (False, -0.9, 0.02, -0.9),
                                                             (False, None, -0.6, -1.0), (False, 0.3, None, 0.3)])  # fmt: skip
def test_where_the_sensors_left_no_inertia_the_model_as_given_tells_what_they_take(machine, own, given, bias, monkeypatch):
    """A fit that is no machine cannot: its own inertia is what they left."""
    dataset = SimpleNamespace(prior="given", load_sensor=False, velocity_only=False)
    monkeypatch.setattr(lowpass, "machine_bases", lambda dataset: ["own"])
    monkeypatch.setattr(lowpass, "plain_base", lambda dataset: "plain")
    monkeypatch.setattr(lowpass, "has_inertia", lambda dataset, base: machine)
    monkeypatch.setattr(lowpass, "_bias_at", lambda dataset, base, seed: {"own": own, "given": given}[base])
    assert lowpass.inertia_bias(dataset, 1) == bias


def test_a_free_swing_through_a_coarse_encoder_leaves_no_inertia(tmp_path):
    """Hardly any torque is needed, so that inertia and gravity are only told against each other, and the encoder's steps spoil both. The swing
    is SciPy's."""
    t, inertia, gravity = np.arange(0.0, 20.0, 0.002), 0.045, 0.15 * 9.81
    torque = lambda t: 0.02 * (np.sin(2 * math.sqrt(gravity / inertia) * t) + np.sin(3.1 * t) + 0.5 * np.sin(9.7 * t))
    swing = lambda t, x: [x[1], (torque(t) - gravity * math.sin(x[0]) - 0.003 * x[1]) / inertia]
    q = solve_ivp(swing, (0.0, 20.0), [1.2, 0.0], t_eval=t, rtol=1e-9, atol=1e-9).y[0]
    step = 2 * math.pi / 2**9
    np.savetxt(tmp_path / "swing.csv", np.c_[t, step * np.round(q / step), torque(t)], delimiter=",",
               header="time_s,joint_rad,joint_torque_Nm", comments="")  # fmt: skip
    dataset, _ = recorded(PENDULUM, tmp_path, tmp_path / "swing.csv")
    assert lowpass.inertia_bias(dataset, 1) < -thresholds.HALF
    assert lowpass.Lowpass(30.0, "data", lowpass.inertia_bias(dataset, 1)).fixes_inertia is None


@pytest.mark.parametrize(("short", "long", "taken"), [(-0.98, -0.19, True), (-0.98, 0.05, True), (-0.98, -0.6, False), (-0.3, -0.19, False),
                                                      (-0.3, -0.05, True)])  # fmt: skip
def test_longer_windows_count_where_they_leave_the_inertia_or_most_of_what_short_ones_lose(short, long, taken, monkeypatch):
    looks = lowpass.Looks(SimpleNamespace(score=SimpleNamespace(lowpass_hz=30.0)), [], [], {}, [], {})
    monkeypatch.setattr(lowpass, "chosen", lambda look, hz, kept: (lowpass.Lowpass(9.0, "data", long), "long"))
    found, dataset = looks._with_longer_windows(lowpass.Lowpass(13.0, "data", short), "short", 1)
    assert (found.bias, dataset, looks.window_hz) == ((long, "long", 9.0) if taken else (short, "short", 30.0))
    assert found.window_hz == (9.0 if taken else None)


@pytest.mark.parametrize(("times", "within"), [(1.0, False), (3.0, True)])
def test_a_gap_is_within_the_noise_where_that_is_larger(times, within, tmp_path):
    """A spring that is not in the model, beside the recording's own noise and three times of that."""
    hidden = {"effect": "parallel_spring", "joint": "joint",
              "parameters": dict(stiffness_Nm_rad=0.0, stiffening_Nm_rad3=0.03, preload_Nm=0.0, bend_Nm_rad2=0.0, bumper_Nm_rad=0.0,
                                 bumper_rad=0.0, bumper_side=0)}  # fmt: skip
    (tmp_path / "true.yaml").write_text(yaml.safe_dump({**yaml.safe_load(PENDULUM.read_text()), "effects": [hidden]}))
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, tmp_path / "true.yaml", "--duration", "20"))
    dataset.sigma = {kind: times * sigma for kind, sigma in dataset.sigma.items()}
    assert Search(dataset, plain_base(dataset)).is_within_noise() is within


def test_a_column_that_runs_away_explains_nothing(tmp_path):
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, PENDULUM, "--duration", "20"))
    search = Search(dataset, plain_base(dataset))
    runaway = lambda terms: {kind: np.where(np.arange(len(terms.t_s)) < 100, 1.0, np.inf) for kind in dataset.kinds}
    alone, beside = search.gram.held_out([]), search.gram.held_out([runaway])
    assert beside[0] == pytest.approx(alone[0], rel=1e-6) and np.all(np.isfinite(beside[1]))


@pytest.mark.long
def test_coarse_encoders_get_a_slower_low_pass_and_fine_ones_do_not(tmp_path):
    """14 bits at 250 samples a second pull the inertia down by several percent at 30 Hz; 20 bits leave it alone."""
    fine = diagnosed(tmp_path, PENDULUM, bench(tmp_path, PENDULUM, "--duration", "40", "--encoder-bits", "20"), "--quick")
    coarse = diagnosed(tmp_path, PENDULUM, bench(tmp_path, PENDULUM, "--duration", "40", "--encoder-bits", "13"), "--quick")
    assert fine["lowpass"]["hz"] == 30.0 and abs(fine["lowpass"]["inertia_bias"]) < thresholds.RIGHT_TO
    assert coarse["lowpass"]["hz"] < 30.0 and coarse["lowpass"]["from"] == "data"


def test_the_low_pass_is_the_options_or_the_models(tmp_path):
    path = bench(tmp_path, PENDULUM, "--duration", "20")
    assert diagnosed(tmp_path, PENDULUM, path, "--quick", "--lowpass", "12")["lowpass"]["hz"] == 12.0
    scored = tmp_path / "scored.yaml"
    scored.write_text(PENDULUM.read_text() + "score: {lowpass_hz: 18}\n")
    found = diagnosed(tmp_path, scored, path, "--quick")["lowpass"]
    assert (found["hz"], found["from"]) == (18.0, "model")


@pytest.mark.long
def test_the_low_pass_of_the_option_does_what_the_model_files_does(tmp_path):
    """Windows of the motion and identification follow it, too."""
    path = bench(tmp_path, PENDULUM, "--duration", "20", "--encoder-bits", "13")
    scored = tmp_path / "scored.yaml"
    scored.write_text(PENDULUM.read_text() + "score: {lowpass_hz: 8}\n")
    given, asked = diagnosed(tmp_path, scored, path), diagnosed(tmp_path, PENDULUM, path, "--lowpass", "8")
    assert (given["lowpass"].pop("from"), asked["lowpass"].pop("from")) == ("model", "option")
    assert given == asked


@pytest.mark.parametrize("fault", ["score: 18\n", "score: [1\n", "\0\n"])
def test_a_low_pass_beside_a_model_file_with_a_fault_is_refused_by_its_reader(fault, tmp_path):
    path = bench(tmp_path, PENDULUM, "--duration", "5")
    scored = tmp_path / "scored.yaml"
    scored.write_text(PENDULUM.read_text() + fault)
    done = run("talus-gap", "--model", scored, "--report", tmp_path / "g.json", "--lowpass", "8", path, status=2)
    assert f"{scored}:" in done.stderr


def looks_of(model, folder, path):
    options = command.Options(["-m", str(model), "-r", str(folder / "gap.json"), str(path)])
    options.check()
    given, names, recordings, _ = command.read(options)
    with command.identifying(options) as found:
        _, tree = found()
    return lowpass.Looks(given, recordings, names, tree, lowpass.processed_at(given, recordings, names, given.score.lowpass_hz), EFFECTS)


@pytest.mark.long
def test_windows_grow_where_no_low_pass_leaves_the_inertia_alone(tmp_path):
    """12 bits at 250 samples a second: through windows of a thirtieth of a second more than a tenth of what talus-sim moved is
    lost at any low-pass, through longer ones it is there."""
    path = bench(tmp_path, PENDULUM, "--duration", "20", "--rate", "250", "--encoder-bits", "12")
    true = talus.Model.read(PENDULUM).parameters["inertia_kg_m2"]
    looks = looks_of(PENDULUM, tmp_path, path)
    short = [(abs(lowpass.inertia_bias(looks.at(hz), 1)), plain_base(looks.at(hz))[0]) for hz in (20.0, 10.0, 6.0)]
    assert min(bias for bias, _ in short) > thresholds.GIVES_UP
    assert all(abs(inertia / true - 1) > thresholds.GIVES_UP for _, inertia in short)
    through, dataset = looks_of(PENDULUM, tmp_path, path).first(None, 1)
    assert through.fixes_inertia and dataset.processed_recordings[0].window_hz == through.window_hz < looks.window_hz
    assert plain_base(dataset)[0] == pytest.approx(true, rel=thresholds.GIVES_UP)


def test_longer_windows_are_said_and_the_option_that_identifies_with_them(tmp_path):
    path = bench(tmp_path, PENDULUM, "--duration", "20", "--rate", "250", "--encoder-bits", "12")
    report, page = tmp_path / "gap.json", tmp_path / "gap.html"
    done = run("talus-gap", "--quiet", "--model", PENDULUM, "--report", report, "--html", page, "--quick", path)
    grown = json.loads(report.read_text())["lowpass"]["window_hz"]
    assert f"`--lowpass {grown:.3g}`" in done.stderr and "shorter ones lose more to steps and noise" in page.read_text()
    fine = diagnosed(tmp_path, PENDULUM, bench(tmp_path, PENDULUM, "--duration", "20", "--encoder-bits", "20"), "--quick")
    assert fine["lowpass"]["window_hz"] is None


@pytest.mark.parametrize(("bias", "left", "nothing"), [
    (lowpass.ALL_OF_IT, 0.0, True), (-0.9, 0.9, True), (0.6, 0.6, True), (-0.9, 0.4, False), (-0.4, 0.9, False), (None, 0.9, False)])  # fmt: skip
def test_nothing_is_told_where_sensors_take_most_of_the_inertia_and_the_model_leaves_most_of_the_torque(bias, left, nothing):
    assert lowpass.Lowpass(30.0, "data", bias, left=left).nothing_left is nothing


def test_a_slider_of_which_its_steps_leave_nothing_is_withheld(tmp_path):
    """At 12 bits and 250 Hz it was `unknown` with 0.94, and nothing is hidden."""
    found = diagnosed(tmp_path, SLIDER, bench(tmp_path, SLIDER, "--duration", "20", "--rate", "250", "--encoder-bits", "12", "--seed", "3"), "--quick")
    assert found["verdict"]["withheld"] and found["findings"][0]["id"] == "coarse"
    assert "the identified mass comes out" in found["findings"][0]["evidence"] and "of the measured force" in found["findings"][0]["evidence"]


def test_what_the_plain_model_leaves_is_numpys(tmp_path):
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, PENDULUM, "--duration", "20", "--rate", "250", "--encoder-bits", "16"))
    [channel], [processed] = dataset.channels, dataset.processed_recordings
    x, y = processed.x[0][channel.rows], processed.target[0][channel.rows]
    left = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    assert lowpass.share_left(dataset) == pytest.approx(np.sqrt(np.mean(left**2) / np.mean(y**2)), rel=1e-3)


def test_noise_is_not_twice_what_the_model_leaves(tmp_path):
    """What is foretold is motion. The bound is white noise's, through the low-pass."""
    dataset, _ = recorded(PENDULUM, tmp_path, bench(tmp_path, PENDULUM, "--duration", "12", "--rate", "250"))
    before = dataset.sigma["T0"]
    through = math.sqrt(dataset.bandwidth[0])
    for share, kept in ((0.6, 1.0), (0.4, 0.4)):
        dataset.find_sigma(lambda channel, share=share: np.full(len(channel.values), share * before * through))
        assert dataset.sigma["T0"] == pytest.approx(kept * before, rel=1e-9)


def test_a_low_pass_that_is_no_frequency_is_refused(tmp_path):
    done = run("talus-gap", "--model", PENDULUM, "--report", tmp_path / "g.json", "--lowpass", "fast", "x.csv", status=2)
    assert "--lowpass: expected a frequency" in done.stderr


# ---- verdicts --------------------------------------------------------------------------


@pytest.mark.parametrize(("model", "options"), [
    pytest.param(PENDULUM, (), marks=pytest.mark.long),
    pytest.param(PENDULUM, ("--rate", "200", "--encoder-bits", "16", "--excitation", "paper", "--fit"), marks=pytest.mark.long),
    pytest.param(LEG, ("--rate", "125", "--duration", "60"), marks=pytest.mark.long),
    pytest.param(LEG, ("--rate", "100", "--encoder-bits", "16", "--duration", "60"), marks=pytest.mark.long),
], ids=["pendulum", "pendulum-series", "leg-125", "leg-100"])  # fmt: skip
def test_a_bench_that_hides_nothing_is_none(model, options, tmp_path):
    """Each of these named a cause, or none that is known, before replicates were there."""
    found = diagnosed(tmp_path, model, bench(tmp_path, model, "--duration", "60", "--seed", "7", *options))
    assert found["verdict"]["effect"] == "none" and found["effects"] == []
    assert found["calibrated"] and found["replicates"] >= gains.FEWEST


@pytest.mark.long
def test_what_is_found_downhill_is_looked_for_in_the_replicates_as_well(tmp_path):
    """Lost motion, refined from a shape that is too little of it, gains 12,000 of chi-square here: in the replicates, too."""
    options = ("--rate", "200", "--encoder-bits", "16", "--duration", "60", "--seed", "110", "--fit")
    found = diagnosed(tmp_path, PENDULUM, bench(tmp_path, PENDULUM, *options))
    assert found["verdict"]["effect"] == "none" and found["verdict"]["probability"] > 0.5
    largest = found["nearest"][0]
    assert largest["replicates"] > 0.5 * largest["gain"]


def test_the_low_pass_is_one_whose_band_the_windows_keep(tmp_path):
    """A polynomial of order 5 needs seven samples: 65 ms at 100 Hz, with the half sample by which windows are wider."""
    for rate, hz in ((100, 100 / 6.5), (250, 30.0)):
        path = bench(tmp_path, LEG, "--rate", str(rate), "--duration", "20", "--jitter", "0", "--encoder-bits", "0", "--ankle-bits", "0")
        assert diagnosed(tmp_path, LEG, path, "--quick")["lowpass"]["hz"] == pytest.approx(hz, rel=1e-3)


def test_quick_has_no_replicates_and_says_so(tmp_path):
    found = diagnosed(tmp_path, PENDULUM, bench(tmp_path, PENDULUM, "--duration", "20"), "--quick")
    assert found["calibrated"] is False and found["replicates"] == 0


def test_an_effect_has_an_interval_and_what_it_closes(tmp_path):
    """A spring beside the joint, seen by exact encoders."""
    model = tmp_path / "spring.yaml"
    model.write_text(PENDULUM.read_text() + "effects:\n  - {effect: parallel_spring, joint: joint, parameters: "
                     "{stiffness_Nm_rad: 0.9, stiffening_Nm_rad3: 0, preload_Nm: 0}}\n")  # fmt: skip
    found = diagnosed(tmp_path, PENDULUM, bench(tmp_path, model, "--duration", "40", "--encoder-bits", "0"))
    (effect,) = found["effects"]
    assert effect["effect"] == "parallel_spring" and effect["closes"]["joint"] > 0.9
    assert set(effect["interval"]) <= set(effect["parameters"])
    for name, (low, high) in effect["interval"].items():
        assert low <= effect["parameters"][name] <= high
    assert found["lowpass"]["stable"] is True


def test_python_is_the_same_library():
    assert talus.diagnosis.calibration.gains is gains
