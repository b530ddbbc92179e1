"""The motion gap: the model moved forward in time by the recorded torque, against the recorded motion.

The recorded torque in open loop runs away from any recording, so the motion begins anew at the recorded state every
WINDOW_S, in all windows at once. docs/diagnosis.md has the equations and their limits.
"""

import numpy as np

from .acting import Acting
from .scene import Scene

WINDOW_S = 0.25
LONGEST_STEP_S = 0.0025
RARELY = 20  # samples between two looks at the inertia
SMALL = 1e-6  # rad and rad/s, of differences
MOST_OF_GIVEN = 4.0  # factor on the given inertia beyond which a fit's is not a plant's


class Plant:
    """A model along one recording on the grid, linear about the recorded motion but for dry friction. Each array is
    (joints, ..., n)."""

    def __init__(self, scene):
        joints = self.joints = range(scene.evidence.joints)
        self.q, self.v = (np.array([scene.grid(name, j) for j in joints]) for name in ("q", "v"))
        self.coulomb_Nm, self.viscous = (np.maximum(x, 0.0) for x in (scene.coulomb_Nm, scene.viscous))
        own = inertia_of(scene, scene.base)
        self.inertia = np.array([[scene.track.resample(own[i][j]) for j in joints] for i in joints])
        self.by_position, self.by_speed = slopes(scene)
        self.a = np.array([scene.track.resample(scene.a[j]) for j in joints])
        self.beyond_Nm = self._beyond(scene, own)

    def _beyond(self, scene, inertia):
        """What is to be added to a residual for the torque that moves each joint: the reading, unfiltered, less all
        that the plain model needs besides this joint's own acceleration and friction."""
        track, out = scene.track, []
        for j in self.joints:
            reading = scene.evidence.effort(scene.record, j)
            model = track.operate(scene.joint_Nm[j] / scene.ratio[j], j)
            besides = scene.link_Nm[j] + scene.rotor_Nm[j] - inertia[j][j] * scene.a[j]
            out.append(scene.grid("ratio", j) * (track.resample(reading) - track.operate(reading) + model)
                       - track.resample(besides))  # fmt: skip
        return np.array(out)

    @staticmethod
    def at_joint(scene, columns):
        """Motor torques (joints, n) as torques at the joints."""
        return np.array([scene.grid("ratio", j) * column for j, column in enumerate(columns)])


def inertia_of(scene, base):
    """Inertia at the joints with the rotors at some base parameters, (joints, joints, n) at the samples."""
    if not scene.evidence.leg:
        names = list(scene.evidence.model.base)
        return np.full((1, 1, len(scene.t_s)), base[names.index("mass" if "mass" in names else "inertia")])
    out = scene._leg_inertia(base)[0]
    out[1, 1] = out[1, 1] + base[4] * scene.ratio[1] ** 2
    return out


def is_plausible(scene):
    """Is the fit's inertia one that a plant can have, and within a factor of the given one?"""
    mine, given = (np.moveaxis(inertia_of(scene, x)[:, :, ::RARELY], -1, 0) for x in (scene.base, scene.evidence.prior))
    try:
        roots = np.linalg.inv(np.linalg.cholesky(given))
    except np.linalg.LinAlgError:
        return True  # nothing to compare with
    share = np.linalg.eigvalsh(roots @ mine @ np.swapaxes(roots, 1, 2))
    return bool(share.min() > 1 / MOST_OF_GIVEN and share.max() < MOST_OF_GIVEN)


def plant_of(search, record, base):
    """The plant of a fit; that of the given model where the fit's inertia is none that a plant can have."""
    scene = Scene(search.evidence, record, base)
    return Plant(scene if is_plausible(scene) else Scene(search.evidence, record, search.evidence.prior))


def slopes(scene):
    """Derivatives of the links' torques by position and by speed, (joints, joints, n) each, friction apart."""
    joints, resample = range(scene.evidence.joints), scene.track.resample
    if not scene.evidence.leg:
        names, raw = list(scene.evidence.model.base), scene.track.raw[0]
        slope = np.zeros(len(raw))
        if "gravity_sin" in names:
            sine, cosine = names.index("gravity_sin"), names.index("gravity_cos")
            slope = scene.base[sine] * raw[:, cosine] - scene.base[cosine] * raw[:, sine]
        return resample(slope)[None, None], np.zeros((1, 1, len(scene.track.grid_t_s)))

    def slope(of):
        columns = []
        for j in joints:
            at = {"q": scene.q, "v": scene.v}
            at[of] = at[of] + SMALL * np.eye(len(joints))[:, j:j + 1]
            columns.append((scene.links(at["q"], at["v"], scene.a) - scene.link_Nm) / SMALL)
        return np.array([[resample(columns[j][i]) for j in joints] for i in joints])

    return slope("q"), slope("v")


class Windows:
    """Stretches of the grid that do not overlap, in the rows that are kept at every joint."""

    def __init__(self, track):
        self.steps = max(2, round(WINDOW_S / track.step_s))
        self.step_s, begin, starts = track.step_s, 0, []
        kept = np.all([kind != 0 for kind in track.kind], axis=0)
        for part in track.parts:
            first = begin
            while first + self.steps < begin + part["n"]:
                if kept[first:first + self.steps + 1].all():
                    starts.append(first)
                    first += self.steps
                else:
                    first += 1
            begin += part["n"]
        self.starts = np.array(starts, int)


