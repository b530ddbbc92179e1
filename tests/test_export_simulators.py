"""talus-export to simulators: what each file holds, by readers that are not talus, and the loss report of all 22 effects."""

import importlib
import json
import sys
import types
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import talus
from support import REPOSITORY, run
from talus import ffi, lib
from talus.exporting import command

LEG, ARM = (REPOSITORY / "models" / f"{name}.yaml" for name in ("leg", "pendulum"))
PLACE = {"gravity_tilt": "base", "base_compliance": "base", "encoder_eccentricity": "ankle", "linkage_error": "ankle",
         "torque_constant": "joint", "sensor_offset": "joint"}  # fmt: skip
SHAPED = {"nonlinear_viscous": "{size_Nm: 0.3, exponent: 2}", "current_offset": "{torque_Nm: 0.01}",
          "parallel_spring": "{stiffness_Nm_rad: 3, stiffening_Nm_rad3: 0, preload_Nm: 0}"}  # fmt: skip
# exact E, approximate A, callback C, lost L; in the order of TARGETS
TARGETS = ("mjcf", "urdf", "sdf", "bam", "isaac")
HELD = {
    "stribeck": "CAAEA", "load_friction": "CAAAA", "asymmetric_friction": "CLLLL", "nonlinear_viscous": "EAAAA",
    "position_friction": "CAAAA", "friction_drift": "CAAAA", "directional_efficiency": "CAAAA", "kinematic_error": "CLLLL",
    "cogging": "CLLLL", "torque_saturation": "CLLLL", "current_offset": "ELLLL", "gravity_tilt": "ELLLL",
    "parallel_spring": "ELELL", "torque_constant": "ELLLL", "sensor_offset": "CLLLL", "delay": "CLLLL",
    "encoder_eccentricity": "CLLLL", "linkage_error": "CLLLL", "presliding": "CLLLL", "elasticity": "ELLLL",
    "backlash": "CLLLL", "base_compliance": "LLLLL",
}  # fmt: skip


def kinds():
    n = ffi.new("int *")
    table = lib.tl_effect_table(n)
    return [ffi.string(table[i].name).decode() for i in range(n[0])]


def parameters(name):
    kind = lib.tl_effect_find(name.encode())
    return {ffi.string(p.name).decode(): p.typical for p in kind.parameter[0 : kind.strengths + kind.shapes] if p.name != ffi.NULL and not p.flags}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The leg's and the arm's motions, the latter with a load sensor that shows half of the drive's torque."""
    out = tmp_path_factory.mktemp("export")
    run("talus-sim", "--model", LEG, "--out", out / "leg.csv", "--ideal", "--duration", 12)
    run("talus-sim", "--model", ARM, "--out", out / "arm.csv", "--ideal", "--duration", 12)
    arm = talus.Recording.read(out / "arm.csv")
    talus.Recording({**arm.columns, "joint_load_Nm": 0.5 * 9 * 0.091 * arm.columns["joint_current_A"]}).write(out / "load.csv")
    return out


def with_effect(name):
    """The leg or the arm with one effect, and its motion."""
    joint = PLACE.get(name, "knee")
    base, recording = (ARM, "load.csv") if joint == "joint" else (LEG, "leg.csv")
    given = SHAPED.get(name) or json.dumps(parameters(name))
    text = base.read_text() + f"effects: [{{effect: {name}, joint: {joint}, parameters: {given}}}]\n"
    return talus.Model.from_text(text), joint, recording


def exported(folder, target, name):
    """Entry of an effect in the loss report, at its place; the file is left in folder/out."""
    model, joint, recording = with_effect(name)
    drive = (joint if joint in model.joints else model.joints[0]) if target == "bam" else None
    text, report = command.export(model, target, "m.yaml", recording=talus.Recording.read(folder / recording, model=model), joint=drive)
    (folder / "out").write_text(text)
    assert report["schema"] == "talus-loss/1" and report["target"] == target
    (entry,) = [e for e in report["entries"] if e["effect"] == name]
    assert entry["joint"] == joint
    return entry


