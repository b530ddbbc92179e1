"""lib/effect.c and lib/effects/: laws against closed forms, prediction and identification with effects on board."""

import json
import re

import numpy as np
import pytest
import talus
import yaml
from support import REPOSITORY, run
from talus import check, constants, ffi, lib, pointer
from test_kinematics import leg_tree
from test_regression import PENDULUM, leg_recording, pendulum_recording


def kinds():
    count = ffi.new("int *")
    table = lib.tl_effect_table(count)
    return {ffi.string(table[i].name).decode(): table[i] for i in range(count[0])}


CATALOGUE = set(
    "stribeck load_friction asymmetric_friction nonlinear_viscous position_friction presliding friction_drift backlash "
    "elasticity kinematic_error linkage_error directional_efficiency cogging torque_saturation current_offset delay "
    "encoder_eccentricity gravity_tilt parallel_spring base_compliance torque_constant sensor_offset".split())


def instant(**values):
    return ffi.new("tl_effect_instant *", values)


def columns(name, shape=(), **values):
    kind = kinds()[name]
    out = np.empty(constants.TL_EFFECT_MAX_STRENGTHS)
    lib.tl_effect_columns(kind, pointer(np.array([*shape, 0.0, 0.0, 0.0, 0.0, 0.0])), instant(**values), pointer(out))
    return out[: kind.strengths]


def test_every_kind_bears_an_id_of_the_catalogue_and_sound_parameters():
    assert set(kinds()) >= CATALOGUE
    for name, kind in kinds().items():
        assert kind.strengths >= 1 and kind.places > 0 and ffi.string(kind.meaning)
        assert kind.law or ((kind.columns or kind.link) and kind.change)
        assert kind.strengths + kind.shapes <= constants.TL_EFFECT_MAX_PARAMETERS
        for i in range(kind.strengths + kind.shapes):
            p = kind.parameter[i]
            assert p.low <= p.typical <= p.high, (name, ffi.string(p.name))
            assert p.low <= p.default_value <= p.high or not p.flags & lib.TL_PARAMETER_OPTIONAL, (name, ffi.string(p.name))


def test_the_page_lists_every_kind_with_its_parameters():
    page = re.sub(r"^```.*?^```$", "", (REPOSITORY / "docs" / "effects.md").read_text(), flags=re.MULTILINE | re.DOTALL)
    sections = {part.split("`")[1]: part for part in re.split(r"^### ", page, flags=re.MULTILINE)[1:]}
    assert set(sections) == set(kinds())
    for name, kind in kinds().items():
        for i in range(kind.strengths + kind.shapes):
            p = kind.parameter[i]
            assert f"`{ffi.string(p.name).decode()}` {p.low:g} to {p.high:g}" in sections[name], name


def test_a_kinds_file_is_its_only_place_in_c():
    named = re.compile(r'"({0})"|tl_effect_({0})\b'.format("|".join(kinds())))
    sources = [path for folder in ("lib", "apps", "include") for path in (REPOSITORY / folder).rglob("*.[ch]")]
    comments = re.compile(r"/\*.*?\*/", re.DOTALL)
    naming = {path for path in sources if named.search(comments.sub("", path.read_text()))}
    assert naming == set((REPOSITORY / "lib" / "effects").glob("*.c"))


def test_the_page_of_the_controller_names_the_effects_that_have_a_fast_form():
    section = (REPOSITORY / "docs" / "controller.md").read_text().split("\n## Effects\n")[1].split("What has a")[0]
    fast = {name for name, kind in kinds().items() if kind.fast != lib.TL_FAST_NONE}
    assert set(re.findall(r"`(\w+)`", section)) == fast
    for name in fast:
        kind = kinds()[name]
        assert bool(kind.numbers) == (kind.fast == lib.TL_FAST_NUMBERS), name
        assert bool(kind.law) == (kind.fast != lib.TL_FAST_DRIVE), name


