"""The controller: its law against tl_inverse and effects, its three scalars against each other, its limits, and what
happens when frames fail. Long sequences run in tests/programs/controller_*.c."""

import subprocess

import numpy
import pytest
from leg_example import leg
from support import BUILD, REPOSITORY
from talus import constants, ffi, lib

KNOTS = constants.TL_CONTROLLER_KNOTS
EFFECTS = """effects:
  - {effect: stribeck, joint: ankle, parameters: {extra_Nm: 0.4, speed_rad_s: 0.1, exponent: 2}}
  - {effect: nonlinear_viscous, joint: ankle, parameters: {size_Nm: 0.02, exponent: 2}}
  - {effect: asymmetric_friction, joint: knee, parameters: {coulomb_Nm: 0.2, viscous_Nms_rad: 0.1}}
  - {effect: load_friction, joint: knee, parameters: {coefficient: 0.1}}
  - {effect: directional_efficiency, joint: ankle, parameters: {driving: 0.15, back_driving: 0.05}}
  - {effect: position_friction, joint: knee, parameters: {slope_Nm_rad: 0.3, bend_Nm_rad2: 0.1}}
  - {effect: parallel_spring, joint: knee, parameters: {stiffness_Nm_rad: 3, stiffening_Nm_rad3: 1, preload_Nm: 0.1}}
  - {effect: gravity_tilt, joint: base, parameters: {tilt_rad: 0.03}}
"""
DRIVES = """effects:
  - {effect: torque_saturation, joint: ankle, parameters: {droop_1_Nm: 0.05, exponent: 1}}
  - {effect: current_offset, joint: ankle, parameters: {torque_Nm: 0.01}}
"""
SCREW = "{type: screw_linkage, lead_m: 0.002, AB_m: 0.090, BO_m: 0.040, AC_m: 0.035, BOF_deg: 84.75}"


def model_file(folder, effects="", ankle=SCREW):
    path = folder / "model.yaml"
    path.write_text((REPOSITORY / "models/leg.yaml").read_text().replace(SCREW, ankle) + effects)
    return path


