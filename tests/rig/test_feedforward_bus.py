"""talus-feedforward on a real CAN interface, with the twin at its other end: the torque it sends is the model's, a stop from
anywhere takes it away, and what the bus carried is recorded."""

import math
import os
import socket
import struct
import subprocess
import time
from contextlib import contextmanager, nullcontext
from unittest.mock import patch

import can
import numpy
import pytest
from recording import Recording
from scipy.interpolate import CubicSpline
from support import REPOSITORY, program
from talus import Model, ffi, lib
from test_player import commands, tmp_path  # noqa: F401 (a fixture)
from trajectory import LIMITS, PATIENT

pytestmark = [pytest.mark.rig, pytest.mark.release]

HOPS = 2  # of a motion that something ends: what a guest that stood still owes goes out at once
MODEL = REPOSITORY / "models/leg_bench.yaml"
REST, TICK, FALL = 1000, 1e-3, 100  # ticks before and behind the motion; s; ticks before the end from which torque falls
DECAY = 15
KNEE, MEASURED = 0x101, 0x201  # identifiers: the knee's set-point, and what its drive measured
OUTAGE = 4 + DECAY + 50 + DECAY  # ticks: too late, torque falls, good frames are waited for, torque comes back


def motion(folder, hops=1):
    """Hops of both joints, 2 s each, rows of 20 ms; the spline through them, at rest at both ends."""
    t = numpy.arange(100 * hops + 1) / 50
    hop = 0.5 * (1 - numpy.cos(math.pi * t))
    angles = numpy.stack([0.5 * hop, -0.2 * hop * numpy.sin(math.pi * t)])
    path = folder / "hop.csv"
    path.write_text("time_s,knee_rad,ankle_rad\n" + "".join(f"{x:.2f},{a:.12f},{b:.12f}\n" for x, a, b in zip(t, *angles)))
    return path, CubicSpline(t, angles, axis=1, bc_type="clamped")


def torque_of(spline, t):
    """Motor torque of the model for the motion at t, all friction in proportion to speed below 0.05 rad/s."""
    model = Model.read(MODEL)
    at, torque = ffi.new("tl_motion *"), ffi.new("double[2]")
    for j in range(2):
        at.q[j], at.v[j], at.a[j] = (float(spline(t, n)[j]) for n in range(3))
        at.slip[j] = max(-1.0, min(1.0, at.v[j] / 0.05))
    lib.tl_inverse(model.struct, at, torque)
    return list(torque)


def comes(interface, identifier, counter=0):
    """Waits for a frame of this identifier with this counter or a later one: an instant of the motion, whatever the clock says. Looks
    at a frame now and then, for the guest has no time to read them all once more."""
    at = -1
    while at < counter:
        time.sleep(0.05)
        with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as bus:
            bus.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, struct.pack("=II", identifier, socket.CAN_SFF_MASK))
            bus.bind((interface,))
            bus.settimeout(20)
            try:
                at = struct.unpack_from("<H", bus.recv(16), 8)[0]
            except TimeoutError:
                return False
    return True


@contextmanager
def twin(folder, interface):
    command = [program("talus-sim"), "--model", MODEL, "--can", interface, "--excitation", "bus", "--duration", 600, "--out", folder / "twin.csv"]
    process = subprocess.Popen([str(word) for word in command], stderr=subprocess.PIPE, text=True)
    try:
        assert comes(interface, MEASURED)
        yield
    finally:
        process.terminate()
        process.communicate(timeout=60)


def fed(folder, interface, *options, hops=1):
    path, _ = motion(folder, hops)
    arguments = ("--can", interface, "--play", path, *PATIENT, "--limits", LIMITS, "--friction-share", 1, *options, MODEL)
    return Recording(folder / "r", *arguments, path=program("talus-feedforward"))