def test_laws_against_their_formulas():
    v, slip, load, motor, ratio, q = -0.3, -1.0, -2.5, 0.02, 51.0, 0.4
    at = {"v": v, "slip": slip, "load_Nm": load, "motor_Nm": motor, "ratio": ratio, "q": q, "motor_rad": 51 * q, "t_s": 30.0,
          "gravity_tilt_Nm": 1.7, "effort_Nm": 0.9, "rotor_Nm": 0.2, "friction_Nm": -0.8, "offset_Nm": 0.4, "temp_C": 41.0}
    expected = {
        ("stribeck", (0.1, 2.0)): [-np.exp(-9.0)],
        ("stribeck", (0.1, 1.0)): [-np.exp(-3.0)],
        ("load_friction", (1.0, 0.0, 0.0, 1.0, 1.0, 0.0)): [-2.5],
        ("load_friction", (0.0, 0.0, 0.0, 1.0, 1.0, 0.0)): [-2.7],
        ("load_friction", (1.0, 1.0, 0.0, 1.0, 1.0, 0.0)): [-3.3],
        ("load_friction", (1.0, 0.0, 1.0, 1.0, 1.0, 0.0)): [-2.1],
        ("load_friction", (1.0, 0.0, 0.0, 2.0, 5.0, 0.0)): [-1.25],
        # T = X + c |T| slip: X / (1 - c) driving, and what is more than X per c
        ("load_friction", (1.0, 0.0, 0.0, 1.0, 1.0, 0.25)): [(-2.5 / 0.75 + 2.5) / 0.25],
        ("asymmetric_friction", ()): [1.0, 0.3],
        ("nonlinear_viscous", (2.0,)): [-0.09],
        ("nonlinear_viscous", (0.5,)): [-np.sqrt(0.3)],
        ("nonlinear_viscous", (1.0, 0.2)): [-np.tanh(1.5)],
        ("position_friction", (0.0, 0.0)): [-0.4, -0.16, -0.064, -0.0256, 0.0, -1.0],
        ("position_friction", (0.1, 3.0)): [-0.3, -0.09, -0.027, -0.0081, -np.sin(0.9), -np.cos(0.9)],
        ("position_friction", (0.1, 3.0, 0.2)): [-0.2, -0.04, -0.008, -0.0016, -np.sin(0.9), -np.cos(0.9)],  # beyond its range
        ("friction_drift", (60.0, 31.0)): [-(1 - np.exp(-0.5)), -0.3 * (1 - np.exp(-0.5)), -np.exp(-0.5),
                                           -0.3 * np.exp(-0.5), -1.0, -0.3],
        ("directional_efficiency", (1.0, 0.0, 0.0)): [-2.5, 0.0],  # load and motion in one direction: driving
        ("kinematic_error", (2.0, 0.0)): [np.sin(2 * 51 * q), np.cos(2 * 51 * q), 0.0, 0.0,
                                          load * np.sin(2 * 51 * q), load * np.cos(2 * 51 * q)],
        ("kinematic_error", (2.0, 4.0)): [x * f(2 * 51 * q) / (1 + (2 * 51 * v / (2 * np.pi * 4)) ** 4)
                                          for x, f in ((1, np.sin), (1, np.cos), (0, np.sin), (0, np.cos),
                                                       (load, np.sin), (load, np.cos))],
        ("cogging", (12.0, 0.0)): [51 * f(k * 12 * 51 * q) for k in (1, 2) for f in (np.sin, np.cos)],
        ("cogging", (12.0, 18.0)): [51 * f(k * 12 * 51 * q) / (1 + (k * 12 * 51 * v / (2 * np.pi * 18)) ** 4)
                                    for k in (1, 2) for f in (np.sin, np.cos)],
        ("torque_saturation", (1.0,)): [51 * 0.02 * 0.02],
        ("torque_saturation", (0.0, 0.005)): [51 * 0.015],
        ("current_offset", ()): [51.0],
        ("gravity_tilt", ()): [1.7],
        ("parallel_spring", (0.1, 1.0)): [0.4, 0.064, 1.0, 0.16, 0.3],
        ("parallel_spring", (0.1, -1.0)): [0.4, 0.064, 1.0, 0.16, 0.0],
        ("parallel_spring", (0.7, -1.0)): [0.4, 0.064, 1.0, 0.16, -0.3],
        ("sensor_offset", ()): [-1.0],
    }
    assert {name for name, _ in expected} == {name for name, kind in kinds().items() if kind.law}
    for (name, shape), want in expected.items():
        assert columns(name, shape, **at) == pytest.approx(want, rel=1e-12, abs=1e-15), name
    assert columns("directional_efficiency", (1.0, 0.0, 0.0), **{**at, "load_Nm": 2.5}) == pytest.approx([0.0, -2.5])


