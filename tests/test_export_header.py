"""talus-export --to c: what it refuses, in one line with status 2, and that its numbers are the library's to the last bit."""

import subprocess

import pytest
from support import REPOSITORY, run

LEG = REPOSITORY / "models/leg.yaml"
REFUSED = "effects:\n  - {effect: cogging, joint: knee, parameters: {sine_Nm: 0.01, cosine_Nm: 0, per_turn: 12, fades_Hz: 0}}\n"


def test_the_header_is_the_same_every_time_and_compiles_alone(tmp_path):
    for name in ("leg.h", "again.h"):
        run("talus-export", "--to", "c", "--name", "leg", "--out", tmp_path / name, LEG)
    assert (tmp_path / "leg.h").read_bytes() == (tmp_path / "again.h").read_bytes()
    (tmp_path / "a.c").write_text('#include "leg.h"\nint main(void) { return leg_q31.stale_ticks - leg_f64.stale_ticks; }\n')
    flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-I", str(REPOSITORY / "include"), "-I", str(tmp_path)]
    subprocess.run(["cc", *flags, str(tmp_path / "a.c"), "-o", str(tmp_path / "a")], check=True)
    subprocess.run([str(tmp_path / "a")], check=True)


@pytest.mark.parametrize(("more", "options", "words"), [
    (REFUSED, [], ["cogging", "knee", "no fast form"]), ("", ["--knee-current", "0"], ["limit"]),
    ("", ["--name", "1leg"], ["--name"]), ("", ["--to", "fortran"], ["--to"]), ("", ["--ankle-high", "0.6"], ["limit"]),
    ("form: paper\n", [], ["lagrange"]),
])  # fmt: skip
def test_what_cannot_be_written_is_refused(tmp_path, more, options, words):
    model, out = tmp_path / "model.yaml", tmp_path / "leg.h"
    model.write_text(LEG.read_text() + more)
    out.write_text("as it was")
    options = options if "--to" in options else ["--to", "c", *options]
    said = run("talus-export", *options, "--out", out, model, status=2).stderr
    assert all(word in said for word in words), said
    assert out.read_text() == "as it was"


def test_a_pendulum_is_refused(tmp_path):
    said = run("talus-export", "--to", "c", "--out", tmp_path / "x.h", REPOSITORY / "models/pendulum.yaml", status=2).stderr
    assert "leg" in said and not (tmp_path / "x.h").exists()


def test_sizes_are_printed():
    done = subprocess.run([str(REPOSITORY / "tools/sizes")], capture_output=True, text=True, check=True)
    assert "tl_controller_state_q31" in done.stdout and "stack" in done.stdout
