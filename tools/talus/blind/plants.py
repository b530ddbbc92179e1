"""Plants as they really are, and as a model file has them: a leg, one rotary joint alone, one linear axis.

The twin knows two drives, `knee` and `ankle`; a plant with one joint is the twin's knee alone."""

from dataclasses import asdict, dataclass, field

import numpy as np

LINKAGE = {"lead_m": 0.002, "AB_m": 0.090, "BO_m": 0.040, "AC_m": 0.035, "BOF_deg": 84.75}
FIXED = {"gravity": 9.81, "ms": 1.624, "mf": 0.442, "mm": 0.4112, "ls": 0.3615, "ratio": 51.0, "K": 0.1031}
G = FIXED["gravity"]


@dataclass
class Scale:
    """How large a joint's motion and torque are: what is a small effect or a large one goes by it. `torque`, `angle` and
    `speed` are relative to the narrow protocol's joint, so that they are 1 there."""

    ratio: float
    fast: float  # rad/s, about the fastest of training
    peak_A: float
    peak_Nm: float
    half_range: float
    torque: float = 1.0
    angle: float = 1.0
    speed: float = 1.0
    motor: float = 1.0  # torque at the motor
    stiffest: float = np.inf  # beyond it a spring would need shorter steps than the twin makes
    units: tuple = ("rad", "Nm")


NARROW = {"knee": Scale(51.0, 4.5, 2.2, 8.0, 0.55), "ankle": Scale(125.0, 3.2, 0.24, 1.6, 0.33)}


def scaled(joint, ratio, fast, peak_A, peak_Nm, half_range, stiffest, units=("rad", "Nm")):
    """A joint's scale from what its bench shows without any effect."""
    like = NARROW[joint]
    torque = peak_Nm / like.peak_Nm
    return Scale(ratio, fast, peak_A, peak_Nm, half_range, torque, half_range / like.half_range, fast / like.fast,
                 torque * like.ratio / ratio, stiffest, units)  # fmt: skip


def log_uniform(rng, low, high):
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def off(rng, parameters, part):
    """Parameters, each off by up to its part."""
    return {name: x * rng.uniform(1 - part(name), 1 + part(name)) for name, x in parameters.items()}


