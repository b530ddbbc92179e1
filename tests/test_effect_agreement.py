"""Forward time against recorded motion: an effect simulated, and what its columns say of that very motion. docs/effects.md
shows the table, which this file prints when it is run."""

import math
import pathlib
import re
import tempfile

import numpy as np
import pytest
from leg_example import leg
from scipy.signal import butter, filtfilt
from support import REPOSITORY, run
from talus import check, ffi, lib, pointer
from test_simulate_effects import MODEL, begin, law, model_with, rows
from test_simulate_effects import simulate as record

RATE_HZ, STEP_S, SECONDS, SETTLE_S, TRIM_S = 1000.0, 5e-4, 6.0, 1.5, 0.25
GAINS, DAMPING = (60.0, 15.0), (3.0, 0.8)  # of a position control without steps, N m/rad and N m s/rad
STANDSTILL_RAD_S, GUARD_S, LOWPASS_HZ = 0.008, 0.016, 30.0  # the score's
KNEE, ANKLE, BASE = 0, 1, 2


def reference(t):
    wave = [0.45 * math.sin(2 * math.pi * hz * t + phase) for hz, phase in ((0.31, 0.0), (0.83, 1.0), (1.7, 2.0))]
    return 0.8 * wave[0] + 0.4 * wave[1] + 0.15 * wave[2], 0.35 * wave[0] - 0.5 * wave[1] + 0.2 * wave[2]


def values(name, parameters):
    """All parameters of an effect: those given, the default of those that may be left out, else the typical value."""
    kind, left = lib.tl_effect_find(name.encode()), dict(parameters)
    made = []
    for p in kind.parameter[0:kind.strengths + kind.shapes]:
        usual = p.default_value if p.flags & lib.TL_PARAMETER_OPTIONAL else p.typical
        made.append(left.pop(ffi.string(p.name).decode(), usual))
    assert not left, left
    return made


def joint_torque(m, q, torque):
    out = ffi.new("double[2]")
    lib.tl_joint_torque(m, list(q), list(torque), out)
    return list(out)


def controlled(m):
    def control(t, q, v):
        now, next_ = reference(t), reference(t + 1e-5)
        ratio = joint_torque(m, q, (1.0, 1.0))
        return [(GAINS[j] * (now[j] - q[j]) + DAMPING[j] * ((next_[j] - now[j]) / 1e-5 - v[j])) / ratio[j] for j in (0, 1)]

    return control


def simulate(m, *effects, rate_hz=RATE_HZ):
    """t, the motion (4 x 2 x n: q, v, a, slip) and the own torque of effects (name, joint, parameters) at both joints (2 x n)."""
    s, keep = begin(m, reference(0.0), [0.0, 0.0], *[(effect, at, *values(effect, p)) for effect, at, p in effects])
    control = controlled(m)
    torque, plain = law(control), ffi.new("double[2]")
    t = np.arange(int(SECONDS * rate_hz)) / rate_hz
    motion, own = np.empty((len(t), 4, 2)), np.empty((len(t), 2))
    for i, until in enumerate(t):
        check(lib.tl_simulate(m, torque, ffi.NULL, STEP_S, s, until))
        now = s.motion
        motion[i] = [list(now.q), list(now.v), list(now.a), list(now.slip)]
        lib.tl_inverse(m, ffi.addressof(s, "motion"), plain)
        drive = control(until, list(now.q), list(now.v))
        own[i] = joint_torque(m, now.q, [drive[j] - plain[j] for j in (0, 1)])
    return t, np.ascontiguousarray(motion.transpose(1, 2, 0)), own.T, keep


def predicted(m, t, motion, keep, joint):
    """What the effect's columns say of a joint's torque along the motion."""
    effect, n = keep[0], len(t)
    segment = ffi.new("tl_effect_segment *", {"model": m, "n": n, "t_s": pointer(t)})
    for j in (0, 1):
        segment.q[j], segment.v[j], segment.a[j], segment.slip[j] = (pointer(motion[k, j]) for k in range(4))
    memory, prepared = np.empty(lib.tl_effect_prepared_memory(2, n)), ffi.new("tl_effect_prepared *")
    lib.tl_effect_prepare(prepared, segment, pointer(memory))
    strengths = np.array(list(effect.value)[:effect.kind.strengths])
    shapes = np.array(list(effect.value)[effect.kind.strengths:])
    columns = np.zeros((len(strengths), n))
    wanted = ffi.new("tl_effect_wanted *", {"strengths": (1 << len(strengths)) - 1})
    wanted.shown[joint] = pointer(columns)
    lib.tl_effect_segment_columns(effect.kind, effect.joint, pointer(shapes), 1, prepared, wanted)
    if effect.kind.law and effect.joint in (joint, BASE):
        now, at_once = ffi.new("tl_effect_instant[]", n), np.empty_like(columns)
        lib.tl_effect_instants(segment, joint, now)
        lib.tl_effect_columns_at(effect.kind, pointer(shapes), now, n, pointer(at_once))
        columns += at_once
    return strengths @ columns


