"""What each slip of the paper's print costs, alone and together.

The library has the print as a whole (`form: paper`). Here each slip is a change of some regressor columns:

    rotor      velocity terms of the ankle's rotor: -3 for +1 times Ima ka ka' theta_a'^2
    sign       the ankle's friction enters the knee's equation with the wrong sign: twice its value
    speed      the ankle's friction follows the foot's absolute speed, not the joint's

so any set of them can be fitted, in the leg's base parameters with friction and inertia not negative.
"""

import numpy
from scipy.optimize import least_squares

from talus import Recording, Regression, ffi, lib, pointer

from .bench import JOINTS
from .scoring import on_grid

SLIPS = ("rotor", "sign", "speed")


class Prepared:
    """One recording's regression under the model without slips, and the motion that the slips need."""

    def __init__(self, model, columns):
        self.recording = Recording(columns)
        regression = Regression(model, self.recording)
        self.base, self.motion = list(model.base), regression.motion()
        self.parts = [part for (part,) in regression.rows()]  # these recordings have no gaps
        self.knee_ratio = _ratios(model, 0, self.motion["q"][0])[0]
        self.ankle_ratio, self.ankle_slope = _ratios(model, 1, self.motion["q"][1])
        self.regression = regression
        space, _alive = regression._segment(0, len(self.recording.t), with_rows=False)
        self.stops = [ffi.new("tl_stop[]", ffi.unpack(space.track.stop[j], space.track.stops[j])) for j in range(len(JOINTS))]

    def _bridged(self, values, joint):
        """As the library's own rows pass through the joint's stops."""
        out, stops = numpy.array(values), self.stops[joint]
        lib.tl_bridge_stops(stops, len(stops), pointer(self.recording.t), len(out), pointer(out))
        return out

    def rows(self, slips):
        """Scored rows with these slips: for each joint (X, y)."""
        out, lowpass = [], ffi.addressof(self.regression.struct, "lowpass")
        for joint, (part, changes) in enumerate(zip(self.parts, self._changes(slips))):
            x = numpy.zeros((len(part.t), len(self.base)))
            x[:, part.index] = part.x
            for column, values in changes.items():
                bridged = self._bridged(values, joint)
                x[:, column] += on_grid(self.recording.t, bridged, part.t, self.recording.step_s, lowpass)
            scored = part.kind == lib.TL_ROW_SCORED
            out.append((x[scored], part.target[scored]))
        return out

    def _changes(self, slips):
        """What the slips add to each joint's regressor at the recording's samples: {base index: values}."""
        coulomb, viscous, rotor = (
            self.base.index(f"ankle_{n}") for n in ("coulomb", "viscous", "rotor_inertia")
        )
        v = self.motion["v"]
        direction, speed = self.motion["slip"][1], v[1]
        knee, ankle = {}, {}
        if "rotor" in slips:
            ankle[rotor] = -4.0 * self.ankle_slope * v[1] ** 2
        if "speed" in slips:
            foot = numpy.sign(v[0] + v[1])
            ankle[coulomb], ankle[viscous] = (foot - direction) / self.ankle_ratio, v[0] / self.ankle_ratio
            direction, speed = foot, v[0] + v[1]
        if "sign" in slips:
            knee[coulomb], knee[viscous] = 2.0 * direction / self.knee_ratio, 2.0 * speed / self.knee_ratio
        return knee, ankle


class Rows:
    """Scored rows of several recordings under one set of slips."""

    def __init__(self, prepared, slips=()):
        parts = [p.rows(slips) for p in prepared]
        self.base = prepared[0].base
        self.joint = [
            tuple(numpy.concatenate([p[j][k] for p in parts]) for k in (0, 1)) for j in range(len(JOINTS))
        ]

    def rms(self, values):
        """RMS residual of each joint [Nm] with these base parameters."""
        return {name: float(numpy.sqrt(numpy.mean((y - x @ values) ** 2)))
                for name, (x, y) in zip(JOINTS, self.joint)}  # fmt: skip

    def noise(self):
        """RMS residual of each joint's own least squares; its inverse weighs the joint in the default fit."""
        out = []
        for x, y in self.joint:
            used = x[:, x.any(axis=0)]
            out.append(numpy.sqrt(numpy.mean((y - used @ numpy.linalg.lstsq(used, y, rcond=None)[0]) ** 2)))
        return out

    def triangle(self, equal_weights=False):
        """R and z of the weighted rows: their squared residual is |R base - z|^2 and a constant."""
        noise = [1.0] * len(JOINTS) if equal_weights else self.noise()
        rows = [numpy.column_stack((x, y)) / size for (x, y), size in zip(self.joint, noise)]
        r = numpy.linalg.qr(numpy.vstack(rows), mode="r")
        return r[:-1, :-1], r[:-1, -1]


def _ratios(model, joint, angles):
    drive, one, slope = (
        ffi.addressof(model.struct.drive[joint], "transmission"),
        ffi.new("double *"),
        ffi.new("double *"),
    )
    out = numpy.empty((2, len(angles)))
    for i, angle in enumerate(angles):
        lib.tl_transmission_ratio(drive, angle, one, slope)
        out[:, i] = one[0], slope[0]
    return out


def fit(model, rows, equal_weights=False):
    """Base parameters by weighted least squares; centre of mass, inertias and frictions not negative."""
    r, z = rows.triangle(equal_weights)
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