def test_the_program_writes_file_report_and_table(folder, tmp_path):
    model, _, recording = with_effect("stribeck")
    model.write(tmp_path / "m.yaml")
    said = run("talus-export", "--to", "sdf", "--out", tmp_path / "m.sdf", tmp_path / "m.yaml", folder / recording).stderr
    entry = exported(folder, "sdf", "stribeck")
    assert entry in json.loads((tmp_path / "m.sdf.loss.json").read_text())["entries"]
    assert (tmp_path / "m.sdf").read_text().split("-->")[1] == (folder / "out").read_text().split("-->")[1]
    row = [line.split() for line in said.splitlines() if line.startswith("stribeck")][0]
    assert row[:3] == ["stribeck", "knee", "approximate"] and float(row[4]) == pytest.approx(entry["lost_Nm"], rel=0.05)


def test_every_effect_has_its_row():
    assert sorted(HELD) == sorted(kinds()) and len(HELD) == 22


@pytest.mark.parametrize("target", TARGETS)
def test_loss_report_of_every_effect(folder, target):
    found = {}
    for name, held in HELD.items():
        entry, expected = exported(folder, target, name), held[TARGETS.index(target)]
        found[name] = (entry["how"][0].upper(), expected)
        lost, torque = entry["lost_Nm"], entry["torque_Nm"]
        assert (entry["callback"] is not None) == (entry["how"] == "callback")
        if entry["how"] == "exact":
            assert lost == 0
        elif torque is not None:
            assert lost < 0.9 * torque if entry["how"] == "approximate" else lost == torque, (name, entry)
    print({k: v for k, v in found.items() if v[0] != v[1]})
    assert not [name for name, (is_, should) in found.items() if is_ != should]


def test_a_constant_torque_behind_a_gap_is_lost(folder):
    """Simulators have it on the motor's side."""
    given = json.dumps({**parameters("backlash"), "offset_share": 1.0})
    model = talus.Model.from_text(LEG.read_text() + f"effects: [{{effect: backlash, joint: knee, parameters: {given}}}]\n")
    _, report = command.export(model, "mjcf", "m.yaml", recording=talus.Recording.read(folder / "leg.csv", model=model))
    assert [e["how"] for e in report["entries"] if e["effect"] == "backlash"] == ["lost"]


def moving(folder):
    model, recording = talus.Model.read(LEG), talus.Recording.read(folder / "leg.csv")
    motion = talus.Regression(model, recording).motion()
    return [(motion["q"][j][r], motion["v"][j][r]) for j in (0, 1) for r in [np.flatnonzero(abs(motion["v"][j]) > model.score.standstill)]]


def test_torques_are_those_of_closed_forms(folder):
    (q, v), (_, ankle_v) = moving(folder)
    size = lambda x: pytest.approx(float(np.sqrt(np.mean(x**2))), rel=5e-3)  # noqa: E731  prediction bridges short stops
    assert exported(folder, "urdf", "nonlinear_viscous")["torque_Nm"] == size(0.3 * v**2)
    assert exported(folder, "urdf", "parallel_spring")["torque_Nm"] == size(3 * q)
    assert exported(folder, "urdf", "current_offset")["torque_Nm"] == pytest.approx(51 * 0.01, rel=1e-6)
    # what is left of 0.3 v |v| when the nearest multiple of v and of v's sign are taken from it
    columns = np.column_stack([np.sign(v), v])
    left = 0.3 * v * abs(v) - columns @ np.linalg.lstsq(columns, 0.3 * v * abs(v), rcond=None)[0]
    assert exported(folder, "urdf", "nonlinear_viscous")["lost_Nm"] == size(left)
    assert len(ankle_v)


def library_matrices(model, q):
    """Mass matrix and gravity at the joints, by the library's inverse dynamics without friction and rotor."""
    bare = model.copy()
    for j in range(len(model.joints)):
        bare.struct.drive[j].coulomb_Nm = bare.struct.drive[j].viscous_Nms_rad = bare.struct.drive[j].rotor_inertia_kg_m2 = 0.0
    n, q = len(q), np.reshape(q, (-1, 1))
    ratio = np.array([[lib.tl_torque_ratio(model.struct, j, float(q[j, 0]))] for j in range(n)])
    torque = lambda a: ratio * bare.inverse(q, 0 * q, a)  # noqa: E731
    gravity = torque(0 * q)
    return np.hstack([torque(np.eye(n)[:, [k]]) - gravity for k in range(n)]), gravity[:, 0]


