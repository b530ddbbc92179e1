"""talus-fleet on a fleet of which it is known what there is to find (tools/talus/known/fleet.py), with processes that are killed."""

import json
import os
import subprocess
import sys
import time

import pytest
from support import BUILD, REPOSITORY, run

from talus.known import fleet

pytestmark = [pytest.mark.long, pytest.mark.alone, pytest.mark.release]
COUNT, PART = 80, "2/8"


def test_a_fleet_of_which_workers_die_is_diagnosed_as_one_by_one_and_its_secrets_are_named(tmp_path):
    planted = fleet.draw(tmp_path, COUNT, 1)
    count = len(planted.robots) * planted.sessions
    _, watch = fleet.through(tmp_path / "fleet.csv", tmp_path / "many", 2, count)
    assert len(watch.killed) == fleet.KILLS and count == COUNT
    fleet.through(tmp_path / "fleet.csv", tmp_path / "one", 1, count, "--shard", PART)
    many, part = fleet.files(tmp_path / "many"), fleet.files(tmp_path / "one")
    assert len({name.split("/")[1] for name in part}) == COUNT // 8 and part == {name: many[name] for name in part}
    assert sum(name.endswith("item.json") for name in many) == COUNT
    said = run("talus-fleet", "report", tmp_path / "many").stderr
    report = json.loads((tmp_path / "many/report.json").read_text())
    assert report["diagnosed"] == COUNT and said.strip() == report["sentence"]
    found = fleet.found(report)
    assert found["effects"]["nonlinear_viscous at the joint"] == planted.with_effect
    assert ("the fleet", "viscous_Nms_rad", "temperature") in found["drifts"]
    assert [one for one in found["drifts"] if one[0] != "the fleet"] == [(planted.drifting, "coulomb_Nm", "date")]
    page = (tmp_path / "many/report.html").read_text()
    for words in (f"nonlinear viscous at the joint: {planted.with_effect[0]} alone", f"coulomb_Nm of {planted.drifting} drifts by"):
        assert words in page


def test_a_cluster_that_is_there_does_the_same_work(tmp_path):
    """A scheduler and its workers are other processes; what they make is what one makes here."""
    from distributed import LocalCluster

    planted = fleet.draw(tmp_path, 10, 2)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50) as cluster:
        subprocess.run(fleet.command("run", tmp_path / "fleet.csv", "--out", tmp_path / "there", "--quick", "--scheduler", cluster.scheduler_address), check=True)
    fleet.through(tmp_path / "fleet.csv", tmp_path / "here", 1, len(planted.robots))
    assert fleet.files(tmp_path / "there") == fleet.files(tmp_path / "here")
    said = run("talus-fleet", "run", tmp_path / "fleet.csv", "--out", tmp_path / "no", "--scheduler", "tcp://127.0.0.1:9", status=1).stderr
    assert "talus-fleet: --scheduler tcp://127.0.0.1:9: cannot be reached" in said and len(said.splitlines()) == 1


CLUSTER = """
import time
from distributed import LocalCluster
if __name__ == "__main__":
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50) as cluster:
        print(cluster.scheduler_address, flush=True)
        time.sleep(600)
"""


def test_a_cluster_that_dies_is_one_line_and_the_same_command_goes_on(tmp_path):
    planted = fleet.draw(tmp_path, 20, 2)
    (tmp_path / "cluster.py").write_text(CLUSTER)
    environment = {**os.environ, "PYTHONPATH": str(REPOSITORY / "tools"), "TALUS_BUILD": str(BUILD)}
    with subprocess.Popen([sys.executable, tmp_path / "cluster.py"], env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                          text=True) as cluster:  # fmt: skip
        words = fleet.command("run", tmp_path / "fleet.csv", "--out", tmp_path / "out", "--quick", "--scheduler", cluster.stdout.readline().strip())
        with subprocess.Popen(words, stderr=subprocess.PIPE, text=True) as child:
            while not list((tmp_path / "out").glob("items/*/item.json")) and child.poll() is None:
                time.sleep(0.05)
            cluster.kill()
            said = child.stderr.read()
    assert child.returncode == 1 and len(said.splitlines()) == 1, said
    assert said.startswith("talus-fleet: the cluster has gone: ") and "the same command goes on" in said
    done = len(list((tmp_path / "out").glob("items/*/item.json")))
    count = len(planted.robots) * planted.sessions
    assert 0 < done < count
    assert f"{count} of {count} diagnosed, " in run("talus-fleet", "run", tmp_path / "fleet.csv", "--out", tmp_path / "out", "--quick", "--jobs", 1).stderr
