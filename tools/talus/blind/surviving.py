"""What the best linear Coulomb-viscous model cannot explain of a case, by kinematics without noise."""

import numpy as np

from .plants import LINKAGE, G
from .sensors import BANDS_HZ, below

STANDSTILL, GUARD_S = 0.008, 0.016


def linkage(angle, sizes=LINKAGE):
    """Motor angle, ratio and its slope at a joint angle by the drawing's dimensions."""
    ab, bo, ac, scale = (*(sizes[k] for k in ("AB_m", "BO_m", "AC_m")), 2 * np.pi / sizes["lead_m"])
    zero = np.pi - np.radians(sizes["BOF_deg"])

    def nut(phi):
        h = ac - bo * np.sin(phi)
        return bo * np.cos(phi) + np.sqrt(ab**2 - h**2)

    def slope(phi):
        h = ac - bo * np.sin(phi)
        return scale * (bo * np.sin(phi) - h * bo * np.cos(phi) / np.sqrt(ab**2 - h**2))

    phi, d = zero - angle, 1e-5
    return scale * (nut(phi) - nut(zero)), slope(phi), (slope(phi - d) - slope(phi + d)) / (2 * d)


def joint_angle(motor, sizes=LINKAGE, about=125.0):
    """Inverse linkage, by Newton."""
    angle = motor / about
    for _ in range(12):
        value, ratio, _ = linkage(angle, sizes)
        angle = angle - (value - motor) / ratio
    return angle


def shown_motor_motion(run, encoder):
    """Angle, velocity and acceleration of the ankle's motor as its encoder shows them, and the knee's."""
    out = []
    for joint in ("knee", "ankle"):
        v, a = run[f"{joint}_motor_v"], run[f"{joint}_motor_a"]
        order, size, phase = (encoder.get(f"{joint}.enc_{k}", 0.0) for k in ("n", "a", "p"))
        x = order * run[f"{joint}_motor_true"] + phase
        gain = 1 + size * order * np.cos(x)
        out.append((run[f"{joint}_motor"], v * gain, a * gain - size * order**2 * np.sin(x) * v**2))
    return out


def leg_columns(run, encoder, plant):
    """Columns of both joints' motor torques per base parameter (5 of inertia, 2 frictions each), and the known part."""
    (mk, vk, ak), (ma, va, aa) = shown_motor_motion(run, encoder)
    fixed, n, sizes = plant.fixed, plant.fixed["ratio"], plant.linkage
    q = joint_angle(ma, sizes, plant.scale["ankle"].ratio)
    _, ka, bend = linkage(q, sizes)
    qv = va / ka
    qa = (aa - bend * qv**2) / ka
    s, sv, sa = mk / n, vk / n, ak / n
    f, fv, fa = s + q, sv + qv, sa + qa
    c, e, length = np.cos(s - f), np.sin(s - f), fixed["ls"]
    zero, known = np.zeros_like(s), fixed["mf"] * length
    rotor = ka**2 * qa + ka * bend * qv**2
    row_s = [sa, G * np.sin(s), length * (c * fa + e * fv**2), zero, -rotor]
    row_f = [zero, zero, length * (c * sa - e * sv**2) + G * np.sin(f), fa, rotor]
    knee = [(a + b) / n for a, b in zip(row_s, row_f, strict=True)]
    ankle = [b / ka for b in row_f]
    knee += [np.sign(sv) / n, sv / n, zero, zero]
    ankle += [zero, zero, np.sign(qv) / ka, qv / ka]
    given = known * (length * sa + G * np.sin(s)) / n
    return (np.array(knee).T, np.array(ankle).T), (given, zero), (sv, qv), q


