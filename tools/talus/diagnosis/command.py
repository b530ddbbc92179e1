"""talus-gap: the command line."""

import contextlib
import functools
import json
import os
import subprocess
import tempfile
from pathlib import Path

import yaml

import talus
from talus import command_line, outputs
from talus.progress import Stages, say
from talus.refused import Refused

from . import experiment, fitted, gate, picture, report, tilt_source, words
from .calibration import lowpass
from .calibration.longer_windows import hidden_by_readings, look_again
from .catalogue.own import entries
from .effects import EFFECTS
from .gate import excerpt
from .outside import OUTSIDE
from .search import search
from .verdict import judge

NAME = "talus-gap"
USAGE = """\
usage: talus-gap --model M.yaml --report GAP.json [OPTION...] REC.csv...

    talus-gap --model leg.yaml --report gap.json --html gap.html run.csv
    talus-gap --model leg.yaml --report gap.json --save-model fitted.yaml run1.csv run2.csv

says where the gap between a model and its recordings lies, which effect causes it and how far it shrinks

  -m, --model M.yaml           the model to start from
  -r, --report GAP.json        the diagnosis, for machines
      --html GAP.html          the diagnosis as a page
      --save-model FITTED.yaml the identified model, extended by the effects that were found
      --trajectory NEXT.csv    the next experiment's trajectory (default: beside GAP.json, GAP.next.csv)
      --lowpass HZ             of rows, figures and identification (default: the model file's score:, else the fastest at
                               which the sensors leave the inertia alone)
      --camera-zero RAD        how well the camera's zero is known against the bench (standard deviation): then it tells
                               a bench that leans from an encoder's zero
      --quick                  no replicates: faster, and probabilities are not calibrated
      --seed N                 seed of all random numbers (default 1)
  -q, --quiet                  say nothing but warnings
  -h, --help                   print this text
      --version                print the version

The same seed, recordings and version give the same bytes in GAP.json and FITTED.yaml.
"""
LONG = ["model=", "report=", "html=", "save-model=", "trajectory=", "lowpass=", "camera-zero=", "quick", "seed=", "quiet", "help", "version"]
SHORT = {"-m": "--model", "-r": "--report", "-q": "--quiet", "-h": "--help"}
TOO_LITTLE_MOTION = "too few samples in motion"  # talus-identify's words
LARGEST_SEED = 2**64 - 1
# percent of the time after which each stage began, between a minute of a leg without an effect and one of a pendulum with one
BEGINS = {"recordings": 0, "identification": 3, "low-pass": 7, "candidates": 10, "single effects": 18, "candidates, once more": 20,
          "combinations": 65, "another low-pass": 75, "maps": 85, "model with effects": 90, "page": 98}  # fmt: skip


class Options:
    """The command line, parsed."""

    def __init__(self, arguments):
        self.seed, self.quiet = "1", False
        pairs, self.recordings = command_line.parsed(NAME, arguments, LONG, SHORT)
        self.flags = dict(pairs)

    def check(self):
        """What must be there is there."""
        for name in ("--model", "--report"):
            if not self.flags.get(name):
                raise Refused(2, f"{name} is missing; {NAME} --help says what there is")
        if not self.recordings:
            raise Refused(2, f"no recording; {NAME} --help says what there is")
        self.seed = self.flags.get("--seed", "1")
        if not (self.seed.isascii() and self.seed.isdigit() and int(self.seed) <= LARGEST_SEED):
            raise Refused(2, f"--seed: expected a whole number from 0 to {LARGEST_SEED}, found '{self.seed}'")
        self.quiet, self.quick = "--quiet" in self.flags, "--quick" in self.flags
        self.lowpass_hz = self._above_0("--lowpass", "a frequency in Hz")
        self.camera_zero_rad = self._above_0("--camera-zero", "an angle in rad")
        self.trajectory = self.flags.get("--trajectory") or os.path.splitext(self.flags["--report"])[0] + ".next.csv"
        outputs = [self.flags[name] for name in ("--report", "--html", "--save-model") if name in self.flags]
        outputs.append(self.trajectory)
        if len({os.path.realpath(path) for path in outputs}) < len(outputs):
            raise Refused(2, "two outputs have the same name")
        inputs = {os.path.realpath(path) for path in (self.flags["--model"], *self.recordings)}
        for path in outputs:
            if os.path.realpath(path) in inputs:
                raise Refused(2, f"{path}: is an input and an output; expected a file of its own for each of --report, --html, --save-model and "
                                 "--trajectory")  # fmt: skip

    def _above_0(self, name, what):
        """A number, or None where the option was not given."""
        text = self.flags.get(name)
        if text is None:
            return None
        try:
            value = float(text)
        except ValueError:
            value = 0.0
        if not 0.0 < value < float("inf"):
            raise Refused(2, f"{name}: expected {what} above 0, found '{text}'")
        return value


