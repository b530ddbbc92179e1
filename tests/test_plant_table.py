"""The table of plants: nothing outside of the plants' own files asks which plant it is, and another plant is its file,
its row and its page (docs/plants.md), from which it is built here."""

import json
import os
import re
import shutil
import subprocess

import numpy as np
import pytest
from support import REPOSITORY

ASKS = re.compile(r"plant\s*[!=]=|case TL_PLANT_|TL_PLANT_(?:LEG|PENDULUM|SLIDER)\b|\.leg\b(?!\()|in \(?\"(?:leg|pendulum|slider)\"")
QUOTED = re.compile(r"(?:[!=]=|\.get\(|\[)\s*\"(?:leg|pendulum|slider)\"")


# a second program with plants of its own, and plants in the words of other simulators
OTHERS = ("tools/talus/blind/", "tools/talus/exporting/", "tools/talus/mujoco.py")


def lines_that_ask(folder, suffixes):
    """FILE:LINE of every line that asks which plant it is, comments aside."""
    found = []
    for path in sorted((REPOSITORY / folder).rglob("*")):
        if any(str(path.relative_to(REPOSITORY)).startswith(other) for other in OTHERS):
            continue
        if path.suffix not in suffixes or re.match(r"plant(_\w+)?\.[ch]", path.name):
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            code = re.sub(r"^\s*(/?\*|//|#(?!include|define)).*", "", line)
            code = re.sub(r"(?:tl_model_init|recording_open)\(.*|\.plant = TL_PLANT_\w+", "", code)  # says which, does not ask
            if ASKS.search(code) or QUOTED.search(code):
                found.append(f"{path.relative_to(REPOSITORY)}:{number}: {line.strip()}")
    return found


@pytest.mark.parametrize("folder", ["lib", "apps", "include", "tools"])
def test_nothing_outside_of_the_plants_asks_which_it_is(folder):
    assert lines_that_ask(folder, {".c", ".h", ".cpp", ".py"}) == []


def test_the_search_finds_what_asks(tmp_path, monkeypatch):
    """Lines such as stood there once."""
    monkeypatch.setattr("test_plant_table.REPOSITORY", tmp_path)
    (tmp_path / "lib").mkdir()
    asking = ["if (m->plant == TL_PLANT_LEG) x();", "return p != 0 && m->plant != other;", "case TL_PLANT_SLIDER: return 1;"]
    asking += ['if model.plant == "slider":', "if evidence.leg:", 'x = {"leg": 1}["leg"]']
    innocent = ["/* a slider: m->plant == TL_PLANT_SLIDER */", "tl_plant_facts(m->plant)->joints;", " * TL_PLANT_LEG", "evidence.legs"]
    (tmp_path / "lib/simulate.c").write_text("\n".join(asking + innocent))
    (tmp_path / "lib/plant_leg.c").write_text("\n".join(asking))
    assert len(lines_that_ask("lib", {".c"})) == len(asking)


# ---- another plant -------------------------------------------------------------------------------------------------

PARAMETERS = {"inertia_kg_m2": 0.02, "coulomb_Nm": 0.15, "viscous_Nms_rad": 0.05, "drag_Nms2_rad2": 0.03}


def page_block(name):
    text = (REPOSITORY / "docs/plants.md").read_text()
    return re.search(rf"<!-- file: {re.escape(name)} -->\n```\w+\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)[1]


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy of the tree with the page's plant in it, built."""
    folder = tmp_path_factory.mktemp("plants") / "talus"
    unneeded = shutil.ignore_patterns("build", ".git", ".venv", "docs", "tests", "__pycache__", "node_modules")
    shutil.copytree(REPOSITORY, folder, ignore=unneeded, symlinks=True)
    (folder / "lib/plant_propeller.c").write_text(page_block("plant_propeller.c"))
    row = re.search(r"^    (#define TL_PLANTS\(row\).*)$", (REPOSITORY / "docs/plants.md").read_text(), re.MULTILINE)[1]
    header = folder / "include/talus/plant.h"
    header.write_text(re.sub(r"^#define TL_PLANTS\(row\).*$", row, header.read_text(), flags=re.MULTILINE))
    (folder / "propeller.yaml").write_text(page_block("propeller.yaml"))
    clean = {name: value for name, value in os.environ.items() if name not in ("MAKEFLAGS", "MFLAGS", "LD_PRELOAD", "TALUS_BUILD")}
    programs = [f"build/bin/talus-{name}" for name in ("sim", "identify", "predict")]
    subprocess.run(["make", "-j2", "CFLAGS=-O0", *programs], cwd=folder, env=clean, check=True, capture_output=True)
    return folder


def run(tree, name, *arguments):
    command = [f"build/bin/talus-{name}", *arguments]
    done = subprocess.run(command, cwd=tree, check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done


def table(path):
    return np.genfromtxt(path, delimiter=",", names=True)


@pytest.mark.long
@pytest.mark.release
def test_another_plant_is_its_file_its_row_and_its_page(tree):
    run(tree, "sim", "--model", "propeller.yaml", "--out", "run.csv", "--motion", "motion.csv", "--duration", "30", "--ideal")
    moved = table(tree / "motion.csv")
    v, a, slip = (moved[f"joint_{name}"] for name in ("velocity_rad_s", "acceleration_rad_s2", "slip"))
    p = PARAMETERS
    torque = p["inertia_kg_m2"] * a + p["coulomb_Nm"] * slip + p["viscous_Nms_rad"] * v + p["drag_Nms2_rad2"] * v * abs(v)
    np.testing.assert_allclose(moved["joint_torque_Nm"], torque, atol=1e-9)
    assert p["drag_Nms2_rad2"] * np.max(v**2) > 0.2 * np.max(abs(torque)), "the drag is hardly there"

    start = re.sub(r"drag_Nms2_rad2: 0.03", "drag_Nms2_rad2: 0.01", (tree / "propeller.yaml").read_text())
    (tree / "start.yaml").write_text(start)
    run(tree, "identify", "--model", "start.yaml", "--out", "fitted.yaml", "--report", "r.json", "run.csv")
    found = json.loads((tree / "r.json").read_text())["parameters"]
    for name, value in PARAMETERS.items():
        assert abs(found[name]["value"] - value) < max(4 * found[name]["sigma"], 0.01 * value), name

    run(tree, "predict", "--model", "fitted.yaml", "--out", "p.csv", "run.csv")
    predicted = table(tree / "p.csv")["joint_torque_Nm"]
    sliding = np.abs(v) > 0.3
    assert np.sqrt(np.mean((predicted - torque)[sliding] ** 2)) < 0.02 * np.sqrt(np.mean(torque[sliding] ** 2))


@pytest.mark.long
@pytest.mark.release
def test_its_model_file_is_read_as_strictly_as_the_others(tree):
    text = (tree / "propeller.yaml").read_text()
    for change, message in [
        (("drag_Nms2_rad2: 0.03", "drag_Nms2_rad2: -1"), "drag_Nms2_rad2: expected 0 or a number above it"),
        (("drag_Nms2_rad2: 0.03\n", ""), "drag_Nms2_rad2: missing key"),
        (("propeller", "rocket"), "expected leg, pendulum, slider or propeller"),
        (("joint:", "bus: {}\njoint:"), "bus: unknown key"),
    ]:
        (tree / "bad.yaml").write_text(text.replace(*change))
        done = subprocess.run(
            ["build/bin/talus-sim", "--model", "bad.yaml", "--out", "bad.csv"], cwd=tree, check=False, capture_output=True, text=True
        )
        assert done.returncode == 2 and message in done.stderr, done.stderr
