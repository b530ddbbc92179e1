"""The check where nothing is hidden (tools/talus/known): the draw, every figure on reports made by hand, and small benches run."""

import csv
import itertools
import json
import subprocess

import numpy as np
import pytest

import talus
from talus.known import null_scores, nulls, outputs, running
from talus.known.command import main, read_only

SMALL = "plant=pendulum rate_Hz=100 length_s=20 bits=exact excitation=multisine,ramps"


# ---- the draw --------------------------------------------------------------------------


def test_the_grid_is_drawn_whole_and_once():
    size = 3 * 6 * 5 * 3 * 3
    cases = nulls.draw(4, size + 5)
    assert len({case.name for case in cases}) == size + 5
    assert {tuple(case.setting.values()) for case in cases[:size]} == set(itertools.product(*nulls.AXES.values()))
    assert [case.round for case in cases[size:]] == [1] * 5


def test_a_case_does_not_depend_on_the_count():
    assert nulls.draw(4, 40)[:7] == nulls.draw(4, 7)
    assert nulls.draw(5, 7) != nulls.draw(4, 7)
    part = nulls.draw(4, 12, {"plant": {"leg"}, "bits": {0}})
    assert {(case.plant, case.bits, case.encoder) for case in part} == {("leg", 0, "exact")}
    assert part == [case for case in nulls.draw(4, 810) if case.plant == "leg" and case.bits == 0][:12]


def test_noise_and_phases_differ_between_cases_seeds_and_rounds():
    def seed_of(case):
        command = case.command("x.csv")
        return command[command.index("--seed") + 1]

    cases = [*nulls.draw(1, 812), *nulls.draw(2, 300)]
    assert len({seed_of(case) for case in cases}) == len(cases)


def test_a_bench_is_what_its_name_says(tmp_path):
    (case,) = nulls.draw(3, 1, read_only("plant=pendulum rate_Hz=125 length_s=20 bits=12 excitation=ramps"))
    assert case.name == "pendulum-125Hz-12bit-ramps-20s"
    subprocess.run(case.command(tmp_path / "r.csv"), check=True, capture_output=True)
    recording = talus.Recording.read(tmp_path / "r.csv")
    assert len(recording.t) == 125 * 20
    steps = recording.columns["joint_rad"] / (2 * np.pi / 2**12)
    assert np.abs(steps - np.round(steps)).max() < 0.02 and np.ptp(steps) > 100


# ---- every figure, by hand -------------------------------------------------------------


def result(number, effect, probability, listed=(), others=(), findings=None, **setting):
    """One that talus-gap might have given; `findings` are ids of grave findings that withhold it."""
    entry = lambda e, p: {"effect": e, "joint": "joint", "probability": p}  # noqa: E731
    report = {"verdict": entry(effect, probability), "alternatives": [entry(*o) for o in others],
              "effects": [entry(*e) for e in listed], "findings": []}  # fmt: skip
    if findings is not None:
        report["verdict"]["withheld"] = True
        report["findings"] = [{"id": name, "grave": True} for name in findings] + [{"id": "clock", "grave": False}]
    where = {"plant": "leg", "rate_Hz": 100, "bits": 0, "excitation": "paper", "length_s": 20}
    return {"case": f"case{number}", "setting": {**where, **setting}, "bench": "", "report": report, "processor_s": 1.0, "peak_MB": 50.0}


def every_kind():
    some = [
        result(0, "none", 0.9, others=[("unknown", 0.1)]),
        result(1, "none", 0.6, others=[("stribeck", 0.4)], plant="slider"),
        result(2, "unknown", 0.7, others=[("none", 0.3)]),
        result(3, "elasticity", 0.95, listed=[("elasticity", 0.95)]),
        result(4, "stribeck", 0.45, listed=[("stribeck", 0.45), ("delay", 0.6)], others=[("none", 0.2)]),
        result(5, "unknown", 1.0, findings=["too_short"]),
        result(6, "unknown", 1.0, findings=["saturated"]),
        result(7, "unknown", 1.0, findings=["units", "too_short"]),
        {**result(8, "none", 1.0), "report": None},
    ]
    some.append({**result(9, "unknown", 1.0, findings=["saturated"]), "bench": "note: a drive was at its current limit in 3 % of ..."})
    return some


