"""Effects of friction: its dependence on speed, load, direction, position, history and time."""

import math

import numpy as np

from .candidate import Family, named, usual
from .law import law_at

STRIBECK_SPEEDS_RAD_S = (0.02, 0.04, 0.07, 0.12, 0.2, 0.3, 0.45)
VISCOUS_EXPONENTS = (0.33, 0.5, 0.7, 1.5, 2.0, 3.0)
VISCOUS_KNEES = (0.1, 0.2, 0.4, 0.7)  # of the largest speed
POSITION_WAVES = (0.5, 0.75, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 4, 5)  # half turns over half the range
POSITION_POWERS = ("slope_Nm_rad", "bend_Nm_rad2", "cubic_Nm_rad3", "quartic_Nm_rad4")
PRESLIDING_TRAVELS_RAD = (0.0007, 0.0015, 0.003, 0.006, 0.012, 0.024)
USUAL_ASYMMETRY = (0.1, 0.4)  # of Coulomb friction
CONSTANT_BY_FRICTION, CONSTANT_OF_A_SHARE = 0.4, 2.5
HARDLY_GROWS = 0.5  # of the constant difference, that the viscous one adds at full speed
LARGEST_SHARE = 0.45  # of the load, lost in a gear in use
LOAD_POWERS = (1.5, 2.0)
OWN_COEFFICIENTS, OWN_WITHIN = (0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4), 1.2
DRIFT_TIMES_S = (5, 10, 20, 40, 80, 200)
EVENLY, SETTLING = 1000.0, 3.0  # sessions in a time constant so long that change is even; time constants in a session


def stribeck(at):
    j, speed = at.number, at.extent.speed[at.number]
    slider = at.evidence.model.coordinate_unit == "m"
    speeds = [x * speed for x in (0.02, 0.05, 0.1)] if slider else STRIBECK_SPEEDS_RAD_S

    def falling(width, power):
        return at.of_law("stribeck", f"power {power:g}, {width:.3g} rad/s", [{"extra_Nm": 1.0}],
                         {"speed_rad_s": float(width), "exponent": power}, low=(0.02 * at.coulomb_Nm,),
                         high=(1.5 * at.usual_coulomb_Nm,), family=Family(falling, (width, power), (1.5, 0.5),
                         (speeds[0] / 2, 0.5), (0.25 * speed, 2.0)))  # fmt: skip

    for power in (1.0, 2.0):
        for width in speeds:
            if width <= 0.25 * speed:  # wider is viscous friction under another name
                yield falling(width, power)


def _loads(at):
    """Readings of `the torque that the gear carries` that the literature has: name, and shares of the rotor and of friction
    in it."""
    rotor = 0.0 if at.evidence.at_motor and at.number == 1 else 1.0  # the others have no rotor of their own
    yield "link", {"rotor_share": rotor, "friction_share": 0.0}
    if at.evidence.load_sensor:  # the gear carries what the drive gives
        return
    if rotor == 0.0:
        yield "link and rotor", {"rotor_share": 1.0, "friction_share": 0.0}
    yield "all", {"rotor_share": 1.0, "friction_share": 1.0}


def load_friction(at):
    if not at.carries_both_ways:
        return
    within = {"low": (0.0,), "high": (LARGEST_SHARE,)}
    for name, shares in _loads(at):
        yield at.of_law("load_friction", name, [{"coefficient": 1.0}], shares, **within)
        scale = _largest_load(at, shares)
        for power in LOAD_POWERS:
            shapes = {"exponent": power, "scale_Nm": scale, **shares}
            yield at.of_law("load_friction", f"{name}, power {power:g}", [{"coefficient": 1.0}], shapes, **within)
    for own in () if at.evidence.load_sensor else OWN_COEFFICIENTS:
        yield _of_the_motors_torque(at, own)


def _largest_load(at, shares):
    """But for extremes, over all recordings."""
    grown = lambda scene: law_at(scene, at.number, "load_friction", "coefficient", shares)
    return float(max(np.quantile(np.abs(grown(scene)), 0.98) for scene in at.scenes)) + 1e-12


