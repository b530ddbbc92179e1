"""tools/talus/diagnosis/hidden.py: what recordings cannot show, against plain least squares and against joints of known truth."""

import json
import os

import numpy as np
import pytest
import yaml
from gap_in_process import recorded
from support import BUILD, REPOSITORY, run

import talus

os.environ.setdefault("TALUS_BUILD", str(BUILD))

from talus.diagnosis import hidden  # noqa: E402
from talus.diagnosis.search import Search  # noqa: E402

LEG, PENDULUM = REPOSITORY / "models/leg.yaml", REPOSITORY / "models/pendulum.yaml"


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """A search on a bench that hides nothing."""
    folder = tmp_path_factory.mktemp("plain")
    run("talus-sim", "--model", LEG, "--out", folder / "leg.csv", "--duration", 40)
    dataset, _ = recorded(LEG, folder, folder / "leg.csv")
    return Search(dataset, list(dataset.prior))


def gained(search, column, strength):
    """Chi-square that fitting a column gains, were its effect there at this strength: least squares on all rows."""
    parts = [np.concatenate([rows, own]) for rows, own in zip(search.gram.plain, search.gram.gathered([column]))]
    rows = np.concatenate(parts, axis=1).T
    base, effect = rows[:, search.gram.base], strength * rows[:, -1]
    known, weight = search.gram.prior_rows()
    base = np.vstack([base, known[search.gram.base].T])
    effect = np.concatenate([effect, np.zeros(len(weight))])
    scale = np.sqrt((base**2).sum(0))
    best = np.linalg.lstsq(base / scale, effect, rcond=None)[0]
    return np.sum((effect - base / scale @ best) ** 2)


@pytest.mark.parametrize("key", [("delay", "knee"), ("stribeck", "ankle"), ("current_offset", "knee"), ("gravity_tilt", "base")])
def test_the_least_size_that_shows_is_that_of_least_squares(plain, key):
    least, _ = hidden.least_shares(plain)[key]
    every = []
    for candidate in (c for c in plain.gram.candidates if c.key == key):
        for column in candidate.columns:
            strength = np.sqrt(plain.detection_threshold / gained(plain, column, 1.0))
            own = dict(zip((layout.kind for layout in plain.gram.layouts), plain.gram.gathered([column])))
            torque = [np.sqrt(np.sum(own[k] ** 2) / np.sum(plain.gram.reading(k) ** 2)) for k in ("T0", "T1")]
            every.append(strength * max(torque))
    assert least == pytest.approx(min(every), rel=1e-3)


def test_a_bench_in_good_motion_hides_nothing(plain):
    assert hidden.not_observable(plain) == []


def listed(tmp_path, columns, model):
    np.savetxt(tmp_path / "r.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns),
               comments="", fmt="%.9g")  # fmt: skip
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(model))
    # --quick: what is not observable goes by the search alone, whatever replicates gain
    run("talus-gap", "-q", "--quick", "--model", tmp_path / "m.yaml", "--report", tmp_path / "gap.json", tmp_path / "r.csv")
    found = json.loads((tmp_path / "gap.json").read_text())["not_observable"]
    return {(one["effect"], one["joint"]): one["why"] for one in found}


def swinging(amplitude_rad, noise=1e-3):
    """(model, columns) of the project's pendulum, its torque that of its own model."""
    tree = yaml.safe_load(PENDULUM.read_text())
    t = np.arange(0, 40, 0.004)
    q = amplitude_rad * (np.sin(1.3 * t) + 0.4 * np.sin(3.7 * t + 1))
    v, a = np.gradient(q, t), np.gradient(np.gradient(q, t), t)
    torque = talus.Model.from_tree(tree).inverse(q[None], v[None], a[None])[0]
    gain = tree["joint"]["torque_constant_Nm_A"] * tree["joint"]["transmission"]["ratio"]
    current = (torque + np.random.default_rng(1).normal(0, noise * np.std(torque), len(t))) / gain
    return tree, {"time_s": t, "joint_rad": q, "joint_current_A": current}


def test_identification_takes_up_a_joints_own_constants(tmp_path):
    tree, columns = swinging(0.6)
    found = listed(tmp_path, columns, tree)
    assert "own parameters" in found["current_offset", "joint"] and "sensor" in found["torque_constant", "joint"]
    assert not {("stribeck", "joint"), ("load_friction", "joint"), ("delay", "joint"), ("sensor_offset", "joint")} & set(found)


def test_what_took_up_a_currents_zero_is_said_with_its_size(tmp_path):
    """A zero of 0.3 Nm on the project's pendulum, whose model gives none."""
    tree, columns = swinging(0.6)
    gain = tree["joint"]["torque_constant_Nm_A"] * tree["joint"]["transmission"]["ratio"]
    columns["joint_current_A"] = columns["joint_current_A"] + 0.3 / gain
    why = listed(tmp_path, columns, tree)["current_offset", "joint"]
    words = why.split("torque_offset_Nm goes from ")[1].split(" to ")
    assert float(words[0]) == 0.0 and float(words[1]) == pytest.approx(0.3, rel=0.02)


def test_what_does_not_move_is_said(tmp_path):
    """Waves of up to 84 a turn of the motor, on a joint that goes a ninetieth of one."""
    tree, columns = swinging(0.025)
    tree["joint"]["transmission"]["ratio"] = 1.0
    columns["joint_current_A"] = columns["joint_current_A"] * yaml.safe_load(PENDULUM.read_text())["joint"]["transmission"]["ratio"]
    found = listed(tmp_path, columns, tree)
    assert found["cogging", "joint"].startswith("nothing in these recordings")
