"""Effects that only the leg has: the ankle's encoders and linkage, and the bench that carries it."""

import numpy as np
from scipy.signal import lfilter

from ..linkage import ScrewLinkage
from .candidate import Candidate, differentiate, link_displaced, named

JOINT_ENCODER_ORDERS = (*range(1, 33), 36, 40, 48, 64)
BASE_HZ = (2.5, 2.75, 3, 3.25, 3.5, 3.75, 4, 4.25, 4.5, 4.75, 5, 5.25, 5.5, 6, 6.5, 7, 7.5, 8, 9, 10, 11, 12, 13.5, 15)
BASE_DAMPING_RATIOS = (0.02, 0.05, 0.1)
STEP_M, STEP_RAD = 1e-5, 1e-4
ANKLE = 1


def encoder_eccentricity(evidence, scenes):
    if "E" in evidence.kinds:
        for order in JOINT_ENCODER_ORDERS:
            def wave(scene, function, k):
                return {"E": scene.track.operate(function(k * scene.travel_rad[ANKLE]))}
            columns = tuple(lambda s, f=f, k=order: wave(s, f, k) for f in (np.sin, np.cos))
            saved = order == 1  # the model file's effect is once a turn
            names = named("joint_sine_rad", "joint_cosine_rad",
                          **({"motor_sine_rad": 0.0, "motor_cosine_rad": 0.0} if saved else {"per_turn": order}))
            yield Candidate("encoder_eccentricity", "ankle", f"joint encoder, {order} per turn", columns, names, saved=saved)
    for order in (1, 2):
        columns = tuple(
            lambda s, f=f, k=order: link_displaced(s, ANKLE, s.track.resample(f(k * s.motor_rad[ANKLE])))
            for f in (np.sin, np.cos))  # fmt: skip
        yield Candidate("encoder_eccentricity", "ankle", f"motor encoder, {order} per turn", columns,
                        named("shown_sine_rad", "shown_cosine_rad", per_turn=order))  # fmt: skip


def _linkage_column(name):
    """What shows per unit of an error of one dimension: another joint angle for the same motor angle, its rates,
    another ratio, and the encoder's disagreement."""
    step = STEP_RAD if name == "BOF_rad" else STEP_M

    def column(scene):
        evidence, track = scene.evidence, scene.track
        given = evidence.transmissions[ANKLE]
        wrong = given.changed(name, step)
        q1 = wrong.joint_rad(given.motor_rad(scene.q[ANKLE]), scene.q[ANKLE])
        rate = lambda q: given.ratio(q) / wrong.ratio(wrong.joint_rad(given.motor_rad(q), q))
        factor, q = rate(scene.q[ANKLE]), scene.q[ANKLE]
        bend = (rate(q + 1e-4) - rate(q - 1e-4)) / 2e-4
        v1, a1 = scene.v[ANKLE] * factor, scene.a[ANKLE] * factor + bend * scene.v[ANKLE] ** 2
        links = scene.links(*(np.array([x[0], y]) for x, y in ((scene.q, q1), (scene.v, v1), (scene.a, a1))))
        friction = scene.coulomb_Nm[ANKLE] * scene.slip[ANKLE] + scene.viscous[ANKLE] * v1
        before = (scene.link_Nm[ANKLE] + scene.friction_Nm[ANKLE]) / scene.ratio[ANKLE]
        after = (links[ANKLE] + friction) / wrong.ratio(q1)
        shown = {"T1": track.operate((after - before) / step, ANKLE),
                 "T0": track.operate((links[0] - scene.link_Nm[0]) / scene.ratio[0] / step, 0)}  # fmt: skip
        moved = wrong.joint_rad(scene.motor_rad[ANKLE], scene.travel_rad[ANKLE]) - scene.travel_rad[ANKLE]
        return {**shown, **{k: track.operate(moved / step) for k in ("E", "F") if k in evidence.kinds}}

    return column


