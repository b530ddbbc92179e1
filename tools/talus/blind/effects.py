"""Draws of every effect of the catalogue that a leg can have, in several published forms each.

A draw returns Drawn: what the twin's job gets, what the sensors' tables get, and words. Sizes are those of the
catalogue, times 0.5 to 2, for a leg of the narrow protocol; another plant's scale turns them into its own."""

from dataclasses import dataclass, field

import numpy as np

from .plants import NARROW, log_uniform

BOTH, KNEE, ANKLE, BASE = ("knee", "ankle"), ("knee",), ("ankle",), ("base",)
PEAK_A = {joint: scale.peak_A for joint, scale in NARROW.items()}


@dataclass
class Drawn:
    effect: str
    joint: str
    form: str
    size: str
    job: dict = field(default_factory=dict)
    sensor: dict = field(default_factory=dict)
    alias: list = field(default_factory=list)

    def parameters(self):
        return {**self.job, **{k: v for k, v in self.sensor.items()}}


def size(value, digits=2):
    """For people: so many digits behind the point, more where the number is small."""
    return f"{value:.{digits}f}" if abs(value) >= 0.05 else f"{value:.2g}"


def side(rng):
    return float(rng.choice([-1.0, 1.0]))


def phase(rng):
    return float(rng.uniform(0, 2 * np.pi))


def of(joint, **values):
    """Names of one joint."""
    return {f"{joint}.{name}": float(value) for name, value in values.items()}


def waves(joint, name, parts):
    """Orders, sizes and phases of up to three waves."""
    job = {}
    for i, (n, a, p) in enumerate(parts):
        job.update({f"{joint}.{name}_n[{i}]": n, f"{joint}.{name}_a[{i}]": a, f"{joint}.{name}_p[{i}]": p})
    return job


def stribeck(rng, joint, plant):
    form = int(rng.integers(1, 6))
    extra = log_uniform(rng, 0.3, 1.2) * plant.friction(joint)[0]
    s = plant.scale[joint]
    speed, power = log_uniform(rng, 0.04, 0.25) * s.speed, rng.uniform(1.5, 3.0) if form == 3 else rng.uniform(0.6, 1.6)
    names = ("exponential", "Gaussian", "Lorentzian", "1 - tanh", "stretched exponential")
    return Drawn(
        "stribeck",
        joint,
        names[form - 1],
        f"{size(extra)} {s.units[1]} more at standstill, gone beyond about {size(2 * speed)} {s.units[0]}/s",
        of(joint, stribeck_form=form, stribeck_extra=extra, stribeck_speed=speed, stribeck_power=power),
    )


def rotor_carried(rng, joint):
    """Whether losses follow the torque that also turns the rotor: on the ankle, whose foot is light, mostly."""
    return rng.uniform() < (0.2 if joint == "knee" else 0.8)


def load_friction(rng, joint, plant):
    form, coefficient, rotor = int(rng.integers(1, 5)), log_uniform(rng, 0.06, 0.28), rotor_carried(rng, joint)
    reference = {2: rng.uniform(0.05, 0.3), 4: 0.5}.get(form, 1.0) * plant.scale[joint].peak_Nm
    names = ("of the link's torque", "smooth at zero load", "of the motor's torque", "quadratic")
    return Drawn(
        "load_friction",
        joint,
        names[form - 1],
        f"friction grows by {100 * coefficient:.0f} % of the torque carried",
        of(joint, load_form=form, load_coef=coefficient, load_ref=reference, load_rotor=rotor),
        alias=[["directional_efficiency", joint]],
    )


