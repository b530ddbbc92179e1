"""Effects of motor, sensor and sampling: what the current shows and the motion does not feel, and torques that are
periodic in the motor's angle."""

import numpy as np

from .candidate import Candidate, Family, named, usual

SATURATION_POWERS = (1, 2, 3, 5)
LARGEST_DROOP = 0.8  # of the torque at the largest current
LARGEST_DROOP_SEEN = 0.35  # where a sensor shows the torque itself, and a wrong constant could pass for droop
SATURATION_KNEES = (0.3, 0.5, 0.7)  # of the largest torque
# the delay itself is a strength: these are where it is linear
DELAYS_S = (-0.020, -0.015, -0.010, -0.006, -0.003, -0.001, 0.001, 0.003, 0.006, 0.010, 0.015, 0.020)
# of a leg's drives: less than a tenth of a millisecond is nothing, and more than two samples of its recordings no sampling
DELAY_OF_A_LEG_S = (0.0001, 0.010)
COGGING_ORDERS = (*range(5, 25), 28, 30, 32, 36, 40, 42, 48, 54, 60, 72, 84)
LAST_WITH_OVERTONE = 42
USUAL_OFFSET_A, LARGEST_OFFSET_A = (0.02, 0.2), 0.5
BESIDE_A_SENSOR = 0.3  # prior of what a wrong constant, or the sensor's zero, is likelier to be
# A ripple that position control does not hold shakes the motor instead, and the recorded acceleration shows of that what
# the reconstruction's window leaves: half at 1.67 of the low-pass frequency, falling with the fourth power
SHOWN_UP_TO = 1.67
FEWEST_WAVES_RAD = 2 * np.pi * 1.5  # what has not gone through more than one period is not known to have any


def torque_saturation(at):
    largest = at.extent.motor_Nm[at.number]
    most = LARGEST_DROOP_SEEN if at.evidence.load_sensor else LARGEST_DROOP
    likely = lambda x: BESIDE_A_SENSOR if at.evidence.load_sensor else 1.0

    def bent(power):
        unit = {"droop_1_Nm": abs(at.gear / largest) ** power}  # a share of the largest torque
        return at.of_law("torque_saturation", f"power {power:g}", [unit], {"exponent": float(power)}, low=(0.0,), high=(most,),
                         prior=likely, family=Family(bent, (power,), (1.5,), (0.5,), (8.0,)))  # fmt: skip

    def kinked(knee):
        begin = float(knee * largest)
        shapes = {"exponent": 0.0, "begin_Nm": begin / abs(at.gear)}
        return at.of_law("torque_saturation", f"beyond {begin:.3g} Nm", [{"droop_1_Nm": 1.0}], shapes, low=(0.0,),
                         high=(most / (1 - knee),), family=Family(kinked, (knee,), (0.1,), (0.05,), (0.9,)))  # fmt: skip

    yield from map(bent, SATURATION_POWERS)
    if not at.evidence.load_sensor:
        yield from map(kinked, SATURATION_KNEES)


def current_offset(at):
    shape = "beside a sensor" if at.evidence.load_sensor else "constant"

    def prior(x):
        if at.evidence.at_motor:
            return usual(abs(x[0]) / at.evidence.tree[at.name]["torque_constant_Nm_A"], *USUAL_OFFSET_A)
        return BESIDE_A_SENSOR if at.evidence.load_sensor else 1.0

    # beside a spring with a preload an offset could be anything, and both together nearly nothing
    most = LARGEST_OFFSET_A * at.evidence.tree[at.name]["torque_constant_Nm_A"] if at.evidence.at_motor else np.inf
    yield at.of_law("current_offset", shape, [{"torque_Nm": 1.0}], low=(-most,), high=(most,), prior=prior)


def torque_constant(at):
    if not at.evidence.load_sensor:
        return
    j = at.number
    gain = at.reading_column(lambda s: s.given_drive_Nm[j])
    # the reading is the load: the drive gives (1 + excess) of what its constant says
    yield Candidate("torque_constant", at.name, "scale", (gain,), named("excess"), (-0.6,), (1.5,))


def sensor_offset(at):
    if at.evidence.load_sensor:
        yield at.of_law("sensor_offset", "constant", [{"offset_Nm": 1.0}])


def delay(at):
    """A current that is later than the angles; beside a sensor at the output, where the current is known and a late one tells
    of an earlier instant, also both later than the sensor."""
    least, most = DELAY_OF_A_LEG_S if at.evidence.at_motor else (0.0, max(DELAYS_S))
    for near_s in (s for s in DELAYS_S if least < abs(s) <= most):
        near, limits = f"near {1e3 * near_s:g} ms", ((least,), (most,)) if near_s > 0 else ((-most,), (-least,))
        for form, saved in ((near, {}), (f"{near}, angles too", {"angles_too": 1.0}))[:2 if at.evidence.load_sensor else 1]:
            yield at.of_law("delay", form, [{"delay_s": 1.0}], {"near_s": near_s, **saved}, saved=([{"delay_s": 1.0}], saved), low=limits[0],
                            high=limits[1])  # fmt: skip


def fades(at):
    """Frequencies at which half of a ripple shows; 0: all of it, whatever its frequency."""
    window = SHOWN_UP_TO * at.evidence.tracks[0].recording.score.lowpass_hz
    return (window,) if at.evidence.at_motor else (0.0, window)


def cogging(at):
    if at.evidence.velocity_only:
        return
    most = at.extent.motor_Nm[at.number] / abs(at.gear)
    ripple, overtone = ("sine_Nm", "cosine_Nm"), ("overtone_sine_Nm", "overtone_cosine_Nm")

    for order, fades_Hz in ((k, f) for k in COGGING_ORDERS for f in fades(at) if k * at.motor_range > FEWEST_WAVES_RAD):
        name = f", fading at {fades_Hz:g} Hz" if fades_Hz else ""
        shapes = {"per_turn": float(order), "fades_Hz": fades_Hz}
        make = lambda form, names, shapes=shapes: at.of_law(
            "cogging", form, [{n: 1.0} for n in names], shapes, low=(-most,) * len(names), high=(most,) * len(names))
        yield make(f"{order} per turn{name}", ripple)
        if order <= LAST_WITH_OVERTONE:
            yield make(f"{order} and {2 * order} per turn{name}", ripple + overtone)


def kinematic_error(at):
    if at.evidence.velocity_only or not at.evidence.model.facts.motor:
        return

    def ripple(form, of, shapes):
        return at.of_law("kinematic_error", form, [{f"{wave}_{of}": 1.0} for wave in ("sine", "cosine")], shapes)

    for order in (k for k in (1, 2, 4) if k * at.motor_range > FEWEST_WAVES_RAD):
        for fades_Hz in fades(at):
            name = f", fading at {fades_Hz:g} Hz" if fades_Hz else ""
            yield ripple(f"torque, {order} per turn{name}", "Nm", {"per_turn": float(order), "fades_Hz": fades_Hz})
        shapes = {"per_turn": float(order), "fades_Hz": fades(at)[-1]}
        yield ripple(f"share of the load, {order} per turn", "share", shapes)
        if at.evidence.at_motor:
            yield ripple(f"angle, {order} per turn", "rad", {"per_turn": float(order)})
