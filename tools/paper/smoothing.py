"""The paper's smoothing as it prints it: one window that slides over everything, reversals too.

`talus-identify --window 20,1` does the same; here it is done beside the programs, as a check of them.
"""

import numpy

from talus import check, constants, ffi, lib, pointer

from . import published
from .bench import JOINTS
from .scoring import on_grid


class Smoothed:
    """One recording's regression rows from windows across reversals; stands where slips.Prepared does.

    `prepared` is the same recording as the library reads it: its grid, filter, target and scored rows are
    used, so that nothing differs but the motion.
    """

    def __init__(self, model, prepared, window=published.WINDOW):
        self.base, self.prepared = prepared.base, prepared
        motion = [_joint_motion(model, prepared.recording, joint, window) for joint in range(len(JOINTS))]
        self.raw, self.known = _regressor(model, motion)

    def rows(self, slips=()):
        """Scored rows: for each joint (X, y)."""
        assert not slips
        recording, out = self.prepared.recording, []
        lowpass = ffi.addressof(self.prepared.regression.struct, "lowpass")
        for joint, part in enumerate(self.prepared.parts):
            scored = part.kind == lib.TL_ROW_SCORED

            def on_rows(values, part=part, scored=scored):
                return on_grid(recording.t, values, part.t, recording.step_s, lowpass)[scored]

            x = numpy.column_stack([on_rows(column) for column in self.raw[joint].T])
            out.append((x, part.measured[scored] - on_rows(self.known[joint])))
        return out


def _joint_motion(model, recording, joint, window):
    """Angle, speed and acceleration of a joint from its motor's angle: (3, n)."""
    motor, n = numpy.empty((3, len(recording.t))), len(recording.t)
    settings = ffi.new("tl_window *", window)
    work = numpy.empty(lib.tl_reconstruct_workspace(int(2 * window[1] / recording.step_s)))
    angle = recording.columns[f"{JOINTS[joint]}_motor_rad"]
    check(lib.tl_reconstruct(settings, pointer(recording.t), pointer(angle), n, *map(pointer, motor),
                             pointer(work), len(work)))  # fmt: skip
    transmission = ffi.addressof(model.struct.drive[joint], "transmission")
    out = numpy.empty((n, 3))
    for i, one in enumerate(numpy.ascontiguousarray(motor.T)):
        lib.tl_transmission_joint_motion(transmission, pointer(one), pointer(out[i]))
    return out.T


def _regressor(model, motion):
    """The regressor at every sample: for each joint (n, base), and the known torques (joints, n)."""
    n, most = motion[0].shape[1], constants.TL_MAX_ROW
    raw, known = numpy.zeros((len(JOINTS), n, len(model.base))), numpy.empty((n, len(JOINTS)))
    now, row, index = ffi.new("tl_motion *"), numpy.empty(len(JOINTS) * most), ffi.new("int[]", most)
    columns = []
    for j in range(len(JOINTS)):
        count = lib.tl_row_index(model.struct, j, index)
        columns.append(list(index)[:count])
    for i in range(n):
        for j in range(len(JOINTS)):
            now.q[j], now.v[j], now.a[j] = motion[j][:, i]
        lib.tl_slip_from_velocity(model.struct, now)
        lib.tl_regressor(model.struct, now, pointer(row), pointer(known[i]))
        for j, of in enumerate(columns):
            raw[j, i, of] = row[j * most : j * most + len(of)]
    return raw, known.T