def test_the_tally_by_hand():
    rows = [null_scores.judge(one) for one in every_kind()]
    assert [row["outcome"] for row in rows] == ["none", "none", "unknown", "cause", "cause", "shows too little", "accused", "accused",
                                                "failed", "shows too little"]  # fmt: skip
    figures = [bar.value for bar in null_scores.bars(rows)]
    assert figures == pytest.approx([0.4, 0.2, 0.1, 0.2, 0.1, 0.2, 0.1, (0.9 + 0.6 + 0.3 + 0.0 + 0.2) / 5])
    assert [bar.met for bar in null_scores.bars(rows)] == [False, None, None, False, False, False, False, False]


def test_strata_and_bins_by_hand():
    rows = [null_scores.judge(one) for one in every_kind()]
    by_name = {(s["axis"], s["value"]): s for s in null_scores.by_stratum(rows)}
    assert set(by_name) == {("plant", "leg"), ("plant", "slider"), ("rate_Hz", 100), ("bits", "exact"), ("excitation", "paper"),
                            ("length_s", 20)}  # fmt: skip
    slider, leg = by_name["plant", "slider"], by_name["plant", "leg"]
    assert (slider["cases"], slider["none"], slider["p_none"]) == (1, 1.0, 0.6)
    assert (leg["cases"], leg["none"], leg["too_little"], leg["cause_50"], leg["cause_90"]) == pytest.approx((9, 3 / 9, 2 / 9, 2 / 9, 1 / 9))
    # P(none) of 0.9, 0.6, 0.3, 0, 0.2: two below 0.2 or at it
    assert [(low, count, right) for low, _, count, _, right in null_scores.reliability(rows)] == [
        (0.0, 1, 0.0), (0.2, 2, 0.0), (0.5, 1, 1.0), (0.8, 1, 1.0)]  # fmt: skip


def test_all_right_meets_every_bar(tmp_path, capsys):
    results = [result(k, "none", 0.97, others=[("unknown", 0.03)]) for k in range(3)]
    outputs.nulls(results, tmp_path)
    assert "NOT" not in capsys.readouterr().out
    found = json.loads((tmp_path / "nulls.json").read_text())
    assert all(bar["met"] in (True, None) for bar in found["bars"]) and len(found["cases"]) == 3
    assert "3 end as none" in (tmp_path / "nulls.html").read_text()


# ---- the command -----------------------------------------------------------------------


def test_two_small_benches(tmp_path, capsys, monkeypatch):
    """Nothing hidden, exact encoders, and nothing is said to be hidden; the second run finds its reports there."""
    arguments = ["nulls", "--seed", "2", "--count", "2", "--only", SMALL, "--out", str(tmp_path)]
    assert main(arguments) == 0
    first = capsys.readouterr().out
    rows = list(csv.DictReader((tmp_path / "nulls.csv").read_text().splitlines()))
    assert sorted(row["excitation"] for row in rows) == ["multisine", "ramps"]
    for row in rows:
        report = json.loads((tmp_path / "seed2" / f"{row['case']}.json").read_text())["report"]
        assert row["verdict"] == report["verdict"]["effect"] and float(row["probability"]) == report["verdict"]["probability"]
        assert row["outcome"] in ("none", "unknown", "shows too little") and float(row["cause_probability"]) < 0.5
    monkeypatch.setattr(running, "diagnosed", lambda *_: pytest.fail("diagnosed again"))
    assert main(arguments) == 0 and capsys.readouterr().out == first


def test_a_report_of_another_version_is_made_anew_unless_kept(tmp_path, monkeypatch):
    cases = nulls.draw(1, 2)
    old = {"case": cases[0].name, "version": "another", "report": None, "status": 1}
    running.write(tmp_path / f"{cases[0].name}.json", json.dumps(old))
    asked = []

    def one(case):
        asked.append(case.name)
        return {"report": None, "status": 3}

    monkeypatch.setattr(running, "fingerprint", lambda: "this")
    assert [r["status"] for r in running.run("x", cases, tmp_path, one, keep=True)] == [1, 3] and asked == [cases[1].name]
    assert [r["status"] for r in running.run("x", cases, tmp_path, one)] == [3, 3] and asked == [cases[1].name, cases[0].name]


@pytest.mark.parametrize(("words", "message"), [
    (["--count", "0"], "above 0"), (["--only", "rate=100"], "AXIS=VALUE"), (["--only", "plant=arm"], "found 'arm'"),
])  # fmt: skip
def test_bad_options_are_refused(words, message, tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["nulls", "--out", str(tmp_path), *words])
    assert ended.value.code == 2 and message in capsys.readouterr().err


def test_a_bench_that_cannot_be_made_is_named(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(nulls, "model_of", lambda plant: tmp_path / "missing.yaml")
    assert main(["nulls", "--out", str(tmp_path), "--count", "1"]) == 1
    assert "talus-sim" in capsys.readouterr().err
