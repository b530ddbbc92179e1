"""What MJCF cannot say of an identified model, in MuJoCo: forces of effects, and what the sensors show.

    import mujoco, talus, talus.mujoco

    model = talus.Model.read("leg.yaml")
    simulated = talus.mujoco.load(model)            # as talus-export --to mjcf writes it
    data = mujoco.MjData(simulated)
    with talus.mujoco.Runtime(model, simulated, data) as runtime:
        data.ctrl[:] = motor_torque
        runtime.step()
        runtime.shown()["knee_current_A"]

MuJoCo is an optional extra of the package: pip install 'talus[mujoco]'.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ._library import check, constants, ffi, lib
from .model import Model

try:
    import mujoco as mj
except ImportError as error:  # pragma: no cover
    raise ImportError("talus.mujoco needs MuJoCo: pip install 'talus[mujoco]'") from error

if TYPE_CHECKING:
    from types import TracebackType

FLOOR_Nm = 1e-9  # of friction: a row that is 0 would vanish from MuJoCo's constraints
LOAD_STEPS = 50  # at most, until load and friction agree
LOAD_TOLERANCE = 1e-12
STILL = 1e-7  # below this speed [rad/s] the direction of friction is that of the push


def load(model: Model) -> Any:
    """The model as a mujoco.MjModel.

    >>> import talus.mujoco
    >>> talus.mujoco.load(talus.Model.read("models/leg.yaml")).nv
    2
    """
    from .exporting import chain, limits, mjcf, target  # loads SciPy

    held = target.Held(chain.of(model, target.twists_of(model)), [{} for _ in model.joints], [{} for _ in model.joints])
    target.take_exact(model, target.TARGETS["mjcf"], held)
    return mj.MjModel.from_xml_string(mjcf.text(held, limits.read("", model), model.plant))


class Runtime:
    """Carries a model's effects into a simulation whose joints and actuators have the names that talus-export gives them.

    It takes over these joints: damping, stiffness, friction and the actuator's gain in `simulated` become 0, and what the model
    says is in qfrc_passive and in the friction's rows at every evaluation. MuJoCo has one callback for all simulations of a process, so one Runtime can be open at a time. The
    control is torque as the drive's current shows it: of the motor for a leg, of the joint else. A model's elasticity and backlash
    need the bodies of the file (NAME_twist)."""

    def __init__(self, model: Model, simulated: Any, data: Any) -> None:
        self.model, self.simulated, self.data = model, simulated, data
        self._effects = ffi.new("tl_effect[]", model.effects or [lib.tl_effect_typical(lib.tl_effect_find(b"stribeck"), 0)])
        self._joints = [_Drive(self, j) for j in range(len(model.joints))]
        self._before: Any = None

    def __enter__(self) -> Runtime:
        self._before = mj.get_mjcb_passive()
        mj.set_mjcb_passive(self._called)
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        mj.set_mjcb_passive(self._before)

    def step(self, steps: int = 1) -> None:
        """mj_step, so many times; memory of friction and of what is late goes on after each."""
        for _ in range(steps):
            mj.mj_step(self.simulated, self.data)
            for drive in self._joints:
                drive.go_on()

    def forces(self) -> None:
        """Sets friction's levels and adds the effects' torques to qfrc_passive; MuJoCo calls it while a Runtime is open."""
        for drive in self._joints:
            drive.act()

    def shown(self) -> dict[str, float]:
        """What the recording's columns show now: encoders with their errors, currents as late as they are; a torque sensor at the
        output, with its zero, as it was at MuJoCo's last evaluation (mj_forward makes one)."""
        out: dict[str, float] = {}
        for drive in self._joints:
            out.update(drive.shown())
        return out

    def _called(self, simulated: Any, data: Any) -> None:
        if data is self.data or data._address == self.data._address:  # not that of another simulation
            self.forces()