def asymmetric_friction(rng, joint, plant):
    what = int(rng.integers(0, 3))
    coulomb = side(rng) * rng.uniform(0.1, 0.35) if what != 1 else 0.0
    viscous = side(rng) * rng.uniform(0.3, 0.6) if what != 0 else 0.0
    job = of(joint, asym_coulomb=coulomb * plant.friction(joint)[0],
             asym_viscous=viscous * plant.friction(joint)[1])  # fmt: skip
    constant, growing = abs(job[f"{joint}.asym_coulomb"]), abs(job[f"{joint}.asym_viscous"]) * plant.scale[joint].fast / 3
    alias = []
    if growing < 0.2 * constant:  # a difference that does not grow with speed is a constant torque
        alias = [["current_offset", joint], ["parallel_spring", joint]] + (
            [["gravity_tilt", "base"]] if joint == "knee" else []
        )
    return Drawn(
        "asymmetric_friction",
        joint,
        ("Coulomb", "viscous", "both")[what],
        f"differs by direction: Coulomb {100 * coulomb:+.0f} %, viscous {100 * viscous:+.0f} % (half difference)",
        job,
        alias=alias,
    )


def nonlinear_viscous(rng, joint, plant):
    form, fast = int(rng.integers(1, 7)), plant.scale[joint].fast
    full = plant.friction(joint)[0] + fast * plant.friction(joint)[1]
    share = rng.uniform(0.18, 0.5)
    saturating = form in (3, 5, 6)
    speed = fast * (rng.uniform(0.15, 0.5) if saturating else 1.0)
    power = rng.choice([rng.uniform(0.3, 0.65), rng.uniform(1.6, 2.8)])
    gain = {1: 2.0, 2: 2.0, 3: 1.5, 4: 1.5, 5: 2.0, 6: 1.2}[form]
    names = ("power law", "quadratic", "tanh", "cubic", "rational", "arctangent")
    return Drawn(
        "nonlinear_viscous",
        joint,
        names[form - 1],
        f"bends by about {100 * share:.0f} % of friction at {fast:.3g} {plant.scale[joint].units[0]}/s",
        of(joint, nlv_form=form, nlv_size=gain * share * full, nlv_speed=speed, nlv_power=power),
    )


def position_friction(rng, joint, plant):
    form, share, half = int(rng.integers(1, 7)), rng.uniform(0.25, 0.6), plant.scale[joint].half_range
    width = {1: half / rng.uniform(1.0, 4.0), 2: half, 3: half * rng.uniform(0.25, 0.6), 4: half, 5: half,
             6: half * rng.uniform(0.5, 1.5)}[form]  # fmt: skip
    centre = half * rng.uniform(-0.5, 0.5) if form in (3, 6) else 0.0
    names = ("wave", "line", "bump", "parabola", "cubic", "step")
    return Drawn(
        "position_friction",
        joint,
        names[form - 1],
        f"Coulomb friction varies by {100 * share:.0f} % over the range",
        of(
            joint,
            pos_form=form,
            pos_size=side(rng) * share * plant.friction(joint)[0],
            pos_centre=centre,
            pos_width=width,
            pos_phase=phase(rng),
        ),
    )


def presliding(rng, joint, plant):
    s = plant.scale[joint]
    form, travel = int(rng.integers(1, 4)), log_uniform(rng, 0.0012, 0.016) * s.angle
    job = of(
        joint,
        pre_form=form,
        pre_share=rng.uniform(0.8, 1.0),
        pre_travel=travel,
        pre_power=rng.choice([0.5, 1.0, 1.5, 2.0]),
        pre_rise=rng.uniform(0.0, 0.15),
        pre_speed=rng.uniform(0.05, 0.2) * s.speed,
    )
    return Drawn("presliding", joint, ("Dahl", "LuGre", "Iwan")[form - 1],
                 f"friction builds up over about {size(1e3 * travel, 1)} m{s.units[0]} after a reversal", job)  # fmt: skip


def friction_drift(rng, joint, plant):
    form, share, session = int(rng.integers(1, 5)), rng.uniform(0.2, 0.5), bool(rng.integers(0, 2))
    tau = log_uniform(rng, 10, 60) if not session else log_uniform(rng, 30, 150)
    size = share
    if form == 2:
        tau, size = (150.0 if session else 30.0), -share
    if form == 3:
        size = -share
    where = "with temperature" if form == 3 else "over the session" if session else "from the start of each recording"
    names = ("exponential", "linear", "by temperature", "hyperbolic")
    return Drawn("friction_drift", joint, names[form - 1], f"friction falls by up to {100 * share:.0f} % {where}",
                 of(joint, drift_form=form, drift_size=size, drift_tau=tau, drift_session=session,
                    drift_on=rng.choice([0, 0, 1])))  # fmt: skip