# ---- inputs ------------------------------------------------------------------------


@contextlib.contextmanager
def identifying(options):
    """talus-identify, at work beside what this process does: a function that waits for it, and gives (report, model file's
    mapping); without a report where nothing can be identified."""
    program = talus.BUILD / "bin" / "talus-identify"
    with tempfile.TemporaryDirectory(prefix="talus-gap-") as folder:
        outputs = [Path(folder) / name for name in ("fitted.yaml", "report.json")]
        command = [program, "--model", model_file(options, Path(folder)), "--out", outputs[0], "--report", outputs[1],
                   "--seed", options.seed, "--quiet", "--", *options.recordings]  # fmt: skip
        try:
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        except OSError as error:
            raise Refused(1, f"{program}: {error.strerror}") from error
        with process:
            try:
                yield lambda: identified(options, process, outputs)
            finally:
                if process.returncode is None:
                    process.communicate()  # killed, it would leave what it has unpacked


def model_file(options, folder):
    """The model file; with a low-pass asked for, in `folder` with that."""
    path = Path(options.flags["--model"])
    try:
        tree = yaml.safe_load(path.read_text(encoding="utf-8")) if options.lowpass_hz else None
    except (OSError, ValueError, yaml.YAMLError):
        return path  # whose faults its reader tells
    if not isinstance(tree, dict) or not isinstance(tree.get("score", {}), dict):
        return path
    asked = {**tree, "score": {**tree.get("score", {}), "lowpass_hz": options.lowpass_hz}}
    (folder / "model.yaml").write_text(yaml.safe_dump(asked, allow_unicode=True, sort_keys=False), encoding="utf-8")
    return folder / "model.yaml"


def identified(options, process, outputs):
    """What it found."""
    said = process.communicate()[1].replace("talus-identify", NAME).rstrip("\n")
    if process.returncode == 2 and TOO_LITTLE_MOTION in said:  # a sensor at the output, or nothing to diagnose
        return None, yaml.safe_load(Path(options.flags["--model"]).read_text(encoding="utf-8"))
    if process.returncode != 0:
        raise Refused(2 if process.returncode == 2 else 1, said.removeprefix(f"{NAME}: "))
    if said:
        say(said)
    return json.loads(outputs[1].read_text()), yaml.safe_load(outputs[0].read_text())


def read(options):
    """(model, names, recordings, findings on their length) by the programs' own readers; a model's own effects are looked for
    anew."""
    try:
        model = talus.Model.read(options.flags["--model"])
        names, recordings, findings = excerpt.read(options.recordings, model)
    except talus.InputError as error:
        raise Refused(2, str(error)) from error
    except OSError as error:
        raise Refused(1, str(error)) from error
    model.effects = []
    if options.lowpass_hz:
        model.score.lowpass_hz = options.lowpass_hz
    for recording in recordings:
        recording.score = model.score
    return model, names, recordings, findings


# ---- the summary -------------------------------------------------------------------


def summary(found):
    """The diagnosis in a few lines for a person."""
    verdict = found["verdict"]
    yield f"{picture.sentence(found)}"
    for finding in found["findings"]:
        yield f"  {finding['id'].replace('_', ' ')}: {finding['evidence']}; {finding['remedy']}"
    for item in found["effects"]:
        size = words.size(item["effect"], item["parameters"], words.is_linear(found))
        if size:
            yield f"  {words.at(item['effect'], item['joint'])}: {size}"
        if "source" in item:
            yield f"  {tilt_source.words(item['source'])}"
    for item in found["alternatives"][:3]:
        if item["probability"] >= 0.01:
            yield f"  or {words.at(item['effect'], item['joint'])}: probability {words.share(item['probability'])}"
    if verdict["effect"] == "unknown" and found["nearest"]:
        yield "nearest: " + "; ".join(words.nearest(one) for one in found["nearest"][:3])
    said = words.surely_like(found)  # in the sentence
    for one in [one for one in found["resembles"] if one is not said][:2]:
        yield f"  or beyond the catalogue: {words.likeness(one, words.is_linear(found))}: probability {words.share(one['probability'])}"
    for joint, gap in found["gap"].items():
        unit = gap["unit"]
        known = "" if words.is_poor(found) else f", {gap['extended_rms']:.4g} with effects, {gap['noise_floor_rms']:.4g} noise"
        yield f"{joint}: {gap['nominal_rms']:.4g} {unit} as given, {gap['identified_rms']:.4g} identified{known}"
    yield from words.worse_than_given(found)
    if verdict["effect"] != "none":
        yield f"next: {found['next_experiment']['why']}"