def _of_the_motors_torque(at, own):
    """Friction that the motor's torque makes carries itself: T = X + c |T| slip, solved for T with the coefficient `own`, of
    which the strength found must come near."""
    shapes = {"rotor_share": 1.0, "friction_share": 1.0, "own_coefficient": float(own)}
    make = lambda own: _of_the_motors_torque(at, own)
    return at.of_law("load_friction", f"the motor's, {own:g}", [{"coefficient": 1.0}], shapes, low=(own / OWN_WITHIN,),
                     high=(own * OWN_WITHIN,), family=Family(make, (own,), (1.3,), (0.03,), (0.5,)))  # fmt: skip


def directional_efficiency(at):
    if not at.carries_both_ways:
        return
    for name, shares in _loads(at):
        yield at.of_law("directional_efficiency", name, [{"driving": 1.0}, {"back_driving": 1.0}], shares, low=(0.0, 0.0),
                        high=(0.6, 0.6))  # fmt: skip


def asymmetric_friction(at):
    dry, viscous, j = {"coulomb_Nm": 1.0}, {"viscous_Nms_rad": 1.0}, at.number
    hardly_grows = lambda constant, slope: abs(slope) * at.extent.speed[j] < HARDLY_GROWS * abs(constant)

    def constant(size):
        """A constant torque is a current's zero more often than friction's: of asymmetries a third do not grow with speed,
        and large ones are as frequent as small ones, while a zero is as often of one order of magnitude as of another."""
        if not at.evidence.at_motor:
            return CONSTANT_BY_FRICTION
        share = abs(size) / at.coulomb_Nm
        return usual(share, *USUAL_ASYMMETRY) * min(CONSTANT_OF_A_SHARE * share, 1.0)

    yield at.of_law("asymmetric_friction", "viscous", [viscous])
    yield at.of_law("asymmetric_friction", "Coulomb", [dry], prior=lambda x: constant(x[0]))
    yield at.of_law("asymmetric_friction", "both", [dry, viscous],
                    prior=lambda x: constant(x[0]) if hardly_grows(*x) else 1.0)  # fmt: skip


def nonlinear_viscous(at):
    j, speed = at.number, at.extent.speed[at.number]

    def bent(power):
        # below 1 a negative strength would be friction that falls with speed: stribeck's
        low, limits = ((0.0,), ((0.2,), (0.85,))) if power < 1 else (None, ((1.2,), (3.0,)))
        return at.of_law("nonlinear_viscous", f"power {power:g}", [{"size_Nm": 1.0}], {"exponent": power}, low=low,
                         family=Family(bent, (power,), (1.3,), *limits))  # fmt: skip

    def saturating(width):
        return at.of_law("nonlinear_viscous", f"saturating at {width:.3g} rad/s", [{"size_Nm": 1.0}],
                         {"exponent": 1.0, "saturation_rad_s": width}, low=(0.0,),
                         family=Family(saturating, (width,), (1.5,), (0.05 * speed,), (1.5 * speed,)))  # fmt: skip

    yield from map(bent, VISCOUS_EXPONENTS)
    yield from (saturating(float(knee * speed)) for knee in VISCOUS_KNEES)


def position_friction(at):
    if at.evidence.velocity_only or not at.travels:
        return
    j, middle, half = at.number, at.extent.middle[at.number], at.extent.half_range[at.number]
    about = {"middle_rad": float(middle)}
    ends = {**about, "range_rad": float(max(np.abs(s.q[j] - middle).max() for s in at.scenes))}
    # about the middle in units of half the range
    powers = [{name: float(half**-p)} for p, name in enumerate(POSITION_POWERS, 1)]
    make = lambda form, columns, shapes=None: at.of_law("position_friction", form, columns, shapes)
    yield make("line", [{"slope_Nm_rad": 1.0}])
    yield make("parabola", [{"slope_Nm_rad": 1.0}, {"bend_Nm_rad2": 1.0}])
    yield make("parabola about the middle", powers[1:2], ends)
    yield make("polynomial", powers, ends)

    def wave(order):
        return at.of_law("position_friction", f"wave of {order:.3g} per rad", [{"sine_Nm": 1.0}, {"cosine_Nm": 1.0}],
                         {**about, "wave_1_rad": float(order)},
                         family=Family(wave, (order,), (1.15,), (1.0 / half,), (20.0 / half,)))  # fmt: skip

    for k in POSITION_WAVES:
        yield wave(np.pi * k / half)