def test_the_columns_at_many_instants_are_those_at_each():
    """Stribeck and a parabola of the angle over instants that differ, against their formulas; one strength after the other."""
    v, q, slip = np.linspace(-0.6, 0.6, 25), np.linspace(0.5, -0.3, 25), np.sign(np.linspace(-0.6, 0.6, 25))
    now = ffi.new("tl_effect_instant[]", [{"v": a, "q": b, "slip": c} for a, b, c in zip(v, q, slip)])
    for name, shape, want in (
        ("stribeck", (0.2, 2.0), [slip * np.exp(-((v / 0.2) ** 2))]),
        ("position_friction", (0.1, 0.0, 0.0), [slip * (q - 0.1) ** p for p in (1, 2, 3, 4)] + [0 * q, slip]),
    ):
        kind, out = lib.tl_effect_find(name.encode()), np.full((len(want), len(v)), np.nan)
        assert kind.strengths == len(want)
        lib.tl_effect_columns_at(kind, pointer(np.array(shape)), now, len(v), pointer(out))
        assert out == pytest.approx(np.array(want), rel=1e-12, abs=1e-15), name


def test_the_instant_knows_load_and_tilt():
    """Load by hand for a pendulum; tilt against the difference of two tilted gravities."""
    model = talus.Model.from_tree(PENDULUM)
    motion, now = ffi.new("tl_motion *"), ffi.new("tl_effect_instant *")
    motion.q[0], motion.v[0], motion.a[0], motion.slip[0] = 0.3, 0.5, -2.0, 1.0
    lib.tl_effect_instant_of(model.struct, motion, 0, 1.0, ffi.NULL, now)
    assert now.load_Nm == pytest.approx(0.8 * -2.0 + 1.1 * 9.81 * np.sin(0.3 - 0.2), rel=1e-12)
    assert now.motor_Nm == pytest.approx((now.load_Nm + 0.9 + 0.4 * 0.5 + 0.3) / 20, rel=1e-12)
    assert now.ratio == 20 and now.motor_rad == pytest.approx(6.0)
    assert now.rotor_Nm == pytest.approx(0.8 * -2.0) and now.offset_Nm == 0.3  # its rotor is in its inertia
    leg = talus.Model.from_tree(leg_tree())
    for joint in (0, 1):
        motion.q[0], motion.q[1], motion.v[0], motion.v[1] = 0.3, -0.2, 0.0, 0.0
        motion.a[0] = motion.a[1] = motion.slip[0] = motion.slip[1] = 0.0
        lib.tl_effect_instant_of(leg.struct, motion, joint, 0.0, ffi.NULL, now)
        static = lambda tilt: leg.inverse([[0.3 + tilt], [-0.2]], [[0.0], [0.0]], [[0.0], [0.0]])[joint, 0] * now.ratio
        assert now.gravity_tilt_Nm == pytest.approx((static(1e-6) - static(-1e-6)) / 2e-6, rel=1e-6)


def test_the_instant_knows_what_a_rotor_may_take():
    """The knee's is in the shank's inertia; the ankle's is its own, by the square of a ratio that grows with the angle."""
    leg, motion, now = talus.Model.from_tree(leg_tree()), ffi.new("tl_motion *"), ffi.new("tl_effect_instant *")
    motion.q[1], motion.v[1], motion.a[0], motion.a[1] = -0.2, 0.7, 3.0, 5.0
    rotor = [leg_tree()["shank"]["inertia_kg_m2"] * 3.0]
    ratio = lambda q: leg.transmission(1).ratio(np.array([q]))[0]
    slope = (ratio(-0.2 + 1e-5) - ratio(-0.2 - 1e-5)) / 2e-5
    rotor.append(leg_tree()["ankle"]["rotor_inertia_kg_m2"] * ratio(-0.2) * (ratio(-0.2) * 5.0 + slope * 0.7**2))
    for joint in (0, 1):
        lib.tl_effect_instant_of(leg.struct, motion, joint, 0.0, ffi.NULL, now)
        assert now.rotor_Nm == pytest.approx(rotor[joint], rel=1e-7) and now.offset_Nm == 0.0


