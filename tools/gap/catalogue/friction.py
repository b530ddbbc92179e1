"""Effects of friction: its dependence on speed, load, direction, position, history and time."""

import numpy as np

from ..loops import dahl
from .candidate import Candidate, named

STRIBECK_SPEEDS_RAD_S = (0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45)
VISCOUS_EXPONENTS = (0.33, 0.5, 0.7, 1.5, 2.0, 3.0)
VISCOUS_KNEES = (0.1, 0.2, 0.4, 0.7)  # of the largest speed
POSITION_WAVES = (0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5)  # half turns over half the range
PRESLIDING_TRAVELS_RAD = (0.0007, 0.0015, 0.003, 0.006, 0.012, 0.024)
DRIFT_TIMES_S = (5, 10, 20, 40, 80, 200)
TEMPERATURE_WINDOW_S = 2.0  # a gear's temperature changes slower, its sensor's noise faster


def stribeck(at):
    j, speed = at.number, at.extent.speed[at.number]
    slider = at.evidence.model.plant == "slider"
    speeds = [x * speed for x in (0.02, 0.05, 0.1)] if slider else STRIBECK_SPEEDS_RAD_S
    for power in (1.0, 2.0):
        for width in speeds:
            if width > 0.25 * speed:  # wider is viscous friction under another name
                continue
            law = lambda s, p=power, w=width: s.slip[j] * np.exp(-np.abs(s.v[j] / w) ** p)
            yield Candidate("stribeck", at.name, f"power {power:g}, {width:.3g} rad/s", (at.joint_column(law),),
                            named("extra_Nm", speed_rad_s=float(width), exponent=power),
                            (0.02 * at.coulomb_Nm,), (1.5 * at.coulomb_Nm,), saved=True)  # fmt: skip


def _loads(j):
    """Readings of `the torque that the gear carries` that the literature has."""
    return (("link", lambda s: s.link_Nm[j]),
            ("link and rotor", lambda s: s.link_Nm[j] + s.rotor_Nm[j]),
            ("all", lambda s: s.joint_Nm[j]))  # fmt: skip


def load_friction(at):
    j = at.number
    for name, load in _loads(j):
        column = at.joint_column(lambda s, f=load: s.slip[j] * np.abs(f(s)))
        yield Candidate("load_friction", at.name, name, (column,), named("coefficient"), (0.0,), (0.6,), saved=True)


def directional_efficiency(at):
    j = at.number
    for name, load in _loads(j):
        driving = at.joint_column(lambda s, f=load: s.slip[j] * np.abs(f(s)) * (f(s) * s.slip[j] > 0))
        driven = at.joint_column(lambda s, f=load: s.slip[j] * np.abs(f(s)) * ~(f(s) * s.slip[j] > 0))
        yield Candidate("directional_efficiency", at.name, name, (driving, driven),
                        named("driving", "back_driving"), (0.0, 0.0), (0.6, 0.6), saved=True)  # fmt: skip


def asymmetric_friction(at):
    j = at.number
    viscous = at.joint_column(lambda s: np.abs(s.v[j]) * np.abs(s.slip[j]))
    dry = at.joint_column(lambda s: s.slip[j] ** 2)
    both = named("coulomb_Nm", "viscous_Nms_rad")
    yield Candidate("asymmetric_friction", at.name, "viscous", (viscous,),
                    named("viscous_Nms_rad", coulomb_Nm=0.0), saved=True)  # fmt: skip
    yield Candidate("asymmetric_friction", at.name, "Coulomb", (dry,),
                    named("coulomb_Nm", viscous_Nms_rad=0.0), saved=True)  # fmt: skip
    yield Candidate("asymmetric_friction", at.name, "both", (dry, viscous), both, saved=True)


def nonlinear_viscous(at):
    j, speed = at.number, at.extent.speed[at.number]
    for power in VISCOUS_EXPONENTS:
        column = at.joint_column(lambda s, p=power: s.slip[j] * np.abs(s.v[j]) ** p)
        # below 1 a negative strength would be friction that falls with speed: stribeck's
        low = (0.0,) if power < 1 else None
        yield Candidate("nonlinear_viscous", at.name, f"power {power:g}", (column,),
                        named("size_Nm", exponent=power), low, saved=True)  # fmt: skip
    for knee in VISCOUS_KNEES:
        width = float(knee * speed)
        column = at.joint_column(lambda s, w=width: np.tanh(s.v[j] / w))
        yield Candidate("nonlinear_viscous", at.name, f"saturating at {width:.3g} rad/s", (column,),
                        named("size_Nm", saturation_rad_s=width), (0.0,))  # fmt: skip


