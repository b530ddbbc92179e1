"""The check of the gate (tools/talus/known): which benches are drawn, what a fault does and when it is none, every figure on results
made by hand, and one bench run. That the gate names each kind: tests/test_gap_gate.py."""

import csv
import json

import numpy as np
import pytest
import talus
from support import REPOSITORY
from talus.known import benches, gate_outputs, gate_scores, gates, spoilings
from talus.known.command import main

T = np.arange(4000) * 0.005


def bench(model="pendulum", **columns):
    """Of one joint that moves, with a noisy current."""
    q, noise = np.sin(2 * T) + 0.3 * np.sin(3.1 * T), np.random.default_rng(1).normal(size=len(T))
    given = {"time_s": T, "joint_rad": q, "joint_current_A": np.gradient(q, T) + 0.02 * noise, **columns}
    return spoilings.Bench("b", "p", talus.Model.read(REPOSITORY / f"models/{model}.yaml"), [given])


# ---- the draw ------------------------------------------------------------------------------


def test_plants_take_turns_and_no_case_depends_on_the_count():
    numbers = benches.numbers(3, 12)
    assert [benches.first_plant(3, number) for number in numbers] == [*benches.PLANTS] * 3
    assert len(set(numbers)) == 12 and numbers[:5] == benches.numbers(3, 5)


def test_some_benches_are_spoiled_and_more_are_left(monkeypatch):
    monkeypatch.setattr(benches, "real", lambda data: [("r", "emps", "", ["r.csv"])])
    cases = gates.draw("data", 1, 2)
    assert [case.spoils for case in cases] == [True] * 2 + [False] * 2 * gates.LEFT_SOUND + [True]
    assert len({case.name for case in cases}) == len(cases)


# ---- the faults ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", spoilings.KINDS)
def test_a_fault_is_the_same_for_its_seed_and_leaves_the_sound_ones_alone(kind):
    one = bench()
    before = {name: x.copy() for name, x in one.recordings[0].items()}
    first, again = (spoilings.spoil(one, kind, 5) for _ in range(2))
    assert all(np.array_equal(x, before[name]) for name, x in one.recordings[0].items())
    assert (first is None) == (again is None)
    if first:
        for a, b in zip(first.bench.recordings, again.bench.recordings, strict=True):
            assert all(np.array_equal(a[name], b[name]) for name in a)
        assert any(not np.array_equal(c.get(name), before[name]) for c in first.bench.recordings for name in before)


def test_what_nothing_could_tell_is_no_fault():
    assert spoilings.spoil(bench(), "unsigned current", 1)
    assert spoilings.spoil(bench(joint_current_A=2 + 0.1 * np.sin(T)), "unsigned current", 1) is None  # never changes its sign
    assert spoilings.spoil(bench(joint_rad=np.sin(250 * T) * 4), "wrapped angle", 1) is None  # by half a turn from row to row
    assert spoilings.spoil(bench(joint_rad=np.round(np.sin(T) * 10) / 10), "angle in degrees", 1) is None  # too coarse to move
    steady = bench(joint_current_A=np.full(len(T), 3.0) + 1e-3 * np.sin(T))
    assert spoilings.spoil(steady, "current at its limit", 1) is None  # asked to be constant
    beside = bench(joint_load_Nm=np.cos(7 * T))
    assert spoilings.spoil(beside, "current in milliamperes", 1) is None  # goes with nothing


def test_a_speed_tells_an_angles_unit_beside_a_sensor():
    beside = bench(joint_load_Nm=np.cos(7 * T))
    assert spoilings.spoil(beside, "angle in degrees", 1) is None
    moving = bench(joint_load_Nm=np.cos(7 * T), joint_velocity_rad_s=np.gradient(beside.recordings[0]["joint_rad"], T))
    assert spoilings.spoil(moving, "angle in degrees", 1).column == "joint_rad"


# ---- every figure, by hand ------------------------------------------------------------------


def finding(name, column="", grave=True):
    return {"id": name, "column": column, "grave": grave, "evidence": "e", "remedy": "r"}


