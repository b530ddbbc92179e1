"""talus-export --to mcap: what two readers that are not talus find in it, and that the layouts name what is there."""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import talus
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from support import REPOSITORY, run

LEG = REPOSITORY / "models/leg.yaml"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("mcap")
    run("talus-sim", "--model", LEG, "--out", out / "run.csv", "--duration", 4)
    run("talus-predict", "--model", LEG, "--out", out / "p.csv", out / "run.csv")
    run("talus-export", "--to", "mcap", "--out", out / "run.mcap", LEG, out / "run.csv")
    return out


def by_mcap(path):
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [(channel.topic, message.log_time, state) for _, channel, message, state in reader.iter_decoded_messages()]


def by_rosbags(path):
    with AnyReader([path]) as reader:
        return [(c.topic, stamp, reader.deserialize(raw, c.msgtype)) for c, stamp, raw in reader.messages()]


@pytest.mark.parametrize("reader", [by_mcap, by_rosbags])
def test_readers_find_measured_predicted_and_residual(folder, reader):
    found = reader(folder / "run.mcap")
    effort = {topic: np.array([list(s.effort) for name, _, s in found if name == topic]) for topic in ("/measured", "/predicted", "/residual")}
    recording = np.genfromtxt(folder / "run.csv", delimiter=",", names=True)
    predicted = np.genfromtxt(folder / "p.csv", delimiter=",", names=True)
    currents = np.column_stack([recording["knee_current_A"], recording["ankle_current_A"]])
    torques = np.column_stack([predicted["knee_motor_torque_Nm"], predicted["ankle_motor_torque_Nm"]])
    np.testing.assert_allclose(effort["/measured"], 0.1031 * currents, rtol=1e-12)
    np.testing.assert_allclose(effort["/predicted"], torques, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(effort["/residual"], 0.1031 * currents - torques, rtol=1e-9, atol=1e-12)
    stamps = [stamp for topic, stamp, _ in found if topic == "/measured"]
    np.testing.assert_array_equal(stamps, np.rint(recording["time_s"] * 1e9))
    first = next(s for topic, _, s in found if topic == "/measured")
    assert list(first.name) == ["knee", "ankle"] and first.header.stamp.sec * 10**9 + first.header.stamp.nanosec == stamps[0]


def test_layouts_name_the_topics(folder):
    root = ET.parse(folder / "run.mcap.plotjuggler.xml").getroot()
    curves = {c.get("name") for c in root.iter("curve")}
    assert curves == {f"/{topic}/{joint}/effort" for topic in ("measured", "predicted", "residual") for joint in ("knee", "ankle")}
    layout = json.loads((folder / "run.mcap.foxglove.json").read_text())
    paths = {path["value"] for panel in layout["configById"].values() for path in panel["paths"]}
    assert paths == {f"/{topic}.effort[{j}]" for topic in ("measured", "predicted", "residual") for j in (0, 1)}
    assert json.dumps(layout["layout"]).count("Plot!") == len(layout["configById"]) == 4


def test_without_a_recording_it_is_refused(folder, tmp_path):
    said = run("talus-export", "--to", "mcap", "--out", tmp_path / "x.mcap", LEG, status=2).stderr
    assert "--to mcap: expected FITTED.yaml and REC.csv" in said and not list(tmp_path.iterdir())


def test_a_recording_that_is_imported_again_is_the_same(folder):
    run("talus-import", "--map", "joint_rad=knee.position:rad", "--map", "joint_torque_Nm=knee.effort:N*m", "--map", "time_s=stamp:ns",
        "--out", folder / "again.csv", folder / "run.mcap", status=0)  # fmt: skip
    again, was = talus.Recording.read(folder / "again.csv"), talus.Recording.read(folder / "run.csv")
    np.testing.assert_allclose(again.columns["joint_torque_Nm"], 0.1031 * was.columns["knee_current_A"], rtol=1e-9)