def test_where_an_effect_can_stand():
    leg, pendulum = talus.Model.from_tree(leg_tree()), talus.Model.from_tree(PENDULUM)
    applies = lambda name, model, joint: bool(lib.tl_effect_applies(kinds()[name], model.struct, joint))
    assert applies("stribeck", leg, 0) and applies("stribeck", leg, 1) and not applies("stribeck", leg, 2)
    assert applies("kinematic_error", leg, 0) and not applies("kinematic_error", leg, 1)
    assert applies("gravity_tilt", leg, 2) and not applies("gravity_tilt", leg, 0)
    assert applies("torque_constant", pendulum, 0) and not applies("torque_constant", leg, 0)


def with_effects(tree, *effects):
    return {**tree, "effects": [{"effect": e, "joint": j, "parameters": p} for e, j, p in effects]}


def rows(path):
    return np.genfromtxt(path, delimiter=",", names=True)


def write_recording(path, recording):
    names = list(recording.columns)
    np.savetxt(path, np.column_stack([recording.columns[n] for n in names]), delimiter=",", header=",".join(names),
               comments="", fmt="%.12g")


def test_prediction_adds_what_the_effects_say(tmp_path):
    recording, (q, v, a, torque) = pendulum_recording()
    write_recording(tmp_path / "r.csv", recording)
    effects = [("stribeck", "joint", {"extra_Nm": 0.5, "speed_rad_s": 0.2, "exponent": 2.0}),
               ("parallel_spring", "joint", {"stiffness_Nm_rad": 3.0, "stiffening_Nm_rad3": 2.0, "preload_Nm": 0.1})]
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(with_effects(PENDULUM, *effects)))
    run("talus-predict", "--model", tmp_path / "m.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv")
    want = torque + 0.5 * np.exp(-(v / 0.2) ** 2) * np.sign(v) + 3 * q + 2 * q**3 + 0.1
    away = (np.abs(v) > 0.05) & (recording.t > 0.1) & (recording.t < recording.t[-1] - 0.1)
    assert np.max(np.abs(rows(tmp_path / "p.csv")["joint_torque_Nm"] - want)[away]) < 3e-3 * np.max(np.abs(want))


def test_an_effect_at_the_ankle_leaves_the_knee_alone(tmp_path):
    write_recording(tmp_path / "r.csv", leg_recording())
    predictions = []
    for effects in ([], [("current_offset", "ankle", {"torque_Nm": 0.01})], [("gravity_tilt", "base", {"tilt_rad": 0.05})]):
        (tmp_path / "m.yaml").write_text(yaml.safe_dump(with_effects(leg_tree(), *effects)))
        run("talus-predict", "--model", tmp_path / "m.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv")
        predictions.append(rows(tmp_path / "p.csv"))
    plain, offset, tilted = predictions
    knee, ankle = "knee_motor_torque_Nm", "ankle_motor_torque_Nm"
    assert np.array_equal(plain[knee], offset[knee])
    assert offset[ankle] - plain[ankle] == pytest.approx(0.01, abs=1e-11)
    assert np.max(np.abs(tilted[knee] - plain[knee])) > 1e-3 and np.max(np.abs(tilted[ankle] - plain[ankle])) > 1e-5


def test_identification_with_the_effect_on_board_finds_the_plain_parameters(tmp_path):
    recording, (q, v, a, torque) = pendulum_recording(noise_A=0.01)
    current = (torque + 0.15 * np.abs(0.8 * a + 1.1 * 9.81 * np.sin(q - 0.2)) * np.sign(v)) / 2.0
    write_recording(tmp_path / "r.csv", talus.Recording({**recording.columns, "joint_current_A": current}))
    found = {}
    for name, effects in (("plain", []), ("with", [("load_friction", "joint", {"coefficient": 0.15})])):
        (tmp_path / "m.yaml").write_text(yaml.safe_dump(with_effects(PENDULUM, *effects)))
        run("talus-identify", "--model", tmp_path / "m.yaml", "--out", tmp_path / "f.yaml", "--report",
            tmp_path / "r.json", tmp_path / "r.csv")
        found[name] = json.loads((tmp_path / "r.json").read_text())
    fit = found["with"]["parameters"]["coulomb_Nm"]["value"]
    assert fit == pytest.approx(0.9, rel=0.02)
    assert found["plain"]["parameters"]["coulomb_Nm"]["value"] > 1.1  # it swallows the mean of the load's friction
    assert found["with"]["error"]["joint"]["identified_rms"] < 0.3 * found["plain"]["error"]["joint"]["identified_rms"]
    # the fitted model carries the effect on, and reads back
    assert yaml.safe_load((tmp_path / "f.yaml").read_text())["effects"][0]["effect"] == "load_friction"
    run("talus-predict", "--model", tmp_path / "f.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv")