class _Drive:
    """One joint's drive: its law at an instant, and its memory between steps."""

    def __init__(self, runtime: Runtime, number: int) -> None:
        m, model = runtime.simulated, runtime.model
        self.runtime, self.model, self.number, self.name = runtime, model, number, model.joints[number]
        joint = m.joint(self.name)
        self.id, self.q_at, self.v_at = joint.id, int(joint.qposadr[0]), int(joint.dofadr[0])
        self.actuator = m.actuator(self.name).id
        self.effects = [e for e in model.effects if e.joint in (number, constants.TL_MAX_JOINTS) and e.kind.law != ffi.NULL]
        self.of_motion = [e for e in self.effects if e.kind.acts == lib.TL_EFFECT_MECHANICAL and e.joint == number]
        self.of_current = [e for e in self.effects if e.kind.acts == lib.TL_EFFECT_MEASURED and not e.kind.needs_load_sensor]
        self.change = lib.tl_effects_change(runtime._effects, len(model.effects), number)
        self.plant = self._plant()
        self._take_over(m)
        self.z = 0.0
        self.z_from = float(runtime.data.qpos[self.q_at])
        self.late: list[tuple[float, float]] = []
        self.motor_Nm = 0.0
        self.has_load = self.twist_at is None and model.facts.sensors.load != lib.TL_CHANNEL_COUNT
        self.given_Nm, self.q_given = 0.0, self.z_from
        self.own = self._frictionless() if self.has_load else model
        self.load_offset_Nm = sum(float(e.value[0]) for e in self.effects if e.kind.needs_load_sensor and e.kind.acts == lib.TL_EFFECT_MEASURED)

    def _plant(self) -> Any:
        """The model with the linkage as it truly is."""
        plant = ffi.new("tl_model *", self.model.struct[0])
        if self.change.AB_m or self.change.BO_m or self.change.AC_m or self.change.BOF_rad:
            changed = ffi.new("tl_transmission *")
            change = ffi.new("tl_effect_change *", self.change)
            check(lib.tl_effect_change_linkage(change, ffi.addressof(plant.drive[self.number], "transmission"), changed))
            plant.drive[self.number].transmission = changed[0]
        return plant

    def _frictionless(self) -> Model:
        """Inertia and gravity of the joint alone."""
        own = self.model.copy()
        own.effects = []
        own.set_parameters(coulomb_Nm=0.0, viscous_Nms_rad=0.0, torque_offset_Nm=0.0)
        return own

    def _take_over(self, m: Any) -> None:
        m.dof_damping[self.v_at], m.jnt_stiffness[self.id] = 0.0, 0.0
        for poly in ("dof_dampingpoly", "jnt_stiffnesspoly"):
            if hasattr(m, poly):
                getattr(m, poly)[self.v_at if poly[0] == "d" else self.id] = 0.0
        m.dof_frictionloss[self.v_at] = max(m.dof_frictionloss[self.v_at], FLOOR_Nm)
        m.actuator_gainprm[self.actuator, 0], m.actuator_biasprm[self.actuator, :3] = 0.0, 0.0  # its torque is added here
        twist = mj.mj_name2id(m, mj.mjtObj.mjOBJ_JOINT, f"{self.name}_twist")
        self.spring, self.twist_at = None, (int(m.jnt_qposadr[twist]), int(m.jnt_dofadr[twist])) if twist >= 0 else None
        c = self.change
        if twist >= 0 and (c.gap_rad or c.soft_rad):
            m.jnt_stiffness[twist], m.dof_damping[self.twist_at[1]] = 0.0, 0.0  # type: ignore[index]
            stiffness = 1.0 / c.compliance_rad_Nm
            self.spring = ffi.new("tl_spring *", [stiffness, c.gap_rad, c.soft_rad, 1.0 - c.soft_loss, c.hardening_Nm_rad3, c.damping_s * stiffness])

    # -- an instant

    def act(self) -> None:
        """Torque and friction at the present state of MuJoCo's evaluation."""
        d, now = self.runtime.data, self._instant()
        drive = self.model.struct.drive[self.number]
        self.motor_Nm = self._delivered(float(d.ctrl[self.actuator]), now)
        at_joint = self.motor_Nm * float(lib.tl_torque_ratio(self.plant, self.number, now.q))
        push = at_joint - drive.viscous_Nms_rad * now.v - float(lib.tl_joint_offset(self.plant, self.number))
        torque, level = self._solve(now, push)
        memory = self.change.memory_Nm
        level += drive.coulomb_Nm - memory
        self.given_Nm, self.q_given = push - torque - memory * self._z(now.q) + self._rotor(now), float(now.q)
        d.qfrc_passive[self.v_at] += self.given_Nm
        self._set_level(max(level, FLOOR_Nm))
        if self.spring is not None and self.twist_at is not None:
            loss = ffi.new("double *")
            q, v = float(d.qpos[self.twist_at[0]]), float(d.qvel[self.twist_at[1]])
            d.qfrc_passive[self.twist_at[1]] -= lib.tl_spring_torque(self.spring, q, v, loss)

    def _instant(self) -> Any:
        d = self.runtime.data
        motion, now = ffi.new("tl_motion *"), ffi.new("tl_effect_instant *")
        for drive in self.runtime._joints:
            motion.q[drive.number], motion.v[drive.number] = d.qpos[drive.q_at], d.qvel[drive.v_at]
            motion.a[drive.number] = d.qacc[drive.v_at]
        v = motion.v[self.number]
        away = self._push_guess() if abs(v) < STILL else v
        motion.slip[self.number] = 1.0 if away >= 0 else -1.0
        lib.tl_effect_place_of(self.plant, motion, self.number, float(d.time), now)
        now.rotor_Nm = lib.tl_rotor_torque(self.plant, motion, self.number)
        return now

    def _push_guess(self) -> float:
        d = self.runtime.data
        return float(d.ctrl[self.actuator]) * float(np.sign(lib.tl_torque_ratio(self.plant, self.number, 0.0))) - float(d.qfrc_bias[self.v_at])

    def _solve(self, now: Any, push: float) -> tuple[float, float]:
        """Torque and friction of the effects, with the load that is left for inertia and gravity where both act."""
        drive, memory = self.model.struct.drive[self.number], self.change.memory_Nm
        now.motor_Nm = self.motor_Nm
        now.friction_Nm = drive.coulomb_Nm * now.slip + drive.viscous_Nms_rad * now.v
        now.load_Nm, torque, level = push, 0.0, 0.0
        for _ in range(LOAD_STEPS if self.of_motion else 0):
            torque, level = self._laws(self.of_motion, now)
            load = push - torque - memory * self._z(now.q) - now.slip * max(level + drive.coulomb_Nm - memory, 0.0)
            settled = abs(load - now.load_Nm) <= LOAD_TOLERANCE * (abs(push) + abs(load))
            now.load_Nm = load
            if settled:
                break
        return torque, level

    @staticmethod
    def _laws(effects: list[Any], now: Any) -> tuple[float, float]:
        one, friction = ffi.new("double *"), ffi.new("double *")
        total, level = 0.0, 0.0
        for effect in effects:
            lib.tl_effect_law(ffi.new("tl_effect *", effect), now, one, friction)
            total, level = total + one[0], level + friction[0]
        return total, level

    def _delivered(self, shown: float, now: Any) -> float:
        """The drive's torque for what its current shows: the measured effects' laws, inverted."""
        factor = 1.0 + self.change.torque_constant_error
        torque = shown * factor
        scale = float(lib.tl_torque_ratio(self.plant, self.number, now.q)) if self.model.plant == "leg" else 1.0
        for _ in range(LOAD_STEPS if self.of_current else 0):
            now.motor_Nm = torque
            more = self._laws(self.of_current, now)[0] / scale
            if abs(shown * factor - more - torque) <= LOAD_TOLERANCE * abs(shown):
                break
            torque = shown * factor - more
        return float(torque)

    def _rotor(self, now: Any) -> float:
        """What a ratio that changes with the angle asks beside the armature. The armature itself is set for the next evaluation;
        what it lacks in this one is taken with the last acceleration."""
        m, d = self.runtime.simulated, self.runtime.data
        inertia = self.model.struct.drive[self.number].rotor_inertia_kg_m2
        if not inertia or self.model.plant != "leg" or self.number == 0:
            return 0.0
        ratio, step = now.ratio, 1e-5
        slope = (self._ratio(now.q + step) - self._ratio(now.q - step)) / (2 * step)
        used, true = float(m.dof_armature[self.v_at]), inertia * ratio**2
        m.dof_armature[self.v_at] = true
        return float((used - true) * d.qacc[self.v_at] - inertia * ratio * slope * now.v**2)

    def _ratio(self, q: float) -> float:
        return float(lib.tl_torque_ratio(self.plant, self.number, q))

    def _set_level(self, level: float) -> None:
        """Of MuJoCo's row for this joint's friction; the model's number is what the next evaluation starts from."""
        m, d = self.runtime.simulated, self.runtime.data
        m.dof_frictionloss[self.v_at] = level
        rows = (d.efc_type == mj.mjtConstraint.mjCNSTR_FRICTION_DOF) & (d.efc_id == self.v_at)
        d.efc_frictionloss[rows] = level

    # -- between steps

    def _z(self, q: float) -> float:
        """Presliding's memory, along the way since the last step."""
        if not self.change.memory_Nm:
            return 0.0
        way, out = ffi.new("double[2]", [self.z_from, q]), ffi.new("double[2]")
        lib.tl_dahl_along(way, 2, self.change.travel_rad, self.change.memory_power, self.z, out)
        return float(out[1])

    def go_on(self) -> None:
        d = self.runtime.data
        q = float(d.qpos[self.q_at])
        self.z, self.z_from = self._z(q), q
        if self.change.delay_s:
            self.late.append((float(d.time), float(d.ctrl[self.actuator])))
            while len(self.late) > 1 and self.late[1][0] < d.time - abs(self.change.delay_s):
                self.late.pop(0)

    def shown(self) -> dict[str, float]:
        d, facts, sensors = self.runtime.data, self.model.facts, self.model.facts.sensors
        q = float(d.qpos[self.q_at])
        motor = float(lib.tl_motor_angle(self.plant, self.number, q)) if sensors.at_motor else q
        values = {"position": motor + self._wave("motor_encoder", motor), "encoder": q + self._wave("joint_encoder", q), "velocity": float(d.qvel[self.v_at]),
                  "current": self._shown_torque(), "torque": self._shown_torque()}  # fmt: skip
        constant = self.model.struct.drive[self.number].torque_constant_Nm_A
        values["current"] /= constant * (1.0 if sensors.at_motor else float(lib.tl_motor_ratio(self.plant, self.number, q))) or 1.0
        out = {}
        for kind, value in values.items():
            channel = getattr(facts.sensors, kind)[self.number]
            if channel != lib.TL_CHANNEL_COUNT:
                out[ffi.string(lib.tl_channel_name(channel)).decode()] = value
        if self.has_load:
            out[ffi.string(lib.tl_channel_name(sensors.load)).decode()] = self._load_Nm() + self.load_offset_Nm
        return out

    def _load_Nm(self) -> float:
        """What the joint delivers to whatever else pushes or hangs there: its drive's torque less friction, inertia and gravity of its own."""
        d = self.runtime.data
        friction = d.efc_force[(d.efc_type == mj.mjtConstraint.mjCNSTR_FRICTION_DOF) & (d.efc_id == self.v_at)]
        (own,) = self.own.inverse(q=[self.q_given], v=[0.0], a=[float(d.qacc[self.v_at])])
        return self.given_Nm + float(np.sum(friction)) - float(own)

    def _shown_torque(self) -> float:
        """The control as the current shows it: what was asked `delay_s` earlier."""
        d, delay = self.runtime.data, self.change.delay_s
        if not self.late:
            return float(d.ctrl[self.actuator])
        times, values = zip(*self.late, strict=True)
        return float(np.interp(d.time - delay, times, values))

    def _wave(self, kind: str, angle: float) -> float:
        value = ffi.new("double[3]")
        lib.tl_effect_waves_at(ffi.addressof(ffi.new("tl_effect_change *", self.change), kind), angle, value)
        return float(value[0])
