"""What the commands do, from Python: read, simulate, diagnose.

    model, recording = talus.read("arm.yaml"), talus.read("arm.csv")
    diagnosis = talus.diagnose(model, [recording])
    print(diagnosis)                  # what talus-gap says
    diagnosis.verdict["effect"], diagnosis.model, diagnosis.write("gap.json")
"""

from __future__ import annotations

import json
import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy

from . import _drawing, outputs
from ._arrays import Array
from ._library import BUILD, InputError
from .model import Model
from .own_effect import Effect
from .recording import Recording
from .scoring import Panel

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

YAML = (".yaml", ".yml")


def read(path: str | Path) -> Model | Recording:
    """The model of a YAML file, the recording of any other, by the programs' readers. InputError names file and line of what is
    wrong.

    >>> talus.read("models/pendulum.yaml").plant
    'pendulum'
    """
    return (Model if Path(path).suffix in YAML else Recording).read(path)


def simulate(model: Model, *, seed: int = 1, duration_s: float | None = None, rate_hz: float | None = None, **options: Any) -> Recording:
    """A bench recording of the model's plant, as talus-sim makes it: friction that sticks, position control, sensors. `options`
    are talus-sim's, `_` for `-`; True for one without a value. InputError where talus-sim refuses them.

    >>> recording = talus.simulate(talus.read("models/pendulum.yaml"), duration_s=20, ideal=True)
    >>> len(recording.t), sorted(recording.columns)
    (5000, ['joint_current_A', 'joint_rad', 'time_s'])
    """
    options |= {"seed": seed, "duration": duration_s, "rate": rate_hz}
    given = [[f"--{name.replace('_', '-')}", *([] if value is True else [str(value)])]
             for name, value in options.items() if value is not None and value is not False]  # fmt: skip
    with tempfile.TemporaryDirectory(prefix="talus-") as folder:
        truth, out = Path(folder) / "model.yaml", Path(folder) / "recording.csv"
        model.write(truth)
        command = [str(BUILD / "bin" / "talus-sim"), "--model", str(truth), "--out", str(out), *(word for part in given for word in part)]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
        if done.returncode:
            said = done.stderr.strip().replace(f"{folder}/", "").removeprefix("talus-sim: ")
            raise (InputError if done.returncode == 2 else OSError)(said)
        return Recording.read(out, model=model)


@dataclass(frozen=True)
class Diagnosis:
    """What talus-gap finds. `report` is GAP.json (docs/talus-gap.md), `model_text` the extended model's file, `words` what
    talus-gap says, `trajectory` the next experiment's CSV or None. `panels` hold the arrays behind `gap`, one Panel a recording
    and joint: measured, and predicted by the model as given (`nominal`), identified, and with the effects that were found
    (`extended`, the same as identified where there are none), every block by a fit that has not seen it; none while a grave
    finding withholds the diagnosis. `notes` say what `model_text` does not hold. Diagnoses compare and pickle. The examples go on
    from that of `diagnose`.

    >>> found.verdict["effect"], [effect["effect"] for effect in found.effects], found.findings
    ('stribeck', ['stribeck'], [])
    >>> found.gap["joint"]["extended_rms"] < found.gap["joint"]["identified_rms"]
    True
    """

    report: dict[str, Any]
    model_text: str
    words: str
    trajectory: str | None = None
    panels: list[Panel] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def __str__(self) -> str:
        return "\n".join([*(f"note: {note}" for note in self.notes), self.words])

    def __repr__(self) -> str:
        verdict = self.report["verdict"]
        return f"<talus.Diagnosis: {verdict['effect']} at {verdict['joint']}, probability {verdict['probability']:.2f}>"

    @property
    def verdict(self) -> dict[str, Any]:
        """effect, joint and probability of what is most probable."""
        return dict(self.report["verdict"])

    @property
    def effects(self) -> list[dict[str, Any]]:
        """What was added to the model, each with its parameters."""
        return list(self.report["effects"])

    @property
    def gap(self) -> dict[str, dict[str, Any]]:
        """By joint: the errors as given, identified and with effects, and the noise."""
        return dict(self.report["gap"])

    @property
    def findings(self) -> list[dict[str, Any]]:
        """What makes the recordings doubtful, worst first."""
        return list(self.report["findings"])

    @property
    def model(self) -> Model:
        """The identified model with the effects that were found."""
        return Model.from_text(self.model_text)

    def write(self, path: str | Path) -> None:
        """GAP.json, whole or not at all.

        >>> found.write("gap.json")
        >>> import json
        >>> json.load(open("gap.json"))["verdict"] == found.verdict
        True
        """
        outputs.write_text(path, json.dumps(self.report, indent=1, allow_nan=False) + "\n")

    def to_pandas(self) -> DataFrame:
        """All panels as one data frame: columns recording, joint, time_s, measured, nominal, identified, extended, scored. For the
        effects: pandas.DataFrame(diagnosis.effects). ImportError where pandas is missing.

        >>> list(found.to_pandas())
        ['recording', 'joint', 'time_s', 'measured', 'nominal', 'identified', 'extended', 'scored']
        """
        return _drawing.joined(panel.to_pandas() for panel in self.panels)

    def plot(self) -> Figure:
        """A figure with one row a joint: its errors as given, identified and with effects beside the noise, and over time what is
        left of the first recording's torque. ImportError where matplotlib is missing.

        >>> found.plot().savefig("gap.png")
        """
        figure, plots = _drawing.axes(max(len(self.gap), 1), 2)
        for row, (joint, gap) in zip(plots, self.gap.items(), strict=False):  # no joint has a gap where nothing moved
            bars = {name: gap[f"{name}_rms"] for name in ("nominal", "identified", "extended", "noise_floor")}
            row[0].barh(list(bars), list(bars.values()), color=[_drawing.COLOURS[name.removesuffix("_floor")] for name in bars])
            row[0].set_xlabel(f"{joint}: RMS error [{gap['unit']}]")
            row[0].invert_yaxis()
            panel = next((panel for panel in self.panels if panel.joint == joint), None)
            if panel:
                shown = {name: panel.residual(name) for name in ("identified", "extended")}
                _drawing.lines(row[1], panel.t, shown, f"residual [{gap['unit']}]")
                row[1].set_xlabel(f"{panel.recording}: time [s]")
        figure.suptitle(self.words.split("\n")[0], fontsize="small", wrap=True)
        return figure


