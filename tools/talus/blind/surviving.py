"""What the best linear Coulomb-viscous model cannot explain of a case, by kinematics without noise."""

import numpy as np

from .bench import FIXED, LINKAGE, RECORDINGS

STANDSTILL, GUARD_S = 0.008, 0.016
G = FIXED["gravity"]


def linkage(angle):
    """Motor angle, ratio and its slope at a joint angle by the drawing's dimensions."""
    ab, bo, ac, scale = (*(LINKAGE[k] for k in ("AB_m", "BO_m", "AC_m")), 2 * np.pi / LINKAGE["lead_m"])
    zero = np.pi - np.radians(LINKAGE["BOF_deg"])

    def nut(phi):
        h = ac - bo * np.sin(phi)
        return bo * np.cos(phi) + np.sqrt(ab**2 - h**2)

    def slope(phi):
        h = ac - bo * np.sin(phi)
        return scale * (bo * np.sin(phi) - h * bo * np.cos(phi) / np.sqrt(ab**2 - h**2))

    phi, d = zero - angle, 1e-5
    return scale * (nut(phi) - nut(zero)), slope(phi), (slope(phi - d) - slope(phi + d)) / (2 * d)


def joint_angle(motor):
    """Inverse linkage, by Newton."""
    angle = motor / 125.0
    for _ in range(12):
        value, ratio, _ = linkage(angle)
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


def columns(run, encoder):
    """Columns of both joints' motor torques per base parameter (5 of inertia, 2 frictions each), and the known part."""
    (mk, vk, ak), (ma, va, aa) = shown_motor_motion(run, encoder)
    n, q = FIXED["ratio"], joint_angle(ma)
    _, ka, bend = linkage(q)
    qv = va / ka
    qa = (aa - bend * qv**2) / ka
    s, sv, sa = mk / n, vk / n, ak / n
    f, fv, fa = s + q, sv + qv, sa + qa
    c, e, length = np.cos(s - f), np.sin(s - f), FIXED["ls"]
    zero, known = np.zeros_like(s), FIXED["mf"] * length
    rotor = ka**2 * qa + ka * bend * qv**2
    row_s = [sa, G * np.sin(s), length * (c * fa + e * fv**2), zero, -rotor]
    row_f = [zero, zero, length * (c * sa - e * sv**2) + G * np.sin(f), fa, rotor]
    knee = [(a + b) / n for a, b in zip(row_s, row_f, strict=True)]
    ankle = [b / ka for b in row_f]
    knee += [np.sign(sv) / n, sv / n, zero, zero]
    ankle += [zero, zero, np.sign(qv) / ka, qv / ka]
    fixed = known * (length * sa + G * np.sin(s)) / n
    return (np.array(knee).T, np.array(ankle).T), (fixed, zero), (sv, qv), q


def moving(t, speed):
    """Samples away from standstill."""
    still = t[np.abs(speed) < STANDSTILL]
    if len(still) == 0:
        return np.ones(len(t), bool)
    at = np.clip(np.searchsorted(still, t), 1, len(still) - 1) if len(still) > 1 else np.zeros(len(t), int)
    near = np.minimum(np.abs(t - still[at]), np.abs(t - still[np.maximum(at - 1, 0)]))
    return near > GUARD_S


def surviving(runs, currents, noise, encoder, camera=None):
    """The ratios of truth.json for each recording and the detectability; `runs` by recording, without noise."""
    system, pieces = [], {}
    for name in RECORDINGS:
        run = runs[name]
        (xk, xa), (fk, _), (vk, va), q = columns(run, encoder)
        rows = []
        for joint, x, fixed, v in (("knee", xk, fk, vk), ("ankle", xa, 0.0, va)):
            sigma = noise[f"{joint}_torque_Nm"]
            y = FIXED["K"] * currents[name][joint] - fixed
            keep = moving(run["t"], v)
            rows.append((x[keep] / sigma, y[keep] / sigma))
        pieces[name] = rows, q
        if name != "test":
            system += rows
    x, y = np.concatenate([r[0] for r in system]), np.concatenate([r[1] for r in system])
    scale = np.sqrt(np.mean(x**2, axis=0))
    base = np.linalg.lstsq(x / scale, y, rcond=1e-12)[0] / scale
    out, total = {}, 0.0
    for name, (rows, q) in pieces.items():
        rest = [y - x @ base for x, y in rows]
        out[name] = {joint: float(np.sqrt(np.mean(r**2))) for joint, r in zip(("knee", "ankle"), rest, strict=True)}
        if name != "test":
            total += sum(float(r @ r) for r in rest)
        run, shown = runs[name], noise["camera_rad"]
        knee = run["shank"] - run["knee_motor"] / FIXED["ratio"]
        out[name]["knee_camera"] = float(np.sqrt(np.mean(knee**2)) / shown) if shown else 0.0
        joint = run["ankle_joint"] if camera is None else camera[name]
        out[name]["ankle_encoder"] = float(np.sqrt(np.mean((joint - q) ** 2)) / noise["ankle_encoder_rad"])
    return out, float(np.sqrt(total))