def urdf_is_right(folder, path, reader):
    """Mass matrix and gravity of the file that is written of a model, as `reader` has them, against the library's."""
    run("talus-export", "--to", "urdf", "-q", "--limits", "joint.torque=3" if path == ARM else "knee.torque=60,ankle.position=-0.5:0.5",
        "--out", folder / "m.urdf", path)  # fmt: skip
    model = talus.Model.read(path)
    for q in ([0.0, 0.0], [0.4, -0.3], [-1.1, 0.45]):
        q = q[: len(model.joints)]
        for theirs, ours in zip(reader(folder / "m.urdf", np.array(q)), library_matrices(model, q), strict=True):
            np.testing.assert_allclose(theirs, ours, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("path", [LEG, ARM], ids=["leg", "pendulum"])
def test_urdf_has_the_librarys_mass_matrix_and_gravity(tmp_path, path):
    urdf_is_right(tmp_path, path, by_mujoco)


@pytest.mark.long
@pytest.mark.parametrize("path", [LEG, ARM], ids=["leg", "pendulum"])
def test_pinocchio_reads_that_mass_matrix_and_gravity(tmp_path, path):
    """`make check-long` installs Pinocchio: without it this fails."""
    urdf_is_right(tmp_path, path, by_pinocchio)


def by_mujoco(path, q):
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(path))
    model.dof_frictionloss[:] = 0
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_forward(model, data)
    mass = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, mass, data.qM)
    return mass, data.qfrc_bias.copy()


def by_pinocchio(path, q):
    import pinocchio

    model = pinocchio.buildModelFromUrdf(str(path))
    data = model.createData()
    configuration = np.concatenate([[np.cos(x), np.sin(x)] if joint.nq == 2 else [x] for x, joint in zip(q, list(model.joints)[1:], strict=True)])
    mass = pinocchio.crba(model, data, configuration)
    return np.triu(mass) + np.triu(mass, 1).T, pinocchio.computeGeneralizedGravity(model, data, configuration)


def test_urdf_names_limits_for_ros2_control(tmp_path):
    run("talus-export", "--to", "urdf", "-q", "--limits", "knee.torque=60,knee.speed=4", "--out", tmp_path / "m.urdf", LEG)
    root = ET.parse(tmp_path / "m.urdf").getroot()
    assert root.find("joint[@name='knee']/limit").attrib == {"effort": "60", "velocity": "4"}
    command = root.find("ros2_control/joint[@name='knee']/command_interface[@name='effort']")
    assert [p.text for p in command] == ["-60", "60"]
    assert float(root.find("ros2_control/transmission[@name='knee_transmission']/joint/mechanical_reduction").text) == 51


def test_sdf_has_the_librarys_inertia_about_the_knee(tmp_path):
    run("talus-export", "--to", "sdf", "-q", "--out", tmp_path / "m.sdf", LEG)
    model = ET.parse(tmp_path / "m.sdf").getroot().find("model")
    about = moment = below = 0.0
    for link in model.findall("link"):
        below += -float(link.find("pose").text.split()[2])
        centre = below - float(link.find("inertial/pose").text.split()[2])
        mass = float(link.find("inertial/mass").text)
        about += float(link.find("inertial/inertia/iyy").text) + mass * centre**2
        moment += mass * centre
    mass_matrix, _ = library_matrices(talus.Model.read(LEG), [0.0, 0.0])
    _, level = library_matrices(talus.Model.read(LEG), [np.pi / 2, 0.0])
    assert about == pytest.approx(mass_matrix[0, 0], rel=1e-12) and 9.81 * moment == pytest.approx(level[0], rel=1e-12)
    assert [float(model.find(f"joint[@name='ankle']/axis/dynamics/{k}").text) for k in ("damping", "friction")] == [0.3, 0.8]


def test_bam_has_its_friction(folder):
    """In the keys of BAM's parameter files."""
    exported(folder, "bam", "stribeck")
    tree = json.loads((folder / "out").read_text())
    assert tree["model"] == "m2" and tree["kt"] == pytest.approx(51 * 0.1031) and tree["friction_base"] == 1.2
    size = parameters("stribeck")
    assert (tree["friction_stribeck"], tree["dtheta_stribeck"], tree["alpha"]) == (size["extra_Nm"], size["speed_rad_s"], size["exponent"])


