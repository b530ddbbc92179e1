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
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import outputs
from ._library import BUILD, InputError
from .model import Model
from .recording import Recording

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
    talus-gap says, `trajectory` the next experiment's CSV or None. Diagnoses compare and pickle."""

    report: dict[str, Any]
    model_text: str
    words: str
    trajectory: str | None = None

    def __str__(self) -> str:
        return self.words

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
        """GAP.json, whole or not at all."""
        outputs.write_text(path, json.dumps(self.report, indent=1, allow_nan=False) + "\n")


def diagnose(model: Model | str | Path, recordings: Recording | str | Path | Iterable[Recording | str | Path], *, seed: int = 1) -> Diagnosis:
    """Where the gap between a model and its recordings lies, which effect causes it and how far it shrinks: talus-gap's own
    code and figures. Models and recordings are objects or names of files; InputError as talus-gap refuses them.

    >>> model = talus.read("models/pendulum.yaml")
    >>> truth = talus.Model.from_text(model.text() + "effects: [{effect: stribeck, joint: joint, "
    ...                               "parameters: {extra_Nm: 0.3, speed_rad_s: 0.2, exponent: 1}}]")
    >>> talus.diagnose(model, talus.simulate(truth, duration_s=40)).verdict["effect"]
    'stribeck'
    """
    from .diagnosis import command, fitted, report  # SciPy takes its time to load

    many = [recordings] if isinstance(recordings, (Recording, str, Path)) else list(recordings)
    with tempfile.TemporaryDirectory(prefix="talus-") as folder:
        names = [_file(folder, f"recording-{i}.csv", one) for i, one in enumerate(many, 1)]
        arguments = ["--model", _file(folder, "model.yaml", model), "--report", f"{folder}/gap.json", "--seed", str(seed), "--quiet", "--", *names]
        try:
            options = command.Options(arguments)
            options.check()
            found, tree, identified = command.diagnose(options, lambda _: None)
            text, _notes = fitted.model_text(tree, identified, found)
        except command.Refused as refused:
            raise (InputError if refused.status == 2 else OSError)(refused.text.replace(f"{folder}/", "")) from None
        plain = json.loads(report.to_text(found.report).replace(f"{folder}/", ""))
        return Diagnosis(plain, text, "\n".join(command.summary(plain)), found.trajectory)


def _file(folder: str, name: str, given: Model | Recording | str | Path) -> str:
    """The name of a file that holds it."""
    if isinstance(given, (str, Path)):
        return str(given)
    given.write(Path(folder) / name)
    return str(Path(folder) / name)
