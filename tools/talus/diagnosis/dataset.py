"""What all recordings show, as weighted rows: the joints' torques, and where a second sensor sees an angle, its
difference from the motor's.

A channel is one kind of reading in one recording: T0 and T1 the torque of the first and second joint, E the ankle
encoder less the motor's angle through the linkage, K and F the camera's angles less the motors'. Rows are divided
by the channel's noise, so that their sum of squares is chi-square with (rows x noise bandwidth) degrees of freedom.
"""

import numpy as np

import talus

from . import irregular, noise
from .calibration.thresholds import GIVES_UP, HALF, PART
from .effects import EFFECTS

SCORED, NEAR_STOP = 1, 2
FOLDS = 5
PRIOR_WIDTH = 0.2  # of a base parameter: a drawing's standard deviation; more where identification moved it farther
PRIOR_WIDTH_OF_ONE_JOINT = 20.0  # whose model may be no drawing but a first guess
HARDLY_MOVES = 0.2  # share of the time
MOST_ROWS = 30000  # of one kind of channel
MOST_STATES = 4000  # compared with each other
STRETCHES, SHORTEST_STRETCH_S = 40, 0.25  # of the motion, over which what a model lacks of it stays the same
ROWS_PER_PERIOD = 2.6  # of the low-pass frequency: little lies beyond half of that


class Channel:
    """One kind of reading of one recording on the grid."""

    def __init__(self, record, kind, values, scored):
        self.record, self.kind, self.values = record, kind, values
        self.rows = np.flatnonzero(scored)
        self.thinned = self.rows


def session(processed_recordings):
    """(what went before the file of each recording, all together) in s: files one after the other, whose stretches share a begin."""
    begins, total, path = [], 0.0, None
    for origin in (processed.recording.origin for processed in processed_recordings):
        if begins and path is not None and origin.path == path:
            begins.append(begins[-1])
            continue
        begins.append(total)
        total, path = total + origin.length_s, origin.path
    return begins, total


def drawn_width(given):
    """How near a machine's base parameters are to a drawing's {name: value}, one standard deviation: inertia and gravity to its
    accuracy, friction and zeros not at all (infinite)."""
    values = np.array(list(given.values()))
    drawn = np.array([not name.endswith(("coulomb", "viscous", "offset")) for name in given]) & (values != 0.0)
    return np.where(drawn, PART * np.abs(values), np.inf)