def linkage_error(evidence, scenes):
    if not isinstance(evidence.transmissions[ANKLE], ScrewLinkage):
        return
    column = {name: _linkage_column(name) for name in ("AB_m", "BO_m", "AC_m", "BOF_rad")}
    zero = {"AB_m": 0.0, "BO_m": 0.0, "AC_m": 0.0}
    for names in (("AB_m",), ("BO_m",), ("AC_m",), ("BOF_rad",), ("AB_m", "BO_m"), ("BO_m", "AC_m")):
        saved = "BOF_rad" not in names
        figures = lambda x, n=names, saved=saved: {**(zero if saved else {}), **dict(zip(n, map(float, x)))}
        yield Candidate("linkage_error", "ankle", " and ".join(names), tuple(column[n] for n in names), figures,
                        saved=saved)  # fmt: skip


def gravity_tilt(evidence, scenes):
    def column(scene):
        return {f"T{j}": scene.track.operate(scene.tilt_Nm()[j] / scene.ratio[j], j) for j in range(2)}

    yield Candidate("gravity_tilt", "base", "tilt", (column,), named("tilt_rad"), (-0.2,), (0.2,), saved=True)


def _oscillator(drive, step_s, omega, damping):
    """x'' + 2 d w x' + w^2 x = w^2 drive, bilinear."""
    turn, slow = (omega * step_s) ** 2, 4 * damping * omega * step_s
    a = np.array([4 + slow + turn, 2 * turn - 8, 4 - slow + turn])
    return lfilter(turn * np.array([1, 2, 1]) / a[0], a / a[0], drive)


def _horizontal_force(scene):
    """Of both links' inertia on the mount."""
    track, b = scene.track, scene.base
    a, foot = [track.bridge(scene.a[k], k) for k in range(2)], scene.q[0] + scene.q[1]
    shank = b[1] + scene.foot_kg * scene.shank_m
    near = shank * (np.cos(scene.q[0]) * a[0] - np.sin(scene.q[0]) * scene.v[0] ** 2)
    far = b[2] * (np.cos(foot) * (a[0] + a[1]) - np.sin(foot) * (scene.v[0] + scene.v[1]) ** 2)
    return track.lowpass(track.resample(near + far))


def _base_column(frequency_Hz, damping, turning):
    """One mode of the mount: turning about the knee's axis, driven by its torque, or swaying horizontally, driven by
    the links' force."""

    def column(scene):
        track, step_s, omega = scene.track, scene.step_s, 2 * np.pi * frequency_Hz
        if turning:
            drive = scene.once("knee torque", lambda: track.lowpass(track.resample(track.bridge(scene.joint_Nm[0], 0))))
        else:
            drive = scene.once("horizontal force", lambda: _horizontal_force(scene))
        x = _oscillator(-drive, step_s, omega, damping)
        acceleration = -omega * omega * (x + drive) - 2 * damping * omega * differentiate(x, step_s)
        shown = {}
        for j in range(2):
            if turning:
                inertia = scene.once(("inertia", j), lambda j=j: track.resample(scene.inertia[j][0]))
                gravity = scene.once(("tilt", j), lambda j=j: track.resample(scene.tilt_Nm()[j]))
                torque = inertia * acceleration + gravity * x
            else:
                foot = scene.base[2] * np.cos(scene.grid("q", 0) + scene.grid("q", 1))
                shank = (scene.base[1] + scene.foot_kg * scene.shank_m) * np.cos(scene.grid("q", 0))
                torque = (foot + shank * (j == 0)) * acceleration
            shown[f"T{j}"] = track.lowpass(torque / scene.grid("ratio", j))
        if turning and "K" in scene.evidence.kinds:
            shown["K"] = track.lowpass(x)
        return shown

    return column


def base_compliance(evidence, scenes):
    for damping in BASE_DAMPING_RATIOS:
        for hz in BASE_HZ:
            turn, sway = _base_column(hz, damping, True), _base_column(hz, damping, False)
            shape = {"frequency_Hz": float(hz), "damping_ratio": damping}
            make = lambda name, columns, names, saved, hz=hz, damping=damping, shape=shape: Candidate(
                "base_compliance", "base", f"{name}, {hz:g} Hz, damping {damping:g}", columns, named(*names, **shape),
                (0.0,) * len(columns), saved=saved)  # fmt: skip
            yield make("turning", (turn,), ("compliance_rad_Nm",), True)
            yield make("swaying", (sway,), ("sway_per_kg",), False)
            yield make("both", (turn, sway), ("compliance_rad_Nm", "sway_per_kg"), False)


EFFECTS = (encoder_eccentricity, linkage_error, gravity_tilt, base_compliance)
