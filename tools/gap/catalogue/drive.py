"""Effects of motor, sensor and sampling: what the current shows and the motion does not feel, and torques that are
periodic in the motor's angle."""

import numpy as np

from .candidate import Candidate, link_displaced, named

SATURATION_POWERS = (1, 2, 3, 5)
SATURATION_KNEES = (0.3, 0.5, 0.7)  # of the largest torque
DELAYS_S = (-0.006, -0.003, -0.001, 0.001, 0.003, 0.006)  # the delay itself is a strength: these are where it is linear
COGGING_ORDERS = (*range(5, 25), 28, 30, 32, 36, 40, 42, 48, 54, 60, 72, 84)
LAST_WITH_OVERTONE = 42
WAVES = (np.sin, np.cos)


def torque_saturation(at):
    j, largest = at.number, at.extent.motor_Nm[at.number]
    for power in SATURATION_POWERS:
        column = at.motor_column(lambda s, p=power: s.motor_Nm[j] * np.abs(s.motor_Nm[j] / largest) ** p)
        figures = lambda x, p=power: {"droop_1_Nm": float(x[0]) / largest**p, "exponent": float(p)}
        yield Candidate("torque_saturation", at.name, f"power {power}", (column,), figures, (0.0,), (1.0,),
                        saved=power <= 3)  # fmt: skip
    for knee in SATURATION_KNEES:
        begin = float(knee * largest)
        column = at.motor_column(lambda s, b=begin: np.sign(s.motor_Nm[j]) * np.maximum(np.abs(s.motor_Nm[j]) - b, 0))
        yield Candidate("torque_saturation", at.name, f"beyond {begin:.3g} Nm", (column,),
                        named("droop", begin_Nm=begin), (0.0,), (3.0,))  # fmt: skip


def current_offset(at):
    column = at.motor_column(lambda s: np.ones(len(s.t_s)))
    yield Candidate("current_offset", at.name, "constant", (column,), named("torque_Nm"), saved=True)


def sensor_effects(at):
    """What only a torque sensor at the output shows."""
    if not at.evidence.load_sensor:
        return
    j = at.number
    gain = at.motor_column(lambda s: s.drive_Nm[j])
    # the reading is the load: the drive gives (1 + excess) of what its constant says
    yield Candidate("torque_constant", at.name, "scale", (gain,), named("excess"), saved=True)
    yield Candidate("sensor_offset", at.name, "constant", (at.motor_column(lambda s: np.ones(len(s.t_s))),),
                    named("offset_Nm"), saved=True)  # fmt: skip


def delay(at):
    j = at.number
    for shift_s in DELAYS_S:

        def column(scene, shift_s=shift_s):
            def later(piece):
                t = np.arange(len(piece)) * scene.step_s
                return (np.interp(t - shift_s, t, piece) - piece) / shift_s

            return {f"T{j}": scene.track.lowpass(scene.track.by_part(scene.grid("motor_Nm", j), later))}

        yield Candidate("delay", at.name, f"near {1e3 * shift_s:g} ms", (column,), named("delay_s"), saved=True)


def cogging(at):
    if at.evidence.velocity_only:
        return
    j = at.number

    def wave(order, function):
        return at.motor_column(lambda s: function(order * s.motor_rad[j]))

    for order in COGGING_ORDERS:
        one = tuple(wave(order, f) for f in WAVES)
        yield Candidate("cogging", at.name, f"{order} per turn", one,
                        named("sine_Nm", "cosine_Nm", per_turn=float(order)), saved=True)  # fmt: skip
        if order <= LAST_WITH_OVERTONE:
            two = one + tuple(wave(2 * order, f) for f in WAVES)
            names = named("sine_Nm", "cosine_Nm", "overtone_sine_Nm", "overtone_cosine_Nm", per_turn=float(order))
            yield Candidate("cogging", at.name, f"{order} and {2 * order} per turn", two, names)


def kinematic_error(at):
    plant = at.evidence.model.plant
    if at.evidence.velocity_only or plant == "slider" or (plant == "leg" and at.name != "knee"):
        return
    j = at.number
    for order in (1, 2, 4):
        ripple = tuple(at.joint_column(lambda s, f=f, k=order: f(k * s.motor_rad[j])) for f in WAVES)
        yield Candidate("kinematic_error", at.name, f"torque, {order} per turn", ripple,
                        named("sine_Nm", "cosine_Nm", per_turn=float(order)), saved=True)  # fmt: skip
        if plant == "leg":
            error = tuple(
                lambda s, f=f, k=order: link_displaced(s, j, s.track.resample(f(k * s.motor_rad[j]))) for f in WAVES)  # fmt: skip
            yield Candidate("kinematic_error", at.name, f"angle, {order} per turn", error,
                            named("sine_rad", "cosine_rad", per_turn=float(order)))  # fmt: skip


EFFECTS = (torque_saturation, current_offset, sensor_effects, delay, cogging, kinematic_error)
