"""The wide protocol: another plant, machine, rate, resolution, noise, length and motion in every case."""

import numpy as np

from . import motions, sensors
from .plants import Leg, Single, log_uniform, scaled

NAME = "wide"
PLANTS = {"leg": 0.5, "pendulum": 0.35, "slider": 0.15}
RATES_HZ = (100, 125, 200, 250, 400, 500, 800, 1000)
MOST, TOTAL_S, SHORTEST_S, TEST_S = 4, (20.0, 300.0), 10.0, (12.0, 30.0)
RANGES = {"leg": {"knee": (0.3, 0.65), "ankle": (0.2, 0.36)}, "pendulum": {"knee": (0.25, 1.4)}, "slider": {"knee": (0.03, 0.3)}}
ROOM = 3.0  # times the half range, beyond which a run is given up
STIFF_RAD_S = 3000.0  # the twin's shortest step follows such a spring and rotor well
ATTEMPTS = 40


def draw_plant(rng):
    at = rng.uniform()
    for kind, share in PLANTS.items():
        at -= share
        if at < 0:
            break
    return {"leg": Leg.draw_any, "pendulum": Single.draw_pendulum, "slider": Single.draw_slider}[kind](rng)


def draw_control(rng, plant, half):
    control = {"range": ROOM * max(half.values())}
    for joint in plant.joints:
        control |= {f"{joint}.bandwidth": rng.uniform(6, 14), f"{joint}.zeta": rng.uniform(0.7, 1.0),
                    f"{joint}.current_limit": 1e9, f"{joint}.control_inertia": plant.inertia(joint) * rng.uniform(0.9, 1.2)}  # fmt: skip
    return control


def draw_kinds(rng, count):
    """Of the recordings and of the one held out, which is of another kind than at least one of them."""
    names = list(motions.KINDS)
    kinds = [str(rng.choice(names)) for _ in range(count)]
    held_out = str(rng.choice([name for name in names if any(name != kind for kind in kinds)]))
    return kinds, held_out


def draw_lengths(rng, count):
    """Of the recordings, that share a whole; each at least so long that there is something to see."""
    total = max(log_uniform(rng, *TOTAL_S), count * SHORTEST_S)
    part = rng.dirichlet(np.full(count, 4.0))
    return SHORTEST_S + (total - count * SHORTEST_S) * part


def draw_times(rng, length, rate, jitter, lost):
    """Instants of the rows [s]: even but for jitter, some rows lost."""
    n = int(length * rate)
    times = np.round((1 + np.arange(n) + jitter * rng.uniform(-1, 1, n)) / rate, 7)
    return times[rng.uniform(size=n) >= lost]


def draw_runs(rng, half):
    """Each recording's job and instants, and the protocol as it goes into the sealed file."""
    count, rate = int(rng.integers(1, MOST + 1)), int(rng.choice(RATES_HZ))
    kinds, held_out = draw_kinds(rng, count)
    lengths = draw_lengths(rng, count)
    jitter, lost = rng.uniform(0.0, 0.05), rng.choice([0.0, 0.0, rng.uniform(0.0, 0.004)])
    pace = log_uniform(rng, 0.5, 1.3)
    runs, session = {}, 0.0
    names = [*(f"train{i + 1}" for i in range(count)), "test"]
    for name, kind, length in zip(names, [*kinds, held_out], [*lengths, rng.uniform(*TEST_S)], strict=True):
        job = motions.KINDS[kind](rng, half, pace * rng.uniform(0.85, 1.15), length)
        session += job["settle_s"]
        times = draw_times(rng, length, rate, jitter, lost)
        runs[name] = {"job": {**job, "session_s": session, "seed": int(rng.integers(1, 2**31))}, "times": times}
        session += length + rng.uniform(3, 20)
    protocol = {"rate_Hz": rate, "recordings": count, "length_s": [round(float(x), 2) for x in lengths],
                "total_s": round(float(sum(lengths)), 2), "motions": kinds, "held_out": held_out,
                "jitter": jitter, "rows_lost": float(lost)}  # fmt: skip
    return runs, protocol


def measure(case):
    """The bench without any effect: each joint's scale by what its recordings show, limits of the currents, and the noise.
    False where it runs away."""
    plant, shown, scale, rng = case.plant, case.simulate([]), {}, case.streams["noise_size"]
    if shown is None:
        return False
    runs = shown[0]
    for joint in plant.joints:
        ratio = plant.ratio(joint)
        top = {what: max(float(np.abs(run[f"{joint}_{what}"]).max()) for run in runs.values())
               for what in ("motor_v", "A", "load", "motor_true")}  # fmt: skip
        stiff = min(plant.rotor(joint), plant.inertia(joint)) * STIFF_RAD_S**2
        units = plant.units if plant.kind != "leg" else ("rad", "Nm")
        scale[joint] = scaled(joint, ratio, top["motor_v"] / ratio, top["A"], top["load"], top["motor_true"] / ratio, stiff, units)
        case.limits_A[joint] = top["A"] * rng.uniform(2.0, 4.0)
        case.control[f"{joint}.current_limit"] = case.limits_A[joint]
    plant.scale = scale
    case.noise = sensors.draw_any_noise(rng, plant)
    sensors.weigh_noise(case.noise, plant, runs)
    return True


def draw_bench(case):
    """Plant, control, recordings, noise and optional columns; a bench that runs away is drawn anew."""
    case.streams["noise_size"] = np.random.default_rng([*case.seed, 7])
    for _ in range(ATTEMPTS):
        bench = case.streams["bench"]
        case.plant, case.limits_A = draw_plant(case.streams["plant"]), {}
        half = {joint: bench.uniform(*RANGES[case.plant.kind][joint]) for joint in case.plant.joints}
        case.control = draw_control(bench, case.plant, half)
        case.runs, case.protocol = draw_runs(bench, half)
        case.options = sensors.draw_options(bench)
        if measure(case):
            case.protocol |= {"plant": case.plant.kind, "bits": case.noise["bits"], "noise": case.noise["colour"]}
            return
    raise RuntimeError(f"case {case.number} of seed {case.seed[0]}: no bench in {ATTEMPTS} draws stays in its range")
