"""One item's diagnosis, by talus-gap's own code, and its files: GAP.json, FITTED.yaml, the next trajectory, and last of all
ITEM.json, which says what they were made of. What has no ITEM.json, or one of other inputs, is not done."""

import contextlib
import hashlib
import io
import json
import os
from dataclasses import dataclass
from pathlib import Path

import talus
from talus import constants, outputs
from talus.diagnosis import command, fitted, report
from talus.refused import Refused

ITEM = "item.json"
REPORT, FITTED = "gap.json", "fitted.yaml"


@dataclass(frozen=True)
class Work:
    """Where results stand, and talus-gap's options: what is the same for all items."""

    out: str
    options: tuple[str, ...] = ()

    def folder(self, item):
        return Path(self.out) / "items" / item.name

    def __call__(self, item):
        """Diagnoses an item: (status, what was said of a failure). Files are written whole."""
        folder = self.folder(item)
        folder.mkdir(parents=True, exist_ok=True)
        for left in folder.glob("*.tmp*"):  # by one that was killed
            left.unlink(missing_ok=True)
        made_of = self.made_of(item)  # before: what changes meanwhile is to be diagnosed again
        said = io.StringIO()
        with contextlib.redirect_stderr(said):
            status, text, found = _attempt(item, folder, self.options)
        found["notes"] = said.getvalue().splitlines()
        self.keep(item, made_of, status, text, found)
        return status, text

    def made_of(self, item):
        """What an item's result depends on."""
        files = [_stamp(path) for path in item.recordings]
        try:
            model = hashlib.sha256(Path(item.model).read_bytes()).hexdigest()
        except OSError:
            model = None
        return {"version": constants.TL_VERSION, "options": list(self.options), "model": model, "recordings": files}

    def keep(self, item, made_of, status, text, found):
        """Writes ITEM.json."""
        head = {"schema": "talus-fleet-item/1", **item.plain(), "status": status, "said": text, "made_of": made_of}
        self.folder(item).mkdir(parents=True, exist_ok=True)
        outputs.write_text(self.folder(item) / ITEM, json.dumps({**head, **found}, indent=1, allow_nan=False) + "\n")

    def kept(self, item):
        """ITEM.json's mapping; None where there is none."""
        path = self.folder(item) / ITEM
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise Refused(2, f"{path}: cannot be read: {error}") from error

    def is_done(self, item):
        """Diagnosed from these very inputs? What failed is not done."""
        kept = self.kept(item)
        return kept is not None and kept["status"] == 0 and kept["made_of"] == self.made_of(item) and _head(kept) == _head(item.plain())


def _head(plain):
    """What the table says of an item, which may change without its recordings."""
    return {key: plain[key] for key in ("robot", "session", "temperature_C")}


def _stamp(path):
    """A file's size and time of change; its contents may be large."""
    try:
        found = os.stat(path)
    except OSError:
        return None
    return [found.st_size, found.st_mtime_ns]


def _attempt(item, folder, given):
    """(status, text, results): a failure of any kind is an answer, so that the others go on."""
    arguments = ["--model", item.model, "--report", str(folder / REPORT), "--save-model", str(folder / FITTED), "--quiet", *given]
    try:
        return 0, "", _diagnosed([*arguments, "--", *item.recordings])
    except command.Refused as refused:
        return refused.status, refused.text, {}
    except Exception as error:  # noqa: BLE001  of one recording among thousands
        return 1, f"{type(error).__name__}: {error}", {}


def _diagnosed(arguments):
    """Runs talus-gap's diagnosis, writes its files, and returns what a fleet is reduced from."""
    options = command.Options(arguments)
    options.check()
    found, tree, model = command.diagnose(options, lambda _: None)
    texts, plain = {}, {}
    if not any(finding["grave"] for finding in found.report["findings"]):
        plain = talus.Model.from_tree(tree).parameters  # before effects: the same meaning in every session
    if found.trajectory:
        found.report["next_experiment"]["trajectory"] = os.path.basename(options.trajectory)
        texts[options.trajectory] = found.trajectory
    texts[options.flags["--report"]] = report.to_text(found.report)
    texts[options.flags["--save-model"]], _ = fitted.model_text(tree, model, found)
    outputs.write_texts(texts)
    plain_report = json.loads(texts[options.flags["--report"]])
    kept = {key: plain_report[key] for key in ("verdict", "effects", "gap", "motion", "findings")}
    return {**kept, "parameters": plain}