def single_columns(run, plant, behind):
    """The same of one joint alone: inertia, gravity's two, a constant, and two frictions."""
    n = plant.gear
    if behind:
        q, v, a = run["shank"], run["shank_v"], run["shank_a"]
    else:
        q, v, a = (run[f"knee_motor{what}"] / n for what in ("", "_v", "_a"))
    falls = [np.sin(q), np.cos(q)] if plant.gravity_moment_kg_m else []
    x = np.array([a, *falls, np.ones_like(q), np.sign(v), v]).T / n
    return (x,), (np.zeros_like(q),), (v,), q


def columns(run, encoder, plant, noise):
    if plant.kind == "leg":
        return leg_columns(run, encoder, plant)
    return single_columns(run, plant, noise["behind"])


def moving(t, speed):
    """Samples away from standstill."""
    still = t[np.abs(speed) < STANDSTILL]
    if len(still) == 0:
        return np.ones(len(t), bool)
    at = np.clip(np.searchsorted(still, t), 1, len(still) - 1) if len(still) > 1 else np.zeros(len(t), int)
    near = np.minimum(np.abs(t - still[at]), np.abs(t - still[np.maximum(at - 1, 0)]))
    return near > GUARD_S


def left_by_fit(pieces, training):
    """What the training recordings' best fit leaves of every piece [(columns, torque) of each joint]."""
    system = [row for name in training for row in pieces[name]]
    x, y = np.concatenate([r[0] for r in system]), np.concatenate([r[1] for r in system])
    scale = np.sqrt(np.mean(x**2, axis=0))
    base = np.linalg.lstsq(x / scale, y, rcond=1e-12)[0] / scale
    return {name: [y - x @ base for x, y in rows] for name, rows in pieces.items()}


def over_noise(rest, keep, noise, joint, rate_Hz):
    """RMS over the noise; where it is known band by band, over that of the band in which it stands out most. 0 of a joint that rests."""
    if not keep.any():
        return 0.0
    if "bands_Nm" not in noise:
        return float(np.sqrt(np.mean(rest**2)))
    bands, whole = noise["bands_Nm"][joint], np.zeros(len(keep))
    whole[keep] = rest * bands[0]
    return max(float(below(whole, rate_Hz, f)[keep].std() / size) for f, size in zip(BANDS_HZ, bands, strict=True))


def surviving(runs, currents, noise, encoder, plant, camera=None):
    """The ratios of truth.json for each recording and the detectability; `runs` by recording, without noise."""
    pieces, kept, angles = {}, {}, {}
    for name, run in runs.items():
        xs, given, speeds, q = columns(run, encoder, plant, noise)
        rows, kept[name], angles[name] = [], [], q
        for joint, x, fixed, v in zip(plant.joints, xs, given, speeds, strict=True):
            sigma = noise[f"{joint}_torque_Nm"]
            y = plant.torque_constant(joint) * currents[name][joint] - fixed
            keep = moving(run["t"], v)
            rows.append((x[keep] / sigma, y[keep] / sigma))
            kept[name].append(keep)
        pieces[name] = rows
    training = [name for name in runs if name != "test"]
    rest, out = left_by_fit(pieces, training), {}
    for name, run in runs.items():
        rate = 1 / np.median(np.diff(run["t"]))
        out[name] = {joint: over_noise(r, keep, noise, joint, rate)
                     for joint, r, keep in zip(plant.joints, rest[name], kept[name], strict=True)}  # fmt: skip
        if plant.kind == "leg":
            out[name] |= angle_ratios(run, angles[name], noise, plant, run["ankle_joint"] if camera is None else camera[name])
    total = sum(sum(float(r @ r) for r in rest[name]) for name in training)
    return out, float(np.sqrt(total))


def angle_ratios(run, q, noise, plant, joint):
    """The leg's encoders against each other and against the camera."""
    shown, knee = noise["camera_rad"], run["shank"] - run["knee_motor"] / plant.fixed["ratio"]
    return {"knee_camera": float(np.sqrt(np.mean(knee**2)) / shown) if shown else 0.0,
            "ankle_encoder": float(np.sqrt(np.mean((joint - q) ** 2)) / noise["ankle_encoder_rad"])}  # fmt: skip
