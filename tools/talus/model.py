"""A model as Python sees it: the C struct, filled from a model file or a mapping.

    model = talus.Model.read("models/leg.yaml")
    model.parameters["foot_com_m"]          # physical parameters by name
    model.base["foot_moment"]               # the combinations that can be identified
    model.inverse(q, v, a)                  # (joints, n) arrays in, motor torques out
"""


import numpy
import yaml

from ._arrays import pointer
from ._library import check, ffi, lib

_PLANTS = {"leg": "TL_PLANT_LEG", "pendulum": "TL_PLANT_PENDULUM", "slider": "TL_PLANT_SLIDER"}

# keys of the model file that stand in the struct under another name
_SCALARS = {
    "leg": {
        "gravity_m_s2": "gravity_m_s2",
        "shank.length_m": "shank_length_m",
        "shank.mass_kg": "shank_mass_kg",
        "shank.com_m": "shank_com_m",
        "shank.inertia_kg_m2": "shank_inertia_kg_m2",
        "foot.mass_kg": "foot_mass_kg",
        "foot.com_m": "foot_com_m",
        "foot.inertia_kg_m2": "foot_inertia_kg_m2",
        "ankle_motor.mass_kg": "ankle_motor_mass_kg",
        "ankle_motor.com_m": "ankle_motor_com_m",
    },
    "pendulum": {
        name: name
        for name in ("gravity_m_s2", "inertia_kg_m2", "gravity_moment_kg_m", "gravity_zero_rad", "torque_offset_Nm")
    },
    "slider": {"mass_kg": "mass_kg", "force_offset_N": "force_offset_N"},
}


def _at(tree, path):
    for key in path.split("."):
        tree = tree.get(key, {}) if isinstance(tree, dict) else {}
    return tree if not isinstance(tree, dict) else None