def fault(kind, expected, column, *findings):
    return {"kind": kind, "finding": expected, "column": column, "findings": list(findings)}


def results():
    setting = {"plant": "leg", "hidden": "", "rate_Hz": 200, "rows": 10}
    spoiled = [
        fault("degrees", "units", "knee_motor_rad", finding("units", "knee_motor_rad")),
        fault("spike", "spike", "knee_current_A", finding("spike", "knee_current_A", False), finding("sign", "ankle_current_A")),
        fault("sign", "sign", "knee_current_A", finding("sign", "ankle_current_A")),
        fault("few steps", "coarse", "knee_motor_rad", finding("too_little_motion"), finding("coarse", "knee_motor_rad", False)),
    ]
    return [
        {"case": "a", "setting": setting, "sound": [finding("clock", "time_s", False)], "spoiled": spoiled},
        {"case": "b", "setting": {**setting, "hidden": "hose"}, "sound": [finding("sign", "knee_current_A")], "spoiled": []},
        {"case": "c", "setting": {**setting, "plant": "slider"}, "sound": [finding("too_short", "time_s")],
         "spoiled": [fault("degrees", "units", "slider_m")]},
    ]  # fmt: skip


def test_the_tally_by_hand():
    judged = [gate_scores.judge(result) for result in results()]
    spoiled, sound = [row for rows, _ in judged for row in rows], [row for _, row in judged]
    assert [row["named"] for row in spoiled] == [True, True, False, True, False]
    assert [row["others"] for row in spoiled] == ["", "sign ankle_current_A", "sign ankle_current_A", "", ""]
    assert [(row["others"], row["too_little"]) for row in sound] == [("", ""), ("sign knee_current_A", ""), ("", "too_short time_s")]
    kinds = {kind["value"]: (kind["cases"], kind["plants"], kind["named"], kind["others"]) for kind in gate_scores.by(spoiled, "kind")}
    assert kinds == {"degrees": (2, 2, 0.5, 0.0), "spike": (1, 1, 1.0, 1.0), "sign": (1, 1, 0.0, 1.0), "few steps": (1, 1, 1.0, 0.0)}
    bars = gate_scores.bars(spoiled, sound)
    assert [bar.value for bar in bars] == pytest.approx([0.5, 0.0, 0.6, 0.4, 1 / 3, 1 / 3])
    assert [bar.met for bar in bars] == [False, False, False, False, False, None]


def test_the_tables_are_written(tmp_path, capsys):
    gate_outputs.gate(results(), tmp_path)
    said = capsys.readouterr().out
    assert "missed: sign; a; leg; sign knee_current_A; sign ankle_current_A" in said
    assert "on sound ones: b; leg; hose; sign knee_current_A" in said
    rows = list(csv.DictReader((tmp_path / "gate.csv").read_text().splitlines()))
    assert len(rows) == 8 and len(json.loads((tmp_path / "gate.json").read_text())["kinds"]) == 4
    assert "3 are named" in (tmp_path / "gate.html").read_text()


# ---- the command -----------------------------------------------------------------------------


def test_a_bench_with_an_effect_is_sound(tmp_path, capsys, monkeypatch):
    """It is examined once; the second run finds its result there."""
    small = next(gates.Simulated(2, number, True) for number in benches.with_plant(2, "pendulum"))
    monkeypatch.setattr(gates, "draw", lambda data, seed, count: [small])
    arguments = ["gate", "--seed", "2", "--count", "1", "--out", str(tmp_path)]
    assert main(arguments) == 0
    first = capsys.readouterr().out
    (row,) = csv.DictReader((tmp_path / "gate.csv").read_text().splitlines())
    assert row["plant"].startswith("pendulum") and row["hidden"] and row["others"] == "" and row["kind"] == ""
    monkeypatch.setattr(gates, "examine", lambda case: pytest.fail("examined again"))
    assert main(arguments) == 0 and capsys.readouterr().out == first
