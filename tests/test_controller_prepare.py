"""What tl_controller_prepare, tl_controller_to_q31 and tl_drive_table_make refuse, one thing at a time, each beside a sound one."""

import math

import pytest
from leg_example import fixed, leg, linkage
from talus import constants, ffi, lib
from test_controller import KNOTS, prepared

INF, NAN = math.inf, math.nan
SETTINGS = {
    "tick_s": (0.0, -1e-3, INF, NAN), "decay_ticks": (1, 17, 101), "stale_ticks": (-1, 100), "recover_ticks": (0, 1001),
}  # fmt: skip
POSITIVE = ("current_limit_A", "torque_limit_Nm", "rate_Nm_s", "power_limit_W", "fade_rad", "speed_limit_rad_s",
            "acceleration_limit_rad_s2", "slack_rad", "friction_fade_rad_s", "frozen_rad_s")  # fmt: skip
JOINT = {name: (0.0, -1.0, NAN) for name in POSITIVE} | {
    "friction_share": (-0.1, 1.1), "low_rad": (-0.53, 0.6), "high_rad": (0.53, -0.53), "fade_rad": (1.1,), "speed_limit_rad_s": (33.0,),
    "acceleration_limit_rad_s2": (1025.0,), "rate_Nm_s": (0.0, 1.0),
}  # fmt: skip


@pytest.mark.parametrize(("name", "value"), [(n, v) for n, values in SETTINGS.items() for v in values])
def test_ticks_that_cannot_be(name, value):
    def change(s):
        setattr(s, name, value)
        if name in ("decay_ticks", "stale_ticks") and value > 20:
            s.tick_s = 1e-5  # short ones, so that it is their number alone
            for j in range(2):
                s.joint[j].rate_Nm_s = 1e9

    assert prepared(change=change) == (lib.TL_ERR_RANGE, -1)


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize(("name", "value"), [(n, v) for n, values in JOINT.items() for v in values])
def test_drives_that_cannot_be(name, value, joint):
    if name in ("low_rad", "high_rad") and joint == 0:
        value *= 6  # pi with a constant ratio

    assert prepared(change=lambda s: setattr(s.joint[joint], name, value)) == (lib.TL_ERR_RANGE, -1)


def test_the_lesser_of_torque_and_current_limits():
    for torque, expected in ((0.3, 0.3), (99.0, 20 * 0.1031)):
        c, *_ = prepared(change=lambda s: setattr(s.joint[0], "torque_limit_Nm", torque))
        assert c.joint[0].torque_limit_Nm == pytest.approx(expected, rel=1e-15)


def test_nothing_given_and_other_plants():
    c, knot, settings = prepared()
    model, refused = leg(), ffi.new("int *")
    given = [c, model, ffi.NULL, 0, settings, knot, refused]
    assert lib.tl_controller_prepare(*given) == lib.TL_OK
    for i in (0, 1, 4, 5, 6):
        assert lib.tl_controller_prepare(*given[:i], ffi.NULL, *given[i + 1 :]) == lib.TL_ERR_ARGUMENT
    assert lib.tl_controller_prepare(*given[:3], 1, *given[4:]) == lib.TL_ERR_ARGUMENT
    arm = ffi.new("tl_model *")
    assert lib.tl_model_init(arm, lib.TL_PLANT_PENDULUM) == lib.TL_OK
    assert lib.tl_controller_prepare(c, arm, *given[2:]) == lib.TL_ERR_UNSUPPORTED


# what a format has no room for: leg and joint fields of the struct in double
LEG = {"shank_inertia": 17.0, "foot_inertia": 17.0, "coupling": -5.0, "rotor": 17.0, "gravity_shank": 1025.0, "gravity_foot": -300.0,
       "tilt_shank": 1025.0, "tilt_foot": -300.0}  # fmt: skip
JOINTS = {"slope_per_rad": 129.0, "dry_Nm": 1025.0, "viscous": 65.0, "viscous_asymmetry": -65.0, "load_odd": 2.0, "spring_scale": 1025.0,
          "torque_limit_Nm": 33.0, "speed_limit_rad_s": 65.0, "acceleration_limit": 4097.0, "amperes_per_Nm": 2049.0, "offset_Nm": 33.0,
          "angle_slack_rad": 3.95, "speed_step_rad_s": 13.0}  # fmt: skip


@pytest.mark.parametrize(("where", "name", "value"), [
    *(("leg", *item) for item in LEG.items()), *((joint, *item) for joint in (0, 1) for item in JOINTS.items()),
])  # fmt: skip
def test_what_fixed_point_has_no_room_for(where, name, value):
    c, *_keep = prepared()
    q, knot = ffi.new("tl_controller_q31 *"), ffi.new("tl_curve_knot_q31[]", KNOTS)
    assert lib.tl_controller_to_q31(c, knot, q) == lib.TL_OK
    setattr(c if where == "leg" else c.joint[where], name, value)
    q.stale_ticks = 77
    assert lib.tl_controller_to_q31(c, knot, q) == lib.TL_ERR_RANGE
    assert q.stale_ticks == 77  # untouched


