"""Effects found on one recording of a real machine, on its other recordings: whatever the diagnosis found, the machine had it there, too."""

import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import yaml

from . import running
from .machine import model_text, recordings

# Recordings of one machine under one protocol begin so.
MACHINES = ("ak80_A", "ak80_B", "ak80_ripple", "embir_gainday", "embir_geared", "embir_stall", "embir_velstair", "emps")
# Between these something is not the same, as the sets' READMEs say: a sensor's gain, and where the angle of a ripple begins.
NOT_THE_SAME = ("ak80_ripple", "embir_gainday")


@dataclass(frozen=True)
class Source:
    """A recording that is diagnosed, and the others of its machine."""

    machine: str
    path: Path
    others: tuple

    @property
    def name(self):
        return self.path.stem


def draw(data):
    """Every recording that has others of its machine, by name."""
    of_machine = {machine: [path for path in recordings(data) if path.stem.startswith(machine)] for machine in MACHINES}
    return [Source(machine, path, tuple(other for other in paths if other != path))
            for machine, paths in of_machine.items() for path in paths if len(paths) > 1]  # fmt: skip


def program(name, *arguments):
    """Runs one of the project's programs."""
    subprocess.run([running.BUILD / "bin" / name, *map(str, arguments)], check=True, capture_output=True)


def error_percent(model, recording, folder):
    """What a model's prediction leaves of a recording's torque."""
    program("talus-predict", "--model", model, "--report", folder / "error.json", recording)
    (joint,) = json.loads((folder / "error.json").read_text())["error"].values()
    return joint["relative_percent"]


def identified(model, recording, folder):
    """The model file of parameters identified on a recording, beside the effects that the given one has."""
    program("talus-identify", "--quiet", "--model", model, "--out", folder / "identified.yaml", "--report", folder / "identified.json", recording)
    return folder / "identified.yaml"


def with_effects(text, found):
    """A model file's text with another one's effects."""
    effects = yaml.safe_load(found.read_text(encoding="utf-8")).get("effects")
    return text + (yaml.safe_dump({"effects": effects}, default_flow_style=None, width=1000) if effects else "")


def errors(case, other, folder):
    """Of another recording: by all that was identified on the first one, without and with its effects; and by parameters that are
    identified on the other one itself, without and with the effects of the first one, as they were found there."""
    own, anew, beside = folder / "own.yaml", folder / "anew.yaml", folder / "beside.yaml"
    own.write_text(model_text(case.path), encoding="utf-8")
    anew.write_text(model_text(other), encoding="utf-8")
    beside.write_text(with_effects(model_text(other), folder / "found.yaml"), encoding="utf-8")
    return {"recording": other.stem, "plain": error_percent(identified(own, case.path, folder), other, folder),
            "effects": error_percent(folder / "found.yaml", other, folder),
            "plain_anew": error_percent(identified(anew, other, folder), other, folder),
            "effects_anew": error_percent(identified(beside, other, folder), other, folder)}  # fmt: skip


def diagnose(case):
    """A recording's diagnosis, and the errors on the others."""
    with tempfile.TemporaryDirectory(prefix="across-") as temporary:
        folder = Path(temporary)
        (folder / "model.yaml").write_text(model_text(case.path), encoding="utf-8")
        found = running.diagnosed(folder / "model.yaml", case.path, folder, "--save-model", folder / "found.yaml")
        others = [errors(case, other, folder) for other in case.others] if found["report"] else []
        return {"setting": {"machine": case.machine}, **found, "others": others}