def presliding(at):
    friction_Nm = at.usual_coulomb_Nm
    size = 0.1 if at.evidence.model.coordinate_unit == "m" else 1.0  # a slider's travel in m
    travels = [size * x for x in PRESLIDING_TRAVELS_RAD]
    shapes = [(travel, power) for power in (1.0, 2.0) for travel in travels]

    def dahls(travel, power):
        return at.of_law("presliding", f"Dahl, power {power:g}, {1e3 * travel:.2g} mrad", [{"friction_Nm": friction_Nm}],
                         {"travel_rad": float(travel), "power": power}, low=(0.2,), high=(1.5,),
                         family=Family(dahls, (travel, power), (1.7, 0.5), (travels[0] / 2, 1.0), (2 * travels[-1], 2.0)))  # fmt: skip

    for travel, power in shapes:
        yield dahls(travel, power)


def _over_session(scenes):
    """Changes over all recordings, taken one after the other in the order given: (name, time constant)."""
    if len(scenes) > 1:
        whole_s = sum(s.t_s[-1] - s.t_s[0] for s in scenes)
        yield "evenly over the session", EVENLY * whole_s
        yield "settling over the session", whole_s / SETTLING


def friction_drift(at):
    """Strengths are shares of the friction at the scenes' parameters; the model file has them in torques. What changes does
    so from the begin, so that the base parameters are the friction there, which is positive."""
    j = at.number
    dry, viscous = float(at.scenes[0].coulomb_Nm[j]), float(at.scenes[0].viscous[j])
    of_all, of_dry = {"coulomb_Nm": dry, "viscous_Nms_rad": viscous}, {"coulomb_Nm": dry}
    make = lambda form, amounts, shapes, name, **more: at.of_law(
        "friction_drift", form, [amounts], shapes, parameters=named(name), **more)  # fmt: skip

    def timed(form, amounts, name):
        def one(constant):
            shapes = {"time_constant_s": float(constant)}
            return at.of_law("friction_drift", f"{form}, {constant:g} s", [amounts], shapes, parameters=named(name, **shapes),
                             family=Family(one, (constant,), (1.5,), (2.0,), (1000.0,)))  # fmt: skip
        return one

    of_time = timed("all", of_all, "share_at_end"), timed("Coulomb", of_dry, "coulomb_share_at_end")
    for constant in DRIFT_TIMES_S:
        yield from (one(constant) for one in of_time)
    warm = {"time_constant_s": 1.0}  # a later recording finds what the last one ended with
    for name, constant_s in _over_session(at.scenes):
        whole = 1.0 - math.exp(-sum(s.t_s[-1] - s.t_s[0] for s in at.scenes) / constant_s)
        shapes = {"time_constant_s": constant_s}
        for form, amounts, figure in (("all", of_all, "share_at_end"), ("Coulomb", of_dry, "coulomb_share_at_end")):
            by_end = {parameter: amount / whole for parameter, amount in amounts.items()}
            yield make(f"{form}, {name}", by_end, shapes, figure, saved=([amounts], warm), session=True)
    sensor = f"{at.name}_temp_C"
    if all(sensor in s.columns for s in at.scenes):
        middle = float(np.mean([np.mean(s.columns[sensor]) for s in at.scenes]))
        shapes = {"time_constant_s": 60.0, "middle_C": middle}  # the time does not count here
        by_temperature = lambda amounts: {f"{name}_10K": amount for name, amount in amounts.items()}
        yield make("temperature", by_temperature(of_all), shapes, "share_per_10_C")
        yield make("Coulomb, temperature", by_temperature(of_dry), shapes, "coulomb_share_per_10_C")
        yield make("viscous, temperature", {"viscous_Nms_rad_10K": 1.0}, shapes, "viscous_Nms_rad_per_10_C")
