"""Effects found on one recording of a real machine, on its other recordings: whatever the diagnosis found, the machine had it there, too."""

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

import yaml

from ..blind.running import BUILD, quiet
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
    drawn = [Source(machine, path, tuple(other for other in paths if other != path))
             for machine, paths in of_machine.items() for path in paths if len(paths) > 1]  # fmt: skip
    if not drawn:
        raise OSError(f"{data}: no two recordings of one machine here (TALUS_DATA names the folder)")
    return drawn


def error_percent(model, recording, folder):
    """What a model's prediction leaves of a recording's torque."""
    quiet(BUILD / "bin" / "talus-predict", "--model", model, "--report", folder / "error.json", recording)
    (joint,) = json.loads((folder / "error.json").read_text())["error"].values()
    return joint["relative_percent"]


def identified(text, recording, out):
    """The model file of parameters identified on a recording, beside the effects of a model file's text."""
    given = out.with_name(f"given-{out.name}")
    given.write_text(text, encoding="utf-8")
    quiet(BUILD / "bin" / "talus-identify", "--quiet", "--model", given, "--out", out, "--report", out.with_suffix(".json"), recording)
    return out


def with_effects(text, found):
    """A model file's text with another one's effects."""
    effects = yaml.safe_load(found.read_text(encoding="utf-8")).get("effects")
    return text + (yaml.safe_dump({"effects": effects}, default_flow_style=None, width=1000) if effects else "")


def errors(plain, found, other, folder):
    """Of another recording: by all that was identified on the first one, without (`plain`) and with its effects (`found`); and by parameters
    that are identified on the other one itself, without and with the effects of the first one, as they were found there."""
    text = model_text(other)
    anew = identified(text, other, folder / "anew.yaml")
    beside = identified(with_effects(text, found), other, folder / "beside.yaml")
    models = {"plain": plain, "effects": found, "plain_anew": anew, "effects_anew": beside}
    return {"recording": other.stem, **{name: error_percent(model, other, folder) for name, model in models.items()}}


def diagnose(case):
    """A recording's diagnosis, and the errors on the others; none where there is no report."""
    with tempfile.TemporaryDirectory(prefix="across-") as temporary:
        folder, text = Path(temporary), model_text(case.path)
        plain, saved = identified(text, case.path, folder / "plain.yaml"), folder / "found.yaml"
        found = running.diagnosed(folder / "given-plain.yaml", case.path, folder, "--save-model", saved)
        others = [errors(plain, saved, other, folder) for other in case.others] if found["report"] else []
        return {"setting": {"machine": case.machine}, **found, "others": others}
