"""Draws of what is in no catalogue: the verdict for these is `unknown`."""

import numpy as np

from .effects import BOTH, Drawn, of, phase, side
from .plants import FIXED, log_uniform

FRICTION = {"knee": 1.6, "ankle": 0.7}  # Nm of the narrow protocol's joints
FOOT_KG = FIXED["mf"]


def fan(rng, joint, plant):
    size = log_uniform(rng, 0.25, 0.8) * (1.0 if joint == "knee" else 0.4) * plant.scale[joint].torque
    job = {
        "fan_a": size,
        "fan_w": 2 * np.pi * log_uniform(rng, 0.6, 6.0),
        "fan_p": phase(rng),
        "fan_on": joint == "ankle",
    }
    return Drawn("unknown", joint, "fan", f"a disturbance of {size:.2f} Nm, periodic in time", job)


def cable(rng, joint, plant):
    scale = plant.scale["ankle"]
    size = side(rng) * log_uniform(rng, 0.8, 3.0) * (scale.torque / scale.angle)
    job = {"cable": size} if rng.uniform() < 0.5 else {"cable_2": 2.0 * size, "cable": 0.5 * size}
    return Drawn("unknown", "both", "cable", f"a cable couples both joints' angles, {size:.1f} Nm/rad", job)


def bus(rng, joint, plant):
    size, job = rng.uniform(0.05, 0.15), {}
    for i in range(2):
        job |= {
            f"bus_a[{i}]": size * (0.6, 0.4)[i],
            f"bus_w[{i}]": 2 * np.pi * log_uniform(rng, 0.03, 0.4),
            f"bus_p[{i}]": phase(rng),
        }
    return Drawn("unknown", "both", "bus voltage", f"torque constant follows the bus voltage, {100 * size:.0f} %", job)


def controller(rng, joint, plant):
    if rng.uniform() < 0.5:
        size = rng.uniform(0.04, 0.15) * plant.scale[joint].peak_A
        return Drawn("unknown", joint, "dead zone", f"the current's control has a dead zone of {1e3 * size:.0f} mA",
                     of(joint, dead_zone=size))  # fmt: skip
    size = side(rng) * rng.uniform(0.08, 0.25)
    return Drawn("unknown", joint, "gain by sign", f"current shown {100 * size:+.0f} % larger where it is positive",
                 sensor={f"{joint}.positive_gain": size})  # fmt: skip


def payload_scale(plant):
    """A leg bears some hundred grams; one joint what adds as much to its own inertia or weight."""
    if plant.kind == "leg":
        return plant.fixed["mf"] / FOOT_KG
    arm = plant.job()["ls"]
    return plant.inertia("knee") / arm**2


def payload(rng, joint, plant):
    mass = rng.uniform(0.12, 0.4) * payload_scale(plant)
    job = {
        "jump_s": rng.uniform(6, 14),
        "jump_mass": mass,
        "jump_r": rng.uniform(0.04, 0.12),
        "jump_length": rng.choice([0.0, 6.0]),
    }
    return Drawn("unknown", "both", "payload", f"{1e3 * mass:.0f} g come onto the {'foot' if plant.kind == 'leg' else 'link'} in each recording", job)


def wander(rng, joint, plant):
    size, job = rng.uniform(0.25, 0.7) * FRICTION[joint] * plant.scale[joint].torque, {}
    for i in range(3):
        job |= of(
            joint,
            **{
                f"wander_a[{i}]": size * rng.uniform(0.3, 0.7),
                f"wander_w[{i}]": 2 * np.pi * log_uniform(rng, 0.02, 0.3),
                f"wander_p[{i}]": phase(rng),
            },
        )
    return Drawn("unknown", joint, "wandering torque", f"a torque that wanders slowly, {size:.2f} Nm", job)


def hose(rng, joint, plant):
    size, travel = rng.uniform(0.4, 1.2) * FRICTION[joint] * plant.scale[joint].torque, plant.scale[joint].half_range * rng.uniform(0.35, 0.9)
    return Drawn("unknown", joint, "hose", f"a hose with hysteresis, {size:.2f} Nm over {travel:.2f} rad",
                 of(joint, hose_torque=size, hose_travel=travel))  # fmt: skip


def cross_friction(rng, joint, plant):
    size, other = rng.uniform(0.35, 0.8) * FRICTION[joint] * plant.scale[joint].torque, BOTH[joint == "knee"]
    return Drawn(
        "unknown",
        joint,
        "friction by the other joint's angle",
        f"friction varies by {size:.2f} Nm with the {other}'s angle",
        of(joint, cross_size=size, cross_width=plant.scale[other].half_range / rng.uniform(0.8, 2.0), cross_phase=phase(rng)),
    )


def stuck(rng, joint, plant):
    return Drawn(
        "unknown",
        joint,
        "stuck sensor",
        "the current's sensor hangs now and then",
        sensor={f"{joint}.stuck": (rng.uniform(0.5, 2.0), rng.uniform(0.03, 0.12), int(rng.integers(1, 2**31)))},
    )


def random_walk(rng, joint, plant):
    size, tau = rng.uniform(0.2, 0.4), log_uniform(rng, 0.5, 3.0)
    return Drawn(
        "unknown",
        joint,
        "erratic friction",
        f"friction varies by {100 * size:.0f} % erratically within {tau:.1f} s",
        of(joint, walk_size=size, walk_tau=tau),
    )


def drag(rng, joint, plant):
    size, power = log_uniform(rng, 0.8, 4.0) * plant.scale["ankle"].torque, rng.choice([0.3, 1.0, 2.0])
    return Drawn("unknown", "both", "dragging foot", f"the toe drags sideways, {size:.1f} N s/m",
                 {"drag": size, "drag_power": power, "toe_r": rng.uniform(0.08, 0.2)})  # fmt: skip


def product(rng, joint, plant):
    scale = plant.scale[joint]
    size = side(rng) * log_uniform(rng, 0.1, 0.4) * (1.0 if joint == "knee" else 0.5) * (scale.torque / scale.speed**2)
    return Drawn(
        "unknown",
        joint,
        "product of speeds",
        f"{size:+.2f} Nms2/rad2 times both joints' speeds",
        of(joint, product=size),
    )


def cross_talk(rng, joint, plant):
    size = side(rng) * (rng.uniform(0.03, 0.1) if joint == "ankle" else rng.uniform(0.6, 1.5))
    return Drawn("unknown", joint, "cross-talk", f"the current's sensor also shows {size:+.2f} of the other one",
                 sensor={f"{joint}.cross_talk": size})  # fmt: skip


KINDS = (
    fan,
    cable,
    bus,
    controller,
    payload,
    wander,
    hose,
    cross_friction,
    stuck,
    random_walk,
    drag,
    product,
    cross_talk,
)


ALONE = (fan, bus, controller, payload, wander, hose, stuck, random_walk)


def draw(rng, plant, number):
    kinds = KINDS if plant.kind == "leg" else ALONE
    return kinds[int(number * len(kinds)) % len(kinds)](rng, str(rng.choice(plant.joints)), plant)