# numbers that fit each by itself, and whose sums do not
SUMS = [
    {"speed_limit_rad_s": (30.0, 40.0)}, {"speed_limit_rad_s": (63.0, 5.0)}, {"speed_limit_rad_s": (8.0, 25.0), "slope_per_rad": (0, 100.0)},
    {"slope_per_rad": (0, 128.0), "speed_limit_rad_s": (0.1, 0.1)}, {"dry_Nm": (1020.0, 0.0)}, {"inverse_scale": (0.9, 0.9)},
    {"amperes_per_Nm": (1500.0, 1500.0)},
]  # fmt: skip


@pytest.mark.parametrize("fields", SUMS)
def test_sums_that_fixed_point_has_no_room_for(fields):
    c, *_keep = prepared()
    q, knot = ffi.new("tl_controller_q31 *"), ffi.new("tl_curve_knot_q31[]", KNOTS)
    for name, values in fields.items():
        for j in range(2):
            if values[j]:
                setattr(c.joint[j], name, values[j])
    assert lib.tl_controller_to_q31(c, knot, q) == lib.TL_ERR_RANGE


def test_a_curve_that_is_none():
    """tl_curve_init_f64 and tl_curve_to_q31, and with them the controller's fixed point."""
    curve, out, fine = ffi.new("tl_curve_f64 *"), ffi.new("tl_curve_q31 *"), ffi.new("tl_curve_knot_q31[3]")
    knot = ffi.new("tl_curve_knot_f64[3]", [(0.0, 0.01), (0.01, 0.01), (0.02, 0.01)])
    assert lib.tl_curve_init_f64(ffi.NULL, knot, 3, 0.0, 0.1) == lib.tl_curve_init_f64(curve, ffi.NULL, 3, 0.0, 0.1) == lib.TL_ERR_ARGUMENT
    for n, first, step in ((1, 0.0, 0.1), (130, 0.0, 0.1), (3, NAN, 0.1), (3, 0.0, INF), (3, 0.0, 0.0), (3, INF, 0.1)):
        assert lib.tl_curve_init_f64(curve, knot, n, first, step) == lib.TL_ERR_RANGE
    for field in ("value", "rise"):
        spoiled = ffi.new("tl_curve_knot_f64[3]", [(0.0, 0.01), (0.01, 0.01), (0.02, 0.01)])
        setattr(spoiled[1], field, NAN)
        assert lib.tl_curve_init_f64(curve, spoiled, 3, 0.0, 0.1) == lib.TL_ERR_RANGE
    for first, step in ((0.0, 1e-10), (0.0, 4.0), (7.9, 0.1)):  # too close, too far apart, outside of Q29
        assert lib.tl_curve_init_f64(curve, knot, 3, first, step) == lib.TL_OK
        assert lib.tl_curve_to_q31(curve, 29, fine, out) == lib.TL_ERR_RANGE
    assert lib.tl_curve_init_f64(curve, knot, 3, 0.0, 0.1) == lib.TL_OK
    assert lib.tl_curve_to_q31(curve, 29, fine, out) == lib.TL_OK
    c, *_keep = prepared()
    c.joint[1].ratio.knot[3].rise = 0.5  # steeper than the format bears
    q, q_knot = ffi.new("tl_controller_q31 *"), ffi.new("tl_curve_knot_q31[]", KNOTS)
    assert lib.tl_controller_to_q31(c, q_knot, q) == lib.TL_ERR_RANGE


def test_a_drive_table_needs_a_curved_drive():
    made = ffi.new("tl_drive_table *")
    knot = ffi.new("tl_curve_knot_f64[]", constants.TL_DRIVE_TABLE_KNOTS)
    assert lib.tl_drive_table_make(made, linkage(), knot) == lib.TL_OK
    for arguments in ((ffi.NULL, linkage(), knot), (made, ffi.NULL, knot), (made, linkage(), ffi.NULL)):
        assert lib.tl_drive_table_make(*arguments) == lib.TL_ERR_ARGUMENT
    assert lib.tl_drive_table_make(made, fixed(50.0), knot) == lib.TL_ERR_UNSUPPORTED


def test_a_motor_that_turns_the_other_way():
    """A negative ratio at the knee: side, and torque and current with the other sign."""
    model, refused = leg(), ffi.new("int *")
    assert lib.tl_transmission_fixed(ffi.addressof(model.drive[0], "transmission"), -51.0) == lib.TL_OK
    settings, c = ffi.new("tl_controller_settings *"), ffi.new("tl_controller_f64 *")
    knot = ffi.new("tl_curve_knot_f64[]", KNOTS)
    lib.tl_controller_defaults(model, settings)
    assert lib.tl_controller_prepare(c, model, ffi.NULL, 0, settings, knot, refused) == lib.TL_OK
    forward, *_keep = prepared()
    assert c.joint[0].side == -1 == -forward.joint[0].side
    torque, parts = [ffi.new("double[2]") for _ in range(2)], ffi.new("tl_controller_parts_f64 *")
    at = ffi.new("tl_controller_frame_f64 *", {"angle_rad": (0.4, 0.1), "speed_rad_s": (1.0, -1.0)})
    for one, out in ((c, torque[0]), (forward, torque[1])):
        lib.tl_controller_torque_f64(one, at, out, parts)
    assert torque[0][0] == -torque[1][0] != 0.0 and torque[0][1] == torque[1][1]


def test_there_is_room_for_all_knots():
    c, *_keep = prepared([("parallel_spring", 0), ("stribeck", 1), ("torque_saturation", 1)])
    assert lib.tl_controller_knots(prepared()[0]) < lib.tl_controller_knots(c) <= KNOTS