def diagnose(model: Model | str | Path, recordings: Recording | str | Path | Iterable[Recording | str | Path], *, seed: int = 1,
             effects: Iterable[Effect] = (), camera_zero_rad: float | None = None) -> Diagnosis:
    """Where the gap between a model and its recordings lies, which effect causes it and how far it shrinks: talus-gap's own
    code and figures. Models and recordings are objects or names of files; InputError as talus-gap refuses them. `effects` of one's
    own are tried beside the catalogue's (see Effect). `camera_zero_rad`: how well the camera's zero is known against the bench
    (standard deviation); then it tells a bench that leans from an encoder's zero (`source` of gravity_tilt).

    >>> model = talus.read("models/pendulum.yaml")
    >>> truth = talus.Model.from_text(model.text() + "effects: [{effect: stribeck, joint: joint, "
    ...                               "parameters: {extra_Nm: 0.3, speed_rad_s: 0.2, exponent: 1}}]")
    >>> found = talus.diagnose(model, talus.simulate(truth, duration_s=40))
    >>> found.verdict["effect"], found.gap["joint"]["unit"], found.panels[0].joint
    ('stribeck', 'Nm', 'joint')
    """
    from .diagnosis import command, fitted, report  # SciPy takes its time to load

    many = [recordings] if isinstance(recordings, (Recording, str, Path)) else list(recordings)
    with tempfile.TemporaryDirectory(prefix="talus-") as folder:
        names = [_file(folder, f"recording-{i}.csv", one) for i, one in enumerate(many, 1)]
        arguments = ["--model", _file(folder, "model.yaml", model), "--report", f"{folder}/gap.json", "--seed", str(seed), "--quiet",
                     *([] if camera_zero_rad is None else ["--camera-zero", str(camera_zero_rad)]), "--", *names]  # fmt: skip
        try:
            options = command.Options(arguments)
            options.check()
            found, tree, identified = command.diagnose(options, lambda *_: None, effects)
            text, notes = fitted.model_text(tree, identified, found)
        except command.Refused as refused:
            raise (InputError if refused.status == 2 else OSError)(refused.text.replace(f"{folder}/", "")) from None
        plain = json.loads(report.to_text(found.report).replace(f"{folder}/", ""))
        panels = [panel for record in range(_records(found)) for panel in _panels(found, record, f"{folder}/")]
        return Diagnosis(plain, text, "\n".join(command.summary(plain)), found.trajectory, panels, notes)


def _file(folder: str, name: str, given: Model | Recording | str | Path) -> str:
    """The name of a file that holds it."""
    if isinstance(given, (str, Path)):
        return str(given)
    given.write(Path(folder) / name)
    return str(Path(folder) / name)


def _records(found: Any) -> int:
    """The recordings, or stretches of such, that a diagnosis has residuals of."""
    return len(found.search.dataset.processed_recordings) if found.search else 0


def _panels(found: Any, record: int, folder: str) -> Iterable[Panel]:
    """A Panel for each joint of one recording, from the residuals that GAP.json's figures are made of."""
    from .diagnosis.figures import given_residuals

    dataset = found.search.dataset
    processed = dataset.processed_recordings[record]
    ends = numpy.cumsum([part["n"] for part in processed.parts])
    for j, joint in enumerate(dataset.model.joints):
        (channel,) = (c for c in dataset.channels if c.record == record and c.kind == f"T{j}")
        left = {"nominal": given_residuals(dataset, record, j), "identified": found.before.of[record, channel.kind],
                "extended": found.after.of[record, channel.kind]}  # fmt: skip
        measured = processed.measured[j]
        predicted = {name: _parted(measured - residual, ends) for name, residual in left.items()}
        scored = numpy.isin(numpy.arange(len(measured)), channel.rows)
        yield Panel(joint, numpy.insert(processed.grid_t_s, ends, processed.grid_t_s[ends - 1]), _parted(measured, ends), predicted,
                    numpy.insert(scored, ends, False), dataset.model.torque_unit, processed.name.replace(folder, ""))  # fmt: skip


def _parted(values: Array, ends: Array) -> Array:
    """NaN behind each segment, so that no line is drawn over what was not recorded."""
    return numpy.insert(numpy.asarray(values, dtype=float), ends, numpy.nan)
