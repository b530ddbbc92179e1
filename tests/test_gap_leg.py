"""tools/gap/catalogue/leg.py: a mount with two modes, on the withheld cases' bench, which shares no code with the library."""

import json
import math

import pytest
from support import run

from blind import cases, effects

MOUNT_KG, SIDEWAYS_HZ, UP_HZ, DAMPING_RATIO = 5.0, 4.2, 6.4, 0.05


def spring(mass_kg, frequency_Hz):
    """(stiffness, damping) of what swings with that mass at that frequency."""
    w = 2 * math.pi * frequency_Hz
    return mass_kg * w * w, 2 * DAMPING_RATIO * w * mass_kg


def test_a_mount_that_sways_and_rises_is_found_with_both_resonances(tmp_path):
    """The spring carries the mount and the leg that hangs from it."""
    case = cases.Case(5, 0, {"none": 1.0})
    mass = MOUNT_KG + sum(cases.FIXED[part] for part in ("ms", "mf", "mm"))  # shank, foot, ankle motor
    (x_k, x_c), (z_k, z_c) = spring(mass, SIDEWAYS_HZ), spring(mass, UP_HZ)
    job = {"x_mass": MOUNT_KG, "x_k": x_k, "x_c": x_c, "z_mass": MOUNT_KG, "z_k": z_k, "z_c": z_c}
    case.drawn = [effects.Drawn("base_compliance", "base", "sideways and up", "two modes", job)]
    cases.write_case(tmp_path, case, case.simulate(case.drawn))
    (folder,), report = tmp_path.glob("case_*"), tmp_path / "gap.json"
    run("talus-gap", "--quiet", "--model", folder / "model.yaml", "--report", report, *sorted(folder.glob("train*.csv.gz")))
    found = json.loads(report.read_text())
    assert (found["verdict"]["effect"], found["verdict"]["joint"]) == ("base_compliance", "base")
    assert found["verdict"]["probability"] > 0.9 and found["gap"]["knee"]["closed_fraction"] > 0.9
    (mount,) = (e["parameters"] for e in found["effects"] if e["effect"] == "base_compliance")
    assert mount["frequency_Hz"] == pytest.approx(SIDEWAYS_HZ, rel=0.05)
    assert mount["frequency_Hz_2"] == pytest.approx(UP_HZ, rel=0.05)
    assert mount["sway_m_N"] == pytest.approx(1 / x_k, rel=0.2) and mount["rise_m_N_2"] == pytest.approx(1 / z_k, rel=0.2)
