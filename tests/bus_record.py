"""Records of the leg's bus made here, by cantools and by hand, from a recording of the twin.

    frames = frames_of(recording)            # what the bench would send, a Frame each
    write(path, frames)                      # as candump's log
"""

import random
from dataclasses import dataclass, replace

import cantools
import numpy as np
import yaml
from support import REPOSITORY, run

DBC = REPOSITORY / "models/leg.dbc"
MODEL = REPOSITORY / "models/leg_bench.yaml"
DATABASE = cantools.database.load_file(str(DBC))
BUS = yaml.safe_load(MODEL.read_text())["bus"]
BEGIN_NS = 1_700_000_000_123_456_000
ZEROS = {"knee": 60_001, "ankle": 12_345}  # of the relative encoders: anywhere


@dataclass(frozen=True)
class Frame:
    t_ns: int
    name: str
    number: int  # its counter, without wraps
    data: bytes
    interface: str = "can0"

    @property
    def identifier(self):
        return DATABASE.get_message_by_name(self.name).frame_id

    @property
    def line(self):
        return f"({self.t_ns // 10**9}.{self.t_ns % 10**9 // 1000:06d}) {self.interface} {self.identifier:03X}#{self.data.hex().upper()}\n"


def twin(folder, *options, duration=20):
    """A recording of the twin at 1 kHz, with the path it was read from."""
    path = folder / "twin.csv"
    run("talus-sim", "--model", MODEL, "--out", path, "--rate", 1000, "--jitter", 0, "--duration", duration, *options)
    return np.genfromtxt(path, delimiter=",", names=True)


def counts(angle, bus, zero):
    return zero + bus["sign"] * np.rint(angle / (2 * np.pi) * bus["counts_per_turn"]).astype(int)


def state(joint, row, number):
    bus = BUS[joint]
    absolute = row["ankle_joint_rad"] if joint == "ankle" else row["knee_motor_rad"] / 51
    values = {
        "Counter": number % 65536,
        "MotorCount": int(counts(row[f"{joint}_motor_rad"], bus["motor"], ZEROS[joint])) % 65536,
        "JointCount": int(counts(absolute, bus["joint"], bus["joint"]["zero_count"])) % 65536,
        "Current": round(bus["current"]["sign"] * row[f"{joint}_current_A"] / 0.0005) * 0.0005,
    }
    return DATABASE.encode_message(f"{joint.capitalize()}State", values)


def frames_of(recording, first=65_000, seed=1):
    """The state frames of every row with a delay each, and supply and status between them."""
    generator, frames = random.Random(seed), []

    def add(row, name, number, data):
        delay = 40_000 + int(generator.expovariate(1 / 30_000))
        frames.append(Frame(BEGIN_NS + round(row["time_s"] * 1e9) + delay, name, number, data))

    for k, row in enumerate(recording):
        for joint in ("knee", "ankle"):
            add(row, f"{joint.capitalize()}State", first + k, state(joint, row, first + k))
        if k % 10 == 0:
            values = {"Counter": k // 10, "BusVoltage": 24 + k % 7 / 100, "BusCurrent": 0}
            add(row, "Supply", k // 10, DATABASE.encode_message("Supply", values))
        for joint in ("Knee", "Ankle") if k % 100 == 0 else ():
            values = {"Counter": k // 100, "MotorTemperature": 25 + k / 1e4, "DriveTemperature": 30, "State": 2, "Faults": 0}
            add(row, f"{joint}Status", k // 100, DATABASE.encode_message(f"{joint}Status", values))
    return sorted(frames, key=lambda frame: frame.t_ns)


def write(path, frames):
    path.write_text("".join(frame.line for frame in frames))
    return path


# ---- faults ----------------------------------------------------------------------------


def injected(frames, faults, seed):
    """(frames with so many random faults, [(kind, message, counter, count, line)] of them, lines counted from 1).

    Each fault has a stretch of its message to itself, so that none hides another: losses of 1 to 40 frames, frames
    that come up to 5 frames too late, and frames that come again up to 5 frames later."""
    generator = random.Random(seed)
    by_name = {name: [i for i, f in enumerate(frames) if f.name == name] for name in ("KneeState", "AnkleState", "Supply")}
    stretch = {"KneeState": 60, "AnkleState": 60, "Supply": 60}
    places = [(name, k) for name, own in by_name.items() for k in range(3, len(own) - stretch[name] - 3, stretch[name])]
    after, gone, told = {}, set(), []
    for name, k in generator.sample(places, faults):
        own, kind = by_name[name], generator.choice(("lost", "swapped", "repeated"))
        at = k + generator.randrange(5)
        if kind == "lost":
            count = generator.choice((1, 1, 1, 2, 3, generator.randint(4, 40)))
            gone.update(own[at:at + count])
            told.append((kind, frames[own[at]], count, own[at + count]))
            continue
        later = own[at + generator.randint(1, 5)] if kind == "swapped" else own[at + generator.randint(0, 5)]
        after.setdefault(later, []).append(own[at])
        if kind == "swapped":
            gone.add(own[at])
        told.append((kind, frames[own[at]], 1, ("copy", own[at])))
    made, line = [], {}
    for i, frame in enumerate(frames):
        if i not in gone:
            made.append(frame)
            line[i] = len(made)
        for j in after.get(i, ()):
            made.append(replace(frames[j]))
            line["copy", j] = len(made)
    return made, sorted((kind, f.name, f.number % 65536, count, line[mark]) for kind, f, count, mark in told)


FRAMES_IN_10_S = {"Supply": 1000, "KneeStatus": 100, "AnkleStatus": 100}  # of the others 10,000


TEN, SIXTEEN = 10 ** np.arange(9, -1, -1), np.array([4, 0, 12, 8])  # decimal digits of seconds; hexadecimal ones of a counter, its low byte first
HEX = np.frombuffer(b"0123456789ABCDEF", np.uint8)


def write_long(path, frames, times):
    """Ten seconds of frames again and again, each time later and with the counters that follow; every 4096th of a message is lost."""
    lines = [frame.line.encode() for frame in frames]
    text, length = np.frombuffer(b"".join(lines), np.uint8).copy(), np.array([len(line) for line in lines])
    begin = np.cumsum(length) - length
    of_second = begin[:, None] + 1 + np.arange(10)
    of_counter = (begin + [line.index(b"#") for line in lines])[:, None] + 1 + np.arange(4)
    second = np.array([frame.t_ns // 10**9 for frame in frames])
    number = np.array([int.from_bytes(frame.data[:2], "little") for frame in frames])
    each = np.array([FRAMES_IN_10_S.get(frame.name, 10_000) for frame in frames])
    with open(path, "wb") as file:
        for turn in range(times):
            now = number + turn * each
            text[of_second] = (second + 10 * turn)[:, None] // TEN % 10 + ord("0")
            text[of_counter] = HEX[now[:, None] >> SIXTEEN & 15]
            file.write(text[np.repeat(now % 4096 != 0, length)])