@dataclass
class Leg:
    """A leg as it really is."""

    shank_com_m: float
    shank_inertia_kg_m2: float
    foot_com_m: float
    foot_inertia_kg_m2: float
    ankle_motor_com_m: float
    ankle_rotor_inertia_kg_m2: float
    knee_coulomb_Nm: float
    knee_viscous_Nms_rad: float
    ankle_coulomb_Nm: float
    ankle_viscous_Nms_rad: float

    # what the model file knows exactly, and the joints' scales: no fields, so that the parameters are those above
    kind, joints, shown = "leg", ("knee", "ankle"), {}  # noqa: RUF012
    fixed, linkage, scale = FIXED, LINKAGE, NARROW

    @staticmethod
    def draw(rng):
        near = lambda x, part: x * rng.uniform(1 - part, 1 + part)  # noqa: E731
        return Leg(near(0.160, 0.13), near(0.042, 0.25), near(0.055, 0.13), near(0.0021, 0.25), near(0.118, 0.13),
                     near(2.4e-6, 0.2), rng.uniform(0.8, 2.5), rng.uniform(0.2, 0.8), rng.uniform(0.4, 1.2),
                     rng.uniform(0.1, 0.5))  # fmt: skip

    @staticmethod
    def draw_any(rng):
        """A powered leg of any make: from a child's to a heavy man's, harmonic drives or planetary gears at the knee."""
        near = lambda x, part: x * rng.uniform(1 - part, 1 + part)  # noqa: E731
        length, ms, mf, mm = (round(rng.uniform(*ends), 4) for ends in ((0.28, 0.46), (1.0, 3.2), (0.3, 1.1), (0.2, 0.9)))
        size, ratio = rng.uniform(0.8, 1.3), log_uniform(rng, 25, 160)
        rotor = log_uniform(rng, 0.1, 0.5) * ms * length**2 / 8  # the knee's, reflected; I1 holds it
        leg = Leg(length * rng.uniform(0.35, 0.55), ms * length**2 / 12 * rng.uniform(0.8, 1.3) + rotor,
                  rng.uniform(0.03, 0.08), mf * rng.uniform(0.06, 0.09) ** 2, length * rng.uniform(0.2, 0.45),
                  log_uniform(rng, 1e-6, 8e-6), 0.0, 0.0, 0.0, 0.0)  # fmt: skip
        leg.fixed = {"gravity": G, "ms": ms, "mf": mf, "mm": mm, "ls": length, "ratio": round(ratio, 2),
                     "K": round(log_uniform(rng, 0.04, 0.18), 4)}  # fmt: skip
        leg.linkage = {"lead_m": float(rng.choice([0.002, 0.0025, 0.003, 0.004, 0.005])),
                       **{k: round(near(LINKAGE[k] * size, 0.05), 5) for k in ("AB_m", "BO_m", "AC_m")},
                       "BOF_deg": round(rng.uniform(80.0, 90.0), 2)}  # fmt: skip
        weight = {"knee": G * (ms * leg.shank_com_m + mf * length), "ankle": G * mf * leg.foot_com_m + 0.3}
        for joint in leg.joints:
            coulomb = log_uniform(rng, 0.06, 0.4) * weight[joint]
            setattr(leg, f"{joint}_coulomb_Nm", coulomb)
            setattr(leg, f"{joint}_viscous_Nms_rad", coulomb * log_uniform(rng, 0.1, 0.8))
        return leg

    def friction(self, joint):
        return getattr(self, f"{joint}_coulomb_Nm"), getattr(self, f"{joint}_viscous_Nms_rad")

    def parameters(self):
        return asdict(self)

    def ratio(self, joint):
        """Motor angle over joint angle, of the ankle about the middle of its range."""
        if joint == "knee":
            return self.fixed["ratio"]
        ab, bo, ac = (self.linkage[k] for k in ("AB_m", "BO_m", "AC_m"))
        phi = np.pi - np.radians(self.linkage["BOF_deg"])
        h = ac - bo * np.sin(phi)
        return 2 * np.pi / self.linkage["lead_m"] * (bo * np.sin(phi) - h * bo * np.cos(phi) / np.sqrt(ab**2 - h**2))

    def inertia(self, joint):
        """At a joint, with the rotor's."""
        base = self.base()
        if joint == "knee":
            return base["shank_inertia"] + self.fixed["mf"] * self.fixed["ls"] ** 2 + base["foot_inertia"]
        return base["foot_inertia"] + self.ankle_rotor_inertia_kg_m2 * self.ratio("ankle") ** 2

    def rotor(self, joint):
        """What turns with the motor, at the joint: of the knee's a guess."""
        return 0.2 * self.shank_inertia_kg_m2 if joint == "knee" else self.ankle_rotor_inertia_kg_m2 * self.ratio("ankle") ** 2

    def cad(self, rng):
        """A model file as CAD gives it: what has to be identified is off."""
        return self.model_text(off(rng, self.parameters(), self.off_by))

    def base(self):
        """What can be identified of the inertial parameters."""
        fixed = self.fixed
        shank = self.shank_inertia_kg_m2 + fixed["ms"] * self.shank_com_m**2 + fixed["mm"] * self.ankle_motor_com_m**2
        return {
            "shank_inertia": shank,
            "shank_moment": fixed["ms"] * self.shank_com_m + fixed["mm"] * self.ankle_motor_com_m,
            "foot_moment": fixed["mf"] * self.foot_com_m,
            "foot_inertia": self.foot_inertia_kg_m2 + fixed["mf"] * self.foot_com_m**2,
            "ankle_rotor_inertia": self.ankle_rotor_inertia_kg_m2,
        }

    def job(self):
        """The plant as the twin's names."""
        fixed, linkage = self.fixed, self.linkage
        job = {"gravity": G, "ms": fixed["ms"], "ds": self.shank_com_m, "i1": self.shank_inertia_kg_m2,
               "mf": fixed["mf"], "df": self.foot_com_m, "i_f": self.foot_inertia_kg_m2, "mm": fixed["mm"],
               "dma": self.ankle_motor_com_m, "ls": fixed["ls"], "ima": self.ankle_rotor_inertia_kg_m2,
               "ratio": fixed["ratio"], "lead": linkage["lead_m"], "bof": np.radians(linkage["BOF_deg"])}  # fmt: skip
        for name in ("ab", "bo", "ac"):
            job[name] = job[f"n_{name}"] = linkage[f"{name.upper()}_m"]
        for joint in self.joints:
            job[f"{joint}.coulomb"], job[f"{joint}.viscous"] = self.friction(joint)
            job[f"{joint}.torque_constant"] = self.torque_constant(joint)
        return job

    def torque_constant(self, joint):
        return self.fixed["K"]

    @staticmethod
    def off_by(name):
        """Part by which a CAD value is off at the most."""
        return 0.10 if name.endswith("com_m") else 0.20 if "inertia" in name else 0.40

    def model_text(self, parameters):
        """A model file with these values of what has to be identified, and the drawing's of all else."""
        p, fixed = {name: f"{value:.9g}" for name, value in parameters.items()}, self.fixed
        com = [p[f"{name}_com_m"] for name in ("shank", "foot", "ankle_motor")]
        inertia = [p[name] for name in ("shank_inertia_kg_m2", "foot_inertia_kg_m2", "ankle_rotor_inertia_kg_m2")]
        friction = [p[f"{joint}_{what}"] for joint in self.joints for what in ("coulomb_Nm", "viscous_Nms_rad")]
        sizes = ", ".join(f"{name}: {value}" for name, value in self.linkage.items())
        ratio = f"{fixed['ratio']:g}"
        return f"""plant: leg
gravity_m_s2: {G}
shank: {{length_m: {fixed["ls"]}, mass_kg: {fixed["ms"]}, com_m: {com[0]}, inertia_kg_m2: {inertia[0]}}}
foot: {{mass_kg: {fixed["mf"]}, com_m: {com[1]}, inertia_kg_m2: {inertia[1]}}}
ankle_motor: {{mass_kg: {fixed["mm"]}, com_m: {com[2]}}}
knee:
  transmission: {{type: fixed, ratio: {ratio}}}
  torque_constant_Nm_A: {fixed["K"]}
  friction: {{coulomb_Nm: {friction[0]}, viscous_Nms_rad: {friction[1]}}}
ankle:
  transmission: {{type: screw_linkage, {sizes}}}
  torque_constant_Nm_A: {fixed["K"]}
  rotor_inertia_kg_m2: {inertia[2]}
  friction: {{coulomb_Nm: {friction[2]}, viscous_Nms_rad: {friction[3]}}}
"""


