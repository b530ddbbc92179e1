"""talus/experimental/excitation.h against sums written out in NumPy, brute force and calculus."""

import math

import numpy as np
import pytest
from leg_example import leg
from scipy import optimize, stats
from talus import TalusError, check, constants, ffi, lib, pointer

POSITION_LOW, POSITION_HIGH, SPEED, ACCELERATION, TORQUE = range(constants.TL_QUANTITIES)
INF = math.inf


def pendulum(moment=1.5):
    m = ffi.new("tl_model *")
    check(lib.tl_model_init(m, lib.TL_PLANT_PENDULUM))
    m.inertia_kg_m2, m.gravity_moment_kg_m, m.drive[0].torque_constant_Nm_A = 0.4, moment, 0.1
    m.drive[0].coulomb_Nm, m.drive[0].viscous_Nms_rad = 0.7, 0.3
    return m


def paper(joints=2):
    e = ffi.new("tl_excitation *")
    check(lib.tl_excitation_paper(e, joints))
    return e


def multisine(joints=2, model=None, **settings):
    e = ffi.new("tl_excitation *")
    s = ffi.new("tl_multisine_settings *", lib.tl_multisine_defaults(model or leg()))
    for name, value in settings.items():
        setattr(s, name, value)
    check(lib.tl_excitation_multisine(e, joints, s))
    return e


def ramps(joints=2, model=None, **settings):
    e = ffi.new("tl_excitation *")
    s = ffi.new("tl_ramp_settings *", lib.tl_ramp_defaults(model or leg()))
    for name, value in settings.items():
        setattr(s, name, value)
    check(lib.tl_excitation_ramps(e, joints, s))
    return e


def motion(e, t):
    """q, v, a of shape (3, joints, n)"""
    at, out = ffi.new("tl_motion *"), []
    for instant in t:
        lib.tl_excitation_at(e, instant, at)
        out.append([list(at.q)[: e.joints], list(at.v)[: e.joints], list(at.a)[: e.joints]])
    return np.moveaxis(np.array(out), 0, -1)


def series(e, t):
    """(14) written out, and its derivatives, for the joints of e."""
    i = np.arange(1, e.harmonics + 1)[:, None]
    w = 2 * np.pi * e.base_hz * i
    s, c = np.sin(w * t), np.cos(w * t)
    out = []
    for j in range(e.joints):
        a = np.array(list(e.sine[j])[: e.harmonics])[:, None]
        b = np.array(list(e.cosine[j])[: e.harmonics])[:, None]
        q = e.offset[j] + (a * s + b * c).sum(0)
        out.append([q, (w * (a * c - b * s)).sum(0), (-w * w * (a * s + b * c)).sum(0)])
    return np.moveaxis(np.array(out), 0, 1)


def peaks(m, e, limits=None):
    limits = limits or no_limits()
    out = ffi.new("tl_peak[]", constants.TL_MAX_PEAKS)
    lib.tl_excitation_peaks(m, limits, e, out)
    return [out[k] for k in range(e.joints * constants.TL_QUANTITIES)], out


def no_limits():
    return ffi.new("tl_limits[2]", [lib.tl_limits_none(), lib.tl_limits_none()])


def limits_of(joint=0, **values):
    limits = no_limits()
    for name, value in values.items():
        setattr(limits[joint], name, value)
    return limits


def broken(m, limits, e):
    out, n = ffi.new("tl_peak[]", constants.TL_MAX_PEAKS), ffi.new("int *")
    check(lib.tl_excitation_check(m, limits, e, out, n))
    return [out[k] for k in range(n[0])], out


def fit(m, limits, e):
    scaling = ffi.new("tl_scaling *")
    check(lib.tl_excitation_fit(m, limits, e, scaling))
    return scaling


def brute_force(m, e, t):
    """size and value of every quantity on a fine grid: (joints, quantities, n)"""
    q, v, a = motion(e, t)
    torque = np.zeros((2, len(t)))
    full = [np.ascontiguousarray(x) for x in (q, v, a)]
    lib.tl_inverse_batch(m, len(t), *map(pointer, full), ffi.NULL, pointer(torque))
    values = np.array([[q[j], q[j], v[j], a[j], torque[j]] for j in range(e.joints)])
    sizes = np.abs(values)
    sizes[:, POSITION_LOW], sizes[:, POSITION_HIGH] = -values[:, 0], values[:, 1]
    return sizes, values


# ---- the series -------------------------------------------------------------------