def directional_efficiency(rng, joint, plant):
    form, driving = int(rng.integers(1, 3)), rng.uniform(0.68, 0.9)
    back = float(np.clip(driving + side(rng) * rng.uniform(0.08, 0.22), 0.6, 0.99))
    return Drawn(
        "directional_efficiency",
        joint,
        ("of the link's torque", "of the motor's torque")[form - 1],
        f"efficiency {100 * driving:.0f} % driving, {100 * back:.0f} % back-driven",
        of(
            joint,
            eff_form=form,
            eff_driving=driving,
            eff_back=back,
            eff_smooth=rng.choice([0.0, 0.02]) * plant.scale[joint].peak_Nm,
            load_rotor=rotor_carried(rng, joint),
        ),
        alias=[["load_friction", joint]],
    )


def spring_between(joint, rng, plant, stiffness, **more):
    rotor = {"rotor_share": rng.uniform(0.2, 0.5)} if joint == "knee" else {}
    if plant.kind != "leg":
        rotor = {}  # known
    stiffness = min(stiffness, plant.scale[joint].stiffest)
    return of(joint, stiffness=stiffness, damping=rng.uniform(0.0004, 0.0015),
              **{"elastic_form": 1, **sides(rng, 0.4), **rotor, **more})  # fmt: skip


def sides(rng, most):
    """Of dry and of viscous friction, what stands on the joint's side of a spring: nothing, all, or any share."""
    dry, viscous = rng.choice([0.0, 1.0, rng.uniform()], p=[0.35, 0.15, 0.5]), rng.choice([0.0, 1.0, rng.uniform()], p=[0.5, 0.2, 0.3])
    return {"link_share": most * dry, "viscous_share": most * viscous}


def backlash(rng, joint, plant):
    s = plant.scale[joint]
    gap, stiffness = log_uniform(rng, 0.001, 0.01) * s.angle, log_uniform(rng, 4000, 15000) * s.torque / s.angle
    coulomb = rng.choice([0.0, 0.02, 0.05]) * plant.friction(joint)[0]
    return Drawn("backlash", joint, "Coulomb friction in the gap" if coulomb else "free gap",
                 f"lost motion of {size(1e3 * gap, 1)} m{s.units[0]} between motor and joint",
                 spring_between(joint, rng, plant, stiffness, gap_half=gap / 2, gap_coulomb=coulomb, **sides(rng, 1.0)))  # fmt: skip


def elasticity(rng, joint, plant):
    s = plant.scale[joint]
    form, stiffness = int(rng.integers(1, 4)), min(log_uniform(rng, 250, 3500) * s.torque / s.angle, s.stiffest)
    twist = plant.scale[joint].peak_Nm / stiffness
    job = spring_between(
        joint,
        rng,
        plant,
        stiffness,
        elastic_form=form,
        hardening=rng.uniform(0.3, 1.5) * stiffness / twist**2,
        soft_share=rng.uniform(0.3, 0.7),
        soft_zone=twist * rng.uniform(0.1, 0.3),
    )
    return Drawn("elasticity", joint, ("linear", "hardening", "soft at first")[form - 1],
                 f"{'torsional ' if s.units[0] == 'rad' else ''}stiffness about {stiffness:.0f} {s.units[1]}/{s.units[0]} between motor and joint", job)  # fmt: skip


