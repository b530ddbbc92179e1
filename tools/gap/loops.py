"""Laws that must be stepped in time: friction with memory, and a link behind a spring and a gap.

Python steps slowly, so all shapes of an effect are stepped at once, and the link also in chunks of the recording:
its free motion dies out within the overlap that each chunk begins with.
"""

import numpy as np

CHUNK_S = 3.0
OVERLAP_S = 1.5  # several time constants of the softest spring with any friction
LARGEST_TURN = 0.4  # rad of the spring's own oscillation in one step
DAMPING_RATIO = 0.1  # of the spring; metal gears, and enough for the free motion to die out
STEPS = (4, 60)  # of the link for one sample
LARGEST_STEP = 1.0  # rad: beyond it a stepped oscillation grows


def dahl(position, travel, power):
    """Dahl's friction state in [-1, 1] along a position, for arrays of travels and powers (1 or 2): (shapes, n).
    Each step is the closed form for a constant direction."""
    out = np.zeros((len(travel), len(position)))
    z, linear = np.zeros(len(travel)), power == 1
    for k, move in enumerate(np.diff(position), 1):
        side, x = (1.0 if move > 0 else -1.0), abs(move) / travel
        rest = 1 - side * z
        rest = np.where(linear, rest * np.exp(-x), rest / (1 + rest * x))
        z = side * (1 - rest)
        out[:, k] = z
    return out


class LinkShape:
    """A link behind a spring [Nm/rad] and a gap of +-half [rad]; `share` of the friction stands on the link's side."""

    def __init__(self, stiffness, half, share):
        self.stiffness, self.half, self.share = stiffness, half, share

    def key(self):
        return self.stiffness, self.half, self.share


def link_behind(shapes, step_s, motor_speed, other_Nm, inertia, coulomb_Nm, viscous):
    """Angle of the link less the motor's, and torque through the spring, of every shape: dict key -> (angle, torque).

    The motor's speed (at the joint) is given on an even grid, and the torque `other_Nm` that the link needs besides
    its inertia and friction."""
    stiffness = np.array([s.stiffness for s in shapes])
    steps = np.clip(np.ceil(step_s * np.sqrt(stiffness / inertia) / LARGEST_TURN), *STEPS).astype(int)
    out = {}
    for count in np.unique(steps):
        group = [s for s, own in zip(shapes, steps) if own == count]
        angle, torque = _step_group(group, int(count), step_s, motor_speed, other_Nm, inertia, coulomb_Nm, viscous)
        out.update({s.key(): (angle[k], torque[k]) for k, s in enumerate(group)})
    return out


def _chunks(x, length, overlap):
    """(chunks, overlap + length) windows of x, each beginning `overlap` early; x[0] before the beginning."""
    count = -(-len(x) // length)
    padded = np.concatenate([np.full(overlap, x[0]), x, np.full(count * length - len(x), x[-1])])
    return np.array([padded[k * length:k * length + overlap + length] for k in range(count)])


def _step_group(shapes, count, step_s, motor_speed, other_Nm, inertia, coulomb_Nm, viscous):
    length, overlap, n = int(CHUNK_S / step_s), int(OVERLAP_S / step_s), len(motor_speed)
    speed, other = (_chunks(x, length, overlap).T[:, None, :] for x in (motor_speed, other_Nm))
    column = lambda values: np.array(values, float)[:, None]  # noqa: E731
    stiffness, half = column([s.stiffness for s in shapes]), column([s.half for s in shapes])
    share, h = column([s.share for s in shapes]), step_s / count
    damping = 2 * DAMPING_RATIO * np.sqrt(stiffness * inertia)
    dry, slow = h * share * max(coulomb_Nm, 0) / inertia, 1 / (1 + h * share * max(viscous, 0) / inertia)
    angle = np.zeros((len(shapes), speed.shape[2]))
    link = angle + speed[0]
    angles, torques = np.empty((length, *angle.shape)), np.empty((length, *angle.shape))
    for k in range(1, overlap + length):
        total = 0.0
        for part in range(count):
            w = (part + 0.5) / count
            motor = speed[k - 1] + w * (speed[k] - speed[k - 1])
            load = other[k - 1] + w * (other[k] - other[k - 1])
            beyond = angle - np.clip(angle, -half, half)
            force = -stiffness * beyond - damping * (link - motor) * (beyond != 0)
            force = np.where(force * beyond > 0, 0.0, force)  # teeth push and do not pull
            total = total + force
            link = link + h / inertia * (force - load)
            link = (link - np.clip(link, -dry, dry)) * slow
            angle = angle + h * (link - motor)
        if k >= overlap:
            angles[k - overlap], torques[k - overlap] = angle, total / count
    unfold = lambda x: x.transpose(1, 2, 0).reshape(len(shapes), -1)[:, :n]  # noqa: E731
    return unfold(angles), unfold(torques)
