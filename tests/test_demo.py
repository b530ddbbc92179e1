"""`make demo`: what it says is what its files show, scored by the rule in SciPy."""

import json
import re
import subprocess
import sys
import time
from xml.etree import ElementTree

import numpy as np
import pytest
from scoring_reference import score as reference
from support import REPOSITORY
from test_page import Page as Parsed
from test_sim_command import read

JOINTS = ("knee", "ankle")
RATIO = 51


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    begin = time.monotonic()
    command = [sys.executable, REPOSITORY / "tools" / "demo", "--out", folder]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return folder, done.stdout, time.monotonic() - begin


def scored(folder, name):
    """RMS [mNm] and relative error [%] of each joint's prediction on the unseen recording, from the files alone."""
    recording, predicted = read(folder / "unseen.csv"), read(folder / f"predicted_{name}.csv")
    t = recording["time_s"]
    for joint in JOINTS:
        angle = recording["knee_motor_rad"] / RATIO if joint == "knee" else recording["ankle_joint_rad"]
        torque = 0.1031 * recording[f"{joint}_current_A"]
        rms, _, relative, _ = reference(t, torque, predicted[f"{joint}_motor_torque_Nm"], np.gradient(angle, t))
        yield 1e3 * rms, relative


def test_says_the_errors_of_its_files(demo):
    folder, said, _ = demo
    names = ("drawing", "identified", "truth")
    want = dict(zip(names, (list(scored(folder, name)) for name in names)))
    for j, joint in enumerate(JOINTS):
        (row,) = re.findall(rf"^    {joint} +[\d.]+ mNm +(.*)$", said, re.MULTILINE)
        shown = [float(x) for x in re.findall(r"[\d.]+", row)]
        # speeds of another kind leave out a few other samples
        assert shown == pytest.approx([x for name in names for x in want[name][j]], rel=0.03)
        drawn, identified, truth = (want[name][j][0] for name in names)
        assert identified < 0.3 * drawn and identified < 1.08 * truth


def test_names_what_cannot_be_identified(demo):
    folder, said, _ = demo
    report = json.loads((folder / "report.json").read_text())
    unseen = [name for name, p in report["parameters"].items() if not p["identifiable"]]
    assert unseen == ["ankle_motor_com_m", "shank_com_m", "shank_inertia_kg_m2"]
    words = " ".join(said.split())
    assert "7 of 10 parameters are identified. ankle_motor_com_m, shank_com_m and shank_inertia_kg_m2 are not" in words


def test_ends_with_a_picture_that_needs_nothing_else(demo):
    folder, said, _ = demo
    assert said.endswith(f"The picture, for a browser: {folder / 'index.html'}\n")
    parsed = Parsed((folder / "index.html").read_text(encoding="utf-8"))
    assert parsed.open == [] and len(parsed.of("canvas")) == 4
    for tag, attributes in parsed.elements:
        for name in ("src", "href"):
            assert attributes.get(name, "data:,").startswith("data:"), (tag, attributes)


def test_shows_commands_that_can_be_typed(demo):
    _, said, _ = demo
    commands = re.findall(r"\$ \S*?(talus-\w+) ((?:.|\n        )*)", said)
    assert [name for name, _ in commands] == ["talus-sim", "talus-identify", "talus-sim", "talus-predict"]
    assert "--model models/leg_cad.yaml" in " ".join(commands[1][1].split())


def test_fits_a_screen_and_half_a_minute(demo):
    _, said, seconds = demo
    assert seconds < 30
    assert len(said.splitlines()) <= 45 and max(map(len, said.splitlines())) <= 120


def test_picture_of_the_readme(demo, tmp_path):
    """The same files give the same small drawing, made of paths and text."""
    folder, _, _ = demo
    drawn = []
    for name in ("a.svg", "b.svg"):
        command = [sys.executable, REPOSITORY / "tools" / "picture", "--from", folder, "--out", tmp_path / name]
        subprocess.run(command, check=True, capture_output=True)
        drawn.append((tmp_path / name).read_bytes())
    root = ElementTree.fromstring(drawn[0])
    texts = {element.text for element in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"measured", "as drawn", "identified", "ankle motor torque [mNm]", "time [s]"} <= texts
    assert drawn[0] == drawn[1] and len(drawn[0]) < 100_000 and b"<image" not in drawn[0]
    committed = ElementTree.parse(REPOSITORY / "docs" / "images" / "ankle.svg").getroot()
    assert {element.text for element in committed.iter("{http://www.w3.org/2000/svg}text")} >= {"measured", "identified"}