def test_series_is_the_printed_sum():
    rng = np.random.default_rng(3)
    e = paper()
    e.harmonics, e.base_hz, e.offset = 32, 0.37, [0.3, -0.2]
    for j in range(2):
        e.sine[j], e.cosine[j] = rng.normal(size=32).tolist(), rng.normal(size=32).tolist()
    t = rng.uniform(0, 50, 400)
    got, expected = motion(e, t), series(e, t)
    w = 2 * np.pi * 0.37 * np.arange(1, 33)
    scale = [np.sum(w**k) for k in range(3)]
    # the argument itself carries a rounding of 2 pi 0.37 t
    for k in range(3):
        assert np.abs(got[k] - expected[k]).max() < 1e-11 * scale[k] * 3


def test_series_keeps_its_phase_for_days():
    e = multisine(fade_s=0.0)
    whole = 4.0 * 21600 * np.arange(1, 4)  # whole periods, days apart
    t = np.array([0.3, 1.7, 3.1])
    w = 2 * np.pi * e.base_hz * np.arange(1, e.harmonics + 1)
    size = np.hypot(list(e.sine[0]), list(e.cosine[0]))[: e.harmonics]
    apart = np.abs(motion(e, whole + t) - motion(e, t))
    for k in range(3):  # such times are known to 2^-36 s
        assert apart[k].max() < 2.0**-35 * np.sum(size * w ** (k + 1))


def test_papers_series_asks_for_what_the_paper_does_not_say():
    e = paper()
    t = np.linspace(0, 0.4, 400001)
    q, v, a = series(e, t)
    assert e.base_hz == 2.5 and e.harmonics == 5
    # equations.md: 2,926 rad/s^2 at the knee and 1,463 at the ankle
    assert abs(np.abs(a[0]).max() - 2926) < 1 and abs(np.abs(a[1]).max() - 1463) < 1
    found, _ = peaks(leg(), e)
    for p in found:
        if p.quantity == ACCELERATION:
            assert abs(p.peak) == pytest.approx(np.abs(a[p.joint]).max(), rel=1e-9)
        if p.quantity == SPEED:
            assert abs(p.peak) == pytest.approx(np.abs(v[p.joint]).max(), rel=1e-9)


def test_fade_begins_at_rest_and_ends_in_the_series():
    e = multisine(fade_s=2.0)
    begin = motion(e, [-1.0, 0.0])
    for j in range(2):
        assert np.all(begin[0, j] == e.offset[j]) and np.all(begin[1:, j] == 0)
    t = np.linspace(2.0, 9.0, 100)
    assert np.abs(motion(e, t) - series(e, t)).max() < 1e-11
    # no jump at the fade's two ends: its acceleration starts and ends at 0
    for at in (0.0, 2.0):
        before, behind = motion(e, [at - 1e-9, at + 1e-9]).transpose(2, 0, 1)
        assert np.abs(before - behind).max() < 1e-6


@pytest.mark.parametrize("make", [lambda: multisine(fade_s=2.0), lambda: ramps(), lambda: ramps(hold_s=0.0)])
def test_velocity_and_acceleration_are_the_derivatives(make):
    e, h = make(), 1e-5
    # away from a ramp's corners, where the acceleration jumps
    corners = np.array([x for k in range(e.moves) for m in [e.move[k]] for x in (
        m.begin_s, m.begin_s + m.ramp_s, m.begin_s + m.duration_s - m.ramp_s, m.begin_s + m.duration_s)] or [-9.0])  # fmt: skip
    t = np.random.default_rng(1).uniform(0.01, min(lib.tl_excitation_length_s(e), 60), 3000)
    t = t[np.abs(t[:, None] - corners).min(1) > 2 * h]
    q, v, a = motion(e, t)
    ahead, back = motion(e, t + h), motion(e, t - h)
    assert np.abs((ahead[0] - back[0]) / (2 * h) - v).max() < 1e-6
    assert np.abs((ahead[1] - back[1]) / (2 * h) - a).max() < 1e-6


# ---- multisines -------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0])
def test_multisine_has_its_spectrum_and_fills_its_range(exponent):
    e = multisine(exponent=exponent, harmonics=12, base_hz=0.5, centre=[0.2, -0.1], amplitude=[0.5, 0.25], seed=7)
    t = np.arange(4096) / 4096 * 2.0
    q = series(e, t)[0]
    for j in range(2):
        amplitude = 2 * np.abs(np.fft.rfft(q[j]))[:14] / 4096
        shape = amplitude[1:13] * np.arange(1, 13) ** exponent
        assert np.ptp(shape) < 1e-12 * shape.max() and amplitude[13] < 1e-12
        fine = [optimize.minimize_scalar(lambda x, s=s: s * series(e, np.array([x]))[0][j][0], method="bounded",
                bounds=(t[k] - 1e-3, t[k] + 1e-3), options={"xatol": 1e-12}).fun
                for s, k in ((1, q[j].argmin()), (-1, q[j].argmax()))]  # fmt: skip
        centre, amplitude = ((0.2, 0.5), (-0.1, 0.25))[j]
        assert fine[0] == pytest.approx(centre - amplitude, abs=1e-9)
        assert -fine[1] == pytest.approx(centre + amplitude, abs=1e-9)