class Model:
    """Plant, parameters and drives; wraps a `tl_model` and is copied by `copy()`."""

    def __init__(self, plant):
        self.plant = plant
        self.struct = ffi.new("tl_model *")
        check(lib.tl_model_init(self.struct, getattr(lib, _PLANTS[plant])))

    @classmethod
    def read(cls, path):
        """The model of a YAML file. For strict checks with line numbers use the commands."""
        with open(path, encoding="utf-8") as file:
            return cls.from_tree(yaml.safe_load(file))

    @classmethod
    def from_tree(cls, tree):
        """The model of a mapping with the model file's keys."""
        model = cls(tree["plant"])
        for path, field in _SCALARS[model.plant].items():
            value = _at(tree, path)
            if value is not None:
                setattr(model.struct, field, value)
        if tree.get("form", "lagrange") == "paper":
            model.struct.form = lib.TL_FORM_PAPER
        joints = {"leg": ("knee", "ankle"), "pendulum": ("joint",), "slider": (None,)}[model.plant]
        for index, joint in enumerate(joints):
            model._read_drive(index, tree[joint] if joint else tree)
        check(lib.tl_model_check(model.struct))
        return model

    def _read_drive(self, index, tree):
        drive = self.struct.drive[index]
        friction = tree["friction"]
        drive.coulomb_Nm = friction.get("coulomb_Nm", friction.get("coulomb_N", 0.0))
        drive.viscous_Nms_rad = friction.get("viscous_Nms_rad", friction.get("viscous_Ns_m", 0.0))
        drive.torque_constant_Nm_A = tree.get("torque_constant_Nm_A", 0.0)
        drive.rotor_inertia_kg_m2 = tree.get("rotor_inertia_kg_m2", 0.0)
        if "transmission" in tree:
            self._read_transmission(drive, dict(tree["transmission"]))

    def _read_transmission(self, drive, tree):
        kind = tree.pop("type")
        target = ffi.addressof(drive, "transmission")
        if kind == "fixed":
            check(lib.tl_transmission_fixed(target, tree["ratio"]))
        elif kind == "screw_linkage":
            check(lib.tl_transmission_screw_linkage(target, ffi.new("tl_screw_linkage *", tree)))
        else:
            check(lib.tl_transmission_fourier(target, ffi.new("tl_fourier *", tree)))

    def copy(self):
        """An independent model with the same values."""
        other = Model(self.plant)
        other.struct[0] = self.struct[0]
        return other

    @property
    def joints(self):
        """The joints' names, in the order of every array."""
        return [self._text(lib.tl_joint_name(self.struct, j)) for j in range(lib.tl_joint_count(self.struct))]

    @staticmethod
    def _text(string):
        return ffi.string(string).decode()

    @property
    def parameters(self):
        """Physical parameters by name, in the order of the C tables."""
        count = ffi.new("int *")
        table = lib.tl_parameters(self.struct, count)
        values = numpy.empty(count[0])
        lib.tl_parameters_get(self.struct, pointer(values))
        return {self._text(table[i].name): float(values[i]) for i in range(count[0])}

    def set_parameters(self, **changes):
        """Set physical parameters by name."""
        values = {**self.parameters, **changes}
        if len(values) != len(self.parameters):
            raise KeyError(f"unknown among {sorted(changes)}")
        lib.tl_parameters_set(self.struct, pointer(numpy.array(list(values.values()), dtype=float)))

    @property
    def base(self):
        """Base (linear) parameters by name."""
        values = numpy.empty(lib.tl_base_count(self.struct))
        lib.tl_base_values(self.struct, pointer(values))
        return {self._text(lib.tl_base_name(self.struct, i)): float(x) for i, x in enumerate(values)}

    def inverse(self, q, v, a, slip=None):
        """Motor torques (joint torque, force) [(joints, n)] of a motion; arrays of shape (joints, n).
        `slip` is the direction of friction, the sign of v if not given."""
        q, v, a = (numpy.ascontiguousarray(x, dtype=float) for x in (q, v, a))
        slip = None if slip is None else numpy.ascontiguousarray(slip, dtype=float)
        torque = numpy.empty_like(q)
        lib.tl_inverse_batch(self.struct, q.size // len(self.joints), pointer(q), pointer(v), pointer(a),
                             pointer(slip), pointer(torque))
        return torque

    def forward(self, q, v, torque):
        """Accelerations [(joints, n)] under motor torques; friction by the sign of v."""
        q, v, torque = (numpy.atleast_2d(numpy.asarray(x, dtype=float)) for x in (q, v, torque))
        out = numpy.empty_like(q)
        motion = ffi.new("tl_motion *")
        joints = range(q.shape[0])
        for i in range(q.shape[1]):
            for j in joints:
                motion.q[j], motion.v[j] = q[j, i], v[j, i]
            lib.tl_slip_from_velocity(self.struct, motion)
            check(lib.tl_forward(self.struct, [float(torque[j, i]) for j in joints], motion))
            for j in joints:
                out[j, i] = motion.a[j]
        return out

    def energy(self, q, v):
        """Kinetic and potential energy [J], two arrays of length n."""
        q, v = (numpy.atleast_2d(numpy.asarray(x, dtype=float)) for x in (q, v))
        motion, parts = ffi.new("tl_motion *"), ffi.new("double[2]")
        out = numpy.empty((2, q.shape[1]))
        for i in range(q.shape[1]):
            for j in range(q.shape[0]):
                motion.q[j], motion.v[j] = q[j, i], v[j, i]
            lib.tl_energy(self.struct, motion, parts, parts + 1)
            out[:, i] = parts[0], parts[1]
        return out[0], out[1]


def score_settings(tree=None):
    """A `tl_score_settings` with the defaults, changed by the mapping `tree` (the file's `score:`)."""
    settings = ffi.new("tl_score_settings *", lib.tl_score_defaults())
    for name, value in (tree or {}).items():
        setattr(settings, name, value)
    return settings


