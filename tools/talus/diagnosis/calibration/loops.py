"""The drives' own position loops, by which replicates are driven."""

from dataclasses import dataclass, replace

import numpy as np

from . import feedback
from .. import noise

TICK_S = 0.001  # of a drive
CORRECTIONS, CLOSE = 4, 0.05  # of the lag, at most, and how near the recorded torque's roughness ends them
LEAST = 0.3  # of the recorded torque's roughness: a loop that makes less says little about the encoder's steps
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
        self.of = [{j: self._loop(record, j, law) for j, law in laws.items()} for record in self.records]

    def __bool__(self):
        return any(self.of)

    def drop(self, joints):
        """Without those of some joints."""
        self.of = [{j: loop for j, loop in loops.items() if j not in joints} for loops in self.of]

    def on_grids(self, random):
        """The same, each encoder's grid anywhere."""
        return [{j: replace(loop, offset=loop.step * random.random()) for j, loop in loops.items()} for loops in self.of]

    def correct(self, motions):
        """Is there a loop that another lag brings nearer? The lag of a drive's speed is what a recording shows worst: where its loop makes
        much of the torque's roughness, or more than there is, it is the one that makes all of it."""
        changed = False
        for j, loop in dict(self.of[0]).items():
            times = self._roughest(motions, j)
            delay_s = min(TICK_S + times * loop.law.lag_s(TICK_S), feedback.DELAY_S[1])
            known = loop.law.delay_s < feedback.DELAY_S[1]  # else a shorter one may well be it
            if (times > LEAST or not known) and abs(times - 1.0) > CLOSE and delay_s != loop.law.delay_s:
                changed, law = True, replace(loop.law, delay_s=delay_s)
                for record in self.records:
                    self.of[record][j] = self._loop(record, j, law)
        return changed

    def of_little_use(self, motions):
        """Joints whose loop makes a rougher torque than recorded, or a much smoother one: then the encoder's steps are not what makes it
        rough, and the recorded torque itself is the better one."""
        return [j for j in self.of[0] if not LEAST < self._roughest(motions, j) < LOUDEST]

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
        recordings = self.dataset.processed_recordings
        return feedback.law_of(recordings, [one.columns[self._column(joint)] for one in recordings], [one[joint] for one in self.efforts])

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
