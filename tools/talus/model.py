"""A model as Python sees it: the C struct, read and written by the programs' own code.

    model = talus.Model.read("models/leg.yaml")
    model.parameters["foot_com_m"]          # physical parameters by name
    model.base["foot_moment"]               # the combinations that can be identified
    model.inverse(q, v, a)                  # (joints, n) arrays in, motor torques out
    model.write("changed.yaml")
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy
import yaml
from numpy.typing import ArrayLike

from ._arrays import Array, joint_arrays, pointer, vector
from ._library import InputError, check, check_file, ffi, files, lib


def plants() -> list[str]:
    """The names of all plants, in the order of the library's table.

    >>> talus.plants()
    ['leg', 'pendulum', 'slider']
    """
    return [ffi.string(lib.tl_plant_facts(plant).name).decode() for plant in range(lib.TL_PLANT_COUNT)]


class Model:
    """Plant, parameters and drives, and what else a model file says: `struct` is a `tl_model`, `score` a
    `tl_score_settings`, `window` a `tl_window` or None, `effects` a list of `tl_effect`. Copied by `copy()`.

    >>> model = talus.Model.read("models/pendulum.yaml")
    >>> model.set_parameters(coulomb_Nm=0.3)
    >>> float(model.inverse([0.0], [1e-9], [0.0])[0]) > 0.29
    True
    """

    def __init__(self, plant: str) -> None:
        if plant not in plants():
            raise ValueError(f"plant: expected one of {', '.join(plants())}, found {plant!r}")
        self.plant = plant
        self.struct = ffi.new("tl_model *")
        check(lib.tl_model_init(self.struct, plants().index(plant)))
        self.score: Any = score_settings()
        self.window: Any = None
        self.effects: list[Any] = []
        self._file = ffi.new("struct model_file *")

    @classmethod
    def read(cls, path: str | Path) -> Model:
        """The model of a YAML file. InputError names file, line and key of what is wrong, as every command does.

        >>> talus.Model.read("models/leg.yaml").joints
        ['knee', 'ankle']
        """
        file, error = ffi.new("struct model_file *"), ffi.new("struct app_error *")
        check_file(files().model_file_read(str(path).encode(), file, error), error)
        model = cls(plants()[file.model.plant])
        model._file = file
        model.struct[0] = file.model
        model.score[0] = file.score
        model.window = ffi.new("tl_window *", file.window) if file.has_window else None
        model.effects = [ffi.new("tl_effect *", file.effect[i])[0] for i in range(file.effects)]
        return model

    @classmethod
    def from_tree(cls, tree: Mapping[str, Any]) -> Model:
        """The model of a mapping with the model file's keys, by the same rules as a file.

        >>> axis = {"plant": "slider", "mass_kg": 80, "friction": {"coulomb_N": 20, "viscous_Ns_m": 5}, "force_offset_N": 0}
        >>> talus.Model.from_tree(axis).parameters["mass_kg"]
        80.0
        """
        with tempfile.TemporaryDirectory(prefix="talus-") as folder:
            path = Path(folder) / "model"
            path.write_text(yaml.safe_dump(_plain(tree), sort_keys=False), encoding="utf-8")
            try:
                return cls.read(path)
            except InputError as error:
                raise InputError(str(error).replace(f"{folder}/", "")) from None

    def write(self, path: str | Path, comment: str = "") -> None:
        """The model as a YAML file, which every command reads; the file appears whole or not at all.

        >>> model = talus.Model.read("models/pendulum.yaml")
        >>> model.write("copy.yaml", comment="as it was on Monday")
        >>> talus.Model.read("copy.yaml") == model
        True
        """
        file, error = ffi.new("struct model_file *", self._file[0]), ffi.new("struct app_error *")
        file.model, file.score = self.struct[0], self.score[0]
        file.effects = len(self.effects)
        for i, effect in enumerate(self.effects):
            file.effect[i] = effect
        check_file(files().model_file_write(str(path).encode(), file, comment.encode() or ffi.NULL, error), error)

    @classmethod
    def from_text(cls, text: str) -> Model:
        """The model of a model file's text.

        >>> model = talus.Model.read("models/pendulum.yaml")
        >>> coarse = talus.Model.from_text(model.text() + "score: {lowpass_hz: 10}")
        >>> coarse.score.lowpass_hz
        10.0
        """
        return cls.from_tree(yaml.safe_load(text))

    def text(self) -> str:
        """What `write` writes.

        >>> print(talus.Model.read("models/pendulum.yaml").text())
        plant: pendulum
        ...
        """
        with tempfile.TemporaryDirectory(prefix="talus-") as folder:
            self.write(Path(folder) / "model")
            return (Path(folder) / "model").read_text(encoding="utf-8")

    def __reduce__(self) -> tuple[Any, ...]:
        return Model.from_text, (self.text(),)

    def __eq__(self, other: object) -> bool:
        return self.text() == other.text() if isinstance(other, Model) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # it can be changed

    def __repr__(self) -> str:
        return f"<talus.Model: {self.plant}, {', '.join(f'{k} {v:.4g}' for k, v in self.parameters.items())}>"

    def copy(self) -> Model:
        """An independent model with the same values.

        >>> model = talus.Model.read("models/pendulum.yaml")
        >>> heavier = model.copy()
        >>> heavier.set_parameters(inertia_kg_m2=1.0)
        >>> model.parameters["inertia_kg_m2"] < heavier.parameters["inertia_kg_m2"]
        True
        """
        other = Model(self.plant)
        other.struct[0], other.score[0], other._file[0] = self.struct[0], self.score[0], self._file[0]
        other.window = self.window and ffi.new("tl_window *", self.window[0])
        other.effects = list(self.effects)
        return other

    @property
    def facts(self) -> Any:
        """What is known of the plant without its numbers: the C library's `tl_facts` (talus/plant.h)."""
        return lib.tl_plant_facts(self.struct.plant)

    @property
    def coordinate_unit(self) -> str:
        """Of positions: "rad" or "m"."""
        return self._text(self.facts.coordinate_unit)

    @property
    def torque_unit(self) -> str:
        """Of torques: "Nm", or "N" where they are forces."""
        return self._text(self.facts.torque_unit)

    @property
    def torque_name(self) -> str:
        """"torque" or "force"."""
        return self._text(self.facts.torque_name)

    @property
    def has_gravity(self) -> bool:
        """Does gravity act? Not on a slider, nor on a pendulum whose moment is 0."""
        return bool(lib.tl_has_gravity(self.struct))

    def sensor(self, kind: str) -> list[str]:
        """The columns that show a quantity of the joints, a member of `tl_sensors` such as "position" or "camera", for the
        joints that have one.

        >>> talus.Model.read("models/leg.yaml").sensor("position")
        ['knee_motor_rad', 'ankle_motor_rad']
        """
        channels = list(getattr(self.facts.sensors, kind))[: len(self.joints)]
        return [self._text(lib.tl_channel_name(c)) for c in channels if c != lib.TL_CHANNEL_COUNT]

    @property
    def joints(self) -> list[str]:
        """The joints' names, in the order of every array."""
        return [self._text(lib.tl_joint_name(self.struct, j)) for j in range(lib.tl_joint_count(self.struct))]

    @staticmethod
    def _text(string: Any) -> str:
        return str(ffi.string(string).decode())

    def transmission(self, joint: int) -> Transmission:
        """The transmission of a joint, over whole arrays; changes with the model.

        >>> knee = talus.Model.read("models/leg.yaml").transmission(0)
        >>> knee.motor_rad([0.0, 0.5]).tolist(), knee.ratio([0.5]).tolist()
        ([0.0, 25.5], [51.0])
        """
        return Transmission(self, joint)

    @property
    def parameters(self) -> dict[str, float]:
        """Physical parameters by name, in the order of the C tables."""
        count = ffi.new("int *")
        table = lib.tl_parameters(self.struct, count)
        values = numpy.empty(count[0])
        lib.tl_parameters_get(self.struct, pointer(values))
        return {self._text(table[i].name): float(values[i]) for i in range(count[0])}

    def set_parameters(self, **changes: float) -> None:
        """Set physical parameters by name.

        >>> model = talus.Model.read("models/pendulum.yaml")
        >>> model.set_parameters(coulomb_Nm=0.3, viscous_Nms_rad=0.02)
        >>> model.parameters["coulomb_Nm"]
        0.3
        """
        values = {**self.parameters, **changes}
        if len(values) != len(self.parameters):
            raise KeyError(f"unknown among {sorted(changes)}")
        lib.tl_parameters_set(self.struct, pointer(vector("parameters", list(values.values()), len(values))))

    @property
    def base(self) -> dict[str, float]:
        """Base (linear) parameters by name."""
        values = numpy.empty(lib.tl_base_count(self.struct))
        lib.tl_base_values(self.struct, pointer(values))
        return {self._text(lib.tl_base_name(self.struct, i)): float(x) for i, x in enumerate(values)}

    def inverse(self, q: ArrayLike, v: ArrayLike, a: ArrayLike, slip: ArrayLike | None = None) -> Array:
        """Motor torques (joint torque, force) of a motion; arrays of shape (joints, n) [rad, rad/s, rad/s^2], or (n,)
        where there is one joint. `slip` is the direction of friction, the sign of v if not given.

        >>> axis = talus.Model("slider")
        >>> axis.set_parameters(mass_kg=80, coulomb_N=20)
        >>> axis.inverse(q=[0.0, 0.0], v=[0.1, -0.1], a=[1.0, 1.0]).tolist()  # 80 kg x 1 m/s^2, with and against 20 N
        [100.0, 60.0]
        """
        given = joint_arrays(len(self.joints), q=q, v=v, a=a, slip=slip)
        torque: Array = numpy.empty_like(given[0])
        lib.tl_inverse_batch(self.struct, torque.size // len(self.joints), *map(pointer, given), pointer(torque))
        return torque

    def forward(self, q: ArrayLike, v: ArrayLike, torque: ArrayLike) -> Array:
        """Accelerations [(joints, n)] under motor torques; friction by the sign of v.

        >>> axis = talus.Model("slider")
        >>> axis.set_parameters(mass_kg=80, coulomb_N=20)
        >>> axis.forward(q=[0.0, 0.0], v=[0.1, -0.1], torque=[100.0, 60.0]).tolist()
        [[1.0, 1.0]]
        """
        q, v, torque = map(numpy.atleast_2d, joint_arrays(len(self.joints), q=q, v=v, torque=torque))
        out, motion = numpy.empty_like(q), ffi.new("tl_motion *")
        joints = range(q.shape[0])
        for i in range(q.shape[1]):
            for j in joints:
                motion.q[j], motion.v[j] = q[j, i], v[j, i]
            lib.tl_slip_from_velocity(self.struct, motion)
            check(lib.tl_forward(self.struct, [float(torque[j, i]) for j in joints], motion))
            out[:, i] = [motion.a[j] for j in joints]
        return out

    def energy(self, q: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
        """Kinetic and potential energy [J], two arrays of length n.

        >>> axis = talus.Model("slider")
        >>> axis.set_parameters(mass_kg=80)
        >>> kinetic, potential = axis.energy(q=[0.0, 0.0], v=[0.0, 0.5])
        >>> kinetic.tolist(), potential.tolist()  # half of 80 kg x 0.25 m^2/s^2; no gravity
        ([0.0, 10.0], [0.0, 0.0])
        """
        q, v = map(numpy.atleast_2d, joint_arrays(len(self.joints), q=q, v=v))
        motion, parts = ffi.new("tl_motion *"), ffi.new("double[2]")
        out = numpy.empty((2, q.shape[1]))
        for i in range(q.shape[1]):
            for j in range(q.shape[0]):
                motion.q[j], motion.v[j] = q[j, i], v[j, i]
            lib.tl_energy(self.struct, motion, parts, parts + 1)
            out[:, i] = parts[0], parts[1]
        return out[0], out[1]


def _plain(tree: Any) -> Any:
    """The mapping with NumPy's numbers as Python's, as YAML writes them."""
    if isinstance(tree, dict):
        return {str(key): _plain(value) for key, value in tree.items()}
    if isinstance(tree, (list, tuple, numpy.ndarray)):
        return [_plain(value) for value in tree]
    return tree.item() if isinstance(tree, numpy.generic) else tree


class Transmission:
    """Motor angle, ratio and joint angle of a model's joint [rad], of whole arrays."""

    def __init__(self, model: Model, joint: int) -> None:
        self.model, self.struct = model, ffi.addressof(model.struct.drive[joint], "transmission")

    def motor_rad(self, joint_rad: ArrayLike) -> Array:
        return self._each(lib.tl_transmission_motor_angles, joint_rad)

    def ratio(self, joint_rad: ArrayLike) -> Array:
        """d motor / d joint."""
        return self._each(lib.tl_transmission_ratios, joint_rad)

    def joint_rad(self, motor_rad: ArrayLike) -> Array:
        """NaN where the linkage does not reach."""
        return self._each(lib.tl_transmission_joint_angles, motor_rad)

    def _each(self, function: Any, angles: ArrayLike) -> Array:
        angles = numpy.ascontiguousarray(angles, dtype=float)
        out = numpy.empty_like(angles)
        function(self.struct, pointer(angles), angles.size, pointer(out))
        return out


def score_settings(tree: Mapping[str, float] | None = None) -> Any:
    """A `tl_score_settings` with the defaults, changed by the mapping `tree` (the file's `score:`).

    >>> talus.score_settings({"lowpass_hz": 20}).lowpass_hz
    20.0
    """
    settings = ffi.new("tl_score_settings *", lib.tl_score_defaults())
    for name, value in (tree or {}).items():
        setattr(settings, name, value)
    return settings