def phases(e, joint):
    h = e.harmonics
    return np.arctan2(list(e.sine[joint])[:h], list(e.cosine[joint])[:h])


def test_multisine_realisations():
    one, again, other = multisine(seed=5), multisine(seed=5), multisine(seed=6)
    assert bytes(ffi.buffer(one)) == bytes(ffi.buffer(again))
    assert np.abs(phases(one, 0) - phases(other, 0)).min() > 1e-6
    assert np.abs(phases(one, 0) - phases(one, 1)).min() > 1e-6
    drawn = np.concatenate([phases(multisine(seed=s), j) for s in range(100) for j in range(2)])
    assert stats.kstest(drawn, stats.uniform(-np.pi, 2 * np.pi).cdf).pvalue > 1e-3


@pytest.mark.parametrize("wrong", [{"base_hz": 0.0}, {"base_hz": INF}, {"base_hz": math.nan}, {"harmonics": 0},
                                   {"harmonics": 33}, {"amplitude": [-0.1, 0.1]}, {"amplitude": [math.nan, 0.1]},
                                   {"fade_s": -1.0}, {"exponent": math.nan}, {"centre": [INF, 0.0]}])  # fmt: skip
def test_multisine_refuses(wrong):
    with pytest.raises(TalusError) as refusal:
        multisine(**wrong)
    assert refusal.value.status == lib.TL_ERR_RANGE


# ---- ramps ------------------------------------------------------------------------


def test_ramps_do_what_they_are_for():
    e = ramps()
    length = lib.tl_excitation_length_s(e)
    assert 40 < length < 70
    t = np.arange(0, length, 1e-3)
    q, v, a = motion(e, t)
    s = lib.tl_ramp_defaults(leg())
    # knee alone, ankle alone, both; each at three speeds, both ways, with rest between
    moves = np.abs(v) > 0
    alone = [moves[0] & ~moves[1], moves[1] & ~moves[0]]
    for joint in range(2):
        for speed in s.speed:
            for sign in (1, -1):
                assert np.sum(alone[joint] & (np.abs(v[joint] - sign * speed) < 1e-9)) > 300
    assert np.sum(moves[0] & moves[1]) > 3000 and np.sum(~moves[0] & ~moves[1]) > 3000
    assert np.abs(a).max() == pytest.approx(s.acceleration) and np.abs(v).max() == pytest.approx(max(s.speed))
    for j in range(2):
        assert np.abs(q[j]).max() <= s.amplitude[j] + 1e-12 and np.abs(q[j]).max() > 0.8 * s.amplitude[j]
        # what was travelled is the integral of the speed
        assert np.abs(np.cumsum(v[j]) * 1e-3 - q[j]).max() < 2e-3
    # and it stays where it ends
    end = motion(e, [length + 100.0])
    assert np.abs(end[0]).max() < 1e-15 and np.abs(end[1:]).max() == 0


def test_short_way_never_reaches_the_speed():
    e = ramps(joints=1, model=pendulum(), speed=[10.0, 10.0, 10.0], acceleration=2.0, amplitude=[0.1, 0.0])
    t = np.arange(0, lib.tl_excitation_length_s(e), 1e-4)
    q, v, a = motion(e, t)
    assert np.abs(v[0]).max() == pytest.approx(math.sqrt(0.2 * 2.0), rel=1e-3)  # v^2 = a d over a triangle
    assert np.abs(q[0]).max() == pytest.approx(0.1)


@pytest.mark.parametrize("wrong", [{"speed": [0.1, 0.0, 0.1]}, {"amplitude": [-1.0, 0.0]}, {"travel_s": 0.0},
                                   {"hold_s": -1.0}, {"acceleration": 0.0}, {"acceleration": math.nan}])  # fmt: skip
def test_ramps_refuse(wrong):
    with pytest.raises(TalusError) as refusal:
        ramps(**wrong)
    assert refusal.value.status == lib.TL_ERR_RANGE


