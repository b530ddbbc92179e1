"""Robots' logs and MATLAB 7.3 files as others' writers make them: MCAP by mcap_ros2, rosbag2 by sqlite3, HDF5 as MATLAB lays it."""

import sqlite3
import struct
from pathlib import Path

import numpy as np

FIRST_NS = 1_716_123_456_123_456_789
STEP_NS = 4_000_000
SEPARATOR = "\n" + 80 * "=" + "\n"
HEADER = "std_msgs/Header header\n"
HEADER_PARTS = SEPARATOR.join(["", "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n",
                               "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"])  # fmt: skip
JOINT_STATE = HEADER + "string[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n" + HEADER_PARTS
DYNAMIC = (HEADER + "string[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values\n" + HEADER_PARTS + SEPARATOR
           + "MSG: control_msgs/InterfaceValue\nstring[] interface_names\nfloat64[] values\n")  # fmt: skip


def stamps(n):
    return [FIRST_NS + STEP_NS * k for k in range(n)]


def header(ns):
    return {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": ""}


def joint_states(q, v, effort, at=None, sent=None):
    """(time, message) of one joint, `arm`; `sent` are the stamps, where they are not the times."""
    times = [int(ns) for ns in (stamps(len(q)) if at is None else at)]
    for k, (ns, stamp) in enumerate(zip(times, times if sent is None else sent, strict=True)):
        yield ns, {"header": header(int(stamp)), "name": ["arm"], "position": [q[k]], "velocity": [v[k]], "effort": [effort[k]]}


def dynamic_states(series):
    """(time, message) of {joint: {interface: values}}, as ros2_control's broadcaster sends them."""
    n = len(next(iter(next(iter(series.values())).values())))
    for k, ns in enumerate(stamps(n)):
        values = [{"interface_names": list(one), "values": [float(x[k]) for x in one.values()]} for one in series.values()]
        yield ns, {"header": header(ns), "joint_names": list(series), "interface_values": values}


def write_mcap(path, topics):
    """{topic: (type, definition, messages)}."""
    from mcap_ros2.writer import Writer

    with open(path, "wb") as file, Writer(file) as writer:
        for topic, (kind, definition, messages) in topics.items():
            schema = writer.register_msgdef(kind, definition)
            for ns, message in messages:
                writer.write_message(topic, schema, message, log_time=ns + 350_000, publish_time=ns)


# ---- rosbag2 before Iron: a table in SQLite, and no definition of its messages -------------


class Cdr:
    """Little-endian CDR, aligned from behind its four bytes of encapsulation."""

    def __init__(self):
        self.bytes = bytearray()

    def put(self, form, *values):
        size = struct.calcsize(form[-1])
        self.bytes += b"\0" * (-len(self.bytes) % size) + struct.pack("<" + form, *values)

    def text(self, word):
        self.put("I", len(word) + 1)
        self.bytes += word.encode() + b"\0"

    def texts(self, words):
        self.put("I", len(words))
        for word in words:
            self.text(word)

    def reals(self, values):
        self.put("I", len(values))
        if len(values):
            self.put(f"{len(values)}d", *values)


def cdr(message):
    out = Cdr()
    out.put("i", message["header"]["stamp"]["sec"])
    out.put("I", message["header"]["stamp"]["nanosec"])
    out.text("")
    if "joint_names" in message:
        out.texts(message["joint_names"])
        out.put("I", len(message["interface_values"]))
        for one in message["interface_values"]:
            out.texts(one["interface_names"])
            out.reals(one["values"])
    else:
        out.texts(message["name"])
        for field in ("position", "velocity", "effort"):
            out.reals(message[field])
    return b"\0\1\0\0" + bytes(out.bytes)


def write_db3(path, topics):
    """{topic: (type, definition, messages)} as ROS 2 Humble's recorder leaves them, without metadata.yaml."""
    base = sqlite3.connect(path)
    base.executescript("CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
                       "CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);"
                       "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,"
                       " serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);"
                       "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);"
                       "CREATE INDEX timestamp_idx ON messages (timestamp ASC);"
                       "INSERT INTO schema VALUES (3, 'humble');")  # fmt: skip
    for number, (topic, (kind, _, messages)) in enumerate(topics.items(), 1):
        base.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (number, topic, kind))
        rows = [(number, ns + 350_000, cdr(message)) for ns, message in messages]
        base.executemany("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", rows)
    base.commit()
    base.close()


def write_bag_folder(folder, topics):
    """The same with its metadata.yaml, as a folder."""
    import yaml

    folder = Path(folder)
    folder.mkdir()
    topics = {topic: (kind, definition, list(messages)) for topic, (kind, definition, messages) in topics.items()}
    write_db3(folder / "bag_0.db3", topics)
    counts = {topic: len(messages) for topic, (_, _, messages) in topics.items()}
    about = {"version": 5, "storage_identifier": "sqlite3", "relative_file_paths": ["bag_0.db3"], "compression_format": "", "compression_mode": "",
             "duration": {"nanoseconds": STEP_NS * max(counts.values())}, "starting_time": {"nanoseconds_since_epoch": FIRST_NS},
             "message_count": sum(counts.values()),
             "topics_with_message_count": [{"message_count": counts[topic], "topic_metadata": {"name": topic, "type": kind, "serialization_format": "cdr",
                                            "offered_qos_profiles": ""}} for topic, (kind, _, _) in topics.items()]}  # fmt: skip
    (folder / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": about}))


# ---- MATLAB 7.3 ------------------------------------------------------------------------------


def write_matlab73(path, tree):
    """{name: array, text or dict} as MATLAB's save -v7.3 lays them: columns as rows, texts as numbers, cells by reference."""
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        put_matlab(file, tree, h5py)
        references = file.create_group("#refs#")
        cell = references.create_dataset("a", data=np.array([[7.0]]))
        cell.attrs["MATLAB_class"] = np.bytes_("double")
        names = file.create_dataset("names", data=np.array([[cell.ref, cell.ref]], dtype=h5py.ref_dtype))
        names.attrs["MATLAB_class"] = np.bytes_("cell")
    begin = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Nov 23 10:00:00 2026 HDF5 schema 1.00 ."
    with open(path, "r+b") as file:
        file.write(begin.ljust(116) + b"\0" * 8 + b"\0\2IM")


def put_matlab(group, tree, h5py):
    for name, item in tree.items():
        if isinstance(item, dict):
            inner = group.create_group(name)
            inner.attrs["MATLAB_class"] = np.bytes_("struct")
            put_matlab(inner, item, h5py)
        elif isinstance(item, str):
            text = group.create_dataset(name, data=np.array([[ord(letter)] for letter in item], dtype=np.uint16))
            text.attrs["MATLAB_class"], text.attrs["MATLAB_int_decode"] = np.bytes_("char"), np.int32(2)
        else:
            array = np.atleast_2d(np.asarray(item))
            kind = {"f8": "double", "f4": "single", "b1": "logical"}.get(array.dtype.str[1:], array.dtype.name)
            data = group.create_dataset(name, data=array.astype(np.uint8) if kind == "logical" else array)
            data.attrs["MATLAB_class"] = np.bytes_(kind)