def test_with_a_load_sensor_constant_and_zero_are_told(tmp_path):
    recording, (q, v, a, torque) = pendulum_recording()
    load = 2.0 * np.sin(recording.t)
    # the drive gives 1.2 of what its current says, and the sensor reads 0.3 too much
    columns_ = {**recording.columns, "joint_current_A": (torque + load) / 1.2 / 2.0, "joint_load_Nm": load + 0.3}
    write_recording(tmp_path / "r.csv", talus.Recording(columns_))
    effects = [("torque_constant", "joint", {"excess": 0.2}), ("sensor_offset", "joint", {"offset_Nm": 0.3})]
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(with_effects(PENDULUM, *effects)))
    run("talus-predict", "--model", tmp_path / "m.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv")
    away = (np.abs(v) > 0.05) & (recording.t > 0.1) & (recording.t < recording.t[-1] - 0.1)
    error = rows(tmp_path / "p.csv")["joint_load_Nm"] - columns_["joint_load_Nm"]
    assert np.max(np.abs(error)[away]) < 3e-3 * np.max(np.abs(torque))


def sensed(tmp_path, current, load, effects):
    """What a prediction misses of a sensor at the output, beside the largest torque, away from stops and ends."""
    recording, (_, v, _, torque) = pendulum_recording()
    columns_ = {**recording.columns, "joint_current_A": current(torque, v), "joint_load_Nm": load}
    write_recording(tmp_path / "r.csv", talus.Recording(columns_))
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(with_effects(PENDULUM, *effects)))
    run("talus-predict", "--model", tmp_path / "m.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv")
    away = (np.abs(v) > 0.2) & (recording.t > 0.1) & (recording.t < recording.t[-1] - 0.1)
    error = rows(tmp_path / "p.csv")["joint_load_Nm"] - load
    return np.max(np.abs(error)[away]) / np.max(np.abs(torque))


def test_with_a_load_sensor_friction_grows_with_what_the_drive_truly_gives(tmp_path):
    """drive - 0.1 |drive| sgn v = torque + load; the current says drive / 1.2."""
    load = 2.0 * np.sin(pendulum_recording()[0].t)

    def current(torque, v):
        net = torque + load
        return net / np.where(net * v > 0, 0.9, 1.1) / 1.2 / 2.0

    effects = [("torque_constant", "joint", {"excess": 0.2}), ("load_friction", "joint", {"coefficient": 0.1})]
    assert sensed(tmp_path, current, load, effects) < 3e-3
    assert sensed(tmp_path, current, load, effects[:1]) > 0.05


@pytest.mark.parametrize("angles_too", [0.0, 1.0])
def test_with_a_load_sensor_telemetry_may_be_late(tmp_path, angles_too):
    """The current of each row is 8 ms old; with `angles_too` the whole row is, so that the sensor is ahead of it."""
    late_s, t = 0.008, pendulum_recording()[0].t
    if angles_too:
        load, current = 2.0 * np.sin(t + late_s), lambda torque, v: (torque + 2.0 * np.sin(t)) / 2.0
    else:
        load = 2.0 * np.sin(t)
        current = lambda torque, v: np.interp(t - late_s, t, torque + load) / 2.0
    parameters = {"delay_s": late_s, "angles_too": angles_too}
    assert sensed(tmp_path, current, load, [("delay", "joint", parameters)]) < 5e-3
    assert sensed(tmp_path, current, load, [("delay", "joint", {**parameters, "angles_too": 1 - angles_too})]) > 0.01


