"""apps/leg_bus/orders.c and lateness.c: what the bus asks of the twin, and what it then does, tick by tick."""

import math
import subprocess

import pytest
from bus_record import DATABASE, MODEL
from support import BUILD

OFF, HOLD, FOLLOW, STOPPED = range(4)
PATIENCE = 100  # ticks: 0.1 s at 1 kHz
TICK = "tick"


def frame(name, **values):
    message = DATABASE.get_message_by_name(name)
    return f"{message.frame_id:03X}#{message.encode({'Counter': 0, **values}).hex()}"


def command(joint, q, v=0.0, torque=0.0):
    return frame(f"{joint}Command", Position=q, Velocity=v, TorqueFeedforward=torque)


def both(q=0.1, v=0.5):
    return [command("Knee", q, v), command("Ankle", -q, -v)]


def host(mode):
    return frame("HostHeartbeat", Mode=("Off", "Hold", "Follow")[mode])


STOP = frame("Stop", Reason="EmergencyStop", Source=0)


def run(lines, follow="follow"):
    """(the drives' stiffnesses and limit, the answers as numbers)."""
    done = subprocess.run([BUILD / "tests/twin_orders", MODEL, follow], input="".join(f"{line}\n" for line in lines), check=True,
                          capture_output=True, text=True)  # fmt: skip
    first, *rest = ([float(x) for x in line.split()] for line in done.stdout.splitlines())
    return first, rest


def states(lines, **more):
    return [int(answer[0]) for answer in run(lines, **more)[1]]


def test_stands_still_until_a_set_point_comes():
    _, answers = run([TICK, *both(), TICK])
    assert answers[0] == [HOLD, 0, 0, 0, 0, 1, 0, 0]
    assert answers[1] == pytest.approx([FOLLOW, 0.1, 0.5, -0.1, -0.5, 1, 0, 0], abs=1e-12)


def test_each_tick_goes_through_its_own_set_point():
    lines, expected = [], []
    for k in range(200):
        q, v = 0.3 * math.sin(k / 30), 0.3 * math.cos(k / 30)
        lines += [*both(q, v), TICK]
        expected.append((q, v))
    for answer, (q, v) in zip(run(lines)[1], expected, strict=True):
        assert answer[1:5] == pytest.approx([q, v, -q, -v], abs=1.1e-3)  # speeds come in steps of 2 mrad/s
        assert answer[1] == pytest.approx(q, abs=2.6e-6) and answer[6] == 0


def test_without_new_set_points_it_holds_after_a_while():
    _, answers = run([*both(), *[TICK] * (PATIENCE + 10), *both(0.2), TICK])
    assert [int(a[0]) for a in answers] == [FOLLOW] * (PATIENCE + 1) + [HOLD] * 9 + [FOLLOW]
    assert answers[-2][1:5] == pytest.approx([0.1, 0, -0.1, 0])  # at the last set-point, at rest
    assert [int(a[6]) for a in answers[:3]] == [0, 1, 2] and answers[-1][6] == PATIENCE  # counted while it follows


def test_one_joint_alone_is_a_tick_without():
    assert run([*both(), TICK, command("Knee", 0.1), TICK])[1][-1][6] == 1


def test_the_hosts_mode_counts_where_there_is_one():
    assert states([host(OFF), *both(), TICK, host(HOLD), *both(), TICK, host(FOLLOW), *both(), TICK]) == [OFF, HOLD, FOLLOW]
    _, answers = run([host(OFF), *both(), TICK, host(FOLLOW), TICK])
    assert [a[5] for a in answers] == [0, 1]  # powered


def test_a_heartbeat_that_stays_away_means_hold():
    lines = [host(FOLLOW)] + [line for _ in range(PATIENCE + 5) for line in (*both(), TICK)]
    assert states(lines) == [FOLLOW] * (PATIENCE + 1) + [HOLD] * 4


def test_a_stop_is_for_good():
    _, answers = run([*both(), TICK, STOP, TICK, host(FOLLOW), *both(), TICK])
    assert [a[0] for a in answers] == [FOLLOW, STOPPED, STOPPED] and [a[5] for a in answers] == [1, 0, 0]
    assert states([TICK, STOP, TICK], follow="own") == [FOLLOW, STOPPED]


def test_its_own_excitation_takes_no_set_points():
    assert states([*both(), host(OFF), TICK], follow="own") == [FOLLOW]


def test_positions_are_kept_within_their_limits():
    _, answers = run([command("Knee", 2.0), command("Ankle", -0.7), TICK])
    assert answers[0][1::2][:2] == [1.0, -0.5] and answers[0][7] == 2


@pytest.mark.parametrize(("joint", "place", "torque"), [("Knee", 0, 0.02), ("Knee", 0, -0.3), ("Ankle", 1, 0.004)])
def test_feedforward_is_the_shift_that_makes_its_torque(joint, place, torque):
    """Position control: current = stiffness x (motor angle wanted - motor angle)."""
    (*stiffness, limit), ((_, q_knee, _, q_ankle, *_),) = run([command("Knee", 0.2), command("Ankle", 0.1),
                                                               command(joint, 0.2 - 0.1 * place, 0.0, torque), TICK])  # fmt: skip
    current = torque / 0.1031
    shift = (max(-limit, min(limit, current)) if place == 0 else current) / stiffness[place]
    if place == 0:
        assert 51 * (q_knee - 0.2) == pytest.approx(shift, rel=1e-6)
        return
    from talus import Model, ffi, lib

    model = Model.read(MODEL)
    drive = ffi.addressof(model.struct.drive[1], "transmission")
    moved = lib.tl_transmission_motor_angle(drive, q_ankle) - lib.tl_transmission_motor_angle(drive, 0.1)
    assert moved == pytest.approx(shift, rel=1e-6)


def test_short_frames_ask_for_nothing():
    assert states([command("Knee", 0.3)[:-2], STOP[:-2], host(OFF)[:-2], TICK]) == [HOLD]


def test_lateness_in_classes():
    _, ((half, every, over, worst),) = run(["late 500 900 3000 5000000 1500000"])
    assert half == 4 and every == 5000 and over == 2 and worst == 5_000_000