def kinematic_error(rng, joint, plant):
    s = plant.scale[joint]
    orders = rng.permutation([1, 2, 4])[: int(rng.integers(1, 3))]
    if rng.uniform() < 0.6:
        ripple = rng.uniform(0.3, 1.0) * s.torque
        parts = [(n, ripple * (1.0 if i == 0 else 0.4), phase(rng)) for i, n in enumerate(orders)]
        load = rng.uniform() < 0.25
        if load:
            parts = [(n, a / 4.0 / s.torque, p) for n, a, p in parts]
        return Drawn("kinematic_error", joint, "torque ripple by load" if load else "torque ripple",
                     f"torque ripple {size(ripple)} Nm at the joint, {orders[0]} per motor turn",
                     waves(joint, "ripple", parts) | of(joint, ripple_load=load))  # fmt: skip
    error = log_uniform(rng, 0.0002, 0.0008) * s.angle / orders[0]
    parts = [(n, error * (1.0 if i == 0 else 0.3), phase(rng)) for i, n in enumerate(orders)]
    return Drawn(
        "kinematic_error",
        joint,
        "angle error",
        f"angle error {1e3 * error:.2f} mrad, {orders[0]} per motor turn",
        waves(joint, "angle", parts) | spring_between(joint, rng, plant, log_uniform(rng, 10000, 20000) * s.torque / s.angle, link_share=0.0, viscous_share=0.0),
        alias=[["elasticity", joint]],  # the spring is there, and where the angle's error is small it shows first
    )


def linkage_error(rng, joint, plant):
    alias = [["encoder_eccentricity", "ankle"]]
    if rng.uniform() < 0.3:
        size, order = rng.uniform(0.002, 0.008), rng.uniform(2.0, 6.0)
        return Drawn(
            "linkage_error",
            joint,
            "smooth function",
            f"the ratio is wrong by a wave worth {1e3 * size:.1f} mrad",
            {"wave_a": plant.scale["ankle"].ratio * size, "wave_w": order, "wave_p": phase(rng)},
            alias=alias,
        )
    names = rng.permutation(["ab", "bo", "ac"])[: int(rng.integers(1, 3))]
    true = {n: plant.linkage[f"{n.upper()}_m"] for n in ("ab", "bo", "ac")}
    errors = {str(n): side(rng) * log_uniform(rng, 0.0005, 0.0025) for n in names}
    words = ", ".join(f"{n.upper()} {1e3 * e:+.2f} mm" for n, e in errors.items())
    return Drawn("linkage_error", joint, "dimensions", f"real linkage differs: {words}",
                 {n: true[n] + e for n, e in errors.items()}, alias=alias)  # fmt: skip


def cogging(rng, joint, plant):
    first = int(
        rng.choice(
            [6, 7, 9, 10, 12, 14, 18, 21, 24, 28, 36, 42, 84],
            p=[0.16, 0.1, 0.08, 0.1, 0.16, 0.1, 0.05, 0.05, 0.06, 0.04, 0.04, 0.03, 0.03],
        )
    )
    s = plant.scale[joint]
    size = s.motor * (log_uniform(rng, 0.005, 0.016) if joint == "knee" else log_uniform(rng, 0.0008, 0.004))
    parts = [(first, size, phase(rng))]
    for k in range(int(rng.integers(0, 3))):
        parts.append((first * (2 + k), size * rng.uniform(0.2, 0.5), phase(rng)))
    return Drawn("cogging", joint, f"{len(parts)} orders", f"{1e3 * size:.1f} mNm at the motor, {first} per turn",
                 waves(joint, "cog", parts))  # fmt: skip


def torque_saturation(rng, joint, plant):
    form, droop = int(rng.integers(1, 6)), rng.uniform(0.12, 0.3)
    names = ("quadratic", "rational", "logarithmic", "knee", "linear")
    return Drawn(
        "torque_saturation",
        joint,
        names[form - 1],
        f"torque constant {100 * droop:.0f} % lower at {plant.scale[joint].peak_A:.3g} A",
        of(joint, sat_form=form, sat_droop=droop, sat_ref=plant.scale[joint].peak_A, sat_width=rng.uniform(0.3, 0.6)),
    )


def current_offset(rng, joint, plant):
    least = PEAK_A[joint]
    offset = side(rng) * (log_uniform(rng, 0.03, 0.2) if joint == "knee" else log_uniform(rng, 0.01, 0.05))
    offset *= plant.scale[joint].peak_A / least
    alias = [["asymmetric_friction", joint], ["parallel_spring", joint]] + (
        [["gravity_tilt", "base"]] if joint == "knee" else []
    )
    return Drawn("current_offset", joint, "constant", f"{1e3 * offset:+.0f} mA", sensor={f"{joint}.offset_A": offset},
                 alias=alias)  # fmt: skip


