"""The low-pass that a diagnosis looks through: the fastest at which the sensors leave the inertia alone.

Steps and noise of the angles, and slow samples, make regressors that are off, and these pull the fitted inertia away from the
true one (errors in variables). How far is told by replicates: the identified model recorded anew by the same sensors, and
identified once more. The windows of the motion stay as short as the score's own low-pass asks, for longer ones smear reversals; unless
no low-pass leaves the inertia alone through these.
"""

import copy
import functools
from dataclasses import dataclass, replace

import numpy as np

from talus import ffi

from .. import processors
from ..dataset import Dataset
from ..gate.finding import Finding
from ..motion import has_inertia, inertia_over
from ..processed_recording import ProcessedRecording
from .replicates import Source, replicable
from ..search import machine_bases, plain_base
from .thresholds import GIVES_UP, HALF, RIGHT_TO
from ..torque_terms import model_at

STEP = 1.5  # from one frequency to the next slower one
SLOWEST_HZ = 5.0
ALL_OF_IT = -1.0


@dataclass(frozen=True)
class Lowpass:
    """`hz`; `source` "model" (the file's), "option" or "data"; `bias` that is left of the inertia, None where that cannot be told;
    `window_hz` whose windows the motion is seen through, where the model file's were too short; `left`, the share of the
    measured torque (RMS) that the plain model does not explain, where most of the inertia is lost."""

    hz: float
    source: str
    bias: float | None = None
    window_hz: float | None = None
    left: float = 0.0

    @property
    def fixes_inertia(self):
        """Do the sensors leave the inertia known? None: they take more of it than they leave."""
        off = abs(self.bias or 0.0)
        return None if off > HALF else off <= GIVES_UP

    @property
    def leaves_inertia(self):
        """As far as it can be told."""
        return self.bias is None or self.fixes_inertia

    @property
    def other_hz(self):
        """Where a verdict must hold as well: at half of it, or at twice where rivals cannot be tried so slowly. None where the data
        themselves ask for one so slow: at twice of it the sensors show."""
        if 0.5 * self.hz >= SLOWEST_HZ:
            return 0.5 * self.hz
        return None if self.source == "data" else 2.0 * self.hz

    @property
    def nothing_left(self):
        """Do they leave nothing of it at any frequency, or most of the torque unexplained as well?"""
        return self.bias == ALL_OF_IT or (self.fixes_inertia is None and self.left > HALF)


def inertia_of(model):
    """Its name: a slider's is a mass."""
    return "inertia" if model.torque_unit == "Nm" else "mass"


def too_coarse(model, through):
    """The finding where nothing is left."""
    inertia, torque = inertia_of(model), "torque" if model.torque_unit == "Nm" else "force"
    what = f"nothing is left of the identified {inertia}, at any low-pass" if through.bias == ALL_OF_IT else (
        f"the identified {inertia} comes out {100 * abs(through.bias):.0f} % too {'small' if through.bias < 0 else 'large'}, and "
        f"{100 * through.left:.0f} % of the measured {torque} stays unexplained")  # fmt: skip
    return Finding("coarse", True, "", f"steps and noise of the angles are so large, or the machine is so unlike the model, that {what}",
                   "a finer encoder, or faster motion over a larger range, by the joint's own drive")  # fmt: skip


def processed_at(model, recordings, names, hz, window_hz=None):
    """The recordings through a low-pass of this frequency, the motion's windows as long as another asks: by default the model's."""
    def at(recording, name):
        one = copy.copy(recording)
        one.score = ffi.new("tl_score_settings *", model.score[0])
        one.score.lowpass_hz = hz
        return ProcessedRecording(model, one, name, window_hz or model.score.lowpass_hz)

    return processors.each(lambda both: at(*both), zip(recordings, names))


def dataset_of(model, processed, tree, effects):
    """The rows of those recordings that can be used."""
    return Dataset(model, [one for one in processed if one.parts], tree, effects)


def inertia_bias(dataset, seed):
    """By what share the inertia comes out wrong, of its largest error over all directions: -1 where none is left of it, None
    where that cannot be told."""
    if not replicable(dataset):
        return None
    found = [next((bias for base in machine_bases(dataset) if (bias := _bias_at(dataset, base, seed)) is not None), ALL_OF_IT)]
    if not has_inertia(dataset, plain_base(dataset)):  # the sensors may have taken all of it: what do they leave of the one as given?
        found.append(_bias_at(dataset, dataset.prior, seed) or 0.0)
    return max(found, key=abs)


def _bias_at(dataset, base, seed):
    """The same of a machine with these base parameters; None where that cannot be simulated."""
    source = Source.of(dataset, base)
    if not source:
        return None
    replicate = source.replicate(seed, 0)
    if not replicate:
        return ALL_OF_IT
    poses = np.median(dataset.processed_recordings[0].q, axis=1)[None]
    true, found = (inertia_over(model_at(dataset, x), poses)[0] for x in (base, plain_base(replicate)))
    try:
        root = np.linalg.inv(np.linalg.cholesky(true))
    except np.linalg.LinAlgError:
        return ALL_OF_IT
    off = np.linalg.eigvalsh(root @ found @ root.T) - 1.0
    return float(off[np.argmax(np.abs(off))])


