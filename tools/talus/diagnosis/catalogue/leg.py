"""Effects that only the leg has: the ankle's encoders and linkage, and the bench that carries it."""

import numpy as np

from ..kinds import kind_of
from ..linkage import ScrewLinkage
from ..loops import second_order
from .candidate import Candidate, Family, named, usual
from .law import column_along, law_column

JOINT_ENCODER_ORDERS = (*range(1, 33), 36, 40, 48, 64)
BASE_HZ = (2.5, 2.75, 3, 3.25, 3.5, 3.75, 4, 4.25, 4.5, 4.75, 5, 5.25, 5.5, 6, 6.5, 7, 7.5, 8, 9, 10, 11, 12, 13.5, 15)
BASE_DAMPING_RATIOS = (0.02, 0.05, 0.1)
RISING_DAMPING_RATIO = 0.05  # of a second mode, whose resonance is refined
STEP_M, STEP_RAD = 1e-5, 1e-4
ANKLE = 1
USUAL_TILT_RAD = (0.017, 0.087)


def encoder_eccentricity(at):
    if "E" in at.evidence.kinds:
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


def linkage_error(at):
    if not isinstance(at.evidence.transmissions[ANKLE], ScrewLinkage):
        return
    known = {parameter.name: parameter for parameter in kind_of("linkage_error").strengths}
    column = {name: _linkage_column(name) for name in known}
    for names in (("AB_m",), ("BO_m",), ("AC_m",), ("BOF_rad",), ("AB_m", "BO_m"), ("BO_m", "AC_m")):
        low, high = zip(*((known[name].low, known[name].high) for name in names))  # two lengths far off make a wave together
        yield Candidate("linkage_error", "ankle", " and ".join(names), tuple(column[n] for n in names), named(*names), low, high)


def gravity_tilt(at):
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


def _forces(scene):
    """Of both links' inertia on the mount: to the front and upwards."""
    track, b, a, foot = scene.track, scene.base, scene.a, scene.q[0] + scene.q[1]
    near, far = b[1] + scene.foot_kg * scene.shank_m, b[2]
    knee_v2, foot_v2, foot_a = scene.v[0] ** 2, (scene.v[0] + scene.v[1]) ** 2, a[0] + a[1]
    sine, cosine, foot_sine, foot_cosine = np.sin(scene.q[0]), np.cos(scene.q[0]), np.sin(foot), np.cos(foot)
    front = near * (cosine * a[0] - sine * knee_v2) + far * (foot_cosine * foot_a - foot_sine * foot_v2)
    upwards = near * (sine * a[0] + cosine * knee_v2) + far * (foot_sine * foot_a + foot_cosine * foot_v2)
    return track.resample(front), track.resample(upwards)


def _turned(scene, j):
    """Change of a joint's torque per speed of the mount's turning."""
    bend = 2 * scene.base[2] * scene.shank_m * np.sin(scene.q[1])
    return scene.track.resample(bend * scene.v[0] if j == 1 else -bend * scene.v[1])


def _turning(scene):
    """What drives a mount that turns about the knee's axis: what the leg's inertia and gravity ask of it. Not bridged: a stop
    of the leg jolts its mount."""
    return scene.once("knee torque", lambda: scene.track.resample(scene.link_Nm[0]))


def _base_column(mode, frequency_Hz, damping):
    """One mode of the mount: turning, or one that sways or rises under the links' forces."""

    def column(scene):
        track = scene.track
        drive = _turning(scene) if mode == "turning" else scene.once("forces", lambda: _forces(scene))[mode == "rising"]
        x, speed, acceleration = _oscillator(-drive, scene.step_s, 2 * np.pi * frequency_Hz, damping)
        shown = {}
        for j in range(2):
            if mode == "turning":
                inertia = scene.once(("inertia", j), lambda j=j: track.resample(scene.inertia[j][0]))
                gravity = scene.once(("tilt", j), lambda j=j: track.resample(scene.tilt_Nm()[j]))
                torque = inertia * acceleration + gravity * x + scene.once(("turned", j), lambda j=j: _turned(scene, j)) * speed
            else:
                torque = scene.once(("arm", mode, j), lambda j=j: _arm(scene, mode, j)) * acceleration
            shown[f"T{j}"] = track.lowpass(torque / scene.grid("ratio", j))
        if mode == "turning" and "K" in scene.evidence.kinds:
            shown["K"] = track.lowpass(x)
        return shown

    return column


def _arm(scene, mode, j):
    """Torque of a joint per acceleration of the mount."""
    part = np.sin if mode == "rising" else np.cos
    foot = scene.base[2] * part(scene.grid("q", 0) + scene.grid("q", 1))
    return foot + (scene.base[1] + scene.foot_kg * scene.shank_m) * part(scene.grid("q", 0)) * (j == 0)


def base_compliance(at):
    strength = {"turning": "compliance_rad_Nm", "swaying": "sway_m_N", "rising": "rise_m_N"}
    forms = {"turning": ("turning",), "swaying": ("swaying",), "rising": ("rising",), "both": ("turning", "swaying")}

    def mode(form, hz, damping, made=None):
        """A form at one resonance; forms share their columns in `made`."""
        made = {} if made is None else made
        columns = tuple(made.setdefault(one, _base_column(one, hz, damping)) for one in forms[form])
        own = [strength[one] for one in forms[form]]
        return Candidate("base_compliance", "base", f"{form}, {hz:g} Hz, damping {damping:g}", columns,
                         named(*own, frequency_Hz=float(hz), damping_ratio=float(damping)), (0.0,) * len(own),
                         family=Family(lambda hz, damping: mode(form, hz, damping), (hz, damping), (1.05, 1.6), (1.5, 0.006),
                         (25.0, 0.5)))  # fmt: skip

    for damping in BASE_DAMPING_RATIOS:
        for hz in BASE_HZ:
            made = {}
            yield from (mode(form, hz, damping, made) for form in forms if form != "rising" or damping == RISING_DAMPING_RATIO)