@pytest.mark.parametrize("effect, message", [
    ({"effect": "stribeck", "joint": "knee", "parameters": {"extra_Nm": 0.4}}, "missing"),
    ({"effect": "stribeck", "joint": "hip", "parameters": {}}, "cannot stand at 'hip'"),
    ({"effect": "kinematic_error", "joint": "ankle", "parameters": {}}, "cannot stand at 'ankle'"),
    ({"effect": "load_friction", "joint": "knee", "parameters": {"coefficient": 3.0}}, "out of its range"),
    ({"effect": "load_friction", "joint": "knee", "parameters": {"coefficient": 0.1, "x": 1}}, "unknown key|not known"),
    ({"effect": "load_friction", "joint": "knee"}, "missing"),
])  # fmt: skip
def test_bad_effects_in_a_model_file(tmp_path, effect, message):
    write_recording(tmp_path / "r.csv", leg_recording())
    (tmp_path / "m.yaml").write_text(yaml.safe_dump({**leg_tree(), "effects": [effect]}))
    done = run("talus-predict", "--model", tmp_path / "m.yaml", "--out", tmp_path / "p.csv", tmp_path / "r.csv", status=2)
    assert len(done.stderr.splitlines()) == 1 and "m.yaml:" in done.stderr
    assert any(part in done.stderr for part in message.split("|")), done.stderr
    assert not (tmp_path / "p.csv").exists()


ONCE = {
    "presliding": ("knee", {"friction_Nm": 0.3, "travel_rad": 0.005}),
    "elasticity": ("knee", {"share": 1.0, "stiffness_Nm_rad": 500.0, "damping_s": 0.001}),
    "backlash": ("knee", {"share": 1.0, "gap_rad": 0.004, "stiffness_Nm_rad": 3000.0}),
}


@pytest.mark.parametrize("name", ONCE)
def test_a_second_entry_that_has_no_sum_with_the_first_is_refused_by_name(tmp_path, name):
    joint, parameters = ONCE[name]
    one = (name, joint, parameters)
    write_recording(tmp_path / "r.csv", leg_recording())
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(with_effects(leg_tree(), one, ("gravity_tilt", "base", {"tilt_rad": 0.1}), one)))
    for program, *rest in (("talus-predict", tmp_path / "r.csv"), ("talus-sim",)):
        done = run(program, "--model", tmp_path / "m.yaml", "--out", tmp_path / "o.csv", *rest, status=2)
        assert len(done.stderr.splitlines()) == 1 and f"a second '{name}' at '{joint}'" in done.stderr
        assert not (tmp_path / "o.csv").exists()


def test_the_check_of_a_list_knows_what_stands_once_at_a_joint():
    model, table = talus.Model.from_tree(leg_tree()), kinds()
    at = lambda name, joint: lib.tl_effect_typical(table[name], joint)
    status = lambda *list_: lib.tl_effects_check(ffi.new("tl_effect[]", list_), len(list_), model.struct)
    for name in ONCE:
        assert status(at(name, 0), at(name, 0)) == lib.TL_ERR_UNSUPPORTED
        assert status(at(name, 0), at(name, 1)) == lib.TL_OK
    assert status(at("elasticity", 0), at("elasticity", 1), at("backlash", 0)) == lib.TL_OK  # a series
    assert status(at("cogging", 0), at("cogging", 0), at("delay", 1), at("delay", 1)) == lib.TL_OK
    assert status(at("kinematic_error", 1)) == lib.TL_ERR_UNSUPPORTED
    assert lib.tl_effects_check(ffi.NULL, 1, model.struct) == lib.TL_ERR_ARGUMENT


def test_the_table_is_the_folder_by_the_order_that_each_file_names():
    names, orders = [*kinds()], [kind.order for kind in kinds().values()]
    assert set(names) == {path.stem for path in (REPOSITORY / "lib" / "effects").glob("*.c")}
    assert orders == sorted(orders) and 0 < orders[0]


def prediction(folder, recording, *effects, status=0):
    """What talus-predict says of the pendulum with these effects; with a status other than 0 the complaint."""
    write_recording(folder / "r.csv", recording)
    (folder / "m.yaml").write_text(yaml.safe_dump(with_effects(PENDULUM, *effects)))
    done = run("talus-predict", "--model", folder / "m.yaml", "--out", folder / "p.csv", folder / "r.csv", status=status)
    return rows(folder / "p.csv")["joint_torque_Nm"] if status == 0 else done.stderr


