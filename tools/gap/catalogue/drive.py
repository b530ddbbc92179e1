"""Effects of motor, sensor and sampling: what the current shows and the motion does not feel, and torques that are
periodic in the motor's angle."""

import numpy as np

from .candidate import Candidate, Family, library_column, named, usual

SATURATION_POWERS = (1, 2, 3, 5)
LARGEST_DROOP = 0.8  # of the torque at the largest current
LARGEST_DROOP_SEEN = 0.35  # where a sensor shows the torque itself, and a wrong constant could pass for droop
SATURATION_KNEES = (0.3, 0.5, 0.7)  # of the largest torque
# the delay itself is a strength: these are where it is linear
DELAYS_S = (-0.020, -0.015, -0.010, -0.006, -0.003, -0.001, 0.001, 0.003, 0.006, 0.010, 0.015, 0.020)
COGGING_ORDERS = (*range(5, 25), 28, 30, 32, 36, 40, 42, 48, 54, 60, 72, 84)
LAST_WITH_OVERTONE = 42
USUAL_OFFSET_A = (0.02, 0.2)
BESIDE_A_SENSOR = 0.3  # prior of what a wrong constant, or the sensor's zero, is likelier to be
WAVES = (np.sin, np.cos)
# A ripple that position control does not hold shakes the motor instead, and the recorded acceleration shows of that what
# the reconstruction's window leaves: half at 1.67 of the low-pass frequency, falling with the fourth power
SHOWN_UP_TO = 1.67
FEWEST_WAVES_RAD = 2 * np.pi * 1.5  # what has not gone through more than one period is not known to have any


def torque_saturation(at):
    j, largest = at.number, at.extent.motor_Nm[at.number]
    most = LARGEST_DROOP_SEEN if at.evidence.load_sensor else LARGEST_DROOP
    likely = lambda x: BESIDE_A_SENSOR if at.evidence.load_sensor else 1.0

    def bent(power):
        column = at.motor_column(lambda s: s.motor_Nm[j] * np.abs(s.motor_Nm[j] / largest) ** power)
        figures = lambda x: {"droop_1_Nm": float(x[0]) * abs(at.gear / largest) ** power, "exponent": float(power)}
        return Candidate("torque_saturation", at.name, f"power {power:g}", (column,), figures, (0.0,), (most,), prior=likely,
                         family=Family(bent, (power,), (1.5,), (0.5,), (8.0,)))  # fmt: skip

    def kinked(knee):
        begin = float(knee * largest)
        column = at.motor_column(lambda s: np.sign(s.motor_Nm[j]) * np.maximum(np.abs(s.motor_Nm[j]) - begin, 0))
        return Candidate("torque_saturation", at.name, f"beyond {begin:.3g} Nm", (column,),
                         named("droop_1_Nm", exponent=0.0, begin_Nm=begin / abs(at.gear)), (0.0,),
                         (most / (1 - knee),), family=Family(kinked, (knee,), (0.1,), (0.05,), (0.9,)))  # fmt: skip

    yield from map(bent, SATURATION_POWERS)
    if not at.evidence.load_sensor:
        yield from map(kinked, SATURATION_KNEES)


def current_offset(at):
    column = at.motor_column(lambda s: np.ones(len(s.t_s)))
    figures = lambda x: {"torque_Nm": float(x[0]) / at.gear}
    shape = "beside a sensor" if at.evidence.load_sensor else "constant"

    def prior(x):
        if at.evidence.leg:
            return usual(abs(x[0]) / at.evidence.tree[at.name]["torque_constant_Nm_A"], *USUAL_OFFSET_A)
        return BESIDE_A_SENSOR if at.evidence.load_sensor else 1.0

    yield Candidate("current_offset", at.name, shape, (column,), figures, prior=prior)


def sensor_effects(at):
    """What only a torque sensor at the output shows."""
    if not at.evidence.load_sensor:
        return
    j = at.number
    gain = at.reading_column(lambda s: s.given_drive_Nm[j])
    # the reading is the load: the drive gives (1 + excess) of what its constant says
    yield Candidate("torque_constant", at.name, "scale", (gain,), named("excess"), (-0.6,), (1.5,))
    yield Candidate("sensor_offset", at.name, "constant", (at.reading_column(lambda s: np.ones(len(s.t_s))),),
                    named("offset_Nm"))  # fmt: skip


def delay(at):
    """A current that is later than the angles; beside a sensor at the output, where the current is known and a late one tells
    of an earlier instant, also both later than the sensor."""
    j = at.number

    def column(shift_s, of):
        def later(piece, step_s):
            t = np.arange(len(piece)) * step_s
            return (np.interp(t - at.sign * shift_s, t, piece) - piece) / shift_s

        return lambda s: {f"T{j}": s.track.lowpass(s.track.by_part(of(s), lambda piece: later(piece, s.step_s)))}

    def current(scene):
        return scene.grid("motor_Nm", j)

    def reading(scene):
        return scene.once("load", lambda: scene.track.resample(scene.drive_Nm[j] + scene.track.raw[j] @ scene.base))

    for shift_s in DELAYS_S:
        near = f"near {1e3 * shift_s:g} ms"
        yield Candidate("delay", at.name, near, (column(shift_s, current),), named("delay_s"))
        if at.evidence.load_sensor:
            yield Candidate("delay", at.name, f"{near}, angles too", (column(shift_s, reading),),
                            named("delay_s", angles_too=1.0))  # fmt: skip


