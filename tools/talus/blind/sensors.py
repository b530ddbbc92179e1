"""From the twin's exact rows to what a recording shows: sensor effects, noise, encoder steps, optional columns."""

import gzip
import io

import numpy as np

from .bench import FIXED

DECIMALS = {
    "time_s": 6,
    "knee_motor_rad": 5,
    "ankle_motor_rad": 5,
    "ankle_joint_rad": 6,
    "knee_current_A": 4,
    "ankle_current_A": 5,
    "shank_rad": 5,
    "foot_rad": 5,
    "knee_temp_C": 2,
    "ankle_temp_C": 2,
    "bus_V": 2,
}


def draw_noise(rng):
    turn = lambda: 2 * np.pi / 2.0 ** rng.integers(14, 17)  # noqa: E731
    return {"knee_current_A": rng.uniform(0.015, 0.04), "ankle_current_A": rng.uniform(0.003, 0.008),
            "knee_motor_lsb_rad": turn(), "ankle_motor_lsb_rad": turn(), "ankle_joint_lsb_rad": turn(),
            "camera_rad": rng.uniform(0.0006, 0.0015)}  # fmt: skip


def complete_noise(noise):
    """The same as torques and of the ankle's encoders together."""
    for joint in ("knee", "ankle"):
        noise[f"{joint}_torque_Nm"] = FIXED["K"] * noise[f"{joint}_current_A"]
    noise["ankle_encoder_rad"] = float(
        np.hypot(noise["ankle_joint_lsb_rad"], noise["ankle_motor_lsb_rad"] / 125) / np.sqrt(12)
    )
    return noise


def draw_options(rng):
    """Optional columns, whatever the effect."""
    return {"camera": rng.uniform() < 0.45, "temperature": rng.uniform() < 0.5, "bus": rng.uniform() < 0.3,
            "ambient_C": rng.uniform(19, 27), "rise_C": rng.uniform(12, 30), "tau_s": rng.uniform(40, 150)}  # fmt: skip


def shown_currents(run, sensor):
    """Currents as the sensors show them, without noise."""
    out = {"knee": run["knee_A"].copy(), "ankle": run["ankle_A"].copy()}
    for joint, other in (("knee", "ankle"), ("ankle", "knee")):
        i = out[joint]
        i += sensor.get(f"{joint}.offset_A", 0.0)
        i += sensor.get(f"{joint}.positive_gain", 0.0) * np.maximum(i, 0.0)
        i += sensor.get(f"{joint}.cross_talk", 0.0) * run[f"{other}_A"]
    return out


def shown_joint(run, sensor):
    """The ankle's joint encoder, without its steps."""
    if "joint_encoder" not in sensor:
        return run["ankle_joint"]
    order, size, phase = sensor["joint_encoder"]
    return run["ankle_joint"] + size * (np.sin(order * run["ankle_joint"] + phase) - np.sin(phase))


def hang(values, t, sensor, joint):
    """A sensor that holds its value now and then."""
    if f"{joint}.stuck" not in sensor:
        return values
    every, length, seed = sensor[f"{joint}.stuck"]
    rng, values, at = np.random.default_rng(seed), values.copy(), 0.0
    while at < t[-1]:
        at += rng.exponential(every)
        inside = np.flatnonzero((t >= at) & (t < at + length))
        if len(inside):
            values[inside] = values[inside[0]]
        at += length
    return values


def steps(values, lsb):
    return np.round(values / lsb) * lsb


def temperature(options, session_s, joint):
    rise = options["rise_C"] * (1.0 if joint == "knee" else 1.15)
    return options["ambient_C"] + rise * (1 - np.exp(-session_s / options["tau_s"]))


def bus_voltage(job, session_s, run, rng):
    """A battery under load; where the case says so it wanders, and the torque constant with it."""
    wave = np.zeros_like(session_s)
    for i in range(3):
        wave += job.get(f"bus_a[{i}]", 0.0) * np.sin(
            job.get(f"bus_w[{i}]", 0.0) * session_s + job.get(f"bus_p[{i}]", 0.0)
        )
    return 36.0 * (1 + wave) - 0.05 * np.abs(run["knee_A"]) + 0.03 * rng.standard_normal(len(session_s))


def recording(run, currents, sensor, noise, options, job, session_s, rng):
    """Columns of the file."""
    t = run["t"]
    shown = {"time_s": t, "knee_motor_rad": steps(run["knee_motor"], noise["knee_motor_lsb_rad"]),
             "ankle_motor_rad": steps(run["ankle_motor"], noise["ankle_motor_lsb_rad"]),
             "ankle_joint_rad": steps(shown_joint(run, sensor), noise["ankle_joint_lsb_rad"])}  # fmt: skip
    for joint in ("knee", "ankle"):
        noisy = currents[joint] + noise[f"{joint}_current_A"] * rng.standard_normal(len(t))
        shown[f"{joint}_current_A"] = hang(noisy, t, sensor, joint)
    if options["camera"]:
        for name in ("shank", "foot"):
            shown[f"{name}_rad"] = run[name] + noise["camera_rad"] * rng.standard_normal(len(t))
    if options["temperature"]:
        for joint in ("knee", "ankle"):
            shown[f"{joint}_temp_C"] = temperature(options, session_s + t, joint) + 0.06 * rng.standard_normal(len(t))
    if options["bus"]:
        shown["bus_V"] = bus_voltage(job, session_s + t, run, rng)
    return shown


def write(path, shown):
    """CSV, compressed; the same bytes every time."""
    text = io.StringIO()
    np.savetxt(text, np.array(list(shown.values())).T, delimiter=",", fmt=[f"%.{DECIMALS[name]}f" for name in shown])
    body = (",".join(shown) + "\n" + text.getvalue()).encode()
    path.write_bytes(gzip.compress(body, compresslevel=6, mtime=0))
