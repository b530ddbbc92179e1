"""A trajectory that has not been run, as a recording without readings: what each effect's columns would be along it."""

import copy

import numpy as np

import talus

from .. import noise
from ..torque_terms import TorqueTerms
from ..processed_recording import ProcessedRecording
from ..numerics import interpolated
from .path import STEP_S, length_s

PAYLOAD_KG = 1.0
HEAVIER, MORE = ("inertia_kg_m2", "mass_kg", "gravity_moment_kg_m"), 1.5  # what a load at a single joint changes, and by what
CAMERA = {"shank_rad", "foot_rad"}


def recording_of(dataset, q, camera=False):
    """The recording that sensors would make of a joint motion `q` on the file's rows, all efforts 0; with a camera, too."""
    first = dataset.processed_recordings[0]
    t = np.arange(0, (q.shape[1] - 1) * STEP_S, first.step_s)
    q = np.array([interpolated(x, t / STEP_S) for x in q])
    columns = {"time_s": t, **angles(dataset, q)}
    for name, values in first.columns.items():
        if name not in columns and name != "valid":
            columns[name] = np.full(len(t), float(np.mean(values)) if name.endswith("_C") else 0.0)
    seen = set(first.columns) | (CAMERA if camera else set())
    settings = first.recording.score
    recording = talus.Recording({n: rounded(x, first.columns.get(n, x)) for n, x in columns.items() if n in seen})
    recording.score = settings
    return recording


def angles(dataset, q):
    """Columns of a motion of the joints."""
    if dataset.at_motor:
        knee, ankle = dataset.transmissions
        return {"knee_motor_rad": knee.motor_rad(q[0]), "ankle_motor_rad": ankle.motor_rad(q[1]),
                "ankle_joint_rad": q[1], "shank_rad": q[0], "foot_rad": q[0] + q[1]}  # fmt: skip
    (position,), velocity = dataset.model.sensor("position"), dataset.model.sensor("velocity")
    return {position: q[0], **{name: np.gradient(q[0], dataset.processed_recordings[0].step_s) for name in velocity}}


def rounded(values, like):
    """With the resolution of a column that was recorded; times stay."""
    step = noise.quantisation_step(like[:4000])
    return values if step <= 0 or np.all(np.diff(values) > 0) else np.round(values / step) * step


def planned_dataset(dataset, recording):
    """What such a recording would show: channels and noise of the recordings there are, and a camera's if it has one; one
    block."""
    out = copy.copy(dataset)
    if CAMERA <= set(recording.columns):
        out.kinds = sorted({*dataset.kinds, "F", "K"})
    out.models = {}
    out.processed_recordings = [processed := ProcessedRecording(dataset.model, recording)]
    if out.at_motor:
        out.ankle_rad = [dataset.transmissions[1].joint_rad(processed.columns["ankle_motor_rad"])]
    out.channels = [c for c in out._channels(0) if c.kind in out.kinds]
    out.block_of, out.block_record = [np.zeros(len(processed.grid_t_s), int)], np.zeros(1, int)
    out.blocks, out.folds, out.fold_count = 1, np.zeros(1, int), 1
    for channel in out.channels:
        channel.thinned = channel.rows[channel.rows % out.thin == 0]
    return out


class Planned:
    """A trajectory at the identified parameters; `loaded` with a known mass where it is farthest out, or before a camera."""

    def __init__(self, search, q, loaded=False, camera=False):
        self.dataset = planned_dataset(search.dataset, recording_of(search.dataset, q, camera))
        base = search.all_terms[0].base
        if loaded:
            base, self.dataset.model = with_payload(search.dataset, search.all_terms[0].model)
        self.terms = TorqueTerms(self.dataset, 0, base)
        self.length_s = length_s(q)

    def torque(self):
        """Largest motor torque of each joint."""
        return np.array([np.abs(x).max() for x in self.terms.motor_Nm])


def with_payload(dataset, model):
    """(base parameters, given model) with PAYLOAD_KG at the foot's centre, or half as much again at a single joint."""
    loaded, given = model.copy(), dataset.model.copy()
    for one in (loaded, given):
        if "foot_com_m" in one.parameters:
            one.struct.foot_mass_kg += PAYLOAD_KG
        else:
            heavier = [name for name in one.parameters if name in HEAVIER]
            one.set_parameters(**{name: MORE * one.parameters[name] for name in heavier})
    return list(loaded.base.values()), given