def delay(rng, joint, plant):
    shift = side(rng) * log_uniform(rng, *((0.0015, 0.009) if joint == "knee" else (0.0025, 0.01)))
    if shift > 0 and rng.uniform() < 0.4:
        part = rng.uniform(0.4, 1.0)
        return Drawn("delay", joint, "with a first-order lag", f"current {1e3 * shift:.1f} ms after the angles",
                     of(joint, delay=shift * (1 - part), lag=shift * part))  # fmt: skip
    return Drawn(
        "delay",
        joint,
        "fixed",
        f"current sampled {1e3 * abs(shift):.1f} ms {'after' if shift > 0 else 'before'} the angles",
        of(joint, delay=shift),
    )


def encoder_eccentricity(rng, joint, plant):
    if rng.uniform() < 0.65:
        size, order = (
            log_uniform(rng, 0.0015, 0.008),
            int(rng.choice([1, 2, 3, 6, 10, 16, 21], p=[0.3, 0.2, 0.1, 0.1, 0.1, 0.1, 0.1])),
        )
        return Drawn(
            "encoder_eccentricity",
            joint,
            "joint encoder",
            f"joint encoder {1e3 * size:.1f} mrad, {order} per joint turn",
            sensor={"joint_encoder": (order, size, phase(rng))},
            alias=[["linkage_error", "ankle"]] if order <= 3 else [],
        )
    size, order = log_uniform(rng, 0.004, 0.016), int(rng.choice([1, 2], p=[0.75, 0.25]))
    return Drawn(
        "encoder_eccentricity",
        joint,
        "motor encoder",
        f"motor encoder {1e3 * size:.1f} mrad, {order} per motor turn",
        of(joint, enc_n=order, enc_a=size / order, enc_p=phase(rng)),
    )


def gravity_tilt(rng, joint, plant):
    tilt = side(rng) * np.radians(log_uniform(rng, 1.2, 5.0))
    foot = rng.uniform() < 0.2
    job = {"tilt": tilt} if not foot else {"tilt": tilt, "tilt_foot": -tilt * rng.uniform(0.0, 0.3)}
    return Drawn(
        "gravity_tilt",
        joint,
        "bench and foot" if foot else "bench",
        f"{np.degrees(tilt):+.1f} deg",
        job,
        alias=[["current_offset", "knee"], ["asymmetric_friction", "knee"], ["parallel_spring", "knee"]],
    )


def parallel_spring(rng, joint, plant):
    form, half = int(rng.integers(1, 7)), plant.scale[joint].half_range
    s = plant.scale[joint]
    stiffness = (log_uniform(rng, 1.2, 10) if joint == "knee" else log_uniform(rng, 0.8, 6)) * (s.torque / s.angle)
    zero = {1: half * rng.uniform(-0.6, 0.6), 2: 0.0, 3: half * rng.uniform(0.0, 0.5), 4: half * rng.uniform(-0.5, 0.0),
            5: 0.0, 6: half * rng.uniform(-0.2, 0.3)}[form]  # fmt: skip
    if form in (3, 4, 6):
        stiffness *= 2.5
    names = ("linear", "hardening", "bumper ahead", "bumper behind", "sinh", "quadratic bumper")
    return Drawn("parallel_spring", joint, names[form - 1], f"spring of about {stiffness:.1f} {s.units[1]}/{s.units[0]} beside the joint",
                 of(joint, spring_form=form, spring_k=stiffness, spring_k3=stiffness * rng.uniform(1, 4) / half**2,
                    spring_zero=zero))  # fmt: skip


def base_compliance(rng, joint, plant):
    frequency, zeta, job = log_uniform(rng, 3, 12), rng.uniform(0.02, 0.1), {}
    kind = int(rng.integers(0, 3))
    if kind in (0, 1):
        mass, w = rng.uniform(3, 9), 2 * np.pi * frequency
        job.update(x_mass=mass, x_k=(mass + 2.5) * w**2, x_c=2 * zeta * w * (mass + 2.5))
        if kind == 1:
            w *= rng.uniform(1.2, 1.8)
            job.update(z_mass=mass, z_k=(mass + 2.5) * w**2, z_c=2 * zeta * w * (mass + 2.5))
    else:
        inertia, lever, w = rng.uniform(0.3, 1.2), rng.uniform(0.0, 0.4), 2 * np.pi * frequency
        all_of = inertia + 2.48 * lever**2
        job.update(phi_inertia=inertia, phi_lever=lever, phi_k=all_of * w**2, phi_c=2 * zeta * w * all_of)
    return Drawn(
        "base_compliance",
        joint,
        ("sideways", "sideways and up", "rotation")[kind],
        f"mount sways at {frequency:.1f} Hz",
        job,
    )


