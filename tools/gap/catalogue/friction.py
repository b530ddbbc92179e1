"""Effects of friction: its dependence on speed, load, direction, position, history and time."""

import numpy as np

from ..loops import dahl
from .candidate import Candidate, Family, named, usual

STRIBECK_SPEEDS_RAD_S = (0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45)
VISCOUS_EXPONENTS = (0.33, 0.5, 0.7, 1.5, 2.0, 3.0)
VISCOUS_KNEES = (0.1, 0.2, 0.4, 0.7)  # of the largest speed
POSITION_WAVES = (0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5)  # half turns over half the range
PRESLIDING_TRAVELS_RAD = (0.0007, 0.0015, 0.003, 0.006, 0.012, 0.024)
USUAL_ASYMMETRY = (0.1, 0.4)  # of Coulomb friction
CONSTANT_BY_FRICTION, CONSTANT_OF_A_SHARE = 0.4, 2.5
HARDLY_GROWS = 0.5  # of the constant difference, that the viscous one adds at full speed
LARGEST_SHARE = 0.45  # of the load, lost in a gear in use
LOAD_POWERS = (1.5, 2.0)
OWN_COEFFICIENTS, OWN_WITHIN = (0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4), 1.2
DRIFT_TIMES_S = (5, 10, 20, 40, 80, 200)
TEMPERATURE_WINDOW_S = 2.0  # a gear's temperature changes slower, its sensor's noise faster


def stribeck(at):
    j, speed = at.number, at.extent.speed[at.number]
    slider = at.evidence.model.plant == "slider"
    speeds = [x * speed for x in (0.02, 0.05, 0.1)] if slider else STRIBECK_SPEEDS_RAD_S

    def falling(width, power):
        law = lambda s: s.slip[j] * np.exp(-np.abs(s.v[j] / width) ** power)
        return Candidate("stribeck", at.name, f"power {power:g}, {width:.3g} rad/s", (at.joint_column(law),),
                         named("extra_Nm", speed_rad_s=float(width), exponent=power), (0.02 * at.coulomb_Nm,),
                         (1.5 * at.coulomb_Nm,), family=Family(falling, (width, power), (1.5, 0.5),
                         (speeds[0] / 2, 0.5), (0.25 * speed, 2.0)))  # fmt: skip

    for power in (1.0, 2.0):
        for width in speeds:
            if width <= 0.25 * speed:  # wider is viscous friction under another name
                yield falling(width, power)


def _loads(at):
    """Readings of `the torque that the gear carries` that the literature has: name, law, and shares of the rotor and of
    friction in it."""
    j = at.number
    rotor = 0.0 if at.evidence.leg and j == 1 else 1.0  # the others have no rotor of their own
    yield "link", lambda s: s.link_Nm[j], {"rotor_share": rotor, "friction_share": 0.0}
    if at.evidence.load_sensor:  # the gear carries what the drive gives
        return
    if rotor == 0.0:
        yield "link and rotor", lambda s: s.link_Nm[j] + s.rotor_Nm[j], {"rotor_share": 1.0, "friction_share": 0.0}
    yield "all", lambda s: s.joint_Nm[j], {"rotor_share": 1.0, "friction_share": 1.0}


def load_friction(at):
    j = at.number
    if not at.carries_both_ways:
        return
    for name, load, shares in _loads(at):
        column = at.joint_column(lambda s, f=load: s.slip[j] * np.abs(f(s)))
        yield Candidate("load_friction", at.name, name, (column,), named("coefficient", **shares), (0.0,), (LARGEST_SHARE,))
        for power in LOAD_POWERS:
            scale = float(max(np.quantile(np.abs(load(s)), 0.98) for s in at.scenes)) + 1e-12
            law = lambda s, f=load, p=power, x=scale: s.slip[j] * np.abs(f(s)) * np.abs(f(s) / x) ** (p - 1)
            yield Candidate("load_friction", at.name, f"{name}, power {power:g}", (at.joint_column(law),),
                            named("coefficient", exponent=power, scale_Nm=scale, **shares), (0.0,), (LARGEST_SHARE,))  # fmt: skip
    for own in () if at.evidence.load_sensor else OWN_COEFFICIENTS:
        yield _of_the_motors_torque(at, own)


