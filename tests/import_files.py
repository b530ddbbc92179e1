"""Files as people have them, each from one recording of an arm in closed form: every format with the disorders that occur.

    for case in cases(folder): case.path, case.columns, case.tolerance

`columns` is what a right import holds, `tolerance` the rounding that the file itself has done to it.
"""

from dataclasses import dataclass, field

import numpy as np

N, STEP_S = 1500, 0.004


@dataclass
class Truth:
    """Time, angle, velocity and current of an arm; the current leads to motion (friction and inertia)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    i: np.ndarray


def truth(step_s=STEP_S, turns=0.0):
    t = step_s * np.arange(N)
    w1, w2 = 2 * np.pi * 0.7 * STEP_S / step_s, 2 * np.pi * 1.9 * STEP_S / step_s
    q = 0.9 * np.sin(w1 * t) + 0.3 * np.sin(w2 * t + 1) + turns * t
    v = 0.9 * w1 * np.cos(w1 * t) + 0.3 * w2 * np.cos(w2 * t + 1) + turns
    a = -0.9 * w1**2 * np.sin(w1 * t) - 0.3 * w2**2 * np.sin(w2 * t + 1)
    return Truth(t, q, v, 0.02 * a + 0.5 * np.tanh(4 * v) + 0.2 * v + 0.8 * np.sin(q))


@dataclass
class Case:
    name: str
    paths: list
    columns: dict
    tolerance: float = 1e-9
    drops: int = 0
    arguments: list = field(default_factory=list)


def table(names, columns, separator=",", decimal=".", digits=10, quote="", end="\n"):
    def cell(x):
        if not isinstance(x, str):
            x = str(x) if isinstance(x, (int, np.integer)) else f"{x:.{digits}g}".replace(".", decimal)
        return quote + x + quote

    lines = [separator.join(quote + n + quote for n in names)]
    lines += [separator.join(map(cell, row)) for row in zip(*columns, strict=True)]
    return end.join(lines) + end


class Builder:
    """Writes cases into a folder."""

    def __init__(self, folder):
        self.folder, self.cases = folder, []

    def add(self, name, content, columns, tolerance=1e-8, encoding="utf-8", **more):
        """A case of one text file, or of several {suffix: text}."""
        paths = []
        for suffix, text in (content if isinstance(content, dict) else {".csv": content}).items():
            path = self.folder / f"{name}{suffix}"
            path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
            paths.append(path)
        self.cases.append(Case(name, paths, columns, tolerance, **more))


def texts(b, x, rng):
    """Separators, decimal signs, encodings, quoting, where the unit stands."""
    right, deg = {"time_s": x.t, "joint_rad": x.q, "joint_current_A": x.i}, np.degrees(x.q)
    ms, ma = 1000 * x.t, 1000 * x.i
    b.add("semicolon_comma", table(["Zeit [s]", "Winkel [°]", "Strom [A]"], [x.t, deg, x.i], ";", ","), right)
    b.add("tabs", table(["time_ms", "angle_deg", "current_mA"], [ms, deg, ma], "\t"), right)
    b.add("pipes", table(["t (s)", "theta (rad)", "iq (A)"], [x.t, x.q, x.i], "|"), right)
    b.add("blanks", table(["time_s", "joint_rad", "joint_current_A"], [x.t, x.q, x.i], "  "), right)
    b.add("quoted", table(["time [ms]", "position [deg]", "motor current [A]"], [ms, deg, x.i], quote='"'), right)
    b.add("quoted_comma", table(["Zeit [ms]", "Winkel [Grad]", "Strom [mA]"], [ms, deg, ma], ",", ",", quote='"'), right)
    b.add("utf16", table(["Zeit / s", "Winkel / °", "Strom / A"], [x.t, deg, x.i], "\t", ","), right, encoding="utf-16")
    b.add("utf16_no_mark", table(["Time [s]", "Angle [deg]", "Current [A]"], [x.t, deg, x.i]), right, encoding="utf-16-le")
    b.add("bom", table(["time_s", "joint_rad", "joint_current_A"], [x.t, x.q, x.i]), right, encoding="utf-8-sig")
    b.add("windows", table(["Zeit [s]", "Gelenkwinkel [°]", "Motorstrom [A]"], [x.t, deg, x.i], ";", ",", end="\r\n"), right, encoding="cp1252")
    b.add("mac_lines", table(["time_s", "angle_rad", "current_A"], [x.t, x.q, x.i], end="\r"), right)
    units = table(["Time", "Position", "Current"], [["ms", *ms], ["deg", *deg], ["mA", *ma]])
    b.add("row_of_units", units, right)
    head = "# robot 7\nsep=;\nLog of Tuesday\n\n" + table(["t [s]", "pos [deg]", "cur [A]"], [x.t, deg, x.i], ";")
    b.add("preamble", head, right)
    trailing = "\n".join(line + ";" for line in table(["t [s]", "pos [deg]", "cur [A]"], [x.t, deg, x.i], ";").splitlines())
    b.add("trailing_separator", trailing, right)
    b.add("camel", table(["timeMs", "jointAngleDeg", "motorCurrentAmps", "status"], [ms, deg, x.i, ["ok"] * N]), right)
    b.add("chinese", table(["时间 [s]", "角度 [°]", "电流 [A]"], [x.t, deg, x.i]), right)
    thousands = [f"{v:,.4f}".replace(",", "_").replace(".", ",").replace("_", ".") for v in ma * 10]
    b.add("thousands", table(["Zeit [s]", "Winkel [°]", "Strom [mA]"], [[f"{v:.6f}".replace(".", ",") for v in x.t],
          [f"{v:.6f}".replace(".", ",") for v in deg], thousands], ";", "."), right | {"joint_current_A": 10 * x.i}, 1e-6)  # fmt: skip
    commanded = table(["t_s", "q_cmd_rad", "q_rad", "i_cmd_A", "i_A", "temp_C"], [x.t, x.q + 0.2, x.q, x.i * 2, x.i, 300 * x.t * 0 + 31])
    b.add("commands_beside", commanded, right | {"joint_temp_C": np.full(N, 31.0)})
    b.add("no_unit_at_all", table(["time", "angle", "current"], [ms, deg, ma]), right)
    b.add("headless", table(["0", "0.1", "0.2"], [x.t, x.q, x.i]), right)


def times(b, x, rng):
    """Clocks: Unix, nanoseconds, rounded, unsorted, repeated, two of them, dates, gaps."""
    right, deg = {"time_s": x.t, "joint_rad": x.q, "joint_current_A": x.i}, np.degrees(x.q)
    names, rest = ["angle [deg]", "current [A]"], [deg, x.i]
    whole = (4_000_000 * np.arange(N)).astype(np.int64)
    ns = [int(1_716_123_456_123_456_789 + k) for k in whole]
    b.add("unix_ns", table(["timestamp_ns", *names], [ns, *rest]), right)
    b.add("unix_ns_bare", table(["timestamp", *names], [ns, *rest]), right)
    b.add("unix_s", table(["timestamp [s]", *names], [[f"{k // 10**9}.{k % 10**9:09d}" for k in ns], *rest]), right)
    b.add("iso", table(["stamp", *names], [[str(np.datetime64(k, "ns")) for k in ns], *rest]), right)
    clock = [f"12.05.2026 10:{k // 60000:02d}:{k // 1000 % 60:02d},{k % 1000:03d}" for k in range(0, 4 * N, 4)]
    b.add("german_dates", table(["Zeit", "Winkel [°]", "Strom [A]"], [clock, *rest], ";", ","), right)
    fine = truth(0.0025)
    rounded = table(["time_ms", *names], [np.floor(fine.t * 1000 + 0.5).astype(int), np.degrees(fine.q), fine.i])
    b.add("ms_rounded", rounded, {"time_s": fine.t, "joint_rad": fine.q, "joint_current_A": fine.i}, 6e-4)
    fast = truth(0.0005)
    same = table(["time_ms", *names], [np.floor(fast.t * 1000).astype(int), np.degrees(fast.q), fast.i])
    b.add("ms_repeated", same, {"time_s": fast.t, "joint_rad": fast.q, "joint_current_A": fast.i}, 6e-4)
    order = np.arange(N).reshape(-1, 5)[:, [1, 0, 2, 4, 3]].ravel()
    b.add("unsorted", table(["time_s", *names], [x.t[order], deg[order], x.i[order]]), right)
    twice = np.sort(np.concatenate([np.arange(N), np.arange(100, 200)]))
    b.add("repeated", table(["time_s", *names], [x.t[twice], deg[twice], x.i[twice]]), right)
    lost = np.ones(N, bool)
    lost[500:540] = False
    holes = [[f"{v:.9g}" if ok else "NaN" for v, ok in zip(column, lost, strict=True)] for column in rest]
    b.add("dropouts", table(["time_s", *names], [x.t, *holes]), {k: v[lost] for k, v in right.items()})
    jitter = x.t + rng.normal(0, 0.001, N)
    b.add("two_clocks_in_one", table(["recv_time_s", "device_time_s", *names], [jitter, x.t, *rest]), right)
    slow = slice(None, None, 2)
    two = {"_a.csv": table(["t_s", "angle_deg"], [x.t, deg]), "_b.csv": table(["t_s", "current_A"], [x.t[slow], x.i[slow]])}
    inside = {k: v[:-1] for k, v in right.items()}  # straight lines between the slow sensor's samples, no further
    b.add("two_files", two, inside | {"joint_current_A": np.interp(x.t[:-1], x.t[slow], x.i[slow])})
    apart = {"_a.csv": table(["t_s", "angle_deg"], [x.t, deg]), "_b.csv": table(["stamp_ns", "current_A"], [ns, x.i])}
    b.add("two_clocks_apart", apart, right)
    again = np.concatenate([np.arange(N), np.arange(N)])
    b.add("clock_starts_anew", table(["time_s", *names], [x.t[again], deg[again], x.i[again]]), right)


def values(b, x, rng):
    """What sensors do: wraps, counts, missing signs, other units, speed in rpm."""
    right, deg = {"time_s": x.t, "joint_rad": x.q, "joint_current_A": x.i}, np.degrees(x.q)
    spin = truth(turns=2.0)
    turned = {"time_s": spin.t, "joint_rad": spin.q, "joint_current_A": spin.i}
    b.add("wrapped_degrees", table(["t_s", "angle_deg", "current_A"], [spin.t, np.degrees(spin.q) % 360, spin.i]), turned)
    counts = np.floor((spin.q % (2 * np.pi)) / (2 * np.pi) * 16384).astype(int)
    b.add("wrapped_counts", table(["t_s", "encoder", "current_A"], [spin.t, counts, spin.i]), turned, 5e-4)
    word = np.round(1000 * x.i).astype(int) % 65536
    b.add("unsigned_words", table(["t_s", "angle_deg", "current_mA"], [x.t, deg, word]), right, 6e-4)
    b.add("unsigned_current", table(["t_s", "angle_deg", "current_A"], [x.t, deg, np.abs(x.i)]), right)
    b.add("turned_sign", table(["t_s", "angle_deg", "current_A"], [x.t, deg, -x.i]), right)
    phases = [x.i * np.sin(9 * x.q + k * 2 * np.pi / 3) for k in range(3)]
    b.add("currents_of_phases", table(["t_s", "angle_deg", "ia_A", "ib_A", "ic_A"], [x.t, deg, *phases]), right)
    b.add("rotor_and_joint", table(["t_s", "motor_angle_deg", "joint_angle_deg", "bus_current_A", "motor_current_A"],
          [x.t, 9 * deg, deg, x.i / 3, x.i]), right)  # fmt: skip
    b.add("rotor_alone", table(["t_s", "rotor_position_rad", "current_A"], [x.t, 9 * x.q, x.i]), right)
    rpm = table(["t_s", "angle_deg", "speed_rpm", "current_A"], [x.t, deg, x.v * 30 / np.pi, x.i])
    b.add("speed_in_rpm", rpm, right | {"joint_velocity_rad_s": x.v})
    wrong = table(["t_s", "angle_rad", "speed_rad_s", "current_A"], [x.t, deg, x.v, x.i])
    b.add("degrees_said_to_be_rad", wrong, right | {"joint_velocity_rad_s": x.v})
    knee = {"time_s": x.t, "knee_motor_rad": 51 * x.q, "ankle_motor_rad": 9 * x.q, "ankle_joint_rad": x.q / 2,
            "knee_current_A": x.i, "ankle_current_A": x.i / 2}  # fmt: skip
    leg = table(["t_ms", "knee motor [rev]", "ankle motor [rad]", "ankle joint [deg]", "knee current [A]", "ankle current [mA]"],
                [1000 * x.t, 51 * x.q / 2 / np.pi, 9 * x.q, deg / 2, x.i, 500 * x.i])  # fmt: skip
    b.add("leg", leg, knee, 1e-6)
    axis = {"time_s": x.t, "slider_m": 0.1 * x.q, "slider_force_N": 40 * x.i}
    b.add("axis", table(["Zeit [s]", "Weg [mm]", "Kraft [kN]"], [x.t, 100 * x.q, 0.04 * x.i], ";", ","), axis, 1e-6)


def binaries(b, x, rng):
    """MATLAB, HDF5, Parquet, rosbag2, MCAP and MDF."""
    import h5py
    import pyarrow
    import pyarrow.parquet
    import scipy.io

    right, deg = {"time_s": x.t, "joint_rad": x.q, "joint_current_A": x.i}, np.degrees(x.q)
    torque = {"time_s": x.t, "joint_rad": x.q, "joint_velocity_rad_s": x.v, "joint_torque_Nm": x.i}
    f = b.folder
    scipy.io.savemat(f / "matlab.mat", {"log": {"time_s": x.t, "angle_deg": deg, "current_A": x.i, "rate": 250.0}})
    b.cases.append(Case("matlab", [f / "matlab.mat"], right))
    with h5py.File(f / "hdf5.h5", "w") as file:
        for name, unit, column in (("time", "s", x.t), ("joint/position", "deg", deg), ("joint/current", "A", x.i)):
            file.create_dataset(f"robot/{name}", data=column).attrs["unit"] = unit
    b.cases.append(Case("hdf5", [f / "hdf5.h5"], right))
    frame = {"timestamp": (4_000_000 * np.arange(N) + 1_716_123_456_123_456_789).astype("datetime64[ns]"), "angle_rad": x.q, "current_A": x.i}
    pyarrow.parquet.write_table(pyarrow.table(frame), f / "parquet.parquet")
    b.cases.append(Case("parquet", [f / "parquet.parquet"], right))
    for suffix in ("db3", "mcap"):
        write_bag(f / f"rosbag_{suffix}", suffix, x)
        b.cases.append(Case(f"rosbag_{suffix}", [f / f"rosbag_{suffix}"], torque))
    b.cases.append(Case("mcap_file", [f / "rosbag_mcap" / "rosbag_mcap.mcap"], torque))
    angle, gears = ("Gelenkwinkel", "°", x.t, deg), ("gear", "", x.t, np.arange(N) % 2, {"val_0": 0, "text_0": "in", "val_1": 1, "text_1": "out"})
    write_mdf(f / "mdf.mf4", [[angle, ("Motorstrom", "mA", x.t, 1000 * x.i)]])
    b.cases.append(Case("mdf", [f / "mdf.mf4"], right))
    slow = slice(None, None, 2)
    write_mdf(f / "mdf_rates.mf4", [[("current", "A", x.t[slow], x.i[slow])], [angle, gears], [("speed", "rpm", x.t, x.v * 30 / np.pi)]])
    inside = {k: v[:-1] for k, v in right.items()} | {"joint_velocity_rad_s": x.v[:-1]}  # as with two files
    b.cases.append(Case("mdf_rates", [f / "mdf_rates.mf4"], inside | {"joint_current_A": np.interp(x.t[:-1], x.t[slow], x.i[slow])}))
    write_mdf(f / "mdf_3.mdf", [[angle], [("current_A", "A", x.t, x.i)]], version="3.30")
    b.cases.append(Case("mdf_3", [f / "mdf_3.mdf"], right))


def write_mdf(path, groups, version="4.10", **more):
    """Groups of (name, unit, instants [s], values, and a conversion if there is one)."""
    from asammdf import MDF, Signal

    with MDF(version=version) as file:
        for group in groups:
            file.append([Signal(values, seconds, unit, name, *conversion, **more) for name, unit, seconds, values, *conversion in group])
        file.save(path, overwrite=True)


def write_bag(folder, storage, x):
    """sensor_msgs/JointState, as ros2_control's broadcaster writes it."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kind = store.types["sensor_msgs/msg/JointState"]
    header, time = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    plugin = {"db3": StoragePlugin.SQLITE3, "mcap": StoragePlugin.MCAP}[storage]
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connection = writer.add_connection("/joint_states", kind.__msgtype__, typestore=store)
        for k in range(N):
            ns = 1_716_123_456_123_456_789 + 4_000_000 * k
            message = kind(header(time(ns // 10**9, ns % 10**9), ""), ["arm"], x.q[k : k + 1], x.v[k : k + 1], x.i[k : k + 1])
            writer.write(connection, ns + 350_000, store.serialize_cdr(message, kind.__msgtype__))


def cases(folder, with_binaries=True):
    """Every case, written into a folder."""
    b, rng, x = Builder(folder), np.random.default_rng(1), truth()
    for group in (texts, times, values, *([binaries] if with_binaries else [])):
        group(b, x, rng)
    return b.cases