CATALOGUE = {
    "stribeck": (stribeck, BOTH),
    "load_friction": (load_friction, BOTH),
    "asymmetric_friction": (asymmetric_friction, BOTH),
    "nonlinear_viscous": (nonlinear_viscous, BOTH),
    "position_friction": (position_friction, BOTH),
    "presliding": (presliding, BOTH),
    "friction_drift": (friction_drift, BOTH),
    "backlash": (backlash, BOTH),
    "elasticity": (elasticity, BOTH),
    "kinematic_error": (kinematic_error, KNEE),
    "linkage_error": (linkage_error, ANKLE),
    "directional_efficiency": (directional_efficiency, BOTH),
    "cogging": (cogging, BOTH),
    "torque_saturation": (torque_saturation, BOTH),
    "current_offset": (current_offset, BOTH),
    "delay": (delay, BOTH),
    "encoder_eccentricity": (encoder_eccentricity, ANKLE),
    "gravity_tilt": (gravity_tilt, BASE),
    "parallel_spring": (parallel_spring, BOTH),
    "base_compliance": (base_compliance, BASE),
}

SHOWS = {  # coordinates over which each may be reported; the judge's own table, so that no change of the diagnosis moves it
    "stribeck": {"velocity", "reversal"}, "load_friction": {"load", "current", "acceleration"},
    "asymmetric_friction": {"velocity"}, "nonlinear_viscous": {"velocity"}, "position_friction": {"position"},
    "presliding": {"reversal"}, "friction_drift": {"time"}, "backlash": {"reversal", "load", "encoder"},
    "elasticity": {"load", "acceleration", "frequency", "encoder"}, "kinematic_error": {"motor_angle"},
    "linkage_error": {"position", "encoder"}, "directional_efficiency": {"load", "current"}, "cogging": {"motor_angle"},
    "torque_saturation": {"current", "load"}, "current_offset": {"current", "velocity", "position"},
    "delay": {"acceleration", "frequency", "reversal"}, "encoder_eccentricity": {"encoder", "position", "motor_angle"},
    "gravity_tilt": {"position"}, "parallel_spring": {"position"}, "base_compliance": {"frequency", "acceleration"},
}  # fmt: skip


def droops(drawn):
    """Does its drive give ever less torque per current?"""
    return drawn.effect == "torque_saturation"


ALONE = [  # of one joint; the others act on a leg's linkage or mount, or the model of one joint takes them up
    "stribeck", "load_friction", "asymmetric_friction", "nonlinear_viscous", "position_friction", "presliding", "friction_drift",
    "backlash", "elasticity", "directional_efficiency", "torque_saturation", "delay", "parallel_spring",
]  # fmt: skip
OF_PLANT = {"leg": list(CATALOGUE), "pendulum": [*ALONE, "kinematic_error", "cogging"], "slider": ALONE}


def draw(rng, plant, number):
    """One effect; `number` in 0..1 chooses which."""
    names = OF_PLANT[plant.kind]
    make, joints = CATALOGUE[names[int(number * len(names)) % len(names)]]
    return make(rng, str(rng.choice([j for j in joints if j in (*plant.joints, "base")])), plant)


def draw_pair(rng, plant, number):
    """Two effects that can be had together: another name, and nothing that the twin has in one place only."""
    first = draw(rng, plant, number)
    while True:
        second = draw(rng, plant, rng.uniform())
        alike = [first.effect, first.joint] in second.alias or [second.effect, second.joint] in first.alias
        if second.effect != first.effect and not alike and not set(first.job) & set(second.job):
            return [first, second]
