"""The drives' own position loops, by which replicates are driven."""

from dataclasses import dataclass, replace

import numpy as np

from . import feedback
from .thresholds import HALF
from .. import noise

TICK_S = 0.001  # of a drive
CORRECTIONS, CLOSE = 4, 0.05  # of the lag, at most, and how near the recorded torque's roughness ends them
MOST = 0.7  # of the recorded torque's roughness: where no lag makes so much, the encoder's steps are not what makes it
LOUDEST = 1.5  # as rough as the recorded torque: a loop that makes a rougher one is not that of this encoder


@dataclass
class Loop:
    """A drive's own loop in one recording: its `law`, what it orders beside that at its ticks in each part, and its encoder's grid."""

    law: feedback.Law
    order: list
    step: float
    offset: float = 0.0


class Loops:
    """Of all joints whose drive answers an encoder of which the steps are all the noise there is. `of[record]`: {joint: Loop}."""

    def __init__(self, dataset, sensors):
        self.dataset, self.sensors = dataset, sensors
        self.records = range(len(sensors))
        self.rows = [_inner(processed) for processed in dataset.processed_recordings]
        self.efforts = [[dataset.effort(record, j) for j in range(dataset.joints)] for record in self.records]
        laws = {j: law for j in range(dataset.joints) if self._steps_alone(j) and (law := self._law(j))}
        self.measured = [{j: self._loop(record, j, law) for j, law in laws.items()} for record in self.records]
        self.of = [dict(loops) for loops in self.measured]

    def __bool__(self):
        return any(self.of)

    def drop(self, joints):
        """Without those of some joints."""
        self.of = [{j: loop for j, loop in loops.items() if j not in joints} for loops in self.of]

    def on_grids(self, random):
        """The same, each encoder's grid anywhere."""
        return [{j: replace(loop, offset=loop.step * random.random()) for j, loop in loops.items()} for loops in self.of]

    def without_steps(self):
        """The same through exact encoders."""
        return [{j: replace(loop, step=0.0) for j, loop in loops.items()} for loops in self.of]

    def are_doubtful(self, motions):
        """Is there one whose lag is not sure, or that makes more than the recorded torque's roughness?"""
        return any(not loop.law.is_sure or self._roughest(motions, j) > 1.0 for j, loop in self.of[0].items())

    def correct(self, motions, exact):
        """Is there a loop that another lag brings nearer? The lag of a drive's speed is what a recording shows worst. Where it is not
        sure, or the encoder's steps make more than the torque's roughness, beside what the loop makes of an `exact` encoder, it is the
        one by which they make all of it."""
        changed = False
        for j, loop in dict(self.of[0]).items():
            times = self._by_steps(motions, exact, j)
            if loop.law is self.measured[0][j].law and times < 1.0 and loop.law.is_sure:
                continue
            delay_s = float(min(TICK_S + times * loop.law.lag_s(TICK_S), feedback.DELAY_S[1]))
            if abs(times - 1.0) > CLOSE and delay_s != loop.law.delay_s:
                changed, law = True, replace(loop.law, delay_s=delay_s)
                for record in self.records:
                    self.of[record][j] = self._loop(record, j, law)
        return changed

    def restore(self, motions, exact):
        """Is there a loop whose lag was corrected in vain, or until it ran away? It has the measured one again."""
        corrected = [j for j, loop in self.of[0].items() if loop is not self.measured[0][j]]
        in_vain = [j for j in corrected if not motions or self._by_steps(motions, exact, j) < MOST]
        for record in self.records:
            self.of[record] |= {j: self.measured[record][j] for j in in_vain}
        return bool(in_vain)

    def _by_steps(self, motions, exact, joint):
        """Roughness that the encoder's steps make, over that of the recorded torque, both beside what an exact encoder makes; in the
        recording where that is most."""
        return max(self._share(self._roughness(motions, record, joint), self._roughness(exact, record, joint)) for record in self.records)

    @staticmethod
    def _share(made, smooth):
        return np.sqrt(max(made**2 - smooth**2, 0.0) / (1.0 - smooth**2)) if smooth < 1.0 else 1.0

    def too_loud(self, motions):
        """Joints whose loop makes a rougher torque than recorded: their drives answer another encoder."""
        return [j for j in self.of[0] if self._roughest(motions, j) > LOUDEST]

    def shows(self, joint, positions, torques):
        """Do a replicate's recordings show a joint's law as the real ones do? Where noise is taken for a loop, the position tells less of the
        torque that such a loop makes."""
        return feedback.explained(self.dataset.processed_recordings, positions, torques) >= HALF * self.of[0][joint].law.explains

    def _roughest(self, motions, joint):
        """The torque that a joint's loop makes over the recorded one, in the recording where that is most."""
        return max(self._roughness(motions, record, joint) for record in self.records)

    def _roughness(self, motions, record, joint):
        made, recorded = (noise.roughness(x[joint][self.rows[record]]) for x in (motions[record].torque, self.efforts[record]))
        return made / recorded if recorded > 0 else np.inf if made > 0 else 0.0

    def _column(self, joint):
        return self.dataset.model.sensor("position")[joint]

    def _steps_alone(self, joint):
        name = self._column(joint)
        return all(name in one.columns and sensors.step[name] > 0 and sensors.noise[name] == 0
                   for one, sensors in zip(self.dataset.processed_recordings, self.sensors))  # fmt: skip

    def _law(self, joint):
        recordings, name = self.dataset.processed_recordings, self._column(joint)
        return feedback.law_of(recordings, [one.columns[name] for one in recordings], [one[joint] for one in self.efforts])

    def _loop(self, record, joint, law):
        processed = self.dataset.processed_recordings[record]
        position, period_s = processed.columns[self._column(joint)], self.dataset.periods_s[record]
        order = feedback.order(processed, law, position, self.efforts[record][joint], TICK_S, period_s)
        # an encoder's step is seen best where a recording has most of its values: in a short one it may seem some times as large
        return Loop(law, order, min(sensors.step[self._column(joint)] for sensors in self.sensors))


def _inner(processed):
    """Rows but for the begin and end of each part, which filters spoil; all where that leaves none."""
    out, n = np.zeros(len(processed.t_s), bool), round(feedback.EDGE_S / processed.step_s)
    for part in processed.parts:
        out[part["begin"] + n : part["end"] - n] = True
    return out if np.count_nonzero(out) > 2 * n else processed.inside