@pytest.mark.long
@pytest.mark.parametrize("name", ["stribeck", "gravity_tilt"])
def test_bam_reads_it(folder, monkeypatch, name):
    """By BAM's own code, its models M2 and M1; `make check-long` installs it apart, and without it this fails."""
    model, _, recording = with_effect(name)
    text, _ = command.export(model, "bam", "m.yaml", recording=talus.Recording.read(folder / recording), joint="knee")
    (folder / "bam.json").write_text(text)
    monkeypatch.syspath_prepend(REPOSITORY / ".venv" / "apart" / "bam")
    theirs = importlib.import_module("bam.model").load_model(str(folder / "bam.json"))
    size = parameters("stribeck")
    for v in (0.01, 0.1, -1.0):
        extra = size["extra_Nm"] * np.exp(-(abs(v / size["speed_rad_s"]) ** size["exponent"])) if name == "stribeck" else 0.0
        assert theirs.compute_frictions(2.0, -1.0, v) == pytest.approx((1.2 + extra, 0.45), rel=1e-12)
    assert theirs.name == ("m2" if name == "stribeck" else "m1") and theirs.actuator.control_unit() == "amps"
    assert theirs.actuator.compute_torque(1.5, True, 0.0, 0.0) == pytest.approx(51 * 0.1031 * 1.5, rel=1e-12)


def test_isaac_configures_each_drive(tmp_path, monkeypatch):
    """Of Isaac Lab's classes only their fields are here: those that a drive of this kind has."""
    base = {"joint_names_expr", "effort_limit", "velocity_limit", "stiffness", "damping", "armature", "friction", "dynamic_friction", "viscous_friction"}
    of_kind = {"DCMotorCfg": base | {"saturation_effort"}, "RemotizedPDActuatorCfg": base - {"effort_limit"} | {"joint_parameter_lookup"}}
    module = types.ModuleType("isaaclab.actuators")
    for name, fields in of_kind.items():
        def make(_name=name, _fields=fields, **given):
            assert set(given) <= _fields
            return _name, given
        setattr(module, name, make)
    monkeypatch.setitem(sys.modules, "isaaclab", types.ModuleType("isaaclab"))
    monkeypatch.setitem(sys.modules, "isaaclab.actuators", module)
    run("talus-export", "--to", "isaac", "-q", "--limits", "knee.torque=60,knee.speed=4,ankle.torque=20", "--out", tmp_path / "drives.py", LEG)
    space = {}
    exec((tmp_path / "drives.py").read_text(), space)  # noqa: S102
    (knee_kind, knee), (ankle_kind, ankle) = space["ACTUATORS"]["knee"], space["ACTUATORS"]["ankle"]
    assert (knee_kind, knee["effort_limit"], knee["saturation_effort"], knee["friction"], knee["viscous_friction"]) == ("DCMotorCfg", 60, 60, 1.2, 0.45)
    ratio = lambda q: float(lib.tl_torque_ratio(talus.Model.read(LEG).struct, 1, q))  # noqa: E731
    assert ankle_kind == "RemotizedPDActuatorCfg" and ankle["armature"] == pytest.approx(2.4e-6 * ratio(0) ** 2)
    for q, gear, limit in ankle["joint_parameter_lookup"]:
        assert gear == pytest.approx(abs(ratio(q))) and limit == pytest.approx(20 * abs(ratio(q) / ratio(0)))


@pytest.mark.parametrize(("arguments", "words"), [
    (["--to", "usd", LEG], "--to: expected c, mjcf, urdf, sdf, bam, isaac or mcap, got usd"),
    (["--to", "bam", LEG], "--joint: expected one of knee, ankle, found none"),
    (["--to", "urdf", "--limits", "hip.speed=3", LEG], "--limits: hip.speed: expected one of knee, ankle"),
    (["--to", "urdf", "--limits", "knee.position=2:1", LEG], "--limits: knee.position: expected LOW:HIGH, found '2:1'"),
    (["--to", "mjcf", "none.yaml"], "none.yaml"),
])  # fmt: skip
def test_refusals_are_one_line_and_write_nothing(tmp_path, arguments, words):
    said = run("talus-export", "--out", tmp_path / "out", *arguments, status=2).stderr
    assert words in said and said.count("\n") == 1 and not list(tmp_path.iterdir())


def test_what_has_no_bodies_is_refused(tmp_path):
    (tmp_path / "paper.yaml").write_text("form: paper\n" + LEG.read_text())
    said = run("talus-export", "--to", "urdf", "--out", tmp_path / "out", tmp_path / "paper.yaml", status=2).stderr
    assert "form: expected lagrange, found paper" in said and not (tmp_path / "out").exists()
