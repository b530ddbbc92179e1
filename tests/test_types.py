"""What a user imports has complete type hints."""

import subprocess
import sys

import pytest
from support import BUILD, REPOSITORY

pytestmark = pytest.mark.release
USE = """
import talus

model = talus.Model.read("m.yaml")
recording = talus.Recording({"time_s": [0.0, 0.1], "joint_rad": [0.0, 0.0]})
fit = talus.identify(model, [recording])
x: float = fit.sigma["inertia_kg_m2"]
reveal_type(fit.model.joints)
talus.Recording(recording.to_pandas())
recording.plot().savefig("arm.png")
talus.predict(model, 3)
"""


def mypy(*arguments):
    command = [sys.executable, "-m", "mypy", "--config-file", REPOSITORY / "pyproject.toml", "--cache-dir", BUILD / "mypy",
               *arguments]  # fmt: skip
    return subprocess.run(command, cwd=REPOSITORY, check=False, capture_output=True, text=True)


def test_the_public_face_is_strict():
    done = mypy()
    assert done.returncode == 0 and "no issues found in" in done.stdout, done.stdout + done.stderr


def test_a_user_is_told_of_a_wrong_argument(tmp_path):
    (tmp_path / "use.py").write_text(USE)
    done = mypy(tmp_path / "use.py")
    assert 'use.py:8: note: Revealed type is "builtins.list[builtins.str]"' in done.stdout.replace("list[str]", "list[builtins.str]").replace('"list[', '"builtins.list[')
    assert 'use.py:11: error: Argument 2 to "predict" has incompatible type "int"; expected "Recording"' in done.stdout
    assert "Found 1 error" in done.stdout
