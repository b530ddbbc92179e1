"""The leg's inverse dynamics in NumPy, as a careful user of NumPy would write them.

Written from docs/equations.md, not from the library: it is the other side of the
comparison, and the tests hold the two against each other. Angles, speeds and
accelerations are (2, n) arrays (knee, ankle); torques are those of the motors.
"""

from types import SimpleNamespace

import numpy

# the leg of models/leg.yaml; what is identified stands in PRIOR, in the order of the library's table
GRAVITY = 9.81
SHANK_LENGTH, SHANK_MASS, FOOT_MASS, MOTOR_MASS = 0.3615, 1.624, 0.442, 0.4112
KNEE_RATIO = 51.0
LEAD, AB, BO, AC, BOF = 0.002, 0.090, 0.040, 0.035, numpy.deg2rad(84.75)
PRIOR = {
    "ankle_motor_com_m": 0.120,
    "foot_com_m": 0.055,
    "shank_com_m": 0.160,
    "shank_inertia_kg_m2": 0.0420,
    "ankle_rotor_inertia_kg_m2": 2.4e-6,
    "foot_inertia_kg_m2": 0.0021,
    "knee_coulomb_Nm": 1.2,
    "knee_viscous_Nms_rad": 0.45,
    "ankle_coulomb_Nm": 0.8,
    "ankle_viscous_Nms_rad": 0.30,
}


def linkage(ankle):
    """Ratio d motor / d joint of the screw linkage, and its derivative."""
    phi = numpy.pi - BOF - ankle
    x, y = BO * numpy.cos(phi), BO * numpy.sin(phi)
    offset = AC - y
    root = numpy.sqrt(AB**2 - offset**2)
    turn = offset * x / root
    screw = 2.0 * numpy.pi / LEAD
    return screw * (y - turn), -screw * (x + (x**2 + offset * y + turn**2) / root)


def pose(q, v):
    """Everything that no parameter moves: sines, ratio, directions of friction."""
    ratio, slope = linkage(q[1])
    return SimpleNamespace(
        ratio=ratio,
        slope=slope,
        sin_shank=numpy.sin(q[0]),
        sin_foot=numpy.sin(q[0] + q[1]),
        sin_ankle=numpy.sin(q[1]),
        cos_ankle=numpy.cos(q[1]),
        knee_slip=numpy.sign(v[0]),
        ankle_slip=numpy.sign(v[1]),
    )


def torques(parameters, q, v, a, p):
    """Motor torques (12) of knee and ankle, two arrays. `parameters` are ten numbers, or ten arrays that
    broadcast against the samples; p is pose(q, v)."""
    dma, df, ds, i1, rotor, i_foot, knee_c, knee_v, ankle_c, ankle_v = parameters
    shank = i1 + SHANK_MASS * ds**2 + MOTOR_MASS * dma**2 + FOOT_MASS * SHANK_LENGTH**2
    moment = SHANK_MASS * ds + MOTOR_MASS * dma + FOOT_MASS * SHANK_LENGTH
    foot, coupling = i_foot + FOOT_MASS * df**2, FOOT_MASS * SHANK_LENGTH * df
    foot_weight = FOOT_MASS * df * GRAVITY * p.sin_foot
    knee = (
        (shank + foot + 2.0 * coupling * p.cos_ankle) * a[0]
        + (foot + coupling * p.cos_ankle) * a[1]
        - coupling * p.sin_ankle * (2.0 * v[0] + v[1]) * v[1]
        + moment * GRAVITY * p.sin_shank
        + foot_weight
        + knee_c * p.knee_slip
        + knee_v * v[0]
    )
    ankle = (
        (foot + coupling * p.cos_ankle) * a[0]
        + (foot + rotor * p.ratio**2) * a[1]
        + coupling * p.sin_ankle * v[0] ** 2
        + rotor * p.ratio * p.slope * v[1] ** 2
        + foot_weight
        + ankle_c * p.ankle_slip
        + ankle_v * v[1]
    )
    return knee / KNEE_RATIO, ankle / p.ratio


def swarm_cost(q, v, a, torque):
    """(16) of all particles (particles, 10) at once, over the samples: the shape that pyswarms asks for."""

    def cost(particles):
        knee, ankle = torques(particles.T[:, :, None], q, v, a, pose(q, v))
        return ((knee - torque[0]) ** 2 + (ankle - torque[1]) ** 2).mean(axis=1)

    return cost


def prepared_cost(q, v, a, torque):
    """The same by hand: sines and ratios computed once, particles one after the other so that what a
    particle needs stays in the cache. The fastest that was found without leaving the samples."""
    p = pose(q, v)

    def one(x):
        knee, ankle = torques(x, q, v, a, p)
        knee -= torque[0]
        ankle -= torque[1]
        return (knee @ knee + ankle @ ankle) / len(knee)

    return lambda particles: numpy.array([one(x) for x in particles])


def base(parameters):
    """The nine base parameters, in the order of the library's table."""
    dma, df, ds, i1, rotor, i_foot, knee_c, knee_v, ankle_c, ankle_v = parameters
    return numpy.stack([
        i1 + SHANK_MASS * ds**2 + MOTOR_MASS * dma**2,
        SHANK_MASS * ds + MOTOR_MASS * dma,
        FOOT_MASS * df,
        i_foot + FOOT_MASS * df**2,
        rotor, knee_c, knee_v, ankle_c, ankle_v,
    ])  # fmt: skip


def factor_cost(triangle, rows):
    """(16) from the triangular factor (10 x 10, the last column the right-hand side) of `rows` samples."""

    def cost(particles):
        solution = numpy.vstack([base(particles.T), numpy.full(len(particles), -1.0)])
        residual = triangle @ solution
        return numpy.einsum("ij,ij->j", residual, residual) / rows

    return cost


def regressor(q, v, a):
    """(2n, 9) regressor, knee's rows before the ankle's, and what is known of the torque (2n)."""
    p, n = pose(q, v), q.shape[1]
    rows, known = numpy.zeros((2 * n, 9)), numpy.zeros(2 * n)
    knee, ankle = rows[:n], rows[n:]
    knee[:, 0] = a[0]
    knee[:, 1] = GRAVITY * p.sin_shank
    knee[:, 2] = (
        SHANK_LENGTH * (p.cos_ankle * (2.0 * a[0] + a[1]) - p.sin_ankle * (2.0 * v[0] + v[1]) * v[1])
        + GRAVITY * p.sin_foot
    )
    knee[:, 3] = a[0] + a[1]
    knee[:, 5] = p.knee_slip
    knee[:, 6] = v[0]
    known[:n] = FOOT_MASS * SHANK_LENGTH * (SHANK_LENGTH * a[0] + GRAVITY * p.sin_shank)
    ankle[:, 2] = SHANK_LENGTH * (p.cos_ankle * a[0] + p.sin_ankle * v[0] ** 2) + GRAVITY * p.sin_foot
    ankle[:, 3] = a[0] + a[1]
    ankle[:, 4] = p.ratio**2 * a[1] + p.ratio * p.slope * v[1] ** 2
    ankle[:, 7] = p.ankle_slip
    ankle[:, 8] = v[1]
    knee /= KNEE_RATIO
    known[:n] /= KNEE_RATIO
    ankle /= p.ratio[:, None]
    return rows, known
