"""talus-fleet: its files are talus-gap's, whoever makes them; what is done stays, what fails is said, and what dies is made again."""

import csv
import json
import os
import shutil
import signal
import time

import numpy as np
import pytest
from support import REPOSITORY, run

from talus.fleet import command, item, pool, table
from talus.refused import Refused

pytestmark = pytest.mark.release  # processes of a cluster start and end beside each other: sanitizers are for the programs themselves
HEADER = "recording,model,robot,session,temperature_C\n"


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """Two sessions of two arms; the last is not there."""
    folder = tmp_path_factory.mktemp("arms")
    shutil.copy(REPOSITORY / "models/pendulum.yaml", folder)
    rows = [f"{robot}-{day}.csv,pendulum.yaml,arm {robot},2026-03-{day:02d},{20 + day}\n" for robot in "ab" for day in (1, 2)]
    for k, row in enumerate(rows[:-1]):
        run("talus-sim", "--model", folder / "pendulum.yaml", "--out", folder / row.split(",")[0], "--duration", 10, "--seed", k)
    (folder / "fleet.csv").write_text(HEADER + "".join(rows))
    return folder


@pytest.fixture(scope="module")
def many(recordings, tmp_path_factory):
    """What two processes make of them, and what the command says."""
    out = tmp_path_factory.mktemp("many")
    return out, run("talus-fleet", "run", recordings / "fleet.csv", "--out", out, "--quick", "--jobs", 2).stderr


def results(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted((folder / "items").rglob("*")) if path.is_file()}


def here(capsys, *words):
    """What the command says, one item after the other in this process."""
    assert command.main([*map(str, words), *(["--quick", "--jobs", "1"] if words[0] == "run" else [])]) == 0
    return capsys.readouterr().err


def test_a_run_is_talus_gap_on_each_recording(recordings, many, tmp_path):
    out, said = many
    assert len(said.splitlines()) == 2 and "talus-fleet: 3 of 4 diagnosed; 1 failed" in said
    assert said.count("failed: arm b, 2026-03-02: ") == 1 and "b-2.csv" in said
    run("talus-gap", "--model", recordings / "pendulum.yaml", "--report", tmp_path / "gap.json", "--save-model", tmp_path / "fitted.yaml",
        "--quick", "--quiet", recordings / "b-1.csv")  # fmt: skip
    own = next((out / "items").glob("arm-b_2026-03-01_*"))
    for name in ("gap.json", "fitted.yaml"):
        assert (own / name).read_bytes() == (tmp_path / name).read_bytes()


@pytest.mark.long
def test_shards_make_the_same_files_the_report_says_what_is_missing_and_a_run_goes_on(recordings, many, tmp_path, capsys):
    here(capsys, "run", recordings / "fleet.csv", "--out", tmp_path, "--shard", "2/3")
    here(capsys, "report", tmp_path)
    first = json.loads((tmp_path / "report.json").read_text())
    assert (first["diagnosed"], len(first["waiting"]), first["items"]) == (1, 3, 4)
    for shard in ("1/3", "3/3"):
        here(capsys, "run", recordings / "fleet.csv", "--out", tmp_path, "--shard", shard)
    assert results(tmp_path) == results(many[0]) and len(results(tmp_path)) >= 3 * 3 + 1
    said = here(capsys, "report", tmp_path)
    whole = json.loads((tmp_path / "report.json").read_text())
    assert (whole["diagnosed"], whole["waiting"], [one["robot"] for one in whole["failed"]]) == (3, [], ["arm b"])
    page = (tmp_path / "report.html").read_text()
    assert said.strip() == whole["sentence"] and "b-2.csv" in page and "3 of 4 diagnoses of 2 robots" in page
    goes_on(recordings, tmp_path, capsys)


def goes_on(recordings, out, capsys):
    """A second run makes what failed and what is half there; it leaves the rest as it is, until that is recorded anew."""
    before = {path: path.stat().st_mtime_ns for path in (out / "items").glob("*/item.json")}
    shutil.copy(recordings / "a-1.csv", recordings / "b-2.csv")
    half = next((out / "items").glob("arm-a_2026-03-02_*"))
    (half / "item.json").unlink()
    (half / "gap.json.99.tmp").write_text("{")
    try:
        said = here(capsys, "run", recordings / "fleet.csv", "--out", out)
        assert said == "talus-fleet: 4 of 4 diagnosed, 2 of them before\n"
        kept = {path.parent.name[:16] for path, when in before.items() if path.stat().st_mtime_ns == when}
        assert kept == {"arm-a_2026-03-01", "arm-b_2026-03-01"} and not list(half.glob("*.tmp*"))
        os.utime(recordings / "b-2.csv", ns=(1, 1))
        assert here(capsys, "run", recordings / "fleet.csv", "--out", out).endswith("4 of 4 diagnosed, 3 of them before\n")
    finally:
        (recordings / "b-2.csv").unlink()