def rms(x):
    return float(np.sqrt(np.mean(x**2)))


def difference(effect, at, parameters, rate_hz=RATE_HZ):
    """RMS of prediction less simulation over that of the effect's own torque at its joint, as it is and as the score sees
    it, and the effect's own."""
    m = leg()
    t, motion, own, keep = simulate(m, (effect, at, parameters), rate_hz=rate_hz)
    joint = KNEE if at == BASE else at
    return shares(predicted(m, t, motion, keep, joint) - own[joint], own[joint], t, motion[1, joint])


def shares(off, own, t, v):
    """What is off over the effect's own torque, as it is and as the score sees it, and the effect's own [N m]."""
    rate = (len(t) - 1) / (t[-1] - t[0])
    guarded = np.convolve(np.abs(v) < STANDSTILL_RAD_S, np.ones(2 * int(GUARD_S * rate) + 1), "same") > 0.5
    counts = (t > SETTLE_S) & (t < t[-1] - TRIM_S) & ~guarded
    lowpass = lambda x: filtfilt(*butter(4, 2 * LOWPASS_HZ / rate), x)[counts]
    return rms(off[counts]) / rms(own[counts]), rms(lowpass(off)) / rms(lowpass(own)), rms(own[counts])


def delayed(folder, parameters):
    """A late current as recordings at 250 Hz show it, and as prediction shifts it (torque of the knee's motor)."""
    late = model_with(folder / "late.yaml", "leg", ("delay", "knee", parameters))
    torque = lambda recording: 0.1031 * recording["knee_current_A"]
    plain, motion = record(folder, MODEL["leg"], "--duration", 10)
    said = []
    for model in (late, MODEL["leg"]):
        run("talus-predict", "--model", model, "--out", folder / "p.csv", folder / "r.csv")
        said.append(rows(folder / "p.csv")["knee_motor_torque_Nm"])
    own = torque(record(folder, late, "--duration", 10)[0]) - torque(plain)
    return shares(said[0] - said[1] - own, own, plain["time_s"], motion["knee_velocity_rad_s"])


SOFT = {"share": 1.0, "stiffness_Nm_rad": 500.0, "damping_s": 0.002}
TEETH = {"share": 1.0, "gap_rad": 0.005, "stiffness_Nm_rad": 3000.0}
MOUNT = {"compliance_rad_Nm": 0.0, "frequency_Hz": 8.0, "damping_ratio": 0.05}
DELAY = {"delay_s": 0.004}
# what the table shows, and the bar that its last column keeps [%]
TABLE = [
    ("elasticity", KNEE, SOFT, 2),
    ("elasticity", KNEE, {**SOFT, "soft_rad": 0.003, "soft_share": 0.4}, 2),
    ("elasticity", KNEE, {**SOFT, "friction_share": 0.5}, 2),
    ("elasticity", ANKLE, SOFT, 2),
    ("elasticity", ANKLE, {**SOFT, "stiffness_Nm_rad": 2000.0}, 11),  # sways at 122 Hz: see BETWEEN_SAMPLES
    ("backlash", KNEE, TEETH, 2),
    ("backlash", KNEE, {**TEETH, "friction_share": 0.5}, 2.5),
    ("backlash", KNEE, {**TEETH, "drag_Nm": 0.5}, 2),
    ("backlash", ANKLE, TEETH, 27),  # rattles at 150 Hz: samples do not tell when the teeth meet
    ("base_compliance", BASE, {**MOUNT, "compliance_rad_Nm": 0.0005}, 2.5),  # columns are its first order
    ("base_compliance", BASE, {**MOUNT, "sway_m_N": 2e-5}, 2),
    ("base_compliance", BASE, {**MOUNT, "rise_m_N": 2e-5}, 2),
    ("presliding", KNEE, {"friction_Nm": 0.6, "travel_rad": 0.005}, 2),
    ("presliding", ANKLE, {"friction_Nm": 0.4, "travel_rad": 0.01, "power": 2.0}, 2),
]
# What moves too fast for samples at 1 kHz, at 8 kHz: the laws are the same.
BETWEEN_SAMPLES = [("elasticity", ANKLE, {**SOFT, "stiffness_Nm_rad": 2000.0}, 1), ("backlash", ANKLE, TEETH, 4)]
# laws of the instant that need the accelerations themselves, and ripple: exact but for what second order leaves
EXACT = [
    ("load_friction", ANKLE, {"coefficient": 0.15, "rotor_share": 0.0}, 1e-6),
    ("load_friction", KNEE, {"coefficient": 0.15, "rotor_share": 0.4}, 1e-6),
    ("load_friction", KNEE, {"coefficient": 0.15, "own_coefficient": 0.15}, 1e-6),
    ("directional_efficiency", ANKLE, {"driving": 0.2, "back_driving": 0.05, "rotor_share": 0.3}, 1e-6),
    ("kinematic_error", KNEE, {"sine_Nm": 0.0, "cosine_share": 0.03}, 1e-6),
    ("kinematic_error", KNEE, {"sine_Nm": 0.2, "fades_Hz": 10.0}, 1e-6),
    ("kinematic_error", KNEE, {"sine_Nm": 0.0, "sine_rad": 0.0002}, 0.02),
    ("elasticity", KNEE, {**SOFT, "hardening_Nm_rad3": 1e6}, 0.02),
    ("elasticity", KNEE, {**SOFT, "friction_share": 1.0, "viscous_share": 1.0}, 0.02),
]


