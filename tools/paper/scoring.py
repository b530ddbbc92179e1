"""The programs run on files, and what they predict is scored as every command scores it."""

import json
import os
import subprocess
from pathlib import Path

import numpy
import yaml

from talus import Recording, Regression, check, ffi, lib, pointer

from .bench import JOINTS

BUILD = Path(os.environ.get("TALUS_BUILD") or Path(__file__).resolve().parents[2] / "build")


def program(name, *arguments):
    """Runs build/bin/NAME; what it says for people is shown only when it fails."""
    done = subprocess.run(
        [str(BUILD / "bin" / name), *map(str, arguments)], check=False, capture_output=True, text=True
    )
    if done.returncode:
        raise RuntimeError(f"{name} ended with status {done.returncode}: {done.stderr.strip()}")


def write_model(tree, path):
    path.write_text(yaml.safe_dump(tree, sort_keys=False, default_flow_style=None), encoding="utf-8")
    return path


def identify(model, recordings, out, *options):
    """talus-identify: its report (JSON); the model is left at `out`."""
    report = out.with_suffix(".json")
    program(
        "talus-identify", "--quiet", "--model", model, "--out", out, "--report", report, *options, *recordings
    )
    return json.loads(report.read_text(encoding="utf-8"))


def predict(model, recording, out):
    """talus-predict: motor torque [Nm], (joints, n)."""
    program("talus-predict", "--model", model, "--out", out, recording)
    table = numpy.loadtxt(out, delimiter=",", skiprows=1)
    return numpy.ascontiguousarray(table[:, 1 : 1 + len(JOINTS)].T)


class Unseen:
    """A recording to be predicted: its measured torque, what of it is scored, and a prediction's score."""

    def __init__(self, columns, model):
        self.recording = Recording(columns)
        self.t = self.recording.t
        self.motion = Regression(model, self.recording).motion()
        self.measured = numpy.array(
            [
                model.struct.drive[j].torque_constant_Nm_A * columns[f"{name}_current_A"]
                for j, name in enumerate(JOINTS)
            ]
        )

    def score(self, predicted):
        """RMS of the scored error and of the torque [Nm], for each joint."""
        out, n = {}, len(self.t)
        work, result = numpy.empty(lib.tl_score_workspace(n)), ffi.new("tl_score_result *")
        for j, name in enumerate(JOINTS):
            rows = [numpy.ascontiguousarray(x[j]) for x in (self.measured, predicted, self.motion["speed"])]
            check(lib.tl_score(self.recording.score, pointer(self.t), ffi.NULL, *map(pointer, rows), n,
                               pointer(work), len(work), result))  # fmt: skip
            out[name] = {"rms_Nm": result.residual_rms, "measured_rms_Nm": result.measured_rms,
                         "relative_percent": result.relative_percent, "reversal_rms_Nm": result.reversal_rms,
                         "scored": result.scored, "left_out": result.left_out}  # fmt: skip
        return out

    def filtered(self, torque):
        """Torque on the even grid after the score's low-pass: (joints, m), as it is scored."""
        low = ffi.new("tl_lowpass *")
        settings, step = self.recording.score, self.recording.step_s
        check(lib.tl_lowpass_init(low, settings.order, settings.lowpass_hz, step))
        return numpy.array([on_grid(self.t, row, self.grid(), step, low) for row in torque])

    def grid(self):
        """The even grid's instants."""
        step = self.recording.step_s
        return self.t[0] + step * numpy.arange(lib.tl_grid_count(self.t[0], self.t[-1], step))

    def kept(self):
        """Which instants of the grid are scored: (joints, m)."""
        grid, step = self.grid(), self.recording.step_s
        keep = numpy.zeros((len(JOINTS), len(grid)), dtype=numpy.uint8)
        for j in range(len(JOINTS)):
            speed = numpy.interp(grid, self.t, self.motion["speed"][j])
            lib.tl_score_keep(self.recording.score, pointer(speed), len(grid), step, pointer(keep[j]))
        return keep.astype(bool)


def on_grid(t, values, grid, step, lowpass):
    """`values` at the instants t, on the even grid, through the low-pass."""
    out = numpy.empty(len(grid))
    values = numpy.ascontiguousarray(values, dtype=float)
    lib.tl_grid_resample(pointer(t), pointer(values), len(t), grid[0], step, pointer(out), len(grid))
    lib.tl_lowpass_zero_phase(lowpass, pointer(out), len(out))
    return out
