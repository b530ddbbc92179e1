"""The paper's job: 72,000 samples of q, v, a and torque in memory, ten parameters, 40 particles x 500
iterations, the mean square of (16). talus folds the regressor rows into a triangular factor and lets
its swarm search there; the peers are pyswarms on the samples, pyswarms on the same factor, and NumPy's
least squares."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy
import numpy_leg
from measure import Comparison, Outcome, alternate
from talus import Model, check, constants, ffi, lib, pointer

SAMPLES, PARTICLES, ITERATIONS = 72_000, 40, 500
RATE_HZ, NOISE_NM = 200.0, (5e-4, 1.2e-4)
WEIGHTS = {"c1": 1.49618, "c2": 1.49618, "w": 0.72984}  # constriction (2.05, 2.05), as talus has it


@dataclass
class Recording:
    """Motion and torque, (2, n) each."""

    q: numpy.ndarray
    v: numpy.ndarray
    a: numpy.ndarray
    torque: numpy.ndarray


def multisine(random, t, amplitude):
    """Angle, speed, acceleration: eight harmonics of 0.25 Hz, amplitudes falling as the root."""
    q, v, a = numpy.zeros((3, len(t)))
    for harmonic in range(1, 9):
        w, phase = 2.0 * numpy.pi * 0.25 * harmonic, random.uniform(0.0, 2.0 * numpy.pi)
        size = amplitude / numpy.sqrt(harmonic)
        q += size * numpy.sin(w * t + phase)
        v += size * w * numpy.cos(w * t + phase)
        a -= size * w**2 * numpy.sin(w * t + phase)
    return q, v, a


def recording(model, samples):
    """The bench's data: motion of both joints, torque of the model with noise."""
    random = numpy.random.default_rng(1)
    t = numpy.arange(samples) / RATE_HZ
    joints = [multisine(random, t, amplitude) for amplitude in (0.2, 0.1)]
    q, v, a = (numpy.array(x) for x in zip(*joints, strict=True))
    noise = random.normal(size=q.shape) * numpy.array(NOISE_NM)[:, None]
    return Recording(q, v, a, model.inverse(q, v, a) + noise)


class Ours:
    """The job by the library: everything that is timed is inside fold() and swarm()."""

    def __init__(self, model, data, iterations=ITERATIONS):
        self.model, self.data = model, data
        self.settings = ffi.new("tl_identify_settings *", lib.tl_identify_defaults())
        self.settings.weighting = lib.TL_WEIGHT_EQUAL
        self.settings.swarm.particles, self.settings.swarm.iterations = PARTICLES, iterations
        self.settings.swarm.tolerance = 0.0  # every one of the evaluations, as the peers do
        self.problem = ffi.new("tl_problem *")
        self.factor = ffi.new("tl_factor[]", 2)
        self.best, self.evaluations = numpy.empty(10), ffi.new("uint64_t *")
        self.fold()
        self.memory = numpy.empty(lib.tl_identify_memory(self.problem))

    def fold(self):
        """Samples -> rows -> factors -> the swarm's problem."""
        m, d, index = self.model.struct, self.data, ffi.new("int[]", constants.TL_MAX_ROW)
        for joint in range(2):
            check(lib.tl_factor_init(self.factor + joint, lib.tl_row_index(m, joint, index)))
        check(lib.tl_regressor_fold(m, d.q.shape[1], pointer(d.q), pointer(d.v), pointer(d.a), ffi.NULL,
                                    pointer(d.torque), self.factor))
        check(lib.tl_problem_init(self.problem, m, self.settings, self.factor))

    def swarm(self):
        """The swarm on the factor."""
        check(lib.tl_identify_swarm(self.problem, pointer(self.memory), len(self.memory), pointer(self.best),
                                    self.evaluations))

    def whole(self):
        """The job."""
        self.fold()
        self.swarm()

    def triangle(self):
        """The factor over all nine base parameters and the right-hand side, (10, 10)."""
        stride = constants.TL_FACTOR_STRIDE
        r = numpy.frombuffer(ffi.buffer(self.problem.factor.r)).reshape(stride, stride)
        return numpy.ascontiguousarray(numpy.triu(r[:10, :10]))

    def bounds(self):
        """Search bounds, (lower, upper)."""
        return tuple(numpy.array([side[i] for i in range(10)]) for side in (self.problem.lower, self.problem.upper))

    def cost(self, x):
        """(16) at parameters x: the library counts each joint's rows, (16) each instant."""
        b = numpy.empty(9)
        lib.tl_base_at(self.model.struct, pointer(numpy.ascontiguousarray(x)), pointer(b))
        return 2.0 * lib.tl_factor_cost(ffi.addressof(self.problem, "factor"), pointer(b)) / self.problem.factor.rows

    def least_squares(self):
        """Base parameters by linear least squares from the factor."""
        b = numpy.empty(9)
        check(lib.tl_factor_solve(ffi.addressof(self.problem, "factor"), 1e-12, pointer(b), ffi.NULL))
        return b