class Dataset:
    """All recordings of one diagnosis under one model; `effects` are those that are tried, by id."""

    def __init__(self, model, processed_recordings, tree, effects=EFFECTS):
        self.effects = effects
        self.model, self.processed_recordings, self.tree = model, processed_recordings, tree
        self.at_motor = bool(model.facts.sensors.at_motor)  # the joints follow through their transmissions
        self.models = {}  # the model at other base parameters, by these
        self._near_pairs = {}  # by recording and kind of channel: the same for every fit
        self.joints, self.bases = len(model.joints), len(model.base)
        self.prior = np.array(list(model.base.values()))
        self.identified = np.array(list(talus.Model.from_tree(tree).base.values()))
        width = PRIOR_WIDTH if self.joints > 1 else PRIOR_WIDTH_OF_ONE_JOINT
        self.prior_width = np.maximum(width * np.abs(self.prior), np.abs(self.identified - self.prior))
        self.drawn_width = drawn_width(model.base)
        self.is_inertia = np.array([name.startswith("mass") or name.endswith("inertia") for name in model.base])
        no_gravity = not model.has_gravity  # a file's 0 means that there is none
        self.absent = [k for k, name in enumerate(model.base) if no_gravity and name.startswith("gravity")]
        self.velocity_only = not any(name in processed_recordings[0].columns for name in model.sensor("position"))
        self.load_sensor = "joint_load_Nm" in processed_recordings[0].columns
        if self.at_motor:
            self.transmissions = [model.transmission(joint) for joint in range(len(model.joints))]
            self.ankle_rad = [self.transmissions[1].joint_rad(t.columns["ankle_motor_rad"]) for t in processed_recordings]
        self.inertia_kept = 1.0  # share that the sensors leave of it in a fit
        self.channels = [c for record in range(len(processed_recordings)) for c in self._channels(record)]
        self.kinds = sorted({c.kind for c in self.channels})
        self.angle_kinds = [kind for kind in ("E", "K", "F") if kind in self.kinds]
        self.bandwidth = [processed.noise_bandwidth() for processed in processed_recordings]
        self.periods_s = [noise.find_period_s(processed) for processed in processed_recordings]
        self.session_begin_s, self.session_s = session(processed_recordings)
        self.find_sigma()
        self.periodic = any(period is not None for period in self.periods_s)
        self._find_blocks()
        self._find_stretches()
        self._thin()

    # ---- channels ------------------------------------------------------------------

    def _channels(self, record):
        processed = self.processed_recordings[record]
        for joint in range(self.joints):
            yield Channel(record, f"T{joint}", processed.target[joint], self._scored(processed, joint))
        for kind in ("E", "K", "F") if self.at_motor else ():
            raw = self.raw(record, kind)
            if raw is not None:
                yield Channel(record, kind, processed.operate(raw), self._angle_rows(processed, kind))

    def _scored(self, processed, joint):
        """Instants that count. With a sensor at the output the load is known while the joint stands, too: where it hardly
        moves, friction is part of what differs, and all instants count."""
        moving = processed.kind[joint] == SCORED
        if self.load_sensor and moving.sum() < HARDLY_MOVES * (processed.kind[joint] != 0).sum():
            return processed.kind[joint] != 0
        return moving

    @staticmethod
    def _angle_rows(processed, kind):
        """Near the ankle's stops an encoder's step stands still, which is no white noise."""
        return processed.kind[0] != 0 if kind == "K" else processed.kind[1] == SCORED

    def raw(self, record, kind):
        """A channel's reading at the samples; None where the recording lacks it."""
        columns = self.processed_recordings[record].columns
        if kind[0] == "T":
            return self.effort(record, int(kind[1]))
        if kind == "E" and "ankle_joint_rad" in columns:
            return columns["ankle_joint_rad"] - self.ankle_rad[record]
        if kind == "K" and "shank_rad" in columns:
            return columns["shank_rad"] - self.transmissions[0].joint_rad(columns["knee_motor_rad"])
        if kind == "F" and "shank_rad" in columns and "foot_rad" in columns:
            return columns["foot_rad"] - columns["shank_rad"] - self.ankle_rad[record]
        return None

    def effort(self, record, joint):
        """The measured torque or force of a joint at the samples, unfiltered."""
        columns = self.processed_recordings[record].columns
        if self.at_motor:
            name = self.model.joints[joint]
            return columns[f"{name}_current_A"] * self.tree[name]["torque_constant_Nm_A"]
        for name in ("joint_load_Nm", "joint_torque_Nm", "slider_force_N"):
            if name in columns:
                return columns[name]
        return columns["joint_current_A"] * self.drive_gain()

    def drive_gain(self):
        """Joint torque per ampere of a single joint."""
        joint = self.tree["joint"]
        return joint["torque_constant_Nm_A"] * abs(joint.get("transmission", {}).get("ratio", 1.0))

    def with_whole_inertia(self, base):
        """Base parameters of the machine whose inertia the sensors let appear as this one."""
        return np.where(self.is_inertia, np.asarray(base) / max(self.inertia_kept, GIVES_UP), base)

    # ---- noise and blocks ----------------------------------------------------------

    def find_sigma(self, residual=None):
        """Standard deviation of each kind's noise at the samples. `residual(channel)` is what a model leaves of a torque:
        the better the model, the nearer the noise. Without one, noise that is not white is not seen."""
        self.sigma, self.irregular = {}, {}
        for kind in self.kinds:
            mine = [c for c in self.channels if c.kind == kind]
            white = self._pooled([(noise.above_motion(self.raw(c.record, kind)), len(c.rows)) for c in mine])
            repeats = [(s, len(c.rows)) for c in mine if (s := self._repeat_sigma(c)) is not None]
            self.sigma[kind] = max(self._pooled(repeats) if repeats else self._unrepeated_sigma(mine, residual, white), 1e-12)
            self.irregular[kind] = self._irregular(mine, self.sigma[kind] / max(white, 1e-12)) if repeats else 0.0
            if residual and kind[0] == "T":
                self.sigma[kind] = self._none_beyond(self.sigma[kind], mine, residual)
        if "E" in self.sigma:  # quantisation repeats with the motion, so repeats do not show all of it
            self.sigma["E"] = max(self.sigma["E"], *(self._step(record) for record in range(len(self.processed_recordings))))

    def _none_beyond(self, sigma, channels, residual):
        """What a model foretells is no noise: of slow samples what is rough is motion, and noise is at the most what is left."""
        left = self._pooled([(np.sqrt(np.mean(residual(c)[c.rows] ** 2) / self.bandwidth[c.record]), len(c.rows))
                             for c in channels if len(c.rows)])  # fmt: skip
        return max(left, 1e-12) if left < HALF * sigma else sigma

    def _step(self, record):
        """What the steps of both sensors of the ankle do to their difference (RMS)."""
        columns = self.processed_recordings[record].columns
        ratio = np.median(np.abs(self.transmissions[1].ratio(self.ankle_rad[record])))
        steps = noise.quantisation_step(columns["ankle_joint_rad"]), noise.quantisation_step(columns["ankle_motor_rad"]) / ratio
        return np.hypot(*steps) / np.sqrt(12)

    def _irregular(self, channels, ratio):
        """Power over the sensor's of what differs between periods more than from sample to sample, at one frequency or now and
        then. Over a band of frequencies it is noise with a colour, and one joint alone is a machine's, whose noise may have a
        tone."""
        concentrated = self.joints > 1 and max(self._concentration(c) for c in channels) > PART
        return max(ratio**2 - 1.0, 0.0) if concentrated else 0.0

    @staticmethod
    def mask(channel):
        mask = np.zeros(len(channel.values), bool)
        mask[channel.rows] = True
        return mask

    def near_pairs(self, channel):
        """Rows of the grid at which nearly the same state comes back, or None."""
        key = channel.record, channel.kind
        if key not in self._near_pairs:
            self._near_pairs[key] = self._found_near_pairs(channel)
        return self._near_pairs[key]

    def _found_near_pairs(self, channel):
        if len(channel.rows) < noise.FEWEST_REPEATED_ROWS:
            return None
        processed = self.processed_recordings[channel.record]
        rows = channel.rows[::max(1, len(channel.rows) // MOST_STATES)]
        pairs = noise.near_pairs(processed.states(rows), processed.grid_t_s[rows])
        return None if pairs is None else (rows[pairs[0]], rows[pairs[1]])

    @staticmethod
    def _pooled(found):
        """Root mean square of deviations, each of a number of rows."""
        return float(np.sqrt(sum(s * s * n for s, n in found) / max(sum(n for _, n in found), 1)))

    def _concentration(self, channel):
        processed, period_s = self.processed_recordings[channel.record], self.periods_s[channel.record]
        return 0.0 if period_s is None else noise.concentration(processed, channel.values, self.mask(channel), period_s)

    def _repeat_sigma(self, channel):
        processed, period_s = self.processed_recordings[channel.record], self.periods_s[channel.record]
        if period_s is None:
            return None
        found = noise.repeat_deviation(processed, channel.values, self.mask(channel), period_s)
        return None if found is None else found / np.sqrt(self.bandwidth[channel.record])

    def _unrepeated_sigma(self, channels, residual, white):
        """Where nothing repeats: what lies above the motion is white noise, what differs between nearly the same states also holds
        coloured noise. The pairs of all recordings are taken together, for all have the same sensor: where one recording's states
        are sparse, another tells."""
        if residual is None or channels[0].kind[0] != "T":
            return white
        both = [(c, pairs) for c in channels if (pairs := self.near_pairs(c)) is not None]
        if not both:
            return white
        change = [self._steady_change(c, residual(c), np.array(pairs)) / np.sqrt(self.bandwidth[c.record]) for c, pairs in both]
        return max(white, noise.pair_deviation(np.concatenate(change)))

    def _steady_change(self, channel, residual, pairs):
        """What a model leaves at pairs of instants with nearly the same state, less the one's from the other's, and friction's drift."""
        t_s, direction = self.processed_recordings[channel.record].grid_t_s, irregular.of_motion(self, channel)
        return noise.steady(residual[pairs[1]] - residual[pairs[0]], t_s[pairs], direction[pairs])

    def _find_blocks(self):
        """Block of every grid instant: whole periods, or about the wanted length."""
        wanted_s = noise.block_length_s(sum(t.grid_t_s[-1] - t.grid_t_s[0] for t in self.processed_recordings), self.joints)
        self.block_of, self.block_record = [], []
        for record, processed in enumerate(self.processed_recordings):
            period_s = self.periods_s[record]
            length_s = wanted_s if period_s is None else max(1, round(wanted_s / period_s)) * period_s
            t = processed.grid_t_s - processed.grid_t_s[0]
            count = max(2, round(t[-1] / length_s))
            number = np.minimum((t / t[-1] * count).astype(int), count - 1)
            self.block_of.append(number + len(self.block_record))
            self.block_record += [record] * count
        self.blocks, self.block_record = len(self.block_record), np.array(self.block_record)
        self.folds = np.arange(self.blocks) % FOLDS
        self.fold_count = len(np.unique(self.folds))

    def _find_stretches(self):
        """Stretch of the motion of every grid instant: a fortieth of its time, or of the period where it repeats. What a model lacks of
        one comes back with it in every period, and is one error, not many."""
        self.stretch_of, self.stretches = [], 0
        for processed, period_s in zip(self.processed_recordings, self.periods_s, strict=True):
            t = processed.grid_t_s - processed.grid_t_s[0]
            whole_s = t[-1] if period_s is None else min(period_s, t[-1])
            count = max(min(STRETCHES, int(whole_s / SHORTEST_STRETCH_S)), 1)
            self.stretch_of.append(self.stretches + (t % whole_s / whole_s * count).astype(int))
            self.stretches += count

    def _thin(self):
        """Rows that lie closer than the low-pass can tell apart say nothing new; and of very long recordings a part will do."""
        fastest_Hz = max(processed.recording.score.lowpass_hz for processed in self.processed_recordings)
        step_s = min(processed.step_s for processed in self.processed_recordings)
        most = max(sum(len(c.rows) for c in self.channels if c.kind == kind) for kind in self.kinds)
        self.thin = max(1, int(1 / (ROWS_PER_PERIOD * fastest_Hz * step_s)), -(-most // MOST_ROWS))
        for channel in self.channels:
            channel.thinned = channel.rows[channel.rows % self.thin == 0]

    # ---- rows ----------------------------------------------------------------------

    def base_columns(self, channel, rows=None):
        """Regressor of a channel's rows (or some): the base parameters, then a zero for each kind of angle."""
        rows = channel.rows if rows is None else rows
        out = np.zeros((len(rows), self.bases + len(self.angle_kinds)))
        if channel.kind[0] == "T":
            processed, joint = self.processed_recordings[channel.record], int(channel.kind[1])
            out[:, processed.index[joint]] = processed.x[joint][rows]
            out[:, self.absent] = 0
        else:
            out[:, self.bases + self.angle_kinds.index(channel.kind)] = 1
        return out

    def kinds_at(self, joint):
        """The channels that an effect at a joint shows in first."""
        own = {"ankle": ("T1", "E", "F"), "knee": ("T0", "K")}.get(joint, self.kinds) if self.at_motor else self.kinds
        return [kind for kind in self.kinds if kind in own]

    def scopes_at(self, joint):
        """All channels, those at a joint, and its torque alone: what something leaves elsewhere says nothing about what acts there."""
        own = self.kinds_at(joint)
        return self.kinds, own, [kind for kind in own if kind[0] == "T"]

    def repeats(self):
        """How many times the motion of the recordings is repeated, on the average over their rows; 1 where none is."""
        times = [1.0 if period_s is None else max((one.grid_t_s[-1] - one.grid_t_s[0]) / period_s, 1.0)
                 for one, period_s in zip(self.processed_recordings, self.periods_s)]
        return float(np.average(times, weights=[len(one.grid_t_s) for one in self.processed_recordings]))

    def freedom(self, kind=None):
        """Degrees of freedom of the noise over all rows, or those of one kind."""
        return float(sum(self.thin * len(c.thinned) * self.bandwidth[c.record] for c in self.channels
                         if kind in (None, c.kind)))  # fmt: skip