@pytest.mark.parametrize("joints", [0, 3, -1])
def test_impossible_joints(joints):
    e = ffi.new("tl_excitation *")
    s, r = lib.tl_multisine_defaults(leg()), lib.tl_ramp_defaults(leg())
    assert lib.tl_excitation_paper(e, joints) == lib.TL_ERR_ARGUMENT
    assert lib.tl_excitation_multisine(e, joints, ffi.new("tl_multisine_settings *", s)) == lib.TL_ERR_ARGUMENT
    assert lib.tl_excitation_ramps(e, joints, ffi.new("tl_ramp_settings *", r)) == lib.TL_ERR_ARGUMENT


@pytest.mark.parametrize("make", [multisine, ramps])
def test_speed_up_is_the_same_way_in_less_time(make):
    e, fast = make(), make()
    lib.tl_excitation_speed_up(fast, 1.7)
    t = np.linspace(0.01, lib.tl_excitation_length_s(e), 500)
    slow_motion, fast_motion = motion(e, t), motion(fast, t / 1.7)
    for k in range(3):
        assert np.abs(fast_motion[k] - 1.7**k * slow_motion[k]).max() < 1e-9


# ---- limits -----------------------------------------------------------------------


@pytest.mark.parametrize("make", [
    *(pytest.param(make, marks=pytest.mark.long) for make in (paper, lambda: multisine(seed=2, fade_s=2.0))), ramps])
def test_peaks_are_those_of_brute_force(make):
    m, e = leg(), make()
    until = lib.tl_excitation_length_s(e) + e.fade_s
    t = np.linspace(0, until, 400001)
    sizes, values = brute_force(m, e, t)
    found, _ = peaks(m, e)
    assert [(p.joint, p.quantity) for p in found] == [(j, k) for j in range(2) for k in range(5)]
    for p in found:
        size = np.abs(p.peak) if p.quantity >= SPEED else (-p.peak if p.quantity == POSITION_LOW else p.peak)
        best, largest = sizes[p.joint, p.quantity].max(), np.abs(values[p.joint, p.quantity]).max()
        # a finer grid may find a little more where friction changes its sign, nothing elsewhere
        assert size > best - (1e-3 if p.quantity == TORQUE else 1e-9) * largest
        at = brute_force(m, e, np.array([p.t_s]))[1][p.joint, p.quantity, 0]
        assert at == pytest.approx(p.peak, abs=1e-12 * largest)  # it is really reached, then


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize("quantity,field", [(POSITION_LOW, "position_low"), (POSITION_HIGH, "position_high"),
                                            (SPEED, "speed"), (ACCELERATION, "acceleration"), (TORQUE, "torque")])  # fmt: skip
def test_check_names_joint_quantity_amount_and_time(joint, quantity, field):
    m, e = leg(), multisine()
    found, _ = peaks(m, e)
    peak = found[joint * 5 + quantity].peak
    assert broken(m, no_limits(), e)[0] == []
    inside, outside = (peak + 1e-6, peak - 0.01) if quantity == POSITION_HIGH else (peak - 1e-6, peak + 0.01)
    if quantity >= SPEED:
        inside, outside = abs(peak) * 1.000001, abs(peak) - 0.01
    assert broken(m, limits_of(joint, **{field: inside}), e)[0] == []
    said, _ = broken(m, limits_of(joint, **{field: outside}), e)
    assert [(b.joint, b.quantity) for b in said] == [(joint, quantity)]
    assert said[0].excess == pytest.approx(0.01, abs=1e-12) and said[0].peak == peak
    assert abs(said[0].peak - said[0].limit) == pytest.approx(0.01, abs=1e-12)
    name = ffi.string(lib.tl_quantity_name(said[0].quantity)).decode()
    assert name == ("position" if quantity < SPEED else field)


def test_check_tells_every_limit_that_breaks():
    limits = ffi.new("tl_limits[2]", [[-0.5, 0.5, 6.0, 80.0, 0.4], [-0.4, 0.4, 6.0, 80.0, 0.05]])
    said, _ = broken(leg(), limits, paper())
    sizes, _ = brute_force(leg(), paper(), np.linspace(0, 0.4, 20001))
    bounds = [[0.5, 0.5, 6.0, 80.0, 0.4], [0.4, 0.4, 6.0, 80.0, 0.05]]
    expected = [(j, k) for j in range(2) for k in range(5) if sizes[j, k].max() > bounds[j][k]]
    assert len(expected) >= 8 and [(b.joint, b.quantity) for b in said] == expected
    for b in said:
        assert b.excess == pytest.approx(sizes[b.joint, b.quantity].max() - bounds[b.joint][b.quantity], rel=1e-3)