def pyswarms_run(cost, bounds, iterations):
    """A call that runs pyswarms' global-best swarm with its defaults for everything not named here."""
    os.environ["LOG_CFG"] = str(Path(__file__).with_name("pyswarms_logging.yaml"))
    import pyswarms  # reads it

    def run():
        swarm = pyswarms.single.GlobalBestPSO(PARTICLES, 10, WEIGHTS, bounds=bounds)
        return swarm.optimize(cost, iterations, verbose=False)

    return run


def numpy_least_squares(data):
    """Regressor and lstsq: base parameters and cost (16)."""
    rows, known = numpy_leg.regressor(data.q, data.v, data.a)
    target = data.torque.ravel() - known
    solution, residual, _, _ = numpy.linalg.lstsq(rows, target, rcond=None)
    return solution, residual[0] / data.q.shape[1]


def agreement(ours, data, particles):
    """Largest relative difference of the sides' costs at the particles, and of their least squares."""
    costs = numpy.array([ours.cost(x) for x in particles])
    others = (
        numpy_leg.swarm_cost(data.q, data.v, data.a, data.torque),
        numpy_leg.prepared_cost(data.q, data.v, data.a, data.torque),
        numpy_leg.factor_cost(ours.triangle(), data.q.shape[1]),
    )
    cost = max(numpy.abs(other(particles) / costs - 1.0).max() for other in others)
    solution = numpy.abs(ours.least_squares() / numpy_least_squares(data)[0] - 1.0).max()
    return cost, solution


def random_particles(bounds, n=PARTICLES):
    """Points spread over the search's bounds."""
    lower, upper = bounds
    return lower + (upper - lower) * numpy.random.default_rng(2).uniform(size=(n, 10))


def bench(size):
    """The four comparisons. `size`: repetitions, and what share of pyswarms' work is done."""
    model = Model.read(size.repository / "models" / "leg.yaml")
    data = recording(model, size.scaled(SAMPLES, 2_000))
    iterations = size.scaled(ITERATIONS, 20)
    ours = Ours(model, data, iterations)
    samples = data.q.shape[1]
    motion, bounds = (data.q, data.v, data.a, data.torque), ours.bounds()
    cost_gap, solution_gap = agreement(ours, data, random_particles(bounds))

    part = size.scaled(10, 2)  # of pyswarms' iterations on the samples
    slow = alternate(
        size.scaled(7, 1),
        ours=ours.whole,
        broadcast=pyswarms_run(numpy_leg.swarm_cost(*motion), bounds, part),
        prepared=pyswarms_run(numpy_leg.prepared_cost(*motion), bounds, part),
    )
    quick = alternate(
        size.scaled(25, 2),
        fold=ours.fold,
        swarm=ours.swarm,
        factor=pyswarms_run(numpy_leg.factor_cost(ours.triangle(), samples), bounds, iterations),
        lstsq=lambda: numpy_least_squares(data),
    )
    job = f"{samples:,} samples to factor, then {PARTICLES} x {iterations} evaluations"
    scaled = f"(timed over {part} of {iterations} iterations)"
    whole = [f + s for f, s in zip(quick["fold"], quick["swarm"], strict=True)]
    gap = ours.cost(ours.best) / numpy_least_squares(data)[1] - 1.0
    return Outcome(
        [
            Comparison("paper's job, pyswarms on the samples", job,
                       f"pyswarms, NumPy cost over particles and samples at once {scaled}",
                       slow["ours"], times(slow["broadcast"], iterations / part), 10_000.0),
            Comparison("paper's job, pyswarms on the samples, cost prepared by hand", job,
                       f"pyswarms, sines and ratios computed once, particle after particle {scaled}",
                       slow["ours"], times(slow["prepared"], iterations / part)),
            Comparison("swarm on the triangular factor", f"{PARTICLES} x {iterations} evaluations",
                       "pyswarms on the same factor, NumPy cost over all particles at once",
                       quick["swarm"], quick["factor"], 20.0),
            Comparison("paper's job, pyswarms given the factor", job, "pyswarms alone, the factor already there",
                       whole, quick["factor"]),
            Comparison("paper's job, least squares by NumPy", job, "NumPy regressor and numpy.linalg.lstsq",
                       whole, quick["lstsq"], 4.0),
        ],
        [f"same cost to {cost_gap:.1e}, same least squares to {solution_gap:.1e} (relative); "
         f"the swarm's cost lies {gap:.1e} above least squares after {ours.evaluations[0]:,} evaluations"],
        {"cost_difference": cost_gap, "least_squares_difference": solution_gap, "swarm_above_least_squares": gap},
    )  # fmt: skip


def times(seconds, factor):
    """Each of them scaled to the whole work."""
    return [s * factor for s in seconds]
