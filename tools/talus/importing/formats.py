"""Which reader a file needs, by what is in it. Readers besides text are optional packages, named where they are missing."""

import contextlib
import importlib
import tempfile
from pathlib import Path

import numpy as np

from talus.refused import Refused

from . import asam, delimited, headers
from .table import Column, Table


def need(module, package, path):
    """An optional reader."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Refused(1, f"{path}: needs the Python package {package}: pip install {package}") from error


def read(path):
    """The Tables of any file: one for each of its clocks."""
    found = _read(path)
    return found if isinstance(found, list) else [found]


def _read(path):
    try:
        if Path(path).is_dir():
            return rosbag(path)
        with open(path, "rb") as file:
            start = file.read(1024)
            for mark, at, reader in BINARY:
                if start[at:].startswith(mark):
                    return reader(path)
            data = start + file.read()
    except OSError as error:
        raise Refused(2, f"{path}: {error.strerror or error}") from error
    return delimited.read(path, data)


MOST_OF_A_MATRIX = 64  # columns: a wider array is a picture or a spectrum, and no log


def columns_of(arrays, path, units=None):
    """Columns of {name: array}, all of the length that most have; a matrix becomes one column for each of its own. `units` are those
    that stand beside an array and not in its name."""
    flat, unit = {}, {}
    for name, array in arrays.items():
        array = np.asarray(array).squeeze()
        if array.ndim == 2 and array.shape[0] < array.shape[1]:
            array = array.T
        own = {}
        if array.ndim == 1 and array.dtype.kind in "fiubM":
            own = {name: array}
        elif array.ndim == 2 and array.shape[1] <= MOST_OF_A_MATRIX and array.dtype.kind in "fiub":
            own = {f"{name}[{i}]": array[:, i] for i in range(array.shape[1])}
        flat |= own
        unit |= dict.fromkeys(own, (units or {}).get(name))
    if not flat:
        raise Refused(2, f"{path}: holds no columns of numbers")
    lengths = [len(a) for a in flat.values()]
    longest = max(set(lengths), key=lambda n: (n > 1, lengths.count(n), n))
    kept = {name: array for name, array in flat.items() if len(array) == longest}
    named = delimited.named_once([headers.beside(name, unit[name]) for name in kept])
    out = Table(str(path), [Column(*said, array) for said, array in zip(named, kept.values(), strict=True)])
    for name, array in flat.items():
        if len(array) != longest:
            out.notes.append(f"{name}: {len(array)} values where the others have {longest}; left out")
    return out


def matlab(path):
    """MATLAB 5 to 7: arrays, and those within structures."""
    scipy_io = need("scipy.io", "scipy", path)
    try:
        tree = scipy_io.loadmat(path, simplify_cells=True)
    except Exception as error:  # noqa: BLE001  the reader raises many kinds for a damaged file
        raise Refused(2, f"{path}: damaged MATLAB file: {error}") from error
    return columns_of(_leaves({k: v for k, v in tree.items() if not k.startswith("__")}), path)


def _leaves(tree, before=""):
    out = {}
    for name, item in tree.items():
        if isinstance(item, dict):
            out |= _leaves(item, f"{before}{name}.")
        else:
            out[f"{before}{name}"] = item
    return out


def hdf5(path):
    """HDF5, and MATLAB 7.3, which is HDF5: every set of data by its path."""
    h5py = need("h5py", "h5py", path)
    arrays = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiub" and item.size > 1 and not _is_no_number(item):
            arrays[name.replace("/", ".")] = item[()]
            unit = item.attrs.get("unit", item.attrs.get("units"))
            if unit is not None:
                units[name.replace("/", ".")] = unit.decode() if isinstance(unit, bytes) else str(unit)

    units = {}
    try:
        with h5py.File(path, "r") as file:
            file.visititems(take)
    except (OSError, RuntimeError, KeyError) as error:
        raise Refused(2, f"{path}: damaged HDF5 file: {error}") from error
    return columns_of(arrays, path, units)


def _is_no_number(item):
    """MATLAB keeps texts as numbers, and of what is empty its shape."""
    return item.attrs.get("MATLAB_class") == b"char" or "MATLAB_empty" in item.attrs


def parquet(path):
    """Parquet, with lists of one length (LeRobot's observation.state) as columns."""
    reader = need("pyarrow.parquet", "pyarrow", path)
    try:
        table = reader.read_table(path)
    except (OSError, ValueError) as error:
        raise Refused(2, f"{path}: damaged Parquet file: {error}") from error
    arrays, units = {}, {}
    for name in table.column_names:
        values, said = table.column(name).to_numpy(zero_copy_only=False), (table.schema.field(name).metadata or {}).get(b"unit")
        matrix = _of_lists(values)
        if matrix is not None:
            name, values = name if matrix.shape[1] > 1 else f"{name}[0]", matrix
        arrays[name] = values
        if said:
            units[name] = said.decode()
    return columns_of(arrays, path, units)


def _of_lists(values):
    """A matrix of a column of lists of one length, NaN where a row has none; else None."""
    lists = [row for row in values if row is not None] if values.dtype == object else []
    widths = {len(row) if isinstance(row, np.ndarray) and row.dtype.kind in "fiub" else 0 for row in lists}
    if len(widths) != 1 or widths == {0}:
        return None
    nothing = np.full(widths.pop(), np.nan)
    return np.stack([nothing if row is None else row for row in values])


def mdf(path):
    """ASAM MDF 2 to 4: a Table for each clock."""
    return asam.tables(need("asammdf", "asammdf", path), str(path))


# ---- robots' logs ------------------------------------------------------------------------

JOINT_FIELDS = {"position": "rad", "velocity": "rad/s", "effort": "N*m"}  # units that REP 103 demands
# A rosbag2 in SQLite, before ROS 2 Iron, does not say what its messages are made of; and these are not among ROS's own.
DYNAMIC_JOINT_STATES = {
    "control_msgs/msg/InterfaceValue": "string[] interface_names\nfloat64[] values\n",
    "control_msgs/msg/DynamicJointState": "std_msgs/Header header\nstring[] joint_names\ncontrol_msgs/InterfaceValue[] interface_values\n",
}


def rosbag(path):
    """rosbag2 (a folder, or an .mcap or .db3 by itself): joint states, by the stamp of their header."""
    highlevel, typesys = need("rosbags.highlevel", "rosbags", path), need("rosbags.typesys", "rosbags", path)
    states, notes = States(), []
    try:
        with _named(path) as name, highlevel.AnyReader([name], default_typestore=_types(typesys)) as reader:
            found = [c for c in reader.connections if c.msgtype.endswith(("/JointState", "/DynamicJointState"))]
            topic = _topic(found, reader.connections, path, notes)
            for connection, received_ns, raw in reader.messages([c for c in found if c.topic == topic]):
                states.take(reader.deserialize(raw, connection.msgtype), received_ns)
    except Refused:
        raise
    except Exception as error:  # noqa: BLE001  the reader raises many kinds for a damaged log
        raise Refused(2, f"{path}: damaged or no rosbag2: {error}") from error
    return _of_states(states.rows, path, [*notes, *states.notes()])


@contextlib.contextmanager
def _named(path):
    """The log under a name that its reader knows it by."""
    suffix = "" if Path(path).is_dir() else ".mcap" if _begins(path, b"\x89MCAP") else ".db3"
    if suffix == Path(path).suffix or not suffix:
        yield Path(path)
        return
    with tempfile.TemporaryDirectory(prefix="talus-") as folder:
        link = Path(folder) / f"log{suffix}"
        link.symlink_to(Path(path).resolve())
        yield link


def _begins(path, mark):
    with open(path, "rb") as file:
        return file.read(len(mark)) == mark


def _types(typesys):
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    for name, text in DYNAMIC_JOINT_STATES.items():
        store.register(typesys.get_types_from_msg(text, name))
    return store


def _topic(found, every, path, notes):
    if not found:
        there = ", ".join(f"{c.topic} ({c.msgtype})" for c in every)[:300] or "nothing"
        raise Refused(2, f"{path}: no JointState or DynamicJointState in it; found {there}")
    topics = sorted({c.topic for c in found})
    if len(topics) > 1:
        notes.append(f"{topics[0]} is read; there is also {', '.join(topics[1:])}")
    return topics[0]


class States:
    """`rows`: {stamp: {(joint, field): value}} of messages; a joint that none of a stamp names has nothing at that time."""

    def __init__(self):
        self.rows, self.unstamped, self.again = {}, 0, 0

    def take(self, message, received_ns):
        stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        self.unstamped += stamp == 0
        values, new = self.rows.setdefault(stamp or received_ns, {}), _values(message)
        self.again += any(key in values for key in new)
        values.update({key: value for key, value in new.items() if key not in values})

    def notes(self):
        if self.unstamped:
            yield f"{self.unstamped} messages have no stamp; the time at which the log received them is taken"
        if self.again:
            yield f"{self.again} messages repeat a stamp; the first of each is kept"


def _values(message):
    if hasattr(message, "joint_names"):
        pairs = zip(message.joint_names, message.interface_values, strict=True)
        return {(joint, i): v for joint, one in pairs for i, v in zip(one.interface_names, one.values, strict=True)}
    return {(joint, field): value for field in JOINT_FIELDS for joint, value in zip(message.name, getattr(message, field), strict=False)}


def _of_states(rows, path, notes):
    if not rows:
        raise Refused(2, f"{path}: no joint state in it")
    keys = sorted({key for values in rows.values() for key in values})
    stamps = list(rows)
    columns = [Column("stamp", "ns", np.array(stamps, dtype=np.int64))]
    for joint, field in keys:
        values = np.array([rows[stamp].get((joint, field), np.nan) for stamp in stamps], dtype=float)
        if np.isfinite(values).any():
            columns.append(Column(f"{joint}.{field}", JOINT_FIELDS.get(field), values))
    return Table(str(path), columns, notes)


BINARY = ((b"MATLAB 5.0", 0, matlab), (b"MATLAB 7.3", 0, hdf5), (b"\x89HDF\r\n", 0, hdf5), (b"\x89HDF\r\n", 512, hdf5),
          (b"PAR1", 0, parquet), (b"\x89MCAP0", 0, rosbag), (b"SQLite format 3", 0, rosbag), (b"MDF     ", 0, mdf),
          (b"UnFinMF ", 0, mdf))  # fmt: skip