def test_recordings_of_a_session_make_one_diagnosis(recordings, tmp_path, capsys):
    (recordings / "pairs.csv").write_text(HEADER + "a-1.csv,pendulum.yaml,x,2026-03-01,20\na-2.csv,pendulum.yaml,x,2026-03-01,24\n")
    here(capsys, "run", recordings / "pairs.csv", "--out", tmp_path, "--by-session")
    (own,) = (tmp_path / "items").iterdir()
    kept = json.loads((own / "item.json").read_text())
    assert [os.path.basename(path) for path in kept["recordings"]] == ["a-1.csv", "a-2.csv"] and kept["temperature_C"] == 22
    run("talus-gap", "--model", recordings / "pendulum.yaml", "--report", tmp_path / "gap.json", "--quick", "--quiet",
        recordings / "a-1.csv", recordings / "a-2.csv")  # fmt: skip
    assert (own / "gap.json").read_bytes() == (tmp_path / "gap.json").read_bytes()


def test_the_longest_recordings_come_first(tmp_path, monkeypatch):
    """So that the last ones to end are short; of equal length they stay in the table's order."""
    for name, rows in (("short", 1), ("long", 3), ("middle", 2), ("also_long", 3)):
        (tmp_path / f"{name}.csv").write_text("1,2\n" * rows)
    (tmp_path / "fleet.csv").write_text(HEADER + "".join(f"{name}.csv,m.yaml,{name},2026-03-01,20\n" for name in ("short", "long", "gone", "middle", "also_long")))
    asked = []
    monkeypatch.setattr(pool, "outcomes", lambda items, *_: asked.extend(one.robot for one in items) or ())
    command.main(["run", str(tmp_path / "fleet.csv"), "--out", str(tmp_path / "out"), "--quiet"])
    assert asked == ["long", "also_long", "middle", "short", "gone"]


# ---- processes that die, and what the scheduler holds --------------------------------


@pytest.mark.long
def test_a_killed_process_loses_nothing_and_the_scheduler_holds_few(tmp_path):
    """300 items of work that takes a moment; two workers are killed on the way."""
    import distributed

    items = [table.Item(f"n{k}", "r", "2026-01-01", "m", ()) for k in range(300)]

    def work(one):
        time.sleep(0.01)
        return 0, one.name

    seen, most, killed = [], 0, 0
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0", "silence_logs": 50}
    with distributed.LocalCluster(**options) as cluster, distributed.Client(cluster) as client:
        for one, outcome in pool.spread(client, iter(items), work):
            assert outcome == (0, one.name)
            seen.append(one.name)
            most = max(most, len(cluster.scheduler.tasks))
            if killed < 2 and len(seen) >= 40 * (killed + 1):
                os.kill(cluster.workers[killed].pid, signal.SIGKILL)
                killed += 1
    assert killed == 2 and sorted(seen) == sorted(one.name for one in items)
    assert most <= 2 * pool.AHEAD


def test_an_item_that_no_process_survives_is_a_failure_like_others(tmp_path):
    work = item.Work(str(tmp_path))
    one = table.Item("n", "r", "2026-01-01", str(tmp_path / "m.yaml"), (str(tmp_path / "r.csv"),))
    assert command.settled(work, one, RuntimeError("worker died\nagain")) == (1, "RuntimeError: worker died again")
    assert work.kept(one)["said"] == "RuntimeError: worker died again" and not work.is_done(one)


def test_without_dask_one_line_says_so(recordings, tmp_path):
    (tmp_path / "distributed.py").write_text("raise ImportError('not there')\n")
    said = run("talus-fleet", "run", recordings / "fleet.csv", "--out", tmp_path / "out", "--jobs", 2, status=1,
               env={**os.environ, "PYTHONPATH": str(tmp_path)}).stderr  # fmt: skip
    assert said == "talus-fleet: needs Dask's distributed: pip install 'talus[fleet]', or --jobs 1 does without it\n"