def test_check_wants_the_plants_joints():
    n, out = ffi.new("int *", -7), ffi.new("tl_peak[10]")
    assert lib.tl_excitation_check(pendulum(), no_limits(), paper(2), out, n) == lib.TL_ERR_ARGUMENT
    assert lib.tl_excitation_fit(pendulum(), no_limits(), paper(2), ffi.NULL) == lib.TL_ERR_ARGUMENT
    assert n[0] == -7
    assert lib.tl_quantity_name(5) == ffi.NULL


# ---- scaling to fit ---------------------------------------------------------------


def test_what_fits_stays_as_it_is():
    e = multisine()
    before = bytes(ffi.buffer(e))
    s = fit(leg(), no_limits(), e)
    assert bytes(ffi.buffer(e)) == before and list(s.amplitude) == [1, 1] and s.speed == 1


def test_amplitude_gives_way_to_position_only():
    e = multisine(centre=[0.1, 0.0], amplitude=[0.5, 0.3])
    offset = e.offset[0]
    down, up = offset + 0.4, 0.6 - offset  # its range is -0.4 .. 0.6, about the offset
    s = fit(leg(), limits_of(0, position_low=-0.3, position_high=0.45), e)
    assert s.amplitude[0] == pytest.approx(min((offset + 0.3) / down, (0.45 - offset) / up), rel=2e-6)
    assert s.amplitude[1] == 1 and s.speed == 1 and e.offset[0] == offset


@pytest.mark.parametrize("quantity,field,power", [(SPEED, "speed", 1), (ACCELERATION, "acceleration", 0.5)])
def test_speed_and_acceleration_slow_it_down(quantity, field, power):
    m, e = leg(), multisine()
    limit = 0.4 * abs(peaks(m, e)[0][5 + quantity].peak)
    s = fit(m, limits_of(1, **{field: limit}), e)
    assert s.speed == pytest.approx(0.4**power, rel=2e-6) and list(s.amplitude) == [1, 1]
    assert e.base_hz == pytest.approx(0.25 * s.speed) and e.fade_s == pytest.approx(2.0 / s.speed)
    assert broken(m, limits_of(1, **{field: limit}), e)[0] == []


@pytest.mark.parametrize("make", [paper, multisine])
def test_torque_slows_it_down_as_little_as_possible(make):
    m, e = leg(), make()
    at_rest = make()
    lib.tl_excitation_speed_up(at_rest, 1e-3)
    still = [abs(peaks(m, at_rest)[0][j * 5 + TORQUE].peak) for j in range(2)]
    moving = [abs(peaks(m, e)[0][j * 5 + TORQUE].peak) for j in range(2)]
    limits = no_limits()
    for j in range(2):
        limits[j].torque = 0.5 * (still[j] + moving[j])
    s = fit(m, limits, e)
    assert 0.05 < s.speed < 1 and broken(m, limits, e)[0] == []
    lib.tl_excitation_speed_up(e, 1.001)
    assert broken(m, limits, e)[0] != []


def test_papers_series_made_to_fit():
    m, e = leg(), paper()
    limits = ffi.new("tl_limits[2]", [[-0.5, 0.5, 6.0, 80.0, 0.4], [-0.4, 0.4, 6.0, 80.0, 0.05]])
    s = fit(m, limits, e)
    assert broken(m, limits, e)[0] == [] and s.speed < 0.3 and s.amplitude[0] < 0.6
    lib.tl_excitation_speed_up(e, 1.001)
    assert broken(m, limits, e)[0] != []


def test_ramps_made_to_fit():
    m, e = leg(), ramps()
    limits = ffi.new("tl_limits[2]", [[-0.2, 0.2, 0.1, INF, INF], [-0.1, 0.1, 0.1, INF, INF]])
    s = fit(m, limits, e)
    assert broken(m, limits, e)[0] == []
    assert s.amplitude[0] == pytest.approx(0.2 / 0.36, rel=1e-5)
    assert s.amplitude[1] == pytest.approx(0.1 / 0.3, rel=1e-5)


def test_what_cannot_fit_is_said_and_left_alone():
    m, e = pendulum(), multisine(joints=1, model=pendulum())
    before = bytes(ffi.buffer(e))
    # Coulomb friction alone breaks it
    assert lib.tl_excitation_fit(m, limits_of(0, torque=0.6), e, ffi.NULL) == lib.TL_ERR_NO_CONVERGENCE
    # the offset itself is out of range
    low = e.offset[0] + 0.01
    assert lib.tl_excitation_fit(m, limits_of(0, position_low=low), e, ffi.NULL) == lib.TL_ERR_RANGE
    assert bytes(ffi.buffer(e)) == before
