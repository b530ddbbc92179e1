"""talus-export --to mjcf, urdf, sdf, bam, isaac, mcap: the command line. --to c is the C program's."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import talus
from talus import BUILD, InputError, Model, Recording, command_line, outputs
from talus.refused import Refused

from . import bam, isaac, limits, mcap, mjcf, sdf, target, urdf

NAME = "talus-export"
USAGE = """\
usage: talus-export --to TARGET --out OUT [OPTION...] FITTED.yaml [REC.csv]

    talus-export --to mjcf --out leg.xml leg.yaml                  # and leg.xml.loss.json: what MuJoCo cannot hold
    talus-export --to urdf --limits knee.torque=60,knee.speed=4 --out leg.urdf leg.yaml
    talus-export --to bam --joint knee --out knee.json leg.yaml run.csv

    talus-export --to mcap --out run.mcap leg.yaml run.csv         # measured, predicted, residual; and layouts that show them

writes an identified model for a simulator, and how much torque of each effect that cannot hold; or a recording with its prediction

  -t, --to TARGET      mjcf, urdf, sdf, bam, isaac or mcap; c is a header for a controller (talus-export --help)
  -o, --out OUT        where to write
      --report L.json  where to write what is lost (OUT.loss.json)
      --joint NAME     of bam: whose drive, where there are two
      --limits LIST    what joints can do: knee.position=-0.9:0.1,knee.speed=4,knee.torque=60
  -q, --quiet          no table on standard error
  -h, --help           print this text
      --version        print the version

REC.csv is the motion along which torques are counted; without it 20 s on the simulated bench.
"""
LONG = ["to=", "out=", "report=", "joint=", "limits=", "quiet", "help", "version"]
SHORT = {"-t": "--to", "-o": "--out", "-q": "--quiet", "-h": "--help"}
COMMENT = "Made by talus-export from {}. Angles [rad], torques at the joint [Nm]; what is not held stands in the loss report."


class Options:
    """The command line, parsed."""

    def __init__(self, arguments: list[str]) -> None:
        pairs, self.inputs = command_line.parsed(NAME, arguments, LONG, SHORT)
        self.flags = dict(pairs)
        self.to, self.out = self.flags.get("--to", ""), self.flags.get("--out", "")
        self.report = self.flags.get("--report") or f"{self.out}.loss.json"

    def check(self) -> None:
        if self.to not in (*target.TARGETS, "mcap"):
            raise Refused(2, f"--to: expected c, {', '.join(target.TARGETS)} or mcap, got {self.to or 'nothing'}")
        if not self.out:
            raise Refused(2, f"--out is missing; {NAME} --help says what there is")
        if not 1 <= len(self.inputs) <= 2:
            raise Refused(2, "expected FITTED.yaml, and REC.csv or nothing")
        if self.to == "mcap" and len(self.inputs) != 2:
            raise Refused(2, "--to mcap: expected FITTED.yaml and REC.csv")
        if {os.path.realpath(self.out), os.path.realpath(self.report)} & {os.path.realpath(p) for p in self.inputs}:
            raise Refused(2, f"{self.out}: is an input and an output")
        if os.path.realpath(self.out) == os.path.realpath(self.report):
            raise Refused(2, f"--report: {self.report}: is --out, too")


def export(model: Model, to: str, source: str, *, recording: Recording | None = None, joint: str | None = None,
           text_limits: str = "") -> tuple[str, dict[str, object]]:  # fmt: skip
    """The file's text and the loss report."""
    bounds = limits.read(text_limits, model)
    if to == "bam" and (joint or model.joints[0]) not in model.joints or to == "bam" and not joint and len(model.joints) > 1:
        raise Refused(2, f"--joint: expected one of {', '.join(model.joints)}, found {joint or 'none'}")
    held = target.fit(model, target.TARGETS[to], recording)
    comment = COMMENT.format(source)
    if to == "bam":
        joint = joint or model.joints[0]
        text = bam.text(model, held, model.joints.index(joint))
        held.entries = [e for e in held.entries if e["joint"] in (joint, "base")]
    elif to == "isaac":
        text = isaac.text(model, held, bounds, comment)
    else:
        text = {"mjcf": mjcf, "urdf": urdf, "sdf": sdf}[to].text(held, bounds, comment)
    report = {"schema": "talus-loss/1", "target": to, "model": source, "motion_s": held.motion_s, "torque_unit": model.torque_unit,
              "entries": held.entries}  # fmt: skip
    return text, report


def write_mcap(model: Model, recording: Recording, out: str) -> None:
    """The recording, and a layout for PlotJuggler and one for Foxglove beside it."""
    outputs.write(out, [mcap.content(model, recording)])
    outputs.write_text(f"{out}.plotjuggler.xml", mcap.plotjuggler(model.joints))
    outputs.write_text(f"{out}.foxglove.json", mcap.foxglove(model.joints))


def table(report: dict[str, object]) -> str:
    """The report for people."""
    entries = report["entries"]
    assert isinstance(entries, list)
    unit, rows = report["torque_unit"], [("what", "joint", "held", f"torque [{report['torque_unit']}]", f"lost [{report['torque_unit']}]", "")]
    for e in entries:
        rows.append((e["effect"], e["joint"], e["how"], _figure(e["torque_Nm"]), _figure(e["lost_Nm"]), e["callback"] or e["note"] or ""))
    if len(rows) == 1:
        return f"nothing is lost: 0 {unit}"
    width = [max(len(row[c]) for row in rows) for c in range(5)]
    return "\n".join(" ".join(cell.ljust(w) for cell, w in zip(row, [*width, 0], strict=True)).rstrip() for row in rows)


def _figure(x: float | None) -> str:
    return "?" if x is None else f"{x:.2g}"


def run(arguments: list[str]) -> None:
    """The program; raises Refused."""
    options = Options(arguments)
    if command_line.answered(options.flags, NAME, USAGE):
        return
    options.check()
    try:
        model = Model.read(options.inputs[0])
        recording = Recording.read(options.inputs[1], model=model) if len(options.inputs) == 2 else None
        if options.to == "mcap" and recording is not None:
            write_mcap(model, recording, options.out)
            return
        text, report = export(model, options.to, options.inputs[0], recording=recording, joint=options.flags.get("--joint"),
                              text_limits=options.flags.get("--limits", ""))  # fmt: skip
    except InputError as error:
        raise Refused(2, str(error)) from error
    except ValueError as error:
        raise Refused(2, f"{options.inputs[-1]}: {error}") from error
    except (talus.TalusError, OSError) as error:
        raise Refused(1, f"{options.inputs[0]}: {error}") from error
    outputs.write_text(options.out, text)
    outputs.write_text(options.report, json.dumps(report, indent=1, allow_nan=False) + "\n")
    if "--quiet" not in options.flags:
        print(table(report), file=sys.stderr)


def asks_for_c(arguments: list[str]) -> bool:
    """Is it --to c? That is a program in C."""
    try:
        pairs, _ = command_line.parsed(NAME, arguments, LONG, SHORT)
    except Refused:
        return any(x in ("--to=c", "-tc") for x in arguments) or any(a in ("--to", "-t") and b == "c" for a, b in zip(arguments, arguments[1:], strict=False))
    return ("--to", "c") in pairs


def main(arguments: list[str]) -> int:
    """Exit status of the program."""
    if asks_for_c(arguments):
        program = Path(BUILD) / "bin" / NAME
        os.execv(program, [str(program), *arguments])
    return command_line.status(NAME, run, arguments)
