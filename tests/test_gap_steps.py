"""The next experiment as steps with commands, and the model with effects as a patch: on the page and on the terminal."""

import html
import json
import re
import shlex
import subprocess
from types import SimpleNamespace

import numpy
import pytest
import yaml
from support import REPOSITORY, run
from talus.diagnosis.experiment import steps
from talus.diagnosis.experiment.steps import limits

LEG = REPOSITORY / "models/leg.yaml"
TRAJECTORY = "# two seconds\ntime_s,knee_rad,ankle_rad\n" + "".join(
    f"{0.01 * k:.2f},{0.5 * numpy.sin(0.03 * k):.6f},{-0.1 + 0.2 * numpy.cos(0.05 * k):.6f}\n" for k in range(200))  # fmt: skip


def told(verdict, trajectory, joints=2):
    options = SimpleNamespace(flags={"--model": "my leg.yaml", "--report": "gap.json"}, recordings=["a.csv"], trajectory="gap.next.csv")
    report = {"verdict": verdict, "gap": dict.fromkeys(range(joints))}
    return steps(options, SimpleNamespace(report=report, trajectory=trajectory))


def test_limits_hold_the_trajectory_and_little_more():
    table = numpy.loadtxt(TRAJECTORY.splitlines()[2:], delimiter=",")
    for text, q in zip(list(limits(TRAJECTORY))[::2], table.T[1:], strict=True):
        low, high = (float(x) for x in text.split("=")[1].split(":"))
        assert low < q.min()
        assert high > q.max()
        assert high - low < 1.2 * (q.max() - q.min())
    for text, q in zip(list(limits(TRAJECTORY))[1::2], table.T[1:], strict=True):
        most = numpy.abs(numpy.diff(q)).max() / 0.01
        assert most < float(text.split("=")[1]) < 1.1 * most


def test_a_leg_is_played_exported_and_diagnosed():
    commands = [shlex.split(command) for _, command in told({"effect": "stribeck"}, TRAJECTORY)]
    assert [command[0] for command in commands] == ["talus-acquire", "talus-acquire-export", "talus-gap"]
    assert commands[0][3:5] == ["--play", "gap.next.csv"]
    assert "my leg.yaml" in commands[1]
    assert commands[2][-2:] == ["a.csv", "new.csv"]


def test_other_plants_and_other_experiments_are_recorded_by_hand():
    for trajectory, joints in ((TRAJECTORY, 1), (None, 2)):
        first, last = told({"effect": "unknown"}, trajectory, joints)
        assert first[1] is None
        assert last[1].startswith("talus-gap")


def test_where_nothing_is_open_there_are_no_steps():
    assert told({"effect": "none"}, None) == []
    assert told({"effect": "unknown", "withheld": True}, None) == []


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """(folder, page, what the terminal said) of a pendulum with friction higher near standstill."""
    folder = tmp_path_factory.mktemp("steps")
    pendulum = REPOSITORY / "models/pendulum.yaml"
    tree = yaml.safe_load(pendulum.read_text())
    tree["effects"] = [{"effect": "stribeck", "joint": "joint", "parameters": {"extra_Nm": 0.3, "speed_rad_s": 0.2, "exponent": 1}}]
    (folder / "truth.yaml").write_text(yaml.safe_dump(tree))
    run("talus-sim", "--model", folder / "truth.yaml", "--out", folder / "monday.csv", "--duration", 30)
    done = run("talus-gap", "--quick", "--model", pendulum, "--report", folder / "gap.json", "--html", folder / "gap.html", "--save-model",
               folder / "extended.yaml", folder / "monday.csv")  # fmt: skip
    return folder, (folder / "gap.html").read_text(), done.stderr


def test_the_page_is_named_by_its_recording(page):
    assert "<title>Where the gap lies: monday.csv</title>" in page[1]


def test_size_and_steps_are_on_page_and_terminal(page):
    folder, text, said = page
    found = json.loads((folder / "gap.json").read_text())["effects"][0]
    size = f"{found['parameters']['extra_Nm']:.3g} Nm more at standstill"
    assert size in said
    assert size in text
    assert re.search(r"\n  1\. Have the joint follow gap.next.csv", said)
    assert "<li>Have the joint follow gap.next.csv" in text
    assert f"closes of the joint&#x27;s gap</th><td>{100 * found['closes']['joint']:.0f}</td>" in text


def test_the_patch_makes_the_saved_model_of_the_identified_one(page):
    """By the `patch` of the system, taken back: the identified model has no effects, and all else is the saved one's."""
    folder, text, _ = page
    patch = html.unescape(re.search(r'<pre class="wide">(--- identified.*?)</pre>', text, re.DOTALL).group(1))
    (folder / "p.diff").write_text(patch + "\n")
    subprocess.run(["patch", "--quiet", "--reverse", "--output=back.yaml", "extended.yaml", "p.diff"], cwd=folder, check=True)
    back, extended = (yaml.safe_load((folder / name).read_text()) for name in ("back.yaml", "extended.yaml"))
    assert "effects" not in back
    assert back["joint"]["friction"] != extended["joint"]["friction"]  # fitted anew beside the effect
    assert extended["effects"][0]["effect"] == "stribeck"
    run("talus-identify", "--quiet", "--model", REPOSITORY / "models/pendulum.yaml", "--out", folder / "i.yaml", folder / "monday.csv")
    identified = yaml.safe_load((folder / "i.yaml").read_text())
    assert {name: back[name] for name in identified} == identified