def position_friction(at):
    if at.evidence.velocity_only:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    unit = lambda s: (s.q[j] - middle) / half
    line = at.joint_column(lambda s: s.slip[j] * s.q[j])
    bend = at.joint_column(lambda s: s.slip[j] * s.q[j] ** 2)
    powers = [at.joint_column(lambda s, p=p: s.slip[j] * unit(s) ** p) for p in (1, 2, 3, 4)]
    make = lambda shape, columns, names, saved=False: Candidate(
        "position_friction", at.name, shape, tuple(columns), names, saved=saved)  # fmt: skip
    yield make("line", [line], named("slope_Nm_rad", bend_Nm_rad2=0.0), True)
    yield make("parabola", [line, bend], named("slope_Nm_rad", "bend_Nm_rad2"), True)
    yield make("parabola about the middle", powers[1:2], named("bend_Nm", middle_rad=middle, half_range_rad=half))
    yield make("polynomial", powers, named(*(f"power_{p}_Nm" for p in (1, 2, 3, 4)), middle_rad=middle, half_range_rad=half))
    for k in POSITION_WAVES:
        order = np.pi * k / half
        waves = [at.joint_column(lambda s, f=f, o=order: s.slip[j] * f(o * (s.q[j] - middle))) for f in (np.sin, np.cos)]
        yield make(f"wave of {order:.3g} per rad", waves, named("sine_Nm", "cosine_Nm", middle_rad=middle, order_rad=order))


def presliding(at):
    j = at.number
    size = 0.1 if at.evidence.model.plant == "slider" else 1.0  # a slider's travel in m
    travels = [size * x for x in PRESLIDING_TRAVELS_RAD]
    shapes = [(travel, power) for power in (1.0, 2.0) for travel in travels]

    def state(scene, travel, power):
        return dahl(np.nan_to_num(scene.travel_rad[j]), travel, power)

    for travel, power in shapes:
        column = at.joint_column(lambda s, t=travel, p=power: at.coulomb_Nm * (state(s, t, p) - s.slip[j]))
        figures = lambda x, t=travel: {"friction_Nm": float(x[0]) * at.coulomb_Nm, "travel_rad": float(t)}
        yield Candidate("presliding", at.name, f"Dahl, power {power:g}, {1e3 * travel:.2g} mrad", (column,), figures,
                        (0.2,), (1.5,), saved=power == 1.0)  # fmt: skip


def slow(values, step_s):
    """Moving average over TEMPERATURE_WINDOW_S."""
    n = max(1, int(TEMPERATURE_WINDOW_S / step_s))
    padded = np.pad(values, (n // 2, n - 1 - n // 2), mode="edge")
    return np.convolve(padded, np.ones(n) / n, "valid")


def friction_drift(at):
    j = at.number
    make = lambda shape, column, names: Candidate("friction_drift", at.name, shape, (column,), names)
    for constant in DRIFT_TIMES_S:
        fade = lambda s, c=constant: np.exp(-(s.t_s - s.t_s[0]) / c)
        whole = at.joint_column(lambda s, f=fade: s.friction_Nm[j] * f(s))
        dry = at.joint_column(lambda s, f=fade: s.coulomb_Nm[j] * s.slip[j] * f(s))
        shapes = {"time_constant_s": float(constant)}
        yield make(f"all, {constant} s", whole, named("share_at_begin", **shapes))
        yield make(f"Coulomb, {constant} s", dry, named("coulomb_share_at_begin", **shapes))
    sensor = f"{at.name}_temp_C"
    if all(sensor in s.columns for s in at.scenes):
        middle = np.mean([np.mean(s.columns[sensor]) for s in at.scenes])
        warm = lambda s: (slow(s.columns[sensor], s.step_s) - middle) / 10
        yield make("temperature", at.joint_column(lambda s: s.friction_Nm[j] * warm(s)), named("share_per_10_C"))
        dry = at.joint_column(lambda s: s.coulomb_Nm[j] * s.slip[j] * warm(s))
        yield make("Coulomb, temperature", dry, named("coulomb_share_per_10_C"))
        yield make("viscous, temperature", at.joint_column(lambda s: s.v[j] * warm(s)), named("viscous_Nms_rad_per_10_C"))


EFFECTS = (stribeck, load_friction, directional_efficiency, asymmetric_friction, nonlinear_viscous, position_friction,
           presliding, friction_drift)  # fmt: skip