def ripple_shown(scene, at, order, fades_Hz):
    """The part of a ripple, `order` a turn of the motor, that the current shows: half of it at fades_Hz (0: all)."""
    if not fades_Hz:
        return 1.0
    j = at.number
    squared = scene.once(("turns squared", j), lambda: (abs(at.gear) * scene.v[j] * scene.ratio[j] / (2 * np.pi)) ** 2)
    part = squared * (order / fades_Hz) ** 2
    return 1 / (1 + part * part)


def fades(at):
    """Frequencies at which half of a ripple shows; 0: all of it, whatever its frequency."""
    window = SHOWN_UP_TO * at.evidence.tracks[0].recording.score.lowpass_hz
    return (window,) if at.evidence.leg else (0.0, window)


def cogging(at):
    if at.evidence.velocity_only:
        return
    j, made, most = at.number, {}, at.extent.motor_Nm[at.number]

    def wave(order, function, fades_Hz):
        if (order, function, fades_Hz) not in made:
            law = lambda s: function(order * abs(at.gear) * s.motor_rad[j]) * ripple_shown(s, at, order, fades_Hz)
            made[order, function, fades_Hz] = at.motor_column(law)
        return made[order, function, fades_Hz]

    def figures(order, fades_Hz):
        names = ("sine_Nm", "cosine_Nm", "overtone_sine_Nm", "overtone_cosine_Nm")
        gear = abs(at.gear), at.gear, abs(at.gear), at.gear  # of the motor's torque in the joint's
        shape = {"per_turn": float(order), "fades_Hz": fades_Hz}
        return lambda x: {**{n: float(v) / g for n, v, g in zip(names, x, gear)}, **shape}

    for order, fades_Hz in ((k, f) for k in COGGING_ORDERS for f in fades(at) if k * at.motor_range > FEWEST_WAVES_RAD):
        name = f", fading at {fades_Hz:g} Hz" if fades_Hz else ""
        one = tuple(wave(order, f, fades_Hz) for f in WAVES)
        limits = lambda waves: ((-most,) * len(waves), (most,) * len(waves))
        yield Candidate("cogging", at.name, f"{order} per turn{name}", one, figures(order, fades_Hz), *limits(one))
        if order <= LAST_WITH_OVERTONE:
            two = one + tuple(wave(2 * order, f, fades_Hz) for f in WAVES)
            yield Candidate("cogging", at.name, f"{order} and {2 * order} per turn{name}", two, figures(order, fades_Hz),
                            *limits(two))  # fmt: skip


def kinematic_error(at):
    plant = at.evidence.model.plant
    if at.evidence.velocity_only or plant == "slider" or (plant == "leg" and at.name != "knee"):
        return
    j = at.number
    for order in (k for k in (1, 2, 4) if k * at.motor_range > FEWEST_WAVES_RAD):
        turns = order * abs(at.gear)
        side = np.sign(at.gear)
        for fades_Hz in fades(at):
            name = f", fading at {fades_Hz:g} Hz" if fades_Hz else ""
            ripple = tuple(at.joint_column(lambda s, f=f, k=turns, o=order, h=fades_Hz: f(k * s.motor_rad[j])
                                           * ripple_shown(s, at, o, h)) for f in WAVES)  # fmt: skip
            figures = lambda x, k=order, s=side, h=fades_Hz: {
                "sine_Nm": s * float(x[0]), "cosine_Nm": float(x[1]), "per_turn": float(k), "fades_Hz": h}  # fmt: skip
            yield Candidate("kinematic_error", at.name, f"torque, {order} per turn{name}", ripple, figures)
        by_load = tuple(at.joint_column(lambda s, f=f, k=turns, o=order, h=fades(at)[-1]: s.link_Nm[j] * f(k * s.motor_rad[j])
                                        * ripple_shown(s, at, o, h)) for f in WAVES)  # fmt: skip
        shares = lambda x, k=order, s=side, h=fades(at)[-1]: {
            "sine_Nm": 0.0, "cosine_Nm": 0.0, "sine_share": s * float(x[0]), "cosine_share": float(x[1]),
            "per_turn": float(k), "fades_Hz": h}  # fmt: skip
        yield Candidate("kinematic_error", at.name, f"share of the load, {order} per turn", by_load, shares)
        if plant == "leg":
            shape = {"per_turn": float(order), "fades_Hz": 0.0}
            error = tuple(library_column("kinematic_error", j, k, shape) for k in (2, 3))
            yield Candidate("kinematic_error", at.name, f"angle, {order} per turn", error,
                            named("sine_rad", "cosine_rad", per_turn=float(order)))  # fmt: skip


EFFECTS = (torque_saturation, current_offset, sensor_effects, delay, cogging, kinematic_error)
