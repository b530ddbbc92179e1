"""From base parameters, which are linear in the torque, to physical ones."""

import numpy as np

from talus import ffi, lib, pointer

MOST_NEWTON_STEPS = 20
TURNS_rad = (0.0, 0.5 * np.pi, -0.5 * np.pi, np.pi)  # of angles: Newton's steps seldom reach gravity at a right angle to the file's
CONVERGED = 1e-9
PRIOR_CHI2 = 0.01  # of a parameter as far from its prior as that is large: decides only what the data leave open
SEEN = 1e-9  # of the largest slope: a parameter that moves less is not seen
LEAST_SHARE = 1e-3  # of its prior, that a positive parameter keeps


class Parameters:
    """A model's physical parameters as u: relative to their priors, 0 at them."""

    def __init__(self, model):
        self.names, self.start = list(model.parameters), np.array(list(model.parameters.values()))
        self.scale, self._trial = np.maximum(np.abs(self.start), 1e-6), model.copy()
        self.table = lib.tl_parameters(self._trial.struct, ffi.new("int *"))

    def values(self, u):
        return dict(zip(self.names, (self.start + self.scale * u).tolist()))

    def base(self, u):
        self._trial.set_parameters(**self.values(u))
        return np.array(list(self._trial.base.values()))

    def slope(self, u):
        self._trial.set_parameters(**self.values(u))
        jacobian = np.empty((len(self._trial.base), len(u)))
        lib.tl_base_jacobian(self._trial.struct, pointer(jacobian))
        return jacobian * self.scale

    def lower(self):
        """The physical bounds of u."""
        out = np.array([(self.table[k].lower - self.start[k]) / self.scale[k] for k in range(len(self.names))])
        return out + LEAST_SHARE * np.array([self.table[k].positive for k in range(len(self.names))])

    def turned(self, angle_rad):
        """u of the priors with every angle turned."""
        return angle_rad / self.scale * np.array([self.table[k].angle for k in range(len(self.names))])


def physical(model, base):
    """Parameters of base parameters, physical or not: the nearest to the model's own, relative to each, or what is found with its angles
    quarter turns away; None if none is near."""
    parameters = Parameters(model)
    for turn_rad in TURNS_rad if parameters.turned(1.0).any() else TURNS_rad[:1]:
        u = _nearest(parameters, base, parameters.turned(turn_rad))
        if np.all(np.isfinite(u)) and np.allclose(parameters.base(u), base, rtol=1e-6, atol=1e-9):
            return parameters.values(u)
    return None


def _nearest(parameters, base, u):
    """Where Newton's steps end from u, of the smallest u where the base parameters leave some open."""
    size = np.maximum(np.abs(base), 1e-9)
    for _ in range(MOST_NEWTON_STEPS):
        before, now, slope = u, parameters.base(u), parameters.slope(u)
        # the smallest u that meets the linearised equations, not the smallest step
        u = np.linalg.lstsq(slope / size[:, None], (base - now + slope @ u) / size, rcond=1e-12)[0]
        if np.max(np.abs(u - before)) < CONVERGED:
            break
    return u


def constrained(model, root, best, low, high):
    """(physical parameters, the other unknowns, chi-square lost) of a linear fit whose first unknowns are base parameters.

    `root` is an upper triangle R with chi-square = |R (x - best)|^2 above its least; `low` and `high` are the limits of
    the other unknowns. Physical parameters keep their bounds, and what the fit leaves open stays near its prior."""
    from scipy.optimize import least_squares  # slow to load, and few runs need it

    parameters, bases = Parameters(model), len(model.base)
    count, size = len(parameters.start), 1.0 / np.maximum(np.sqrt((root[:, bases:] ** 2).sum(0)), 1e-12)
    moves = np.linalg.norm(root[:, :bases] @ parameters.slope(np.zeros(count)), axis=0)
    seen = moves > SEEN * moves.max()
    weight = np.sqrt(PRIOR_CHI2) * (~seen | (parameters.start != 0))  # a zero does not say how far from it is far

    def unknowns(x):
        return np.concatenate([parameters.base(x[:count]), best[bases:] + size * x[count:]])

    def residual(x):
        return np.concatenate([root @ (unknowns(x) - best), weight * x[:count]])

    def slope(x):
        top = np.hstack([root[:, :bases] @ parameters.slope(x[:count]), root[:, bases:] * size])
        return np.vstack([top, np.hstack([np.diag(weight), np.zeros((count, len(size)))])])

    lower = np.concatenate([parameters.lower(), (low - best[bases:]) / size])
    upper = np.concatenate([np.full(count, np.inf), (high - best[bases:]) / size])
    start = np.clip(np.zeros(len(lower)), lower + 1e-9, upper - 1e-9)
    found = least_squares(residual, start, slope, bounds=(lower, np.maximum(upper, lower + 1e-12)), x_scale="jac",
                          xtol=1e-14, ftol=1e-14, gtol=1e-12, max_nfev=200)  # fmt: skip
    lost = float(np.sum((root @ (unknowns(found.x) - best)) ** 2))
    values = parameters.values(np.where(seen, found.x[:count], 0.0))
    return values, unknowns(found.x)[bases:], lost
