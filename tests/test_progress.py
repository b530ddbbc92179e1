"""What long work shows: percent on a terminal, on one line that is gone in the end; in a pipe nothing."""

import os
import pty
import re

import pytest
from support import REPOSITORY, program, run
from talus.progress import Stages

LEG = REPOSITORY / "models/leg.yaml"
DRAWN = re.compile(r"\r(?:\x1b\[K)?talus-\w+: ([^\r\n%]+?) +(\d+) %")


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    """A recording that takes several tenths of a second, which is how often the line is drawn."""
    path = tmp_path_factory.mktemp("long") / "long.csv"
    run("talus-sim", "--model", LEG, "--out", path, "--duration", "600", "--rate", "500")
    return path


def on_terminal(name, *arguments):
    """All that a program says where somebody watches."""
    said, (pid, terminal) = b"", pty.fork()
    if pid == 0:
        os.execv(program(name), [name, *map(str, arguments)])
    try:
        while chunk := os.read(terminal, 4096):
            said += chunk
    except OSError:
        pass  # the terminal's other end is closed
    os.close(terminal)
    assert os.waitpid(pid, 0)[1] == 0
    return said.decode()


def what_stays(said):
    """The text without what was drawn and wiped."""
    return re.sub(r"\r\x1b\[K", "", DRAWN.sub("", said)).replace("\r\n", "\n")


def check_programs(name, tasks, arguments):
    """The tasks, each with percents that rise; in a pipe the same text without them."""
    said, piped = on_terminal(name, *arguments), run(name, *arguments)
    shown = [(task, int(percent)) for task, percent in DRAWN.findall(said)]
    assert tasks <= {task for task, _ in shown}
    for (task, percent), (task_after, after) in zip(shown, shown[1:], strict=False):
        assert after >= percent or task != task_after
    assert "\r" not in piped.stderr and "\x1b" not in piped.stderr and what_stays(said) == piped.stderr
    assert said.rindex("\x1b[K") > said.rindex(f"{shown[-1][1]} %")


def test_identify_shows_percent(long, tmp_path):
    tasks = {"fitting long.csv", "judging long.csv"}
    check_programs("talus-identify", tasks, ["--model", LEG, "--out", tmp_path / "f.yaml", long])


def test_the_swarm_shows_percent(tmp_path):
    run("talus-sim", "--model", LEG, "--out", tmp_path / "leg.csv", "--duration", "20")
    swarm = ["--particles", "2000", "--iterations", "300", "--restarts", "3"]
    for threads in ("1", "2"):
        check_programs("talus-identify", {"searching"}, ["--model", LEG, "--out", tmp_path / "f.yaml", *swarm, "--threads", threads, tmp_path / "leg.csv"])


def test_predict_shows_percent(long, tmp_path):
    check_programs("talus-predict", {"scoring long.csv", "predicting long.csv"}, ["--model", LEG, "--out", tmp_path / "p.csv", "--report", tmp_path / "p.json", long])


def test_quiet_shows_nothing(long, tmp_path):
    assert not DRAWN.search(on_terminal("talus-identify", "--quiet", "--model", LEG, "--out", tmp_path / "f.yaml", long))


def test_gap_shows_percent(tmp_path):
    run("talus-sim", "--model", REPOSITORY / "models/pendulum.yaml", "--out", tmp_path / "arm.csv", "--rate", "250", "--duration", "20")
    arguments = ["--model", REPOSITORY / "models/pendulum.yaml", "--report", tmp_path / "gap.json", tmp_path / "arm.csv"]
    said, piped = on_terminal("talus-gap", *arguments), run("talus-gap", *arguments)
    percents = [int(percent) for _, percent in DRAWN.findall(said)]
    assert percents == sorted(percents) and percents[0] == 0 and percents[-1] >= 85 and len(set(percents)) >= 8
    assert "\r" not in piped.stderr and what_stays(said) == piped.stderr
    assert DRAWN.search(on_terminal("talus-gap", "--quick", *arguments))
    assert not DRAWN.search(on_terminal("talus-gap", "--quick", "--quiet", *arguments))


def test_a_part_of_a_stage_lies_between_it_and_the_next(monkeypatch):
    step, drawn = Stages("talus-x", {"a": 0, "b": 40}), []
    monkeypatch.setattr(step, "draw", drawn.append)
    for text, part in (("a", 0.0), ("one of a", 0.5), ("b", 0.0), ("one of b", 0.25), ("one of b", 0.1)):
        step(text, part)
    assert [int(line.split()[-2]) for line in drawn] == [0, 20, 40, 55, 55]
