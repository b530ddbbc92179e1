"""Effects that only the leg has: the ankle's encoders and linkage, and the bench that carries it."""

import numpy as np

from ..linkage import ScrewLinkage
from ..loops import second_order
from .candidate import Candidate, Family, named, usual
from .law import column_along, law_column

JOINT_ENCODER_ORDERS = (*range(1, 33), 36, 40, 48, 64)
BASE_HZ = (2.5, 2.75, 3, 3.25, 3.5, 3.75, 4, 4.25, 4.5, 4.75, 5, 5.25, 5.5, 6, 6.5, 7, 7.5, 8, 9, 10, 11, 12, 13.5, 15)
BASE_DAMPING_RATIOS = (0.02, 0.05, 0.1)
STEP_M, STEP_RAD = 1e-5, 1e-4
ANKLE = 1
USUAL_TILT_RAD = (0.017, 0.087)


def encoder_eccentricity(evidence, scenes):
    if "E" in evidence.kinds:
        for order in JOINT_ENCODER_ORDERS:
            def wave(scene, function, k):
                return {"E": scene.track.operate(function(k * scene.travel_rad[ANKLE]))}
            columns = tuple(lambda s, f=f, k=order: wave(s, f, k) for f in (np.sin, np.cos))
            names = named("joint_sine_rad", "joint_cosine_rad", joint_per_turn=float(order))
            yield Candidate("encoder_eccentricity", "ankle", f"joint encoder, {order} per turn", columns, names)
    for order in (1, 2):
        shapes, names = {"motor_per_turn": float(order)}, ("motor_sine_rad", "motor_cosine_rad")
        columns = tuple(column_along("encoder_eccentricity", ANKLE, name, shapes) for name in names)
        yield Candidate("encoder_eccentricity", "ankle", f"motor encoder, {order} per turn", columns, named(*names, **shapes))


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
    for names in (("AB_m",), ("BO_m",), ("AC_m",), ("BOF_rad",), ("AB_m", "BO_m"), ("BO_m", "AC_m")):
        yield Candidate("linkage_error", "ankle", " and ".join(names), tuple(column[n] for n in names), named(*names))


def gravity_tilt(evidence, scenes):
    column = law_column("gravity_tilt", (0, 1), {"tilt_rad": 1.0}, {})
    yield Candidate("gravity_tilt", "base", "tilt", (column,), named("tilt_rad"), (-0.2,), (0.2,),
                    prior=lambda x: usual(abs(x[0]), *USUAL_TILT_RAD))  # fmt: skip


def _oscillator(drive, step_s, omega, damping):
    """(x, x', x'') of x'' + 2 d w x' + w^2 x = w^2 drive, exact for a drive that goes straight from sample to sample,
    at rest with the first."""
    swing, gone = omega * np.sqrt(1 - damping**2), np.exp(-damping * omega * step_s)
    sine, cosine = np.sin(swing * step_s), np.cos(swing * step_s)
    leave = damping * omega / swing
    step = gone * np.array([[cosine + leave * sine, sine / swing],
                            [-omega**2 / swing * sine, cosine - leave * sine]])  # fmt: skip
    # straight drive: x = drive - lag, v = its rate; the rest swings freely
    lag = 2 * damping / omega
    before = -step @ np.array([[1 + lag / step_s, -lag / step_s], [-1 / step_s, 1 / step_s]])
    after = np.array([[lag / step_s, 1 - lag / step_s], [-1 / step_s, 1 / step_s]])
    out = []
    poles = [1.0, -np.trace(step), np.linalg.det(step)]
    push = before + after  # of the state by (drive before, drive now)
    for k in range(2):
        other = 1 - k
        now = np.array([push[k, 1], push[k, 0] + step[k, other] * push[other, 1] - step[other, other] * push[k, 1],
                        step[k, other] * push[other, 0] - step[other, other] * push[k, 0]])  # fmt: skip
        out.append(second_order(now, poles, drive - drive[0]) + (drive[0] if k == 0 else 0.0))
    x, v = out
    return x, v, omega**2 * (drive - x) - 2 * damping * omega * v


def _horizontal_force(scene):
    """Of both links' inertia on the mount."""
    track, b, a, foot = scene.track, scene.base, scene.a, scene.q[0] + scene.q[1]
    shank = b[1] + scene.foot_kg * scene.shank_m
    near = shank * (np.cos(scene.q[0]) * a[0] - np.sin(scene.q[0]) * scene.v[0] ** 2)
    far = b[2] * (np.cos(foot) * (a[0] + a[1]) - np.sin(foot) * (scene.v[0] + scene.v[1]) ** 2)
    return track.resample(near + far)


def _turned(scene, j):
    """Change of a joint's torque per speed of the mount's turning."""
    bend = 2 * scene.base[2] * scene.shank_m * np.sin(scene.q[1])
    return scene.track.resample(bend * scene.v[0] if j == 1 else -bend * scene.v[1])


def _base_column(frequency_Hz, damping, turning):
    """One mode of the mount: turning about the knee's axis, driven by what the leg's inertia and gravity ask of it, or
    swaying horizontally, driven by the links' force. The drive is not bridged: a stop of the leg jolts its mount."""

    def column(scene):
        track, step_s, omega = scene.track, scene.step_s, 2 * np.pi * frequency_Hz
        if turning:
            drive = scene.once("knee torque", lambda: track.resample(scene.link_Nm[0]))
        else:
            drive = scene.once("horizontal force", lambda: _horizontal_force(scene))
        x, speed, acceleration = _oscillator(-drive, step_s, omega, damping)
        shown = {}
        for j in range(2):
            if turning:
                inertia = scene.once(("inertia", j), lambda j=j: track.resample(scene.inertia[j][0]))
                gravity = scene.once(("tilt", j), lambda j=j: track.resample(scene.tilt_Nm()[j]))
                torque = inertia * acceleration + gravity * x + scene.once(("turned", j), lambda j=j: _turned(scene, j)) * speed
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
    names = {"turning": ("compliance_rad_Nm",), "swaying": ("sway_m_N",), "both": ("compliance_rad_Nm", "sway_m_N")}

    def modes(hz, damping):
        """Every form at one resonance; the columns are shared."""
        turn, sway = _base_column(hz, damping, True), _base_column(hz, damping, False)
        columns = {"turning": (turn,), "swaying": (sway,), "both": (turn, sway)}
        for form, own in names.items():
            make = lambda hz, damping, form=form: next(c for c in modes(hz, damping) if c.shape.startswith(form))
            yield Candidate("base_compliance", "base", f"{form}, {hz:g} Hz, damping {damping:g}", columns[form],
                            named(*own, frequency_Hz=float(hz), damping_ratio=float(damping)), (0.0,) * len(own),
                            family=Family(make, (hz, damping), (1.05, 1.6), (1.5, 0.006), (25.0, 0.5)))  # fmt: skip

    for damping in BASE_DAMPING_RATIOS:
        for hz in BASE_HZ:
            yield from modes(hz, damping)


EFFECTS = (encoder_eccentricity, linkage_error, gravity_tilt, base_compliance)