def _of_the_motors_torque(at, own):
    """Friction that the motor's torque makes carries itself: T = X + c |T| slip, solved for T with the coefficient `own`, of
    which the strength found must come near."""
    j = at.number
    column = at.joint_column(lambda s: (s.slip[j] * np.abs(s.joint_Nm[j]) + own * s.joint_Nm[j]) / (1 - own**2))
    shapes = {"rotor_share": 1.0, "friction_share": 1.0, "own_coefficient": float(own)}
    make = lambda own: _of_the_motors_torque(at, own)
    return Candidate("load_friction", at.name, f"the motor's, {own:g}", (column,), named("coefficient", **shapes),
                     (own / OWN_WITHIN,), (own * OWN_WITHIN,), family=Family(make, (own,), (1.3,), (0.03,), (0.5,)))  # fmt: skip


def directional_efficiency(at):
    j = at.number
    if not at.carries_both_ways:
        return
    for name, load, shares in _loads(at):
        driving = at.joint_column(lambda s, f=load: s.slip[j] * np.abs(f(s)) * (f(s) * s.slip[j] > 0))
        driven = at.joint_column(lambda s, f=load: s.slip[j] * np.abs(f(s)) * ~(f(s) * s.slip[j] > 0))
        yield Candidate("directional_efficiency", at.name, name, (driving, driven),
                        named("driving", "back_driving", **shares), (0.0, 0.0), (0.6, 0.6))  # fmt: skip


def asymmetric_friction(at):
    j = at.number
    viscous = at.joint_column(lambda s: np.abs(s.v[j]) * np.abs(s.slip[j]))
    dry = at.joint_column(lambda s: s.slip[j] ** 2)
    both = named("coulomb_Nm", "viscous_Nms_rad")
    hardly_grows = lambda dry, viscous: abs(viscous) * at.extent.speed[j] < HARDLY_GROWS * abs(dry)

    def constant(size):
        """A constant torque is a current's zero more often than friction's: of asymmetries a third do not grow with speed,
        and large ones are as frequent as small ones, while a zero is as often of one order of magnitude as of another."""
        if not at.evidence.leg:
            return CONSTANT_BY_FRICTION
        share = abs(size) / at.coulomb_Nm
        return usual(share, *USUAL_ASYMMETRY) * min(CONSTANT_OF_A_SHARE * share, 1.0)

    yield Candidate("asymmetric_friction", at.name, "viscous", (viscous,),
                    named("viscous_Nms_rad", coulomb_Nm=0.0))  # fmt: skip
    yield Candidate("asymmetric_friction", at.name, "Coulomb", (dry,), named("coulomb_Nm", viscous_Nms_rad=0.0),
                    prior=lambda x: constant(x[0]))  # fmt: skip
    yield Candidate("asymmetric_friction", at.name, "both", (dry, viscous), both,
                    prior=lambda x: constant(x[0]) if hardly_grows(*x) else 1.0)  # fmt: skip


def nonlinear_viscous(at):
    j, speed = at.number, at.extent.speed[at.number]

    def bent(power):
        column = at.joint_column(lambda s: s.slip[j] * np.abs(s.v[j]) ** power)
        # below 1 a negative strength would be friction that falls with speed: stribeck's
        low, limits = ((0.0,), ((0.2,), (0.85,))) if power < 1 else (None, ((1.2,), (3.0,)))
        return Candidate("nonlinear_viscous", at.name, f"power {power:g}", (column,), named("size_Nm", exponent=power), low,
                         family=Family(bent, (power,), (1.3,), *limits))  # fmt: skip

    def saturating(width):
        column = at.joint_column(lambda s: np.tanh(s.v[j] / width))
        return Candidate("nonlinear_viscous", at.name, f"saturating at {width:.3g} rad/s", (column,),
                         named("size_Nm", exponent=1.0, saturation_rad_s=width), (0.0,),
                         family=Family(saturating, (width,), (1.5,), (0.05 * speed,), (1.5 * speed,)))  # fmt: skip

    yield from map(bent, VISCOUS_EXPONENTS)
    yield from (saturating(float(knee * speed)) for knee in VISCOUS_KNEES)


