"""What each slip of the paper's print costs, alone and together.

The library has the print as a whole (`form: paper`). Here each slip is a change of some regressor columns:

    rotor      velocity terms of the ankle's rotor: -3 for +1 times Ima ka ka' theta_a'^2
    sign       the ankle's friction enters the knee's equation with the wrong sign: twice its value
    speed      the ankle's friction follows the foot's absolute speed, not the joint's

so any set of them can be fitted, in the leg's base parameters with friction and inertia not negative.
"""

import numpy
from scipy.optimize import least_squares

from talus import Recording, Regression, ffi, lib

from .bench import JOINTS
from .scoring import on_grid

SLIPS = ("rotor", "sign", "speed")


class Rows:
    """Scored regression rows of recordings under one set of slips: for each joint (X, y)."""

    def __init__(self, model, recordings, slips=()):
        self.base = list(model.base)
        parts = [_rows_of(model, columns, set(slips)) for columns in recordings]
        self.joint = [tuple(numpy.concatenate([p[j][k] for p in parts]) for k in (0, 1)) for j in range(len(JOINTS))]

    def rms(self, values):
        """RMS residual of each joint [Nm] with these base parameters."""
        return {name: float(numpy.sqrt(numpy.mean((y - x @ values) ** 2)))
                for name, (x, y) in zip(JOINTS, self.joint)}  # fmt: skip

    def noise(self):
        """RMS residual of each joint's own least squares: the weights of the default fit."""
        out = []
        for x, y in self.joint:
            used = x[:, x.any(axis=0)]
            out.append(numpy.sqrt(numpy.mean((y - used @ numpy.linalg.lstsq(used, y, rcond=None)[0]) ** 2)))
        return out

    def triangle(self):
        """R and z of the weighted rows: cost |R base - z|^2 but for a constant."""
        rows = [numpy.column_stack((x, y)) / noise for (x, y), noise in zip(self.joint, self.noise())]
        r = numpy.linalg.qr(numpy.vstack(rows), mode="r")
        return r[:-1, :-1], r[:-1, -1]


def _rows_of(model, columns, slips):
    recording = Recording(columns)
    regression = Regression(model, recording)
    motion, out = regression.motion(), []
    lowpass = ffi.addressof(regression.struct, "lowpass")
    changes = _changes(model, motion, slips)
    for joint, parts in enumerate(regression.rows()):
        (part,) = parts  # these recordings have no gaps
        x = numpy.zeros((len(part.t), len(model.base)))
        x[:, part.index] = part.x
        for column, values in changes[joint].items():
            x[:, column] += on_grid(recording.t, values, part.t, recording.step_s, lowpass)
        scored = part.kind == lib.TL_ROW_SCORED
        out.append((x[scored], part.target[scored]))
    return out


def _changes(model, motion, slips):
    """What the slips add to each joint's regressor at the recording's samples: {base index: values}."""
    base = list(model.base)
    coulomb, viscous, rotor = (base.index(n) for n in ("ankle_coulomb", "ankle_viscous", "ankle_rotor_inertia"))
    q, v = motion["q"], motion["v"]
    ratio, slope = _ratios(model, 1, q[1])
    direction, speed = motion["slip"][1], v[1]
    knee, ankle = {}, {}
    if "rotor" in slips:
        ankle[rotor] = -4.0 * slope * v[1] ** 2
    if "speed" in slips:
        ankle[coulomb] = (numpy.sign(v[0] + v[1]) - direction) / ratio
        ankle[viscous] = v[0] / ratio
        direction, speed = numpy.sign(v[0] + v[1]), v[0] + v[1]
    if "sign" in slips:
        gear = _ratios(model, 0, q[0])[0]
        knee[coulomb], knee[viscous] = 2.0 * direction / gear, 2.0 * speed / gear
    return knee, ankle


def _ratios(model, joint, angles):
    drive, one, slope = ffi.addressof(model.struct.drive[joint], "transmission"), ffi.new("double *"), ffi.new("double *")
    out = numpy.empty((2, len(angles)))
    for i, angle in enumerate(angles):
        lib.tl_transmission_ratio(drive, angle, one, slope)
        out[:, i] = one[0], slope[0]
    return out


def fit(model, rows):
    """Base parameters by weighted least squares; centre of mass, inertias and frictions not negative."""
    r, z = rows.triangle()
    names, start = rows.base, numpy.array(list(model.base.values()))
    moment, inertia = names.index("foot_moment"), names.index("foot_inertia")
    mass = model.struct.foot_mass_kg

    def base(p):  # the foot's inertia about its own centre is what may not be negative
        values = p * start
        values[inertia] += values[moment] ** 2 / mass
        return values

    first = numpy.ones(len(start))
    found = least_squares(lambda p: r @ base(p) - z, first, bounds=(0.0, numpy.inf), x_scale="jac",
                          xtol=1e-12, ftol=1e-12, gtol=1e-12)  # fmt: skip
    return base(found.x)
