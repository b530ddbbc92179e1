"""A recording as MCAP: measured, predicted and residual torque as sensor_msgs/JointState, and layouts that show them."""

from __future__ import annotations

import json
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

import talus
from talus import Model, Recording
from talus._arrays import Array
from talus.refused import Refused

from .xml_text import add, to_text

TOPICS = {"measured": "#1f77b4", "predicted": "#ff7f0e", "residual": "#d62728"}  # and the colour of each


def states(model: Model, recording: Recording) -> dict[str, dict[str, Array]]:
    """By topic: the fields of its messages, (joints, n). Residual: measured less predicted."""
    measured, predicted = talus.measured(model, recording), talus.predict(model, recording)
    moved = talus.Regression(model, recording).motion()
    motion = {"position": moved["q"], "velocity": moved["v"]}
    return {"measured": {**motion, "effort": measured}, "predicted": {"effort": predicted}, "residual": {"effort": measured - predicted}}


def content(model: Model, recording: Recording) -> bytes:
    """The file, written by the rosbags package."""
    try:
        from rosbags.rosbag2 import StoragePlugin, Writer
        from rosbags.typesys import Stores, get_typestore
    except ImportError as error:
        raise Refused(1, "--to mcap: needs rosbags: pip install 'talus[rosbag]'") from error
    store, stamps = get_typestore(Stores.ROS2_HUMBLE), np.rint(recording.t * 1e9).astype(np.int64)
    with tempfile.TemporaryDirectory(prefix="talus-") as folder:
        with Writer(Path(folder) / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            for topic, fields in states(model, recording).items():
                connection = writer.add_connection(f"/{topic}", "sensor_msgs/msg/JointState", typestore=store)
                for row, stamp in enumerate(stamps.tolist()):
                    message = _message(store, model.joints, fields, row, stamp)
                    writer.write(connection, stamp, store.serialize_cdr(message, "sensor_msgs/msg/JointState"))
        (file,) = (Path(folder) / "bag").glob("*.mcap")
        return file.read_bytes()


def _message(store: Any, joints: list[str], fields: dict[str, Array], row: int, stamp: int) -> Any:
    types, empty = store.types, np.empty(0)
    time = types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
    values = {name: np.ascontiguousarray(fields[name][:, row]) if name in fields else empty for name in ("position", "velocity", "effort")}
    return types["sensor_msgs/msg/JointState"](header=types["std_msgs/msg/Header"](stamp=time, frame_id=""), name=list(joints), **values)


def plotjuggler(joints: list[str]) -> str:
    """A layout for PlotJuggler: a plot of torques a joint, and its residual below."""
    root = ET.Element("root")
    tabs = add(root, "tabbed_widget", parent_="main_window", name="Main Window")
    for joint in joints:
        splitter = add(add(add(tabs, "Tab", tab_name=joint, containers="1"), "Container"), "DockSplitter", orientation="-", sizes="0.6;0.4", count="2")
        for curves in (("measured", "predicted"), ("residual",)):
            plot = add(add(splitter, "DockArea", name=" and ".join(curves)), "plot", style="Lines", mode="TimeSeries")
            for topic in curves:
                add(plot, "curve", name=f"/{topic}/{joint}/effort", color=TOPICS[topic])
    add(root, "use_relative_time_offset", enabled="1")
    return to_text(root, "PlotJuggler: open the recording, then this layout")


def foxglove(joints: list[str]) -> str:
    """A layout for Foxglove: the same plots, one below the other."""
    panels: dict[str, Any] = {}
    for joint in joints:
        for curves in (("measured", "predicted"), ("residual",)):
            paths = [{"value": f'/{topic}.effort[{joints.index(joint)}]', "label": f"{joint} {topic}", "enabled": True, "color": TOPICS[topic],
                      "timestampMethod": "headerStamp"} for topic in curves]  # fmt: skip
            panels[f"Plot!{joint}{curves[0]}"] = {"title": f"{joint}: {' and '.join(curves)}", "paths": paths, "xAxisVal": "timestamp",
                                                  "showLegend": True, "isSynced": True}  # fmt: skip
    layout: Any = None
    for name in reversed(panels):
        layout = name if layout is None else {"direction": "column", "first": name, "second": layout}
    return json.dumps({"configById": panels, "globalVariables": {}, "userNodes": {}, "layout": layout}, indent=1) + "\n"