@dataclass
class Single:
    """One joint alone: inertia with the rotor's in it, gravity by an arm, friction, and a constant torque that the motor has to give. For a
    linear axis kg, N and m stand in place of kg m², Nm and rad."""

    inertia_: float
    rotor_: float
    gravity_moment_kg_m: float
    gravity_zero_rad: float
    offset: float
    coulomb: float
    viscous: float
    gear: float
    K: float
    kind: str = "pendulum"
    scale: dict = field(default_factory=dict)
    joints = ("knee",)

    @staticmethod
    def draw_pendulum(rng):
        """From a servo's arm to a robot's elbow; three of ten carry nothing that falls."""
        arm, mass = rng.uniform(0.1, 0.6), log_uniform(rng, 0.1, 5.0)
        falls = rng.uniform() < 0.7
        link = mass * arm**2 * rng.uniform(1.0, 1.4) if falls else log_uniform(rng, 0.001, 0.5)
        inertia = link * (1 + log_uniform(rng, 0.02, 0.8))
        torque = inertia * 15.0 + (G * mass * arm if falls else 0.0)
        coulomb, ratio = log_uniform(rng, 0.03, 0.3) * torque, round(log_uniform(rng, 1.0, 160.0), 2)
        torque += coulomb
        return Single(inertia, inertia - link, mass * arm if falls else 0.0, rng.uniform(-0.3, 0.3) if falls else 0.0,
                      rng.choice([0.0, rng.uniform(-0.05, 0.05)]) * torque, coulomb, coulomb * log_uniform(rng, 0.05, 0.6),
                      ratio, float(f"{torque / ratio / log_uniform(rng, 1.0, 20.0):.4g}"))  # fmt: skip

    @staticmethod
    def draw_slider(rng):
        """A carriage on a screw or a belt; its drive's inertia counts as mass."""
        mass = log_uniform(rng, 1.0, 120.0)
        carriage = mass / (1 + log_uniform(rng, 0.1, 1.5))
        coulomb = log_uniform(rng, 0.1, 1.2) * mass
        return Single(mass, mass - carriage, 0.0, 0.0, rng.choice([0.0, rng.uniform(-0.3, 0.3)]) * coulomb, coulomb,
                      coulomb * log_uniform(rng, 0.5, 5.0), 1.0, 1.0, "slider")  # fmt: skip

    @property
    def shown(self):
        return {"knee": "joint" if self.kind == "pendulum" else "slider"}

    @property
    def units(self):
        return ("rad", "Nm") if self.kind == "pendulum" else ("m", "N")

    def friction(self, joint):
        return self.coulomb, self.viscous

    def ratio(self, joint):
        return self.gear

    def inertia(self, joint):
        return self.inertia_

    def rotor(self, joint):
        return self.rotor_

    def torque_constant(self, joint):
        return self.K

    def parameters(self):
        """What is identified, by the model file's names."""
        if self.kind == "slider":
            return {"mass_kg": self.inertia_, "coulomb_N": self.coulomb, "viscous_Ns_m": self.viscous, "force_offset_N": self.offset}
        return {"inertia_kg_m2": self.inertia_, "gravity_moment_kg_m": self.gravity_moment_kg_m,
                "gravity_zero_rad": self.gravity_zero_rad, "torque_offset_Nm": self.offset, "coulomb_Nm": self.coulomb,
                "viscous_Nms_rad": self.viscous}  # fmt: skip

    def cad(self, rng):
        """As CAD gives it, which knows of no constant torque."""
        given = off(rng, self.parameters(), self.off_by)
        return self.model_text({name: 0.0 if "offset" in name else value for name, value in given.items()})

    def base(self):
        return self.parameters()

    def job(self):
        """As the twin's knee: a mass that gravity pulls at, at most half of the inertia, and the rest about its centre."""
        distance = min(1.0, 0.5 * self.inertia_ / self.gravity_moment_kg_m) if self.gravity_moment_kg_m else 1.0
        mass = self.gravity_moment_kg_m / distance
        own = self.inertia_ - mass * distance**2
        return {"alone": 1.0, "gravity": G, "ms": mass, "ds": distance, "i1": own, "ls": distance, "ratio": self.gear,
                "tilt": -self.gravity_zero_rad, "knee.rotor_share": min(0.9, self.rotor_ / own), "knee.coulomb": self.coulomb,
                "knee.viscous": self.viscous, "knee.torque_constant": self.K, "knee.offset": -self.offset}  # fmt: skip

    @staticmethod
    def off_by(name):
        return 0.20 if name in ("inertia_kg_m2", "mass_kg", "gravity_moment_kg_m") else 0.40

    def model_text(self, parameters):
        p = {name: f"{value:.9g}" for name, value in parameters.items()}
        if self.kind == "slider":
            return f"""plant: slider
mass_kg: {p["mass_kg"]}
friction: {{coulomb_N: {p["coulomb_N"]}, viscous_Ns_m: {p["viscous_Ns_m"]}}}
force_offset_N: {p["force_offset_N"]}
"""
        return f"""plant: pendulum
gravity_m_s2: {G}
inertia_kg_m2: {p["inertia_kg_m2"]}
gravity_moment_kg_m: {p["gravity_moment_kg_m"]}
gravity_zero_rad: {p["gravity_zero_rad"]}
torque_offset_Nm: {p["torque_offset_Nm"]}
joint:
  transmission: {{type: fixed, ratio: {self.gear:g}}}
  torque_constant_Nm_A: {self.K:g}
  friction: {{coulomb_Nm: {p["coulomb_Nm"]}, viscous_Nms_rad: {p["viscous_Nms_rad"]}}}
"""