def share_left(dataset):
    """RMS that the plain model leaves of the torque, over the measured one's; several joints' in units of their noise."""
    base, left, whole = plain_base(dataset), 0.0, 0.0
    for channel in (c for c in dataset.channels if c.kind[0] == "T"):
        measured = channel.values[channel.rows] / dataset.sigma[channel.kind]
        plain = dataset.base_columns(channel)[:, :dataset.bases] @ base / dataset.sigma[channel.kind]
        left, whole = left + np.sum((measured - plain) ** 2), whole + np.sum(measured**2)
    return float(np.sqrt(left / max(whole, 1e-300)))


def kept_hz(processed, hz):
    """`hz`, or less where the motion's windows do not keep that band: they are as long as the low-pass's period, up to the next whole
    sample at both ends, or so many samples as their polynomial needs."""
    for one in processed:
        for sensing in one.regression.struct.sensing[0:one.joints]:
            if not sensing.across and sensing.window.length_s > 1 / hz + 1.5 * one.step_s:
                hz = 1 / sensing.window.length_s
    return hz


def chosen(looks, hz, kept):
    """(Lowpass, its dataset): of `looks`, from `hz` down, the first where the inertia is left alone and the windows keep the band
    (`kept`), or where the inertia is least wrong; `looks` gives (Lowpass, dataset) of each frequency."""
    best = None
    while True:
        found = looks(hz)
        bias = found[0].bias
        if bias is None or (abs(bias) < RIGHT_TO and hz <= kept):
            return found
        if best is None or abs(bias) < abs(best[0].bias):
            best = found
        if hz / STEP < SLOWEST_HZ:
            return best
        hz = min(hz / STEP, kept) if hz > kept else hz / STEP


class Looks:
    """The recordings of a diagnosis through any low-pass; `processed` are those at the model's own, `effects` those that are tried."""

    def __init__(self, model, recordings, names, tree, processed, effects):
        self.model, self.recordings, self.names, self.tree, self.processed = model, recordings, names, tree, processed
        self.effects, self.window_hz = effects, model.score.lowpass_hz
        self.fastest_hz = kept_hz(processed, self.window_hz)

    def at(self, hz):
        """The dataset."""
        processed, self.processed = self.processed, None  # looked through once: they would only take up memory
        if not processed or (hz, self.window_hz) != (self.model.score.lowpass_hz,) * 2:
            processed = processed_at(self.model, self.recordings, self.names, hz, self.window_hz)
        return dataset_of(self.model, processed, self.tree, self.effects)

    def first(self, wanted_hz, seed):
        """(Lowpass, dataset) of a diagnosis: the option's, the model file's, or what the data leave."""
        own_hz = self.model.score.lowpass_hz
        if wanted_hz:
            return Lowpass(wanted_hz, "option"), self.at(wanted_hz)
        if "score" in self.tree:
            return Lowpass(own_hz, "model"), self.at(own_hz)
        found, dataset = chosen(functools.partial(self._from_data, seed), own_hz, self.fastest_hz)
        if not found.leaves_inertia and found.bias != ALL_OF_IT:
            found, dataset = self._with_longer_windows(found, dataset, seed)
        return (replace(found, left=share_left(dataset)) if found.fixes_inertia is None else found), dataset

    def _from_data(self, seed, hz):
        dataset = self.at(hz)
        return Lowpass(hz, "data", inertia_bias(dataset, seed)), dataset

    def _with_longer_windows(self, found, dataset, seed):
        """(Lowpass, dataset) through windows as long as the low-pass itself asks, if they leave the inertia known, or more than half of it
        where those found leave less; else those found."""
        own_hz = self.window_hz
        other, its_dataset = chosen(functools.partial(self._windows_as_long, seed), own_hz / STEP, own_hz)
        if not other.leaves_inertia and (found.fixes_inertia is not None or other.fixes_inertia is None):
            self.window_hz = own_hz
            return found, dataset
        self.window_hz = other.hz
        return replace(other, window_hz=other.hz), its_dataset

    def _windows_as_long(self, seed, hz):
        self.window_hz = hz
        return self._from_data(seed, hz)

    def others(self, through, seed):
        """(Lowpass, dataset) through one low-pass after the other with windows as long, where the data chose the first one (`through`): those
        that leave the inertia alone, or no worse than that one."""
        hz = self.fastest_hz / STEP
        while through.source == "data" and hz >= SLOWEST_HZ:
            found, dataset = self._windows_as_long(seed, hz)
            if hz != through.window_hz and abs(found.bias or 0.0) <= max(RIGHT_TO, abs(through.bias or 0.0)):
                yield replace(found, window_hz=hz), dataset
            hz /= STEP

    def around(self, through):
        """What makes the datasets at half and at twice of a Lowpass that has no `other_hz`; nothing for another."""
        return [functools.partial(self.at, times * through.hz) for times in (0.5, 2.0)] if not through.other_hz else []

    def other_than(self, through):
        """What makes the dataset at a Lowpass's `other_hz`; None where there is none."""
        return functools.partial(self.at, through.other_hz) if through.other_hz else None