# ---- bad input -------------------------------------------------------------------------

ROW = "a.csv,m.yaml,r,2026-03-01,20\n"
BAD_TABLES = {
    "": r"fleet.csv:1: missing column: recording; found nothing",
    "recording;model;robot;session\n": r"fleet.csv:1: missing column: recording; found recording;model;robot;session",
    "recording,model,robot,session,colour\n": r"fleet.csv:1: unexpected column: colour",
    "recording,model,robot,session,robot\n": r"fleet.csv:1: unexpected column: robot",
    HEADER: r"fleet.csv: no recording below the header",
    HEADER + "a.csv,m.yaml,r\n": r"fleet.csv:2: expected 5 fields, found 3",
    HEADER + ROW + "b.csv,,r,2026-03-01,20\n": r"fleet.csv:3: model is empty",
    HEADER + "a.csv,m.yaml,r,1.3.2026,20\n": r"fleet.csv:2: session: expected a date such as .*, found '1.3.2026'",
    HEADER + "a.csv,m.yaml,r,2026-03-01,warm\n": r"fleet.csv:2: temperature_C: expected a number from -100 to 300, found 'warm'",
    HEADER + "a.csv,m.yaml,r,2026-03-01,nan\n": r"fleet.csv:2: temperature_C: expected a number from -100 to 300, found 'nan'",
    HEADER + "a.csv,m.yaml,r,2026-03-01,20\n" * 2: r"a.csv stands there twice",
    HEADER + ROW + "b.csv,n.yaml,r,2026-03-01,\n": r"r, 2026-03-01: expected one model for the session's recordings",
}


@pytest.mark.parametrize("text", BAD_TABLES)
def test_a_bad_table_gets_one_line(tmp_path, text):
    (tmp_path / "fleet.csv").write_text(text)
    with pytest.raises(Refused, match=BAD_TABLES[text]) as refused:
        table.read(tmp_path / "fleet.csv", by_session=True)
    assert refused.value.status == 2


@pytest.mark.parametrize(("words", "said"), [
    ("", "expected run or report, found ''"), ("run", "run: expected one FLEET.csv"), ("run f.csv", "--out is missing"),
    ("run f.csv --out d --jobs 0", "--jobs: expected a whole number from 1 to 1024, found '0'"),
    ("run f.csv --out d --shard 3/2", "--shard: expected I/N with I from 1 to N, found '3/2'"),
    ("run f.csv --out d --shard 1", "--shard: expected I/N with I from 1 to N, found '1'"),
    ("run f.csv --out d --lowpass x", "--lowpass: expected a frequency in Hz above 0, found 'x'"),
    ("run f.csv --out d --jobs 2 --scheduler tcp://a:1", "expected one of them"), ("report d --quick", "--quick is an option of talus-fleet run"),
    ("run f.csv --out d", "f.csv: cannot be read: No such file or directory"),
    ("report d", "d/fleet.json: cannot be read: No such file or directory; talus-fleet run makes it")])  # fmt: skip
