"""Each public function and method has an example in its docstring, and each runs and prints what it says."""

import doctest
import importlib
import inspect
import types

import matplotlib
import numpy
import pytest
import talus
from support import REPOSITORY

matplotlib.use("Agg")
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
FUNCTIONS = (types.FunctionType, classmethod, staticmethod)


def examples_of(what, name):
    """The docstring's own, without those of a class's methods."""
    parser = doctest.DocTestParser()
    return parser.get_doctest(inspect.getdoc(what) or "", {"talus": talus, "numpy": numpy}, name, None, None)


def methods(kind):
    """{name: function} of what a class defines itself, for its users."""
    return {f"{kind.__name__}.{name}": getattr(kind, name) for name, item in vars(kind).items()
            if isinstance(item, FUNCTIONS) and not name.startswith("_")}  # fmt: skip


def public_face(module):
    """{name: object} of all that has a docstring of its own: functions, classes, and their methods."""
    out = {}
    for name in module.__all__:
        item = getattr(module, name)
        if inspect.isclass(item):
            out |= {name: item} | methods(item)
        elif callable(item):
            out[name] = item
    return {name: item for name, item in out.items() if item is not talus.lib and item is not talus.ffi}


FACE = public_face(talus)


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    """models/ is there, a recording of an arm, and a folder to write to."""
    folder = tmp_path_factory.mktemp("docstrings")
    (folder / "models").symlink_to(REPOSITORY / "models")
    talus.simulate(talus.Model.read(REPOSITORY / "models/pendulum.yaml"), duration_s=20).write(folder / "arm.csv")
    return folder


def run(example, held=None):
    """The names that the example leaves; none of it fails."""
    example.globs |= held or {}
    said = []
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    runner.run(example, out=said.append, clear_globs=False)
    assert runner.failures == 0, "".join(said)
    return example.globs


def test_the_face_is_all_that_can_be_called():
    assert {"identify", "Model", "Model.read", "Model.energy", "Recording.segments", "Diagnosis.plot", "Page.side_by_side"} <= set(FACE)
    assert not any(name.split(".")[-1].startswith("_") for name in FACE)
    missing = [name for name in talus.__all__ if name not in FACE]
    assert missing == ["BUILD", "constants", "ffi", "lib"]  # a path, and the C library as it is


def test_each_has_an_example():
    assert [name for name, item in FACE.items() if not examples_of(item, name).examples] == []


def test_what_lacks_one_is_found():
    bare = types.SimpleNamespace(__all__=["Bare"], Bare=type("Bare", (), {"read": classmethod(lambda _: None), "__doc__": ">>> 1\n1"}))
    assert [name for name, item in public_face(bare).items() if not examples_of(item, name).examples] == ["Bare.read"]


@pytest.mark.parametrize("name", [name for name in FACE if name != "diagnose" and not name.startswith("Diagnosis")])
def test_each_example_runs(name, scratch, monkeypatch):
    monkeypatch.chdir(scratch)
    run(examples_of(FACE[name], name))
    importlib.import_module("matplotlib.pyplot").close("all")


def test_the_examples_of_a_diagnosis_go_on_from_that_of_diagnose(scratch, monkeypatch):
    monkeypatch.chdir(scratch)
    held = run(examples_of(talus.diagnose, "diagnose"))
    for name in FACE:
        if name.startswith("Diagnosis"):
            run(examples_of(FACE[name], name), {"found": held["found"]})
    importlib.import_module("matplotlib.pyplot").close("all")
