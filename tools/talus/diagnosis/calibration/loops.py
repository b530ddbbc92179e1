"""The drives' own position loops, by which replicates are driven."""

from dataclasses import dataclass, replace

import numpy as np

from . import feedback
from .. import noise

TICK_S = 0.001  # of a drive
CORRECTIONS, CLOSE = 4, 0.05  # of the lag, at most, and how near the recorded torque's roughness ends them
LEAST = 0.3  # of the recorded torque's roughness: less says little about what the encoder's steps make
LOUDEST = 1.5  # as rough as the recorded torque: a loop that makes a rougher one is not that of this encoder


@dataclass
class Loop:
    """A drive's own loop in one recording: its `law`, what it orders beside that at its ticks in each part, and its encoder's grid."""

    law: feedback.Law
    order: list
    step: float
    offset: float = 0.0


class Loops:
    """Of all joints whose drive answers its encoder. `of[record]`: {joint: Loop}."""

    def __init__(self, dataset, sensors):
        self.dataset, self.sensors = dataset, sensors
        self.records = range(len(sensors))
        self.rows = [_inner(processed) for processed in dataset.processed_recordings]
        self.efforts = [[dataset.effort(record, j) for j in range(dataset.joints)] for record in self.records]
        laws = {j: law for j in range(dataset.joints) if (law := self._law(j))}
        self.of = [{j: self._loop(record, j, law) for j, law in laws.items()} for record in self.records]

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

    def correct(self, motions, exact):
        """Is there a loop that another lag brings nearer? The lag of a drive's speed is what a recording shows worst: where the encoder's
        steps, beside what the loop makes of an `exact` one, make much of the torque's roughness, or more than there is, it is the one
        by which they make all of it."""
        changed = False
        for j, loop in dict(self.of[0]).items():
            times = max(self._by_steps(motions, exact, record, j) for record in self.records)
            delay_s = float(min(TICK_S + times * loop.law.lag_s(TICK_S), feedback.DELAY_S[1]))
            known = loop.law.delay_s < feedback.DELAY_S[1]  # else a shorter one may well be it
            if (times > LEAST or not known) and abs(times - 1.0) > CLOSE and delay_s != loop.law.delay_s:
                changed, law = True, replace(loop.law, delay_s=delay_s)
                for record in self.records:
                    self.of[record][j] = self._loop(record, j, law)
        return changed

    def _by_steps(self, motions, exact, record, joint):
        """Roughness that the encoder's steps make, over that of the recorded torque, both beside what an exact encoder makes."""
        made, smooth = (self._roughness(x, record, joint) for x in (motions, exact))
        steps, recorded = max(made**2 - smooth**2, 0.0), max(1.0 - smooth**2, 0.0)
        return np.sqrt(steps / recorded) if recorded > 0 else 1.0

    def too_loud(self, motions):
        """Joints whose loop makes a rougher torque than recorded: their drives answer another encoder."""
        return [j for j in self.of[0] if self._roughest(motions, j) > LOUDEST]

    def _roughest(self, motions, joint):
        """The torque that a joint's loop makes over the recorded one, in the recording where that is most."""
        return max(self._roughness(motions, record, joint) for record in self.records)

    def _roughness(self, motions, record, joint):
        made, recorded = (noise.roughness(x[joint][self.rows[record]]) for x in (motions[record].torque, self.efforts[record]))
        return made / recorded if recorded > 0 else np.inf if made > 0 else 0.0

    def _column(self, joint):
        return self.dataset.model.sensor("position")[joint]

    def _law(self, joint):
        recordings, name = self.dataset.processed_recordings, self._column(joint)
        if not all(name in one.columns for one in recordings):
            return None
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
