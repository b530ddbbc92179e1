"""Effects that only the leg has: the ankle's encoders and linkage, and the bench that carries it."""

from talus import lib

from ..kinds import kind_of
from .candidate import Candidate, Family, named, usual
from .law import BASE, column

JOINT_ENCODER_ORDERS = (*range(1, 33), 36, 40, 48, 64)
BASE_HZ = (2.5, 2.75, 3, 3.25, 3.5, 3.75, 4, 4.25, 4.5, 4.75, 5, 5.25, 5.5, 6, 6.5, 7, 7.5, 8, 9, 10, 11, 12, 13.5, 15)
BASE_DAMPING_RATIOS = (0.02, 0.05, 0.1)
RISING_DAMPING_RATIO = 0.05  # of a second mode, whose resonance is refined
ANKLE = 1
USUAL_TILT_RAD = (0.017, 0.087)


def encoder_eccentricity(at):
    def waves(sensor, order):
        names = f"{sensor}_sine_rad", f"{sensor}_cosine_rad"
        shapes = {f"{sensor}_per_turn": float(order)}
        columns = tuple(column("encoder_eccentricity", (ANKLE,), {name: 1.0}, shapes) for name in names)
        return Candidate("encoder_eccentricity", "ankle", f"{sensor} encoder, {order} per turn", columns, named(*names, **shapes))

    if "E" in at.evidence.kinds:
        yield from (waves("joint", order) for order in JOINT_ENCODER_ORDERS)
    yield from (waves("motor", order) for order in (1, 2))


def linkage_error(at):
    if at.evidence.transmissions[ANKLE].struct.kind != lib.TL_TRANSMISSION_SCREW_LINKAGE:
        return
    known = {parameter.name: parameter for parameter in kind_of("linkage_error").strengths}
    made = {name: column("linkage_error", (ANKLE,), {name: 1.0}, {}) for name in known}
    for names in (("AB_m",), ("BO_m",), ("AC_m",), ("BOF_rad",), ("AB_m", "BO_m"), ("BO_m", "AC_m")):
        low, high = zip(*((known[name].low, known[name].high) for name in names))  # two lengths far off make a wave together
        yield Candidate("linkage_error", "ankle", " and ".join(names), tuple(made[n] for n in names), named(*names), low, high)


def gravity_tilt(at):
    tilt = column("gravity_tilt", (0, 1), {"tilt_rad": 1.0}, {})
    yield Candidate("gravity_tilt", "base", "tilt", (tilt,), named("tilt_rad"), (-0.2,), (0.2,),
                    prior=lambda x: usual(abs(x[0]), *USUAL_TILT_RAD))  # fmt: skip


def base_compliance(at):
    strength = {"turning": "compliance_rad_Nm", "swaying": "sway_m_N", "rising": "rise_m_N"}
    forms = {"turning": ("turning",), "swaying": ("swaying",), "rising": ("rising",), "both": ("turning", "swaying")}

    def mode(form, hz, damping):
        """A form at one resonance."""
        shapes = {"frequency_Hz": float(hz), "damping_ratio": float(damping)}
        own = [strength[one] for one in forms[form]]
        columns = tuple(column("base_compliance", (BASE,), {name: 1.0}, shapes) for name in own)
        return Candidate("base_compliance", "base", f"{form}, {hz:g} Hz, damping {damping:g}", columns, named(*own, **shapes),
                         (0.0,) * len(own), family=Family(lambda hz, damping: mode(form, hz, damping), (hz, damping),
                         (1.05, 1.6), (1.5, 0.006), (25.0, 0.5)))  # fmt: skip

    for damping in BASE_DAMPING_RATIOS:
        for hz in BASE_HZ:
            yield from (mode(form, hz, damping) for form in forms if form != "rising" or damping == RISING_DAMPING_RATIO)
