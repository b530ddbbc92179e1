"""Null replicates: what these very recordings would show if the identified model were the whole truth.

The model is driven once more by the recorded torque and a weak loop onto the recorded motion, and recorded anew by the
same sensors: their resolution, noise and instants. Where the recordings show how the drive answers its own encoder, the
model is driven by that loop instead, through that encoder: what its steps do to the torque, and to the motion, is in a
replicate as well. What the search then finds is what reconstruction and noise alone leave (parametric bootstrap,
Davison and Hinkley, Bootstrap Methods and their Application, ch. 4).
"""

import gc
from dataclasses import dataclass

import numpy as np

import talus
from talus import TalusError, check, ffi, lib, pointer

from . import encoder_steps, feedback
from .loops import CORRECTIONS, TICK_S, Loops
from .. import noise
from ..dataset import Dataset
from ..kinds import is_known
from ..motion import acts_in_time, effect_of, plant_of
from ..processed_recording import ProcessedRecording
from ..torque_terms import TorqueTerms

LOOP_HZ = 3.0  # as slow as keeps the plant near: a stiffer loop would replace the motion by the recorded one
NOISE_WINDOW_S = 0.25  # over which noise is measured: chatter comes and goes with the motion
# keys of generators: of the noise that shows whether a loop is one, and of encoders' grids at the recorded motion
CHECK, STEPS = (0, 0), (0, 1)
FINER, ROUNDED = 0.6, 1e-9  # a step of a half or less beside the decimals of a file; the least deviation beside the last digits