def test_a_parameter_that_may_be_left_out_has_its_value_then(tmp_path):
    recording, _ = pendulum_recording()
    short = ("load_friction", "joint", {"coefficient": 0.2})
    long = ("load_friction", "joint", {"coefficient": 0.2, "rotor_share": 1.0, "friction_share": 0.0})
    other = ("load_friction", "joint", {"coefficient": 0.2, "friction_share": 1.0})
    left_out, given, with_friction = (prediction(tmp_path, recording, e) for e in (short, long, other))
    assert np.array_equal(left_out, given)
    assert np.max(np.abs(with_friction - given)) > 0.1 * 0.2 * 0.9


def test_two_orders_of_one_effect_at_a_joint_add_up(tmp_path):
    recording, _ = pendulum_recording()
    orders = [("cogging", "joint", {"sine_Nm": 0.01, "cosine_Nm": 0.0, "per_turn": order}) for order in (6.0, 12.0)]
    plain, one, two, both = (prediction(tmp_path, recording, *e) for e in ((), orders[:1], orders[1:], orders))
    assert np.max(np.abs(one - plain)) > 0.1 and both - plain == pytest.approx((one - plain) + (two - plain), abs=1e-9)


def test_friction_follows_the_recorded_temperature(tmp_path):
    recording, (_, v, _, _) = pendulum_recording()
    warm = 30 + 8 * np.sin(recording.t / 5)
    heated = talus.Recording({**recording.columns, "joint_temp_C": warm})
    effect = ("friction_drift", "joint", {"coulomb_Nm": 0.0, "viscous_Nms_rad": 0.0, "coulomb_Nm_10K": -0.3,
                                          "viscous_Nms_rad_10K": 0.2, "time_constant_s": 60.0, "middle_C": 28.0})
    change = prediction(tmp_path, heated, effect) - prediction(tmp_path, heated)
    want = (warm - 28) / 10 * (-0.3 * np.sign(v) + 0.2 * v)
    away = (np.abs(v) > 0.05) & (recording.t > 1.1) & (recording.t < recording.t[-1] - 1.1)
    assert np.max(np.abs(change - want)[away]) < 0.01  # the mean over 2 s lags where the temperature bends
    told = prediction(tmp_path, recording, effect, status=2)
    assert "r.csv" in told and "temperature" in told and len(told.splitlines()) == 1


def test_forward_time_knows_all_but_what_the_page_gives_a_reason_for():
    starred = {(name, ffi.string(kind.parameter[i].name).decode()) for name, kind in kinds().items()
               for i in range(kind.strengths + kind.shapes) if kind.parameter[i].flags & lib.TL_PARAMETER_FIT_ONLY}
    assert starred == {("friction_drift", "coulomb_Nm_10K"), ("friction_drift", "viscous_Nms_rad_10K"),
                       ("elasticity", "friction_compliance_rad_Nm"), ("delay", "angles_too")}
    page = (REPOSITORY / "docs" / "effects.md").read_text()
    reasons = page[page.index("Starred:"):].split("\n\n")[0]
    for name, parameter in starred:
        section = page[page.index(f"### `{name}`"):].split("### ")[1]
        assert re.search(rf"`{parameter}`[^,|]*\\\*", section) and f"`{parameter}`" in reasons, parameter
    assert page.count(")\\*") == len(starred)


@pytest.mark.parametrize("effect, name", [
    (("friction_drift", "knee", {"coulomb_Nm": 0.1, "viscous_Nms_rad": 0.0, "time_constant_s": 60.0, "coulomb_Nm_10K": 0.1}), "coulomb_Nm_10K"),
    (("elasticity", "ankle", {"share": 1.0, "stiffness_Nm_rad": 500.0, "damping_s": 0.001, "friction_compliance_rad_Nm": 1e-3}),
     "friction_compliance_rad_Nm"),
    (("delay", "knee", {"delay_s": 0.004, "angles_too": 1.0}), "angles_too"),
])  # fmt: skip
def test_what_recordings_alone_can_show_is_not_simulated(tmp_path, effect, name):
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(with_effects(leg_tree(), effect)))
    done = run("talus-sim", "--model", tmp_path / "m.yaml", "--out", tmp_path / "s.csv", status=2)
    assert name in done.stderr and "m.yaml" in done.stderr and len(done.stderr.splitlines()) == 1
    assert not (tmp_path / "s.csv").exists()


def test_the_models_folder_reads():
    for path in sorted((REPOSITORY / "models").glob("*.yaml")):
        check(lib.tl_model_check(talus.Model.read(path).struct))