def recorded(folder, interface, *options, hops=1, environment=(), during=lambda: None, bench=twin):
    """A motion with a bench at the other end of the bus; ends with 1 where the guest was too slow to record all of it."""
    with bench(folder, interface):
        with patch.dict(os.environ, environment):
            recording = fed(folder, interface, *options, hops=hops)
        with recording:
            during()
            printed = recording.wait(status=None)
    assert recording.process.returncode == (recording.end()["lost"] > 0), printed
    return recording


def torques(recording):
    """(rows, 2) torques that were sent, knee and ankle, by their counters."""
    both = [commands(recording.log, identifier) for identifier in (KNEE, 0x102)]
    for sent in both:
        assert [one["Counter"] for _, one in sent] == list(range(len(sent)))
    n = min(map(len, both))
    return numpy.array([[one["TorqueFeedforward"] for _, one in sent[:n]] for sent in both]).T


def test_the_torque_on_the_bus_is_the_models(vcan, tmp_path, capsys):  # noqa: F811
    (name,) = vcan()
    _, spline = motion(tmp_path)
    recording = recorded(tmp_path, name)
    sent = torques(recording)
    assert len(sent) == 2 * REST + 2001
    (told,) = recording.events("feedforward")
    rows = numpy.arange(REST, REST + 2000, 10)
    model = numpy.array([torque_of(spline, (row - REST + 0.5) * TICK) for row in rows])
    near = 1e-4  # half a step of the field, and what the closed form of the linkage and the two splines differ
    assert (sent[rows] >= numpy.minimum(model, 0) - near).all() and (sent[rows] <= numpy.maximum(model, 0) + near).all()
    whole = (numpy.abs(sent[rows] - model) <= near).all(axis=1)
    with capsys.disabled():
        print(f"\n  {whole.mean():.0%} of the ticks have the whole torque; measured frames were stale in {told['stale measured']} ticks")
    # the guest's clock stands still at times; frames are late then, and torque falls: for each stale tick an outage at the most
    assert 10 * (~whole).sum() <= told["stale measured"] * OUTAGE
    stale = told["stale measured"] > 10
    assert (sent[:50] == 0).all() and (sent[DECAY - FALL :] == 0).all()
    assert stale or numpy.abs(sent).max() > 0.02
    assert told["ticks"] == len(sent) and told["measured"] > 0 and not told["stop_frame"]
    assert str(commands(recording.log, 0x010)[-1][1]["Mode"]) == "Hold"
    assert recording.end()["loop"] == {"page_faults_minor": 0, "page_faults_major": 0, "allocations": 0}


def test_a_stop_frame_from_elsewhere_takes_the_torque_away(vcan, tmp_path):  # noqa: F811
    (name,) = vcan()

    def stop_it():
        comes(name, KNEE, REST + 1000)
        with can.Bus(name, interface="socketcan") as bus:
            bus.send(can.Message(arbitration_id=1, data=struct.pack("<HBB", 0, 4, 1), is_extended_id=False))

    recording = recorded(tmp_path, name, hops=HOPS, during=stop_it)
    (told,) = recording.events("feedforward")
    ((stop, _),) = commands(recording.log, 0x001)
    after = [one["TorqueFeedforward"] for stamp, one in commands(recording.log, KNEE) if stamp > stop]
    assert told["stop_frame"] and told["stopped"] >= len(after) - 2 > 100
    assert set(after[DECAY + 3 :]) == {0.0}


def test_the_emergency_line_stops_drives_and_motion(vcan, tmp_path, button):  # noqa: F811
    (name,) = vcan()

    def press_it():  # nobody has to answer, and the guest is busy enough
        comes(name, KNEE, REST + 1000)
        button.press()

    recording = recorded(tmp_path, name, "--estop", "button=fakechip:4", hops=HOPS, environment=button.environment, during=press_it,
                         bench=lambda *_: nullcontext())  # fmt: skip
    (told,) = recording.events("play")
    assert len(commands(recording.log, 0x001)) == 3  # which the bench obeys: test_twin_orders.py
    assert told["end"] == "stopped" and 0 < told["sent"] < 2 * (REST + 1000 * HOPS)