def position_friction(at):
    if at.evidence.velocity_only or not at.travels:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    unit = lambda s: (s.q[j] - middle) / half
    line = at.joint_column(lambda s: s.slip[j] * s.q[j])
    bend = at.joint_column(lambda s: s.slip[j] * s.q[j] ** 2)
    powers = [at.joint_column(lambda s, p=p: s.slip[j] * unit(s) ** p) for p in (1, 2, 3, 4)]
    make = lambda shape, columns, names: Candidate("position_friction", at.name, shape, tuple(columns), names)
    about = {"middle_rad": float(middle)}
    ends = {**about, "range_rad": float(max(np.abs(s.q[j] - middle).max() for s in at.scenes))}

    def unscaled(*orders):  # columns are in units of half the range
        names = ("slope_Nm_rad", "bend_Nm_rad2", "cubic_Nm_rad3", "quartic_Nm_rad4")
        return lambda x: {**{names[p - 1]: float(v / half**p) for p, v in zip(orders, x)}, **ends}

    yield make("line", [line], named("slope_Nm_rad", bend_Nm_rad2=0.0))
    yield make("parabola", [line, bend], named("slope_Nm_rad", "bend_Nm_rad2"))
    yield make("parabola about the middle", powers[1:2], unscaled(2))
    yield make("polynomial", powers, unscaled(1, 2, 3, 4))

    def wave(order):
        waves = [at.joint_column(lambda s, f=f: s.slip[j] * f(order * (s.q[j] - middle))) for f in (np.sin, np.cos)]
        return Candidate("position_friction", at.name, f"wave of {order:.3g} per rad", tuple(waves),
                         named("sine_Nm", "cosine_Nm", **about, wave_1_rad=float(order)),
                         family=Family(wave, (order,), (1.15,), (1.0 / half,), (20.0 / half,)))  # fmt: skip

    for k in POSITION_WAVES:
        yield wave(np.pi * k / half)


def presliding(at):
    j = at.number
    size = 0.1 if at.evidence.model.plant == "slider" else 1.0  # a slider's travel in m
    travels = [size * x for x in PRESLIDING_TRAVELS_RAD]
    shapes = [(travel, power) for power in (1.0, 2.0) for travel in travels]

    def state(scene, travel, power):
        return dahl(np.nan_to_num(scene.travel_rad[j]), travel, power, scene.slip[j][scene.track.parts[0]["begin"]])

    def dahls(travel, power):
        column = at.joint_column(lambda s: at.coulomb_Nm * (state(s, travel, power) - s.slip[j]))
        figures = lambda x: {"friction_Nm": float(x[0]) * at.coulomb_Nm, "travel_rad": float(travel), "power": power}
        return Candidate("presliding", at.name, f"Dahl, power {power:g}, {1e3 * travel:.2g} mrad", (column,), figures,
                         (0.2,), (1.5,), family=Family(dahls, (travel, power), (1.7, 0.5), (travels[0] / 2, 1.0),
                         (2 * travels[-1], 2.0)))  # fmt: skip

    for travel, power in shapes:
        yield dahls(travel, power)