# ---- the program -------------------------------------------------------------------


def diagnose(options, step, own=()):
    """(diagnosis, model file's mapping, model); `own`: talus.Effects that are tried beside the catalogue's."""
    effects = {**EFFECTS, **({} if options.quick else OUTSIDE), **entries(own)}
    step("recordings")
    with identifying(options) as found:
        given, names, recordings, findings = read(options)
        findings = [*gate.findings(given, names, recordings), *findings]
        step("identification")
        identification, tree = found()
    if tree.get("effects"):
        say(f"{NAME}: note: the model's own effects are left out of the diagnosis, and looked for anew")
    model = talus.Model.from_tree(tree)
    model.effects = []
    if findings and findings[0].grave:
        return report.withheld(identification, findings), tree, model
    processed = lowpass.processed_at(given, recordings, names, given.score.lowpass_hz)
    reason = experiment.too_poor(processed)
    if reason:
        return report.withheld(identification, [reason, *findings]), tree, model
    step("low-pass")
    seed = int(options.seed)
    looks = lowpass.Looks(given, recordings, names, tree, processed, effects)
    del processed
    through, dataset = looks.first(options.lowpass_hz, seed)
    if through.nothing_left:
        return report.withheld(identification, [lowpass.too_coarse(model, through), *findings]), tree, model
    first = judged(options, looks, model, step, through, dataset)
    again = functools.partial(judged, options, looks, model, lambda text, part=0.0: step(f"again: {text}", part))
    through, finished, verdict = look_again(first, looks.others(through, seed), again)
    if through.window_hz:
        say(f"{NAME}: note: {windows_in_words(model, first, through)} (`--lowpass {through.window_hz:.3g}` identifies with them, too)")
    step("maps")
    return report.diagnosis(finished, verdict, seed, findings, through), tree, model


def judged(options, looks, model, step, through, dataset):
    """(Lowpass, search, verdict) of the recordings through it."""
    dataset.inertia_kept = 1.0 + (through.bias or 0.0)
    finished, fit = search(dataset, list(model.base.values()), step, int(options.seed), replicated=not options.quick)
    step("another low-pass")
    finished.camera_zero_rad = options.camera_zero_rad
    verdict = judge(finished, fit, None if options.quick else looks.other_than(through), looks.around(through), through.fixes_inertia)
    return through, finished, verdict


def windows_in_words(model, first, through):
    """Why windows are longer than the model file's; `first` as judged() makes it."""
    short = "windows as short as the model file's low-pass asks for"
    before, *found = first
    if through is before:
        return f"{short} lose the {lowpass.inertia_of(model)}; longer ones were taken"
    why = f"through {short} steps and noise of the angles hide what the machine does" if hidden_by_readings(*found) else (
        f"what is found through {short} does not show through another low-pass, or has another size there")  # fmt: skip
    return f"{why}; a low-pass of {through.hz:.3g} Hz and windows as long were taken"


def run(arguments):
    """The program; raises Refused."""
    options = Options(arguments)
    if command_line.answered(options.flags, NAME, USAGE):
        return
    options.check()
    step = Stages(NAME, BEGINS, options.quiet)
    try:
        found, tree, model = diagnose(options, step)
        steps = experiment.steps(options, found)
        texts, notes = files(options, found, tree, model, steps, step)
    finally:
        step.end()
    outputs.write_texts(texts)
    for note in notes:
        say(f"{NAME}: note: {note}")
    if not options.quiet:
        for line in (*summary(found.report), *numbered(steps)):
            say(line)


def files(options, found, tree, model, steps, step):
    """({name: text} of the files that are asked for, notes on the model with effects)."""
    texts, notes = {}, []
    if found.trajectory:
        found.report["next_experiment"]["trajectory"] = os.path.basename(options.trajectory)
        texts[options.trajectory] = found.trajectory
    texts[options.flags["--report"]] = report.to_text(found.report)
    saved, page = options.flags.get("--save-model"), options.flags.get("--html")
    if saved or page:
        step("model with effects")
        text, lost = fitted.model_text(tree, model, found)
    if saved:
        texts[saved], notes = text, lost
    if page:
        step("page")
        texts[page] = picture.page(found, options, steps, fitted.patch(tree, text))
    return texts, notes


def numbered(steps):
    """Lines of the steps to the next experiment."""
    for k, (what, run) in enumerate(steps, 1):
        yield f"  {k}. {what}{f': {run}' if run else ''}"


def main(arguments):
    """Exit status of the program."""
    return command_line.status(NAME, run, arguments)
