"""Position, velocity and acceleration on even sampling: tl_reconstruct against three savgol_filter calls."""

import numpy
from measure import Comparison, Outcome, alternate
from scipy.signal import savgol_filter
from talus import check, ffi, lib, pointer

SAMPLES, LENGTH, ORDER, STEP_S = 72_000, 51, 6, 0.005


class Ours:
    """One call for all three; the outputs stand in `out` (3, n)."""

    def __init__(self, t, x):
        self.t, self.x, self.out = t, x, numpy.empty((3, len(x)))
        self.window = ffi.new("tl_window *", {"order": ORDER, "length_s": (LENGTH - 1) * STEP_S})
        self.work = numpy.empty(lib.tl_reconstruct_workspace(LENGTH + 2))

    def reconstruct(self):
        """Value, first and second derivative at every sample."""
        check(lib.tl_reconstruct(self.window, pointer(self.t), pointer(self.x), len(self.x), pointer(self.out[0]),
                                 pointer(self.out[1]), pointer(self.out[2]), pointer(self.work), len(self.work)))


def savgol(x):
    """The same by SciPy."""
    return [savgol_filter(x, LENGTH, ORDER, deriv=d, delta=STEP_S) for d in range(3)]


def signal(samples):
    """An angle: eight harmonics of 0.25 Hz and the noise of an encoder."""
    random, t = numpy.random.default_rng(1), STEP_S * numpy.arange(samples)
    x = sum(numpy.sin(2.0 * numpy.pi * 0.25 * k * t + random.uniform(0.0, 6.0)) / k for k in range(1, 9))
    return t, 0.3 * x + 1e-4 * random.normal(size=samples)


def difference(out, expected):
    """Largest difference of each derivative, relative to its RMS."""
    return [float(numpy.abs(o - e).max() / numpy.sqrt(numpy.mean(e**2))) for o, e in zip(out, expected, strict=True)]


def bench(size):
    """One comparison."""
    t, x = signal(size.scaled(SAMPLES, 1_000))
    ours = Ours(t, x)
    ours.reconstruct()
    gap = difference(ours.out, savgol(x))
    seconds = alternate(size.scaled(25, 2), ours=ours.reconstruct, scipy=lambda: savgol(x))
    text = ", ".join(f"{g:.0e}" for g in gap)
    return Outcome(
        [Comparison("three derivatives, even sampling",
                    f"tl_reconstruct, {len(x):,} samples, windows of {LENGTH}, order {ORDER}",
                    "three calls of scipy.signal.savgol_filter", seconds["ours"], seconds["scipy"], 5.0)],
        [f"same value, velocity, acceleration to {text} of their RMS"],
        {"signal_difference": gap},
    )  # fmt: skip
