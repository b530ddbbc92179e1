"""One recording under one model: its motion, its regressor, and the operator that every column passes through.

The operator is that of the score: what is known at the recording's samples is bridged over the joint's stops,
put on an even grid and low-passed, so that a candidate's column meets the measured torque like for like.
"""

import numpy as np

import talus
from talus import ffi, lib, pointer


class ProcessedRecording:
    """One recording. Arrays at the recording's samples have n columns, arrays on the grid one entry an instant."""

    MOTION = ("q", "v", "a", "slip", "speed")

    def __init__(self, model, recording, name="", window_hz=None):
        self.name, self.model, self.recording = name, model, recording
        self.columns, self.t_s, self.step_s = recording.columns, recording.t, recording.step_s
        self.joints = len(model.joints)
        self.window_hz = window_hz
        self.regression = talus.Regression(model, recording, window_hz=window_hz)
        n = len(self.t_s)
        self.q, self.v, self.a, self.slip, self.speed = (np.zeros((self.joints, n)) for _ in self.MOTION)
        self.parts = []
        for begin, end in recording.segments():
            if self.t_s[end - 1] - self.t_s[begin] >= 3 * recording.score.trim_s:
                self._add_part(begin, end)
        if self.parts:
            self._gather()

    def _add_part(self, begin, end):
        space, alive = self.regression._segment(begin, end)
        for name in self.MOTION:
            for joint in range(self.joints):
                values = ffi.buffer(getattr(space.track, name)[joint], 8 * (end - begin))
                getattr(self, name)[joint, begin:end] = np.frombuffer(values)
        rows = [self.regression._copy_rows(space.rows[joint]) for joint in range(self.joints)]
        stops = [self._stops(space, joint) for joint in range(self.joints)]
        self.parts.append({"begin": begin, "end": end, "stops": stops, "rows": rows, "n": len(rows[0].t), "begin_s": rows[0].t[0]})
        del alive

    @staticmethod
    def _stops(space, joint):
        """A joint's stops as the library has them, rows within the segment."""
        return ffi.new("tl_stop[]", [space.track.stop[joint][k] for k in range(space.track.stops[joint])])

    def _gather(self):
        def joined(joint, field):
            return np.concatenate([getattr(part["rows"][joint], field) for part in self.parts])

        self.inside = np.zeros(len(self.t_s), bool)
        for part in self.parts:
            self.inside[part["begin"]:part["end"]] = True
        self.grid_t_s = joined(0, "t")
        every = range(self.joints)
        self.kind = [joined(j, "kind") for j in every]
        self.x = [joined(j, "x") for j in every]
        self.target = [joined(j, "target") for j in every]
        self.measured = [joined(j, "measured") for j in every]
        self.index = [self.parts[0]["rows"][j].index for j in every]
        for part in self.parts:
            del part["rows"]  # gathered: a second copy of them would be as large as all else

    def bridge(self, samples, joint):
        """In a short stop friction and inertia jump against each other and only their sum is smooth: the values there
        are told by those beside it, as in the regressor. A recorded velocity runs on through stops."""
        out = np.array(samples, float)
        if self.regression.struct.layout.position[joint] == lib.TL_CHANNEL_COUNT:
            return out
        for part in self.parts:
            stops, begin, end = part["stops"][joint], part["begin"], part["end"]
            lib.tl_bridge_stops(stops, len(stops), pointer(self.t_s) + begin, end - begin, pointer(out) + begin)
        return out

    def resample(self, samples):
        """Samples -> even grid, segment by segment."""
        samples, out = np.ascontiguousarray(samples, dtype=float), []
        for part in self.parts:
            b, e, values = part["begin"], part["end"], np.empty(part["n"])
            lib.tl_grid_resample(pointer(self.t_s) + b, pointer(samples) + b, e - b, part["begin_s"], self.step_s,
                                 pointer(values), part["n"])  # fmt: skip
            out.append(values)
        return np.concatenate(out)

    def lowpass(self, grid):
        """The score's zero-phase filter on the grid, segment by segment."""
        out, begin = np.array(grid, float), 0
        for part in self.parts:
            piece = np.ascontiguousarray(out[begin:begin + part["n"]])
            lib.tl_lowpass_zero_phase(ffi.addressof(self.regression.struct, "lowpass"), pointer(piece), part["n"])
            out[begin:begin + part["n"]] = piece
            begin += part["n"]
        return out

    def operate(self, samples, joint=None):
        """Samples -> grid, filtered; bridged over the stops of `joint` if it is given."""
        return self.lowpass(self.resample(samples if joint is None else self.bridge(samples, joint)))

    def states(self, rows):
        """What the torque depends on, at some instants of the grid: angles (where recorded), speeds, accelerations, and
        with a sensor at the output the drive's current."""
        seen = [] if "joint_velocity_rad_s" in self.columns and "joint_rad" not in self.columns else list(self.q)
        seen += [*self.v, *(self.bridge(self.a[j], j) for j in range(self.joints))]
        if "joint_load_Nm" in self.columns:
            seen.append(self.columns["joint_current_A"])
        return np.array([self.resample(x)[rows] for x in seen]).T

    def noise_bandwidth(self):
        """Variance that the operator leaves of unit white noise at the samples."""
        white = np.random.default_rng(0).standard_normal(len(self.t_s))
        return float(np.mean(self.operate(white) ** 2))
