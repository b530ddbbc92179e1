"""A linear-Gaussian problem that talus-gap's own code searches: search(), Gram, gains, Calibration, verdict and intervals are the
real ones. Stand-ins are the recording, whose columns are random, and the replicates, which draw noise anew.

    with stand_ins():
        found, fit = searched(problem, problem.recording(strengths))
"""

import contextlib
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np

from talus.diagnosis import search as real
from talus.diagnosis.calibration import gains, replicates
from talus.diagnosis.catalogue.candidate import Candidate, named
from talus.diagnosis.dataset import Channel, Dataset

STEP_S, SAMPLES = 0.04, 1500
LOWPASS_HZ = 2.5
SIGMA_NM = 0.1  # of the samples' white noise
BASE_NM = np.array([1.0, 0.7, 0.4, 0.3])  # base parameters as given, of columns whose RMS is 1
PRIOR_WIDTH = 0.2
KIND = "T0"
KEPT = int(LOWPASS_HZ * STEP_S * SAMPLES) + 1  # lines of the spectrum that the low-pass leaves
DIMENSIONS = 2 * KEPT - 1
BANDWIDTH = DIMENSIONS / SAMPLES


def lowpassed(rows):
    """Rows without what lies above the low-pass."""
    lines = np.fft.rfft(rows)
    lines[..., KEPT:] = 0
    return np.fft.irfft(lines, rows.shape[-1])


def noise(random):
    return lowpassed(SIGMA_NM * random.standard_normal(SAMPLES))


def unit_rows(rows):
    """Low-passed rows of RMS 1."""
    rows = lowpassed(rows)
    return rows / np.sqrt(np.mean(rows**2, axis=-1, keepdims=True))


class Column:
    """One effect's column, the same in the recording and in its replicates."""

    def __init__(self, values):
        self.values = values

    def __call__(self, terms):
        return {KIND: self.values}