def accelerations(f, v, inertia, coulomb_Nm):
    """Of every joint under torque `f` beside dry friction; a joint at rest stays so while friction can hold it."""
    way = np.where(v != 0, np.sign(v), np.sign(f))
    rests = (v == 0) & (np.abs(f) <= coulomb_Nm)
    push = np.where(rests, 0.0, f - coulomb_Nm * way)
    if len(f) == 1:
        return push / inertia[0, 0]
    m00, m11 = inertia[0, 0], inertia[1, 1]
    cross = np.where(rests.any(0), 0.0, inertia[0, 1])
    out = np.array([m11 * push[0] - cross * push[1], m00 * push[1] - cross * push[0]]) / (m00 * m11 - cross**2)
    return np.where(rests, 0.0, out)


def step(f, v, inertia, coulomb_Nm, h):
    """(speed after h, distance): a joint that comes to rest within the step goes on from rest."""
    a = accelerations(f, v, inertia, coulomb_Nm)
    after = v + h * a
    stops = v * after < 0
    if not stops.any():
        return after, 0.5 * h * (v + after)
    spent = np.where(stops, v / np.where(stops, -a, 1.0), 0.0)
    again = accelerations(f, np.where(stops, 0.0, v), inertia, coulomb_Nm) * (h - spent)
    moved = np.where(stops, 0.5 * spent * v + 0.5 * (h - spent) * again, 0.5 * h * (v + after))
    return np.where(stops, again, after), moved


def deviations(plant, windows, torque_Nm):
    """Simulated less recorded position at every instant of all windows: (joints, steps, windows). `torque_Nm` is what
    acts on each joint beyond gravity, the other joint and all effects but dry friction."""
    every = max(1, int(np.ceil(windows.step_s / LONGEST_STEP_S)))
    h, starts = windows.step_s / every, windows.starts
    viscous = plant.viscous[:, None]
    crossing = 1.0 - np.eye(len(torque_Nm))[:, :, None]
    v, e, out = plant.v[:, starts], np.zeros((len(torque_Nm), len(starts))), []
    states = [memory.recorded[starts] for memory in plant.memories]
    for k in range(windows.steps):
        inertia, coulomb_Nm = plant.inertia[:, :, starts + k], plant.level_Nm[:, starts + k]
        for part in range(every):
            share = (part + 0.5) / every
            between = lambda x: (1 - share) * x[..., starts + k] + share * x[..., starts + k + 1]
            ahead = v - between(plant.v)
            f = between(torque_Nm) + np.einsum("ijw,jw->iw", crossing * inertia, between(plant.a)) - viscous * v
            f -= np.einsum("ijw,jw->iw", plant.by_position[..., starts + k], e)
            f -= np.einsum("ijw,jw->iw", plant.by_speed[..., starts + k], ahead)
            for memory, state in zip(plant.memories, states):
                ahead = memory.moved(state, 0.5 * h * v[memory.joint]) - between(memory.recorded)
                f[memory.joint] -= memory.size_Nm * ahead
            v, moved = step(f, v, inertia, coulomb_Nm, h)
            states = [memory.moved(state, moved[memory.joint]) for memory, state in zip(plant.memories, states)]
            e = e + moved
        e = e - (plant.q[:, starts + k + 1] - plant.q[:, starts + k])
        out.append(e)
    return np.moveaxis(np.array(out), 1, 0)


def deviations_of(search, record, chosen, residuals):
    """Deviations of one recording, or None where it has no window."""
    evidence, windows = search.evidence, Windows(search.evidence.tracks[record])
    if not len(windows.starts):
        return None
    plant = plant_of(search, record, residuals.strengths[:evidence.bases])
    left = plant.at_joint(search.scenes[record], [residuals.of[record, f"T{j}"] for j in plant.joints])
    acting = Acting(search, record, chosen, residuals)
    plant.level_Nm = np.maximum(plant.coulomb_Nm[:, None] + acting.level_Nm, 0.0)
    plant.memories = acting.memories
    plant.by_position = plant.by_position + acting.slope_Nm_rad
    return deviations(plant, windows, left + plant.beyond_Nm + acting.sliding_Nm)


def rms(search, chosen, residuals):
    """RMS of each joint's deviation over all recordings."""
    found = [deviations_of(search, record, chosen, residuals) for record in range(len(search.evidence.tracks))]
    found = [x.reshape(len(x), -1) for x in found if x is not None]
    if not found:
        return np.full(search.evidence.joints, np.nan)
    return np.sqrt(np.mean(np.concatenate(found, axis=1) ** 2, axis=1))


def motion(search, fit, before, after):
    """`motion` of the report; empty where a sensor at the output was recorded: there the motion is not the drive's."""
    if search.evidence.load_sensor:
        return {}
    identified = rms(search, [], before)
    extended = rms(search, fit.chosen, after) if fit.chosen else identified
    unit = "m" if search.evidence.model.plant == "slider" else "rad"
    return {name: {"unit": unit, "identified_rms": float(x), "extended_rms": float(y)}
            for name, x, y in zip(search.evidence.model.joints, identified, extended) if np.isfinite(x + y)}  # fmt: skip