def run_program(name, *arguments):
    command = [str(BUILD / "tests" / name), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return dict(line.split(maxsplit=1) for line in done.stdout.splitlines())


def states(path, count):
    """{joint: [double - model, float - double, fixed - double, bound]} over the torque limit."""
    printed = run_program("controller_states", path, count, 1)
    assert printed.pop("saturated") == "0"
    return {joint: [float(x) for x in text.split()] for joint, text in printed.items()}


# ---- the law ------------------------------------------------------------------------------


def test_a_million_states_in_three_scalars(tmp_path):
    for model, single, fixed, bound in states(model_file(tmp_path), 1_000_000).values():
        assert model <= 1e-8  # the table of the ratio against its closed form
        assert single <= 2e-6
        assert fixed <= bound <= 1e-4


def test_the_same_with_effects(tmp_path):
    """Double takes effects as curves: the Stribeck bend between knots decides."""
    for model, single, fixed, bound in states(model_file(tmp_path, EFFECTS), 100_000).values():
        assert model <= 1e-5
        assert single <= 2e-6
        assert fixed <= bound <= 1e-4


def prepared(effects=(), change=None):
    """(struct in double, what it lives on), or the status and the index that was refused."""
    model, settings, refused = leg(), ffi.new("tl_controller_settings *"), ffi.new("int *")
    lib.tl_controller_defaults(model, settings)
    if change:
        change(settings)
    list_ = ffi.new("tl_effect[]", max(1, len(effects)))
    for i, (name, joint) in enumerate(effects):
        list_[i] = lib.tl_effect_typical(lib.tl_effect_find(name.encode()), joint)
    c, knot = ffi.new("tl_controller_f64 *"), ffi.new("tl_curve_knot_f64[]", KNOTS)
    status = lib.tl_controller_prepare(c, model, list_, len(effects), settings, knot, refused)
    return (c, knot, settings) if status == lib.TL_OK else (status, refused[0])


FAST = {"stribeck", "load_friction", "asymmetric_friction", "nonlinear_viscous", "position_friction", "gravity_tilt"}
FAST |= {"directional_efficiency", "torque_saturation", "current_offset", "parallel_spring", "linkage_error"}


def test_every_effect_is_in_it_or_refused_by_its_place():
    n = ffi.new("int *")
    table, model = lib.tl_effect_table(n), leg()
    for i in range(n[0]):
        name = ffi.string(table[i].name).decode()
        for joint in (0, 1, 2):
            if not lib.tl_effect_applies(table[i], model, joint):
                continue
            result = prepared([("stribeck", 0), (name, joint)])
            if name in FAST:
                assert len(result) == 3, (name, joint, result)
            else:
                assert result == (lib.TL_ERR_UNSUPPORTED, 1), (name, joint)


SETTINGS = [("tick_s", 0.0), ("decay_ticks", 17), ("stale_ticks", -1), ("recover_ticks", 0)]
JOINT_SETTINGS = [("current_limit_A", 0.0), ("rate_Nm_s", 1.0), ("high_rad", 0.6), ("low_rad", 0.7), ("fade_rad", 0.0)]
JOINT_SETTINGS += [("friction_share", 1.1), ("speed_limit_rad_s", 33.0), ("power_limit_W", float("nan"))]


@pytest.mark.parametrize(("name", "value"), [*SETTINGS, *JOINT_SETTINGS])
def test_settings_that_cannot_hold_are_refused(name, value):
    def change(settings):
        setattr(settings.joint[1] if (name, value) in JOINT_SETTINGS else settings, name, value)

    assert prepared(change=change) == (lib.TL_ERR_RANGE, -1)


def test_other_plants_are_refused():
    model, refused = leg(), ffi.new("int *")
    settings, c = ffi.new("tl_controller_settings *"), ffi.new("tl_controller_f64 *")
    lib.tl_controller_defaults(model, settings)
    model.form = lib.TL_FORM_PAPER
    knot = ffi.new("tl_curve_knot_f64[]", KNOTS)
    assert lib.tl_controller_prepare(c, model, ffi.NULL, 0, settings, knot, refused) == lib.TL_ERR_UNSUPPORTED


# ---- ticks --------------------------------------------------------------------------------


class Loop:
    """The controller in double, fed frame by frame."""

    def __init__(self, **how):
        self.c, *self.keep = prepared(**how)
        self.state, self.count = ffi.new("tl_controller_state_f64 *"), 0
        lib.tl_controller_start_f64(self.state)

    def tick(self, q=(0.2, 0.1), v=(0.0, 0.0), a=(0.0, 0.0), new=True, enable=1, measured=None):
        self.count += new
        frame = {"angle_rad": q, "speed_rad_s": v, "acceleration": a, "count": self.count}
        seen = frame if measured is None else {**frame, **measured}
        into, out = ffi.new("tl_controller_input_f64 *", (frame, seen, enable)), ffi.new("tl_controller_output_f64 *")
        lib.tl_controller_tick_f64(self.c, self.state, into, out)
        return out

    def warm(self, ticks=80, **how):
        for _ in range(ticks):
            out = self.tick(**how)
        return out


def test_comes_in_gently_and_then_is_the_law():
    loop = Loop()
    first = [loop.tick() for _ in range(50)]
    assert all(out.torque_Nm[0] == 0.0 and out.status == lib.TL_CONTROLLER_ZERO for out in first)
    risen = [abs(loop.tick().torque_Nm[0]) for _ in range(16)]
    assert (numpy.diff(risen[:15]) > 0).all() and risen[15] == risen[14]
    torque, parts = ffi.new("double[2]"), ffi.new("tl_controller_parts_f64 *")
    lib.tl_controller_torque_f64(loop.c, ffi.addressof(loop.state.desired), torque, parts)
    out = loop.tick()
    assert out.status == 0 and list(out.torque_Nm) == list(torque)
    assert out.current_A[0] == pytest.approx(torque[0] / 0.1031, rel=1e-15)
    assert out.parts.gravity_Nm[0] == parts.gravity_Nm[0] != 0.0


@pytest.mark.parametrize(("how", "bit"), [
    ({"new": False}, lib.TL_CONTROLLER_STALE_MEASURED), ({"enable": 0}, lib.TL_CONTROLLER_STOPPED),
    ({"v": (float("nan"), 0.0)}, lib.TL_CONTROLLER_IMPOSSIBLE), ({"q": (0.5, 0.1)}, lib.TL_CONTROLLER_JUMP),
    ({"measured": {"angle_rad": (0.2005, 0.1), "speed_rad_s": (0.6, 0.0)}}, lib.TL_CONTROLLER_FROZEN),
])  # fmt: skip
def test_a_fault_is_named_and_torque_is_zero_within_20_ms(how, bit):
    loop = Loop()
    assert loop.warm().torque_Nm[0] != 0.0
    for k in range(1, 6) if bit == lib.TL_CONTROLLER_FROZEN else ():  # to a speed that it reaches without a jump
        loop.tick(measured={"angle_rad": (0.2 + k * 1e-4, 0.1), "speed_rad_s": (0.12 * k, 0.0)})
    seen = 0
    for _ in range(20):
        out = loop.tick(**how)
        seen |= out.status
    assert seen & bit
    assert out.torque_Nm[0] == out.torque_Nm[1] == out.current_A[0] == 0.0


def test_one_lost_frame_changes_nothing():
    loop = Loop()
    before = loop.warm().torque_Nm[0]
    assert [loop.tick(new=False).torque_Nm[0] for _ in range(4)] == [before] * 4
    assert loop.tick().torque_Nm[0] == before


def test_comes_in_where_frames_come_every_other_tick():
    """Sender and receiver have clocks of their own: ticks without a new frame count neither for nor against it."""
    loop = Loop()
    out = [loop.tick(new=tick % 2 == 0) for tick in range(120)]
    assert out[97].torque_Nm[0] == 0.0 and out[-1].torque_Nm[0] == Loop().warm().torque_Nm[0] != 0.0
    loop.tick(enable=0)
    for tick in range(200):  # a frame that is refused begins the count anew, and one in 50 is
        out = loop.tick(v=(float("nan") if tick % 40 == 20 else 0.0, 0.0))
    assert out.torque_Nm[0] == pytest.approx(14 / 15 * Loop().warm().torque_Nm[0])


def test_fades_towards_a_stop_and_not_away_from_it():
    """Near the knee's upper stop gravity asks for torque away from it; a desired acceleration towards it."""
    loop = Loop()
    out = loop.warm(q=(1.98, 0.0), a=(100.0, 0.0))
    torque, parts = ffi.new("double[2]"), ffi.new("tl_controller_parts_f64 *")
    lib.tl_controller_torque_f64(loop.c, ffi.addressof(loop.state.desired), torque, parts)
    assert torque[0] > 0.0 and out.torque_Nm[0] == pytest.approx(torque[0] * 0.02 / 0.05, rel=1e-9)
    assert out.status == lib.TL_CONTROLLER_JOINT_LIMIT
    out = Loop().warm(q=(-1.98, 0.0), a=(100.0, 0.0))
    assert out.torque_Nm[0] > 0.0 and not out.status & lib.TL_CONTROLLER_JOINT_LIMIT


def test_friction_fades_around_standstill():
    loop = Loop()
    speeds = numpy.linspace(-0.1, 0.1, 41)
    torque, parts, friction = ffi.new("double[2]"), ffi.new("tl_controller_parts_f64 *"), []
    for v in speeds:
        lib.tl_controller_torque_f64(loop.c, ffi.new("tl_controller_frame_f64 *", {"speed_rad_s": (v, 0.0)}), torque, parts)
        friction.append(parts.friction_Nm[0])
    expected = 1.2 * numpy.clip(speeds / 0.05, -1, 1) + 0.45 * speeds
    assert friction == pytest.approx(expected, abs=1e-15)


def driven(model, loop, creep_rad_s, seconds=3.0):
    """Speeds of both joints after each tick, from a push: feedforward and a drive's position control, whose set-points creep from a
    pose. Steps of 50 us; friction smooth below 1 mrad/s."""
    motion, torque, speed = ffi.new("tl_motion *", {"q": (0.25, 0.1)}), ffi.new("double[2]"), []
    ratio, slope = ffi.new("double *"), ffi.new("double *")
    for tick in range(round(1000 * seconds)):
        wanted = [at + 1e-3 * tick * v for at, v in zip((0.2, 0.1), creep_rad_s, strict=True)]
        out = loop.tick(q=wanted, v=creep_rad_s, measured={"angle_rad": tuple(motion.q), "speed_rad_s": tuple(motion.v)})
        for _ in range(20):
            for j, (p, d) in enumerate(((60.0, 3.0), (20.0, 0.6))):
                motion.slip[j] = numpy.tanh(motion.v[j] / 1e-3)
                lib.tl_transmission_ratio(ffi.addressof(model.drive[j], "transmission"), motion.q[j], ratio, slope)
                feedback = p * (wanted[j] - motion.q[j]) + d * (creep_rad_s[j] - motion.v[j])
                torque[j] = out.torque_Nm[j] + feedback / ratio[0]
            assert lib.tl_forward(model, torque, motion) == lib.TL_OK
            for j in range(2):
                motion.v[j] += 5e-5 * motion.a[j]
                motion.q[j] += 5e-5 * motion.v[j]
        speed.append(tuple(motion.v))
    return numpy.array(speed)


@pytest.mark.parametrize("of_model", [0.7, 0.0])
@pytest.mark.parametrize("creep_rad_s", [(0.0, 0.0), (0.03, -0.02)])
def test_no_limit_cycle_with_less_friction_than_the_model(of_model, creep_rad_s):
    """At the default share, the true friction 30 % below the model's, and none at all: a leg that was pushed comes to rest, and where
    it creeps, in the speeds over which compensation fades, it goes evenly."""
    model = leg()
    for j in range(2):
        model.drive[j].coulomb_Nm *= of_model
        model.drive[j].viscous_Nms_rad *= of_model
    late = driven(model, Loop(), creep_rad_s)[2000:]
    assert numpy.abs(late - creep_rad_s).max() <= 1e-3


EVERY = sum(1 << k for k in range(12))  # of the status, but for SATURATED
FIXED = "{type: fixed, ratio: -60}"


@pytest.mark.parametrize(("effects", "ankle", "sequences", "current_A"), [
    ("", SCREW, 4_000, 20), ("", SCREW, 3_000, 3), (EFFECTS, SCREW, 1_000, 20), (DRIVES, SCREW, 1_000, 5), ("", FIXED, 1_000, 20),
])  # fmt: skip
def test_fault_sequences(tmp_path, effects, ankle, sequences, current_A):
    """Torque, rate, power, current and decay over random faults in all scalars: tests/programs/controller_faults.c."""
    played = run_program("controller_faults", model_file(tmp_path, effects, ankle), sequences, 1, current_A)
    seen = int(played.pop("seen"))
    assert all(int(n) > sequences / 3 for n in played.values()) and len(played) == 13
    unseen = {20: lib.TL_CONTROLLER_TORQUE_LIMIT, 3: lib.TL_CONTROLLER_POWER_LIMIT}  # too strong a drive, too weak a one
    if not effects and ankle == SCREW:
        assert seen | unseen[current_A] == EVERY, f"{seen:b}"


def test_saturation_is_flagged():
    """A struct that no model gives: gravity and friction at the format's end."""
    c, *_keep = prepared()
    q, knot = ffi.new("tl_controller_q31 *"), ffi.new("tl_curve_knot_q31[]", KNOTS)
    assert lib.tl_controller_to_q31(c, knot, q) == lib.TL_OK
    state, out = ffi.new("tl_controller_state_q31 *"), ffi.new("tl_controller_output_q31 *")
    lib.tl_controller_start_q31(state)
    frame = {"angle_rad": (2**29, 0), "speed_rad_s": (2**25, 0), "count": 1}
    lib.tl_controller_tick_q31(q, state, ffi.new("tl_controller_input_q31 *", (frame, frame, 1)), out)
    assert not out.status & lib.TL_CONTROLLER_SATURATED
    q.joint[0].dry_Nm = q.gravity_shank = 2**31 - 1
    lib.tl_controller_tick_q31(q, state, ffi.new("tl_controller_input_q31 *", (frame, frame, 1)), out)
    assert out.status & lib.TL_CONTROLLER_SATURATED and out.torque_Nm[0] == 0


def test_a_table_that_no_model_gives_is_flagged():
    c, *_keep = prepared()
    q, knot = ffi.new("tl_controller_q31 *"), ffi.new("tl_curve_knot_q31[]", KNOTS)
    assert lib.tl_controller_to_q31(c, knot, q) == lib.TL_OK
    frame, torque, parts = ffi.new("tl_controller_frame_q31 *"), ffi.new("int32_t[2]"), ffi.new("tl_controller_parts_q31 *")
    saturated = ffi.new("uint32_t *")
    for rise, expected in ((knot[0].rise, 0), (2**31 // 11, 1), (-(2**31), 1)):
        for i in range(q.joint[1].ratio.n):
            knot[i].rise = rise if expected else knot[i].rise
        lib.tl_controller_torque_q31(q, frame, torque, parts, saturated)
        assert saturated[0] == expected


def test_an_inverse_with_other_knots_is_left_out():
    """No model gives one: then 1 / ratio is its scale alone, and nothing is read beside its table."""
    c, *_keep = prepared()
    at, torque, parts = ffi.new("tl_controller_frame_f64 *"), ffi.new("double[2]"), ffi.new("tl_controller_parts_f64 *")
    at.angle_rad = (0.2, 0.1)
    c.joint[1].inverse.n -= 1
    lib.tl_controller_torque_f64(c, at, torque, parts)
    at_joint = parts.inertia_Nm[1] + parts.gravity_Nm[1] + parts.friction_Nm[1]
    assert torque[1] == at_joint * c.joint[1].inverse_scale
    for kind in ("f32", "q31"):
        assert law(c, kind, (0.2, 0.1))[0][1] == pytest.approx(torque[1], rel=1e-5)


def test_tables_keep_their_ends():
    """A spring's torque beyond the knee's range, and what the ankle's ratio makes of gravity beyond its own."""
    c, *_keep = prepared([("parallel_spring", 0)])
    for kind in ("f64", "f32", "q31"):
        for side in (-1, 1):
            near, far = (law(c, kind, (side * q, 0.0))[1] for q in (2.1, 2.5))
            assert far == pytest.approx(near, rel=1e-5) and abs(far) > 1.0
            near, far = (law(c, kind, (side * (1.5 - q), side * q))[0][1] for q in (0.6, 0.7))  # the foot's angle stays
            assert far == pytest.approx(near, rel=1e-4) and far != 0.0


def law(c, kind, angle):
    """(motor torques, the knee's effects) [Nm] of a pose in a scalar."""
    c_of, knot = (ffi.new(f"{name}_{kind}{more}") for name, more in (("tl_controller", " *"), ("tl_curve_knot", f"[{KNOTS}]")))
    frame, parts = ffi.new(f"tl_controller_frame_{kind} *"), ffi.new(f"tl_controller_parts_{kind} *")
    fixed = kind == "q31"
    out = ffi.new({"f64": "double[2]", "f32": "float[2]", "q31": "int32_t[2]"}[kind])
    frame.angle_rad = [int(q * 2**29) for q in angle] if fixed else angle
    if kind != "f64":
        getattr(lib, f"tl_controller_to_{kind}")(c, knot, c_of)
    getattr(lib, f"tl_controller_torque_{kind}")(c if kind == "f64" else c_of, frame, out, parts, *([ffi.new("uint32_t *")] if fixed else []))
    return [x * (2.0**-26 if fixed else 1.0) for x in out], parts.effects_Nm[0] * (2.0**-21 if fixed else 1.0)


def test_currents_hold_what_droop_and_offset_hide(tmp_path):
    """A current is the torque, its offset and its droop over the constant; the limit keeps room for both."""
    offset, droop = ("current_offset", 0), ("torque_saturation", 0)
    loop = Loop(effects=[offset, droop])
    out = loop.warm(q=(1.0, 0.0))
    effect = lib.tl_effect_typical(lib.tl_effect_find(b"torque_saturation"), 0)
    now, torque, friction = ffi.new("tl_effect_instant *", {"motor_Nm": out.torque_Nm[0], "ratio": 1.0}), ffi.new("double *"), ffi.new("double *")
    lib.tl_effect_law(ffi.new("tl_effect *", effect), now, torque, friction)
    assert out.current_A[0] * 0.1031 == pytest.approx(out.torque_Nm[0] + 0.01 + torque[0], abs=1e-6)
    assert loop.c.joint[0].torque_limit_Nm < 20 * 0.1031