def row(effect, at, parameters, shown):
    said = ", ".join(f"`{k}` {v:g}" for k, v in parameters.items() if v != 0.0)
    return f"| `{effect}` | {('knee', 'ankle', 'base')[at]} | {said} | {shown[2]:.2g} | {100 * shown[0]:.1f} | {100 * shown[1]:.1f} |"


def agrees_and_is_said(effect, at, parameters, shown, bar):
    """Within the bar [%] as the score sees it, 2 % but where the reason stands beside it; and docs/effects.md says so."""
    wanted = row(effect, at, parameters, shown)
    head = wanted.rsplit("|", 4)[0] + "|"
    lines = (REPOSITORY / "docs" / "effects.md").read_text().splitlines()
    said = next((line for line in lines if line.startswith(head)), None)
    assert said, f"docs/effects.md lacks\n{wanted}"
    of_page = [float(x) for x in re.findall(r"[\d.]+", said[len(head):])]
    rel = 0.1 if bar < 3 else 0.5  # what rattles depends on the last bits
    assert of_page == pytest.approx([shown[2], 100 * shown[0], 100 * shown[1]], rel=rel, abs=0.11), wanted
    assert 100 * shown[1] <= bar


@pytest.mark.parametrize("effect, at, parameters, bar", TABLE, ids=[f"{e}-{a}-{k}" for k, (e, a, *_) in enumerate(TABLE)])
def test_forward_time_and_recorded_motion_agree(effect, at, parameters, bar):
    agrees_and_is_said(effect, at, parameters, difference(effect, at, parameters), bar)


def test_a_late_current_is_predicted_as_it_is_simulated(tmp_path):
    agrees_and_is_said("delay", KNEE, DELAY, delayed(tmp_path, DELAY), 2)


@pytest.mark.parametrize("effect, at, parameters, bar", BETWEEN_SAMPLES, ids=["elasticity", "backlash"])
def test_what_is_lost_between_samples_is_there_with_more_of_them(effect, at, parameters, bar):
    assert 100 * difference(effect, at, parameters, rate_hz=8000.0)[1] <= bar


def test_both_joints_friction_may_need_its_rotor_at_once():
    """Each joint's friction depends on its own acceleration, and these on each other."""
    m, parameters = leg(), {"coefficient": 0.15, "rotor_share": 0.4}
    t, motion, own, keep = simulate(m, ("load_friction", KNEE, parameters), ("load_friction", ANKLE, parameters))
    for joint in (KNEE, ANKLE):
        off = predicted(m, t, motion, [keep[joint]], joint) - own[joint]
        assert shares(off, own[joint], t, motion[1, joint])[1] < 1e-6


def test_two_sways_of_one_mount_are_predicted_as_their_sum():
    m, modes = leg(), [{**MOUNT, "sway_m_N": 2e-5}, {**MOUNT, "sway_m_N": 1e-5, "frequency_Hz": 11.0}]
    t, motion, own, keep = simulate(m, *[("base_compliance", BASE, mode) for mode in modes])
    said = sum(predicted(m, t, motion, [effect], KNEE) for effect in keep)
    assert shares(said - own[KNEE], own[KNEE], t, motion[1, KNEE])[1] < 0.02


@pytest.mark.parametrize("effect, at, parameters, bar", EXACT, ids=[f"{e}-{k}" for k, (e, *_) in enumerate(EXACT)])
def test_shapes_that_forward_time_and_recorded_motion_share(effect, at, parameters, bar):
    assert difference(effect, at, parameters)[1] < bar


if __name__ == "__main__":
    for case in TABLE:
        print(row(*case[:3], difference(*case[:3])), flush=True)
    with tempfile.TemporaryDirectory() as made:
        print(row("delay", KNEE, DELAY, delayed(pathlib.Path(made), DELAY)))