def test_bad_usage_gets_one_line_and_leaves_nothing(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert command.main(words.split()) == 2
    out = capsys.readouterr().err
    assert len(out.splitlines()) == 1 and out.startswith("talus-fleet: ") and said in out
    assert list(tmp_path.iterdir()) == []


# ---- what they have in common -----------------------------------------------------------


def invented(tmp_path, sessions=9):
    """Results of ten arms as a run leaves them: an effect of arm 3, friction that grows with arm 5's age, oil that all share, a heavy arm 8."""
    rng, items = np.random.default_rng(4), []
    work = item.Work(str(tmp_path))
    for k in range(10):
        for s in range(sessions):
            temperature = float(rng.uniform(15, 30))
            one = table.Item(f"{k}-{s}", f"arm {k}", f"2026-0{1 + s // 4}-{1 + 7 * (s % 4):02d}", "m.yaml", (f"{k}-{s}.csv",), temperature)
            values = {"coulomb_Nm": 0.25 + 0.0015 * s * (k == 5), "viscous_Nms_rad": 0.02 - 2e-4 * (temperature - 22), "inertia_kg_m2": 0.045 + 0.002 * (k == 8)}
            values = {name: value * (1 + 0.002 * rng.standard_normal()) for name, value in values.items()}
            named = {"effect": "stribeck", "joint": "joint", "probability": 0.9, "parameters": {"extra_Nm": 0.1 + 0.001 * rng.standard_normal()}}
            gap = {"joint": {"unit": "Nm", "nominal_rms": 0.02, "identified_rms": 0.02, "noise_floor_rms": 0.01,
                             "extended_rms": 0.011 * float(np.exp(0.02 * rng.standard_normal())) * (3 if (k, s) == (1, 6) else 1)}}  # fmt: skip
            verdict = named if k == 3 else {"effect": "none", "joint": "none", "probability": 0.9}
            kept = {"verdict": {key: verdict[key] for key in ("effect", "joint", "probability")}, "effects": [named] * (k == 3), "gap": gap,
                    "motion": {}, "findings": [], "parameters": values}  # fmt: skip
            work.keep(one, {}, 0, "", kept)
            items.append(one)
    command.write_fleet(work, items)
    return items


def test_the_report_names_what_was_put_there_and_nothing_else(tmp_path):
    items = invented(tmp_path)
    assert command.main(["report", str(tmp_path), "--quiet"]) == 0
    found = json.loads((tmp_path / "report.json").read_text())
    (effect,) = found["effects"]
    assert (effect["effect"], effect["scope"], [robot["robot"] for robot in effect["robots"]]) == ("stribeck", "own", ["arm 3"])
    moving = [(one["robot"], one["quantity"], one["over"]) for one in found["drift"] if one["drifts"] and one["scope"] != "with the fleet"]
    assert moving == [("the fleet", "viscous_Nms_rad", "temperature"), ("arm 5", "coulomb_Nm", "date")]
    slope = next(one for one in found["drift"] if one["robot"] == "arm 5" and one["drifts"] and one["over"] == "date")
    by_least_squares = np.polyfit(*zip(*((table.days(one.session), 0.25 + 0.0015 * s) for s, one in enumerate(items[:9]))), 1)[0]
    assert slope["interval"][0] < by_least_squares < slope["interval"][1] and slope["slope"] == pytest.approx(by_least_squares, rel=0.1)
    outstanding = {(one["robot"], one["quantity"]) for one in found["stand_out"]}
    assert ("arm 8", "inertia_kg_m2") in outstanding and outstanding <= {("arm 8", "inertia_kg_m2"), ("arm 5", "coulomb_Nm")}
    assert [(one["robot"], one["session"], one["quantity"]) for one in found["changes"]] == [("arm 1", items[6].session, "joint: gap")]
    page = (tmp_path / "report.html").read_text()
    assert "stribeck at the joint: arm 3 alone" in page and "coulomb_Nm of arm 5 drifts by" in page and "arm 5: coulomb_Nm over date" in page


def test_the_parquet_table_has_a_row_a_diagnosis(tmp_path):
    from pyarrow import parquet

    items = invented(tmp_path, sessions=1)
    command.main(["report", str(tmp_path), "--quiet"])
    rows = parquet.read_table(tmp_path / "report.parquet").to_pylist()
    assert [row["robot"] for row in rows] == [one.robot for one in items]
    assert [row["temperature_C"] for row in rows] == [one.temperature_C for one in items]
    kept = [json.loads((tmp_path / "items" / one.name / "item.json").read_text()) for one in items]
    assert [row["parameter coulomb_Nm"] for row in rows] == [one["parameters"]["coulomb_Nm"] for one in kept]
    assert [row["effect"] for row in rows].count("stribeck") == 1 and json.loads(rows[3]["effects"])[0]["joint"] == "joint"


def test_a_table_of_a_spreadsheet_is_read(tmp_path):
    """With a byte-order mark, quoted names, empty lines and no temperature."""
    with open(tmp_path / "fleet.csv", "w", encoding="utf-8-sig", newline="") as file:
        csv.writer(file).writerows([["robot", "session", "recording", "model"], ["arm, left", "2026-03-01T08:00", "a.csv", "m.yaml"], []])
    (one,) = table.read(tmp_path / "fleet.csv")
    assert (one.robot, one.temperature_C, one.recordings) == ("arm, left", None, (str(tmp_path / "a.csv"),))
    assert table.days("2026-03-01T08:00") - table.days("2026-03-01") == pytest.approx(1 / 3)