class Sensors:
    """What the sensors of one recording do to a motion: measured from the recording itself."""

    def __init__(self, dataset, record):
        self.processed = processed = dataset.processed_recordings[record]
        self.step, self.noise = {}, {}
        for j, name in enumerate(dataset.model.sensor("position")):
            if name in processed.columns:
                self._angle(name, *_resolved(processed.columns[name], processed.regression.struct.sensing[j]))
        for name in dataset.model.sensor("velocity"):
            if name in processed.columns:
                values = processed.columns[name]
                self._angle(name, noise.quantisation_step(values), noise.above_motion(values))
        self._second(dataset)
        self.torque = [self._torque(dataset, record, j) for j in range(dataset.joints)]

    def _angle(self, name, step, deviation):
        """A sensor's resolution, and what noise it has beyond that."""
        rounding = step / np.sqrt(12)
        own = deviation**2 - rounding**2
        white = own > rounding**2  # else its steps are all that is seen
        self.step[name], self.noise[name] = (0.0 if white and own > 9 * rounding**2 else step), np.sqrt(own) if white else 0.0

    def _second(self, dataset):
        """Sensors that see an angle once more: the noise is what their channel has beyond the motor's sensor."""
        for name, kind, motor in (("ankle_joint_rad", "E", "ankle_motor_rad"), ("shank_rad", "K", "knee_motor_rad"),
                                  ("foot_rad", "F", "ankle_motor_rad")):
            if kind not in dataset.sigma or name not in self.processed.columns:
                continue
            joint = 1 if motor.startswith("ankle") else 0
            ratio = np.median(np.abs(dataset.transmissions[joint].ratio(self.processed.q[joint])))
            # the least change of an exact sensor is no step: the difference of both would show it
            shows = np.sqrt(12) * dataset.sigma[kind]
            self.step[motor] = min(self.step[motor], shows * ratio)
            self.noise[motor] = min(self.noise[motor], dataset.sigma[kind] * ratio)
            first = self.step[motor] / np.sqrt(12) + self.noise[motor]
            own = max(dataset.sigma[kind] ** 2 - (first / ratio) ** 2, 0.0)
            step = min(noise.quantisation_step(self.processed.columns[name]), shows)
            self._angle(name, step, np.sqrt(own))

    def _torque(self, dataset, record, joint):
        """Standard deviation of a torque's noise at every sample."""
        local, sigma = self._local(dataset.effort(record, joint)), dataset.sigma[f"T{joint}"]
        rms = np.sqrt(np.mean(local**2))
        return local * (sigma / rms if rms > 0 and sigma > rms else 1.0)

    def _local(self, raw):
        """Standard deviation of a torque's white noise about every sample."""
        power = np.pad(noise.rough_part(raw) ** 2, (1, 2), mode="edge")
        n = max(8, int(NOISE_WINDOW_S / self.processed.step_s))
        return np.sqrt(np.convolve(np.pad(power, (n // 2, n - 1 - n // 2), mode="edge"), np.ones(n) / n, "valid"))

    def without(self, joint, torque, rows):
        """A torque's noise is what it has beside the roughness that the drive's loop makes, both in these rows."""
        share = np.mean(self._local(torque)[rows] ** 2) / max(np.mean(self.torque[joint][rows] ** 2), 1e-300)
        self.torque[joint] *= np.sqrt(max(1.0 - share, 0.0))

    def seen(self, name, values, random, offset=None):
        """An angle as the sensor shows it; its grid lies anywhere, unless its `offset` is given."""
        step, own = self.step[name], self.noise[name]
        values = values + own * random.standard_normal(len(values)) if own > 0 else values
        if step <= 0:
            return values
        offset = step * random.random() if offset is None else offset
        return np.round((values - offset) / step) * step + offset


def _resolved(values, sensing):
    """(step, deviation) of an angle's sensor. A step that is finer than any change is at most half of the least; then noise of which no
    more was seen than that made is finer, too."""
    finest, rounding = noise.finest_step(values), sensing.step / np.sqrt(12)
    if finest > FINER * sensing.step:
        return sensing.step, sensing.noise
    return finest, sensing.noise if sensing.noise > rounding * (1.0 + ROUNDED) else finest / np.sqrt(12)


@dataclass
class Driven:
    """What the model did under the recorded torque, (joints, n) each: motors' side in the joints' coordinates, the joints
    beyond their transmissions."""

    q: np.ndarray
    v: np.ndarray
    torque: np.ndarray
    joint: np.ndarray


def driven(dataset, record, model, effects=(), loops=None):
    """Driven, joints that have one of the `loops` {joint: Loop} by that; None where the model cannot be simulated."""
    processed, loops = dataset.processed_recordings[record], loops or {}
    torque = np.array([dataset.effort(record, j) for j in range(dataset.joints)])
    out = Driven(processed.q.copy(), processed.v.copy(), torque.copy(), processed.q.copy())
    every = ffi.new("tl_effect[]", max(len(effects), 1))
    for place, effect in enumerate(effects):
        every[place] = effect[0]
    for place, part in enumerate(processed.parts):
        rows = slice(part["begin"], part["end"])
        alive = [np.ascontiguousarray(processed.t_s[rows])]
        spec = ffi.new("tl_replay *", {"model": model.struct, "loop_hz": LOOP_HZ, "longest_step_s": TICK_S, "effect": every,
                                       "effects": len(effects), "n": len(alive[0]), "t_s": pointer(alive[0])})  # fmt: skip
        for j, loop in loops.items():
            alive.append(np.ascontiguousarray(loop.order[place]))
            spec.loop[j] = (loop.law.stiffness, loop.law.damping, loop.law.velocity_hz(TICK_S), loop.step, loop.offset,
                            pointer(alive[-1]))  # fmt: skip
            spec.ticks, spec.first_tick_s = len(alive[-1]), feedback.first_tick_s(alive[0], TICK_S)
        results = []
        for j in range(dataset.joints):
            for name, values in (("q", processed.q), ("v", processed.v), ("torque", torque)):
                alive.append(np.ascontiguousarray(values[j][rows]))
                getattr(spec, name)[j] = pointer(alive[-1])
            for name in ("q", "v", "torque", "joint"):
                results.append((name, j, np.empty(len(alive[0]))))
                getattr(spec, f"{name}_out")[j] = pointer(results[-1][2])
        try:
            check(lib.tl_simulate_replay(spec))
        except TalusError:
            return None
        for name, j, result in results:
            getattr(out, name)[j][rows] = result
    return out


def recorded(dataset, record, motion, sensors, random, loops=None):
    """The recording that the sensors would have made of a motion, the drives' encoders on the grids of their `loops`."""
    offsets = {dataset.model.sensor("position")[j]: loop.offset for j, loop in (loops or {}).items()}
    q, v, torque, joint = motion.q, motion.v, motion.torque, motion.joint
    columns = dict(dataset.processed_recordings[record].columns)
    model = dataset.model
    travel = [dataset.transmissions[j].motor_rad(q[j]) for j in range(dataset.joints)] if dataset.at_motor else list(q)
    shown = dict(zip(model.sensor("position"), travel)) | dict(zip(model.sensor("velocity"), v))
    if dataset.at_motor:
        shown |= {"ankle_joint_rad": joint[1], "shank_rad": joint[0], "foot_rad": joint[0] + joint[1]}
    for name, values in shown.items():
        if name in columns:
            columns[name] = sensors.seen(name, values, random, offsets.get(name))
    for j in range(dataset.joints):
        measured = torque[j] + sensors.torque[j] * random.standard_normal(len(torque[j]))
        name, scale = effort_column(dataset, columns, j)
        columns[name] = measured / scale
    source = dataset.processed_recordings[record].recording
    out = talus.Recording(columns)
    out.score, out.origin = source.score, source.origin
    return out


def effort_column(dataset, columns, joint):
    """(name of the column that tells a joint's torque, torque of one of its units)."""
    if dataset.at_motor:
        name = dataset.model.joints[joint]
        return f"{name}_current_A", dataset.tree[name]["torque_constant_Nm_A"]
    for name in ("joint_torque_Nm", "slider_force_N"):
        if name in columns:
            return name, 1.0
    return "joint_current_A", dataset.drive_gain()


def replicable(dataset):
    """Does the model know the motion? Beside a sensor at the output it is not the drive's, and a speed alone does not say where
    the joint is."""
    return not (dataset.load_sensor or dataset.velocity_only)


class Source:
    """What replicates of a dataset are made of: the model's own motion on each recording, under the recorded torque or the drives' own
    `loops`, and its sensors."""

    def __init__(self, dataset, plants, effects):
        self.dataset, self.plants, self.effects = dataset, plants, effects
        self.sensors = [Sensors(dataset, record) for record in range(len(plants))]
        self.loops = Loops(dataset, self.sensors)
        self.motions = self._by_loops() if self.loops else self._driven(self.loops.of)

    @classmethod
    def of(cls, dataset, base, chosen=(), every=()):
        """At these base parameters, with effects of these strengths; None where that cannot be simulated: it is not
        `replicable`, the model runs away or does not follow the recording, or an effect does not act in forward time."""
        if not replicable(dataset) or not all(is_known(c.effect) for c in chosen):
            return None
        effects = [effect_of(dataset, part, own) for c, all_own in zip(chosen, every) for part, own in c.pieces(all_own)]
        plants = []
        for record in range(len(dataset.processed_recordings)):
            terms = TorqueTerms(dataset, record, base)  # large: one at a time
            if not all(acts_in_time(effect, terms.model) for effect in effects):
                return None
            plants.append(plant_of(terms))
        del terms
        gc.collect()  # they hold themselves in circles
        made = cls(dataset, plants, effects)
        return made if made.motions is not None and made._follows() else None

    def _follows(self):
        """Is every joint's motion nearer to the recorded one than standing still, or what counts as that, would be? Else it is another
        machine's: an effect may drive the model away from its loop."""
        off, moved = np.zeros(self.dataset.joints), np.zeros(self.dataset.joints)
        for motion, processed in zip(self.motions, self.dataset.processed_recordings, strict=True):
            still = [processed.regression.struct.sensing[j].standstill for j in range(self.dataset.joints)]
            off += np.mean((motion.v - processed.v) ** 2, axis=1)
            moved += np.mean(processed.v**2, axis=1) + np.square(still)
        return bool(np.all(off <= moved))

    def _driven(self, loops):
        motions = [driven(self.dataset, record, plant, self.effects, loops[record]) for record, plant in enumerate(self.plants)]
        return None if any(motion is None for motion in motions) else motions

    def _by_loops(self):
        """Motions under loops that make the recorded torque's roughness, or no more than that, and show themselves as they were measured."""
        motions = self._corrected()
        motions = self._without(self.loops.too_loud(motions) if motions else range(self.dataset.joints), motions)
        if not motions or not self.loops:
            return motions
        own = [[one.copy() for one in sensors.torque] for sensors in self.sensors]
        self._leave_noise(motions)
        recordings = self._recorded(motions, self.loops.of, np.random.Generator(np.random.Philox(key=CHECK)))
        wrong = [j for j in self.loops.of[0] if not self.loops.shows(j, *self._drive(recordings, j))]
        if wrong:
            motions = self._without(wrong, motions)
            for sensors, torque in zip(self.sensors, own):
                sensors.torque = torque
            self._leave_noise(motions or ())
        return motions

    def _without(self, joints, motions):
        """Motions without the loops of some joints."""
        if not joints:
            return motions
        self.loops.drop(joints)
        return self._driven(self.loops.of)

    def _leave_noise(self, motions):
        """A torque's noise is what its loop does not make."""
        for sensors, motion, loops, rows in zip(self.sensors, motions, self.loops.of, self.loops.rows):
            for j in loops:
                sensors.without(j, motion.torque[j], rows)

    def _recorded(self, motions, loops, random):
        """The recordings that the sensors would have made of motions."""
        return [recorded(self.dataset, record, motion, sensors, random, own)
                for record, (motion, sensors, own) in enumerate(zip(motions, self.sensors, loops, strict=True))]  # fmt: skip

    def _drive(self, recordings, joint):
        """(positions, torques) of a joint's drive in some recordings."""
        name, scale = effort_column(self.dataset, recordings[0].columns, joint)
        positions = [one.columns[self.dataset.model.sensor("position")[joint]] for one in recordings]
        return positions, [scale * one.columns[name] for one in recordings]

    def _corrected(self):
        """Motions under the loops, their lags corrected as far as the recordings tell these; None where one runs away."""
        motions = self._driven(self.loops.of)
        if not motions or not self.loops.are_doubtful(motions):
            return motions
        exact = self._driven(self.loops.without_steps())
        for _ in range(CORRECTIONS):
            if not motions or not exact or not self.loops.correct(motions, exact):
                break
            motions = self._driven(self.loops.of)
        if exact and self.loops.restore(motions, exact):
            motions = self._driven(self.loops.of)
        return motions

    def excess_of_steps(self):
        """{kind: chi-square over its freedom} that encoders' steps alone leave at the recorded motion."""
        return encoder_steps.excess(self.dataset, self.sensors, np.random.Generator(np.random.Philox(key=STEPS)))

    def replicate(self, seed, number):
        """The dataset of one replicate; None where nothing of it can be used."""
        gc.collect()  # a search's candidates hold their torque terms in circles: those of the replicate before
        random = np.random.Generator(np.random.Philox(key=[seed % 2**64, number]))
        loops = self.loops.on_grids(random)
        motions = self._driven(loops) if self.loops else self.motions
        if motions is None:
            return None
        made = [ProcessedRecording(self.dataset.model, one, old.name, old.window_hz)
                for old, one in zip(self.dataset.processed_recordings, self._recorded(motions, loops, random), strict=True)]  # fmt: skip
        return Anew(self.dataset, made) if all(one.parts for one in made) else None


class Anew(Dataset):
    """A replicate's rows, over the noise of the recordings that it stands for."""

    def __init__(self, source, processed_recordings):
        self._source = source
        super().__init__(source.model, processed_recordings, source.tree, source.effects)
        self.irregular = dict.fromkeys(self.kinds, 0.0)

    def find_sigma(self, residual=None):
        self.sigma, self.irregular = dict(self._source.sigma), dict(self._source.irregular)