class Problem:
    """Random base columns and `effects` candidates of one column each, every two of which are `alike` (their correlation); half of each is
    what a base column shows as well. `rough_gains`: what each candidate gains of its own part of what reconstruction leaves; its logarithm
    differs by `spread` among replicates, and by `misfit` between these and the recording."""

    def __init__(self, random, effects=6, alike=0.9, rough_gains=None, spread=0.3, misfit=0.6):
        self.random, self.spread, self.misfit = random, spread, misfit
        self.base = unit_rows(random.standard_normal((len(BASE_NM), SAMPLES)))
        common = np.repeat(random.standard_normal(((effects + 1) // 2, SAMPLES)), 2, axis=0)[:effects]
        own = unit_rows(np.sqrt(alike) * unit_rows(common) + np.sqrt(1 - alike) * unit_rows(random.standard_normal((effects, SAMPLES))))
        self.effects = unit_rows(own + 0.5 * self.base[np.arange(effects) % len(BASE_NM)])
        self.candidates = [Candidate(f"effect_{k}", "joint", "one", (Column(row),), named("strength_Nm")) for k, row in enumerate(self.effects)]
        self.beside = self.beside_base(self.effects)
        self.unit_Nm = SIGMA_NM / np.sqrt(np.sum(self.beside**2, axis=1))  # strength that gains 1
        self.shown_by_effects = self.shown(self.effects)
        self.rough_Nm = np.zeros(effects) if rough_gains is None else np.sqrt(rough_gains) * self.unit_Nm

    def beside_base(self, rows):
        """What the base columns leave of rows."""
        return rows - np.linalg.lstsq(self.base.T, rows.T, rcond=None)[0].T @ self.base

    def shown(self, torque_Nm):
        """How much of a torque each candidate shows, noise apart: the root of what it gains by it, with a sign."""
        return torque_Nm @ (self.beside / np.sqrt(np.sum(self.beside**2, axis=1, keepdims=True))).T / SIGMA_NM

    def rough_draws(self, random, number, of_recording=False):
        """Strengths of what reconstruction leaves, in replicates or in the recording: (number, effects). Effects that are alike have it
        in common."""
        width = np.hypot(self.spread, self.misfit) if of_recording else self.spread
        factors = np.exp(0.5 * width * random.standard_normal((number, (len(self.rough_Nm) + 1) // 2)))
        return self.rough_Nm * np.repeat(factors, 2, axis=1)[:, :len(self.rough_Nm)]

    def base_Nm(self):
        """True base parameters, from what is known of them before."""
        return BASE_NM * (1 + PRIOR_WIDTH * self.random.standard_normal(len(BASE_NM)))

    def roughness(self):
        """What reconstruction leaves in a recording."""
        return self.rough_draws(self.random, 1, of_recording=True)[0] @ self.effects

    def recording(self, strengths_Nm, roughness_Nm=0.0):
        """Reading of a recording with effects of these strengths."""
        return self.base_Nm() @ self.base + strengths_Nm @ self.effects + roughness_Nm + noise(self.random)


class ToyDataset(Dataset):
    """A recording of one channel as the search sees one; blocks, folds, thinning and freedom are Dataset's."""

    def __init__(self, problem, reading):
        self.problem, self.candidates = problem, problem.candidates
        self.effects = {c.effect: SimpleNamespace(several=False, integrated=False, outside=False, stiffness=None) for c in problem.candidates}
        self.at_motor, self.joints, self.bases = False, 2, len(BASE_NM)  # another joint shows nothing
        self.model = SimpleNamespace(joints=["joint", "other"], torque_unit="Nm")
        self.prior, self.prior_width, self.identified = BASE_NM, PRIOR_WIDTH * BASE_NM, BASE_NM
        self.drawn_width, self.is_inertia = self.prior_width, np.zeros(len(BASE_NM), bool)
        self.inertia_kept = 1.0
        self.absent, self.kinds, self.angle_kinds, self.load_sensor = [], [KIND], [], False
        score = SimpleNamespace(lowpass_hz=LOWPASS_HZ)
        self.processed_recordings = [SimpleNamespace(grid_t_s=STEP_S * np.arange(SAMPLES), step_s=STEP_S, x=[problem.base.T],
                                                     index=[np.arange(self.bases)], recording=SimpleNamespace(score=score),
                                                     target=[reading], v=problem.base[:1], q=problem.base[1:2], resample=lambda motion: motion)]  # fmt: skip
        self.channels = [Channel(0, KIND, reading, np.ones(SAMPLES, bool))]
        self.bandwidth, self.periods_s = [BANDWIDTH], [None]
        self.find_sigma()
        self._find_blocks()
        self._find_stretches()
        self._thin()

    def find_sigma(self, residual=None):
        self.sigma, self.irregular = {KIND: SIGMA_NM}, {KIND: 0.0}

    def near_pairs(self, channel):
        return None


class ToySource:
    """Replicates of a toy: the fitted base, reconstruction and noise anew."""

    @classmethod
    def of(cls, dataset, base, chosen=(), strengths=()):
        source = cls()
        source.problem = dataset.problem
        shown = [s * column.values for c, own in zip(chosen, strengths, strict=True) for s, column in zip(own, c.columns, strict=True)]
        source.torque_Nm = base @ dataset.problem.base + sum(shown)
        return source

    def excess_of_steps(self):
        """There is no encoder whose steps could leave anything."""
        return {}

    def replicate(self, seed, number):
        random = np.random.default_rng([seed, number])
        rough_Nm = self.problem.rough_draws(random, 1)[0] @ self.problem.effects
        return ToyDataset(self.problem, self.torque_Nm + rough_Nm + noise(random))


class Here:
    """In place of other processes: the same in this one."""

    def __init__(self, *_):
        self.map = map

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass


@contextlib.contextmanager
def stand_ins():
    """Within, search() takes toys for recordings."""
    with (patch.multiple(real, TorqueTerms=lambda *_: None, Extent=lambda _: None, candidates=lambda dataset, *_: dataset.candidates),
          patch.object(real, "gc", SimpleNamespace(collect=lambda: None)), patch.object(replicates, "Source", ToySource),
          patch.object(gains, "ProcessPoolExecutor", Here), patch.object(gains, "has_inertia", lambda *_: True)):  # fmt: skip
        yield


def searched(problem, reading, replicated=True):
    """(search, fit) of talus-gap's own search; replicates from a seed that the problem draws."""
    dataset = ToyDataset(problem, reading)
    return real.search(dataset, real.plain_base(dataset), seed=int(problem.random.integers(2**32)), replicated=replicated)