def slow(values, step_s):
    """Moving average over TEMPERATURE_WINDOW_S."""
    n = max(1, int(TEMPERATURE_WINDOW_S / step_s))
    padded = np.pad(values, (n // 2, n - 1 - n // 2), mode="edge")
    return np.convolve(padded, np.ones(n) / n, "valid")


def _over_session(scenes):
    """Changes from 0 to 1 over all recordings, taken one after the other in the order given: (name, function)."""
    if len(scenes) < 2:
        return
    lengths = [s.t_s[-1] - s.t_s[0] for s in scenes]
    begin = np.concatenate([[0.0], np.cumsum(lengths)])
    gone = lambda s: (begin[s.record] + s.t_s - s.t_s[0]) / begin[-1]
    yield "evenly over the session", gone
    yield "settling over the session", lambda s: (1 - np.exp(-3 * gone(s))) / (1 - np.exp(-3.0))


def friction_drift(at):
    """Strengths are shares of the friction at the scenes' parameters; the model file has them in torques. What changes does
    so from the begin, so that the base parameters are the friction there, which is positive."""
    j, dry, viscous = at.number, float(at.scenes[0].coulomb_Nm[at.number]), float(at.scenes[0].viscous[at.number])
    friction = lambda s: dry * s.slip[j] + viscous * s.v[j]
    make = lambda shape, column, names, saved, family=None: Candidate(
        "friction_drift", at.name, shape, (column,), names, saved=saved, family=family)  # fmt: skip

    def all_of_it(constant):
        column = at.joint_column(lambda s: friction(s) * (1 - np.exp(-(s.t_s - s.t_s[0]) / constant)))
        saved = lambda x: {"coulomb_Nm": x[0] * dry, "viscous_Nms_rad": x[0] * viscous, **shapes}
        shapes = {"time_constant_s": float(constant)}
        return make(f"all, {constant:g} s", column, named("share_at_end", **shapes), saved,
                    Family(all_of_it, (constant,), (1.5,), (2.0,), (1000.0,)))  # fmt: skip

    def coulombs(constant):
        column = at.joint_column(lambda s: dry * s.slip[j] * (1 - np.exp(-(s.t_s - s.t_s[0]) / constant)))
        shapes = {"time_constant_s": float(constant)}
        return make(f"Coulomb, {constant:g} s", column, named("coulomb_share_at_end", **shapes),
                    lambda x: {"coulomb_Nm": x[0] * dry, **shapes},
                    Family(coulombs, (constant,), (1.5,), (2.0,), (1000.0,)))  # fmt: skip

    for constant in DRIFT_TIMES_S:
        yield all_of_it(constant)
        yield coulombs(constant)
    for name, fade in _over_session(at.scenes):
        whole = at.joint_column(lambda s, f=fade: friction(s) * f(s))
        coulomb = at.joint_column(lambda s, f=fade: dry * s.slip[j] * f(s))
        warm = {"time_constant_s": 1.0}  # a later recording finds what the last one ended with
        yield make(f"all, {name}", whole, named("share_at_end"),
                   lambda x, w=warm: {"coulomb_Nm": x[0] * dry, "viscous_Nms_rad": x[0] * viscous, **w})
        yield make(f"Coulomb, {name}", coulomb, named("coulomb_share_at_end"),
                   lambda x, w=warm: {"coulomb_Nm": x[0] * dry, **w})  # fmt: skip
    sensor = f"{at.name}_temp_C"
    if all(sensor in s.columns for s in at.scenes):
        middle = float(np.mean([np.mean(s.columns[sensor]) for s in at.scenes]))
        warm = lambda s: (slow(s.columns[sensor], s.step_s) - middle) / 10
        shapes = {"time_constant_s": 60.0, "middle_C": middle}  # the time does not count here
        yield make("temperature", at.joint_column(lambda s: friction(s) * warm(s)), named("share_per_10_C"),
                   lambda x: {"coulomb_Nm_10K": x[0] * dry, "viscous_Nms_rad_10K": x[0] * viscous, **shapes})
        coulomb = at.joint_column(lambda s: dry * s.slip[j] * warm(s))
        yield make("Coulomb, temperature", coulomb, named("coulomb_share_per_10_C"),
                   lambda x: {"coulomb_Nm_10K": x[0] * dry, **shapes})  # fmt: skip
        yield make("viscous, temperature", at.joint_column(lambda s: s.v[j] * warm(s)), named("viscous_Nms_rad_per_10_C"),
                   lambda x: {"viscous_Nms_rad_10K": x[0], **shapes})  # fmt: skip


EFFECTS = (stribeck, load_friction, directional_efficiency, asymmetric_friction, nonlinear_viscous, position_friction,
           presliding, friction_drift)  # fmt: skip
