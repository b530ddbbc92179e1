"""From the twin's exact rows to what a recording shows: sensor effects, noise, encoder steps, optional columns."""

import gzip
import io

import numpy as np
from scipy.signal import lfilter

from .plants import log_uniform

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


def complete_noise(noise, plant):
    """The same as torques and of the ankle's encoders together."""
    for joint in plant.joints:
        noise[f"{joint}_torque_Nm"] = plant.torque_constant(joint) * noise[f"{joint}_current_A"]
    if plant.kind == "leg":
        noise["ankle_encoder_rad"] = float(
            np.hypot(noise["ankle_joint_lsb_rad"], noise["ankle_motor_lsb_rad"] / plant.scale["ankle"].ratio) / np.sqrt(12)
        )
    return noise


def draw_any_noise(rng, plant):
    """Of the wide protocol: one resolution for all encoders (0 bits: exact), noise of the current in shares of its peak, white
    or with a part below a corner, and the step of a converter. A joint alone has its encoder at the motor or behind the gear,
    and shows current or torque."""
    bits = int(rng.choice([0, 12, 13, 14, 15, 16, 17, 18, 19, 20]))
    turn = 2 * np.pi / 2.0**bits if bits else 0.0
    noise = {"bits": bits, "colour": "coloured" if rng.uniform() < 0.4 else "white"}
    noise["coloured_part"] = rng.uniform(0.3, 0.9) if noise["colour"] == "coloured" else 0.0
    noise["corner_Hz"], noise["converter"] = log_uniform(rng, 2.0, 40.0), rng.choice([0.0, 0.0, log_uniform(rng, 0.3, 3.0)])
    for joint in plant.joints:
        noise[f"{joint}_current_A"] = log_uniform(rng, 0.002, 0.03) * plant.scale[joint].peak_A
        noise[f"{joint}_motor_lsb_rad"] = turn
    noise["camera_rad"] = rng.uniform(0.0006, 0.0015)
    behind, torque, screw = rng.uniform() < 0.4, rng.uniform() < 0.3, rng.uniform(0.004, 0.02)
    if plant.kind == "leg":
        noise["ankle_joint_lsb_rad"] = turn
    elif plant.kind == "pendulum":
        noise |= {"behind": bool(behind), "torque_column": bool(torque)}
        noise["knee_motor_lsb_rad"] *= plant.ratio("knee") if behind else 1.0
    else:  # an encoder on the screw
        noise |= {"behind": False, "torque_column": True, "knee_motor_lsb_rad": turn / (2 * np.pi) * screw}
    return noise


def current_noise(noise, joint, n, rate_Hz, rng):
    """Noise of a current: white, and a part of its variance below a corner."""
    white = rng.standard_normal(n)
    part = noise.get("coloured_part", 0.0)
    if part > 0.0:
        keep = np.exp(-2 * np.pi * noise["corner_Hz"] / rate_Hz)
        slow = lfilter([np.sqrt(1 - keep**2)], [1.0, -keep], rng.standard_normal(n))
        white = np.sqrt(1 - part) * white + np.sqrt(part) * slow
    return noise[f"{joint}_current_A"] * white


BANDS_HZ = (30.0, 15.0, 8.0, 4.0)
REFERENCE_HZ = 125.0  # half the narrow protocol's rate: noise there counts as one spread evenly up to here


def below(values, rate_Hz, corner_Hz, derivatives=0):
    """What of rows lies below a corner, so often differentiated."""
    f = np.fft.rfftfreq(len(values), 1 / rate_Hz)
    spectrum = np.fft.rfft(values) * (f < corner_Hz) * (2j * np.pi * f) ** derivatives
    return np.fft.irfft(spectrum, len(values))


def weigh_noise(noise, plant, runs):
    """What current and encoder leave of each motor's torque below each band's corner, as white noise up to REFERENCE_HZ that
    would leave as much; the first band's goes by the narrow protocol's names, too."""
    run, rng = runs["train1"], np.random.default_rng(0)
    rate, n = 1 / np.median(np.diff(run["t"])), len(run["t"])
    noise["bands_Nm"] = {}
    for joint in plant.joints:
        current = plant.torque_constant(joint) * current_noise(noise, joint, n, rate, rng)
        angle = steps(run[f"{joint}_motor"], noise[f"{joint}_motor_lsb_rad"]) - run[f"{joint}_motor"]
        inertia, spread = plant.inertia(joint) / plant.ratio(joint) ** 2, np.sqrt(REFERENCE_HZ / np.array(BANDS_HZ))
        left = [np.hypot(below(current, rate, f).std(), inertia * below(angle, rate, f, 2).std()) for f in BANDS_HZ]
        noise["bands_Nm"][joint] = [float(x) for x in left * spread]
        noise[f"{joint}_torque_Nm"] = noise["bands_Nm"][joint][0]
    if plant.kind == "leg":
        lsb = np.hypot(noise["ankle_joint_lsb_rad"], noise["ankle_motor_lsb_rad"] / plant.ratio("ankle"))
        noise["ankle_encoder_rad"] = float(max(lsb / np.sqrt(12), 1e-6))


def draw_options(rng):
    """Optional columns, whatever the effect."""
    return {"camera": rng.uniform() < 0.45, "temperature": rng.uniform() < 0.5, "bus": rng.uniform() < 0.3,
            "ambient_C": rng.uniform(19, 27), "rise_C": rng.uniform(12, 30), "tau_s": rng.uniform(40, 150)}  # fmt: skip


def shown_currents(run, sensor):
    """Currents as the sensors show them, without noise."""
    out = {"knee": run["knee_A"].copy(), "ankle": run["ankle_A"].copy()}
    for joint, other in (("knee", "ankle"), ("ankle", "knee")):  # of one joint alone the other current is 0
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
    return np.round(values / lsb) * lsb if lsb else values


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


def recording(run, currents, sensor, noise, options, job, session_s, rng, plant):
    """Columns of the file."""
    return (leg_recording if plant.kind == "leg" else single_recording)(
        run, currents, sensor, noise, options, job, session_s, rng, plant
    )


def measured_current(current, noise, joint, sensor, t, rng):
    """As the converter shows it."""
    noisy = current + current_noise(noise, joint, len(t), 1 / np.median(np.diff(t)), rng)
    return hang(steps(noisy, noise.get("converter", 0.0) * noise[f"{joint}_current_A"]), t, sensor, joint)


def leg_recording(run, currents, sensor, noise, options, job, session_s, rng, plant):
    t = run["t"]
    shown = {"time_s": t, "knee_motor_rad": steps(run["knee_motor"], noise["knee_motor_lsb_rad"]),
             "ankle_motor_rad": steps(run["ankle_motor"], noise["ankle_motor_lsb_rad"]),
             "ankle_joint_rad": steps(shown_joint(run, sensor), noise["ankle_joint_lsb_rad"])}  # fmt: skip
    for joint in ("knee", "ankle"):
        shown[f"{joint}_current_A"] = measured_current(currents[joint], noise, joint, sensor, t, rng)
    if options["camera"]:
        for name in ("shank", "foot"):
            shown[f"{name}_rad"] = run[name] + noise["camera_rad"] * rng.standard_normal(len(t))
    if options["temperature"]:
        for joint in ("knee", "ankle"):
            shown[f"{joint}_temp_C"] = temperature(options, session_s + t, joint) + 0.06 * rng.standard_normal(len(t))
    if options["bus"]:
        shown["bus_V"] = bus_voltage(job, session_s + t, run, rng)
    return shown


def single_recording(run, currents, sensor, noise, options, job, session_s, rng, plant):
    t = run["t"]
    motor = steps(run["shank"] * plant.gear if noise["behind"] else run["knee_motor"], noise["knee_motor_lsb_rad"])
    current = measured_current(currents["knee"], noise, "knee", sensor, t, rng)
    if plant.kind == "slider":
        return {"time_s": t, "slider_m": motor, "slider_force_N": current}
    shown = {"time_s": t, "joint_rad": motor / plant.gear}
    torque = plant.K * plant.gear * current
    shown |= {"joint_torque_Nm": torque} if noise["torque_column"] else {"joint_current_A": current}
    if options["temperature"]:
        shown["joint_temp_C"] = temperature(options, session_s + t, "knee") + 0.06 * rng.standard_normal(len(t))
    if options["bus"]:
        shown["bus_V"] = bus_voltage(job, session_s + t, run, rng)
    return shown


def write(path, shown, decimals=DECIMALS):
    """CSV, compressed; the same bytes every time. `decimals` None: as many as tell any two values apart."""
    text, form = io.StringIO(), [f"%.{decimals[name]}f" if decimals else "%.10g" for name in shown]
    np.savetxt(text, np.array(list(shown.values())).T, delimiter=",", fmt=form)
    body = (",".join(shown) + "\n" + text.getvalue()).encode()
    path.write_bytes(gzip.compress(body, compresslevel=6, mtime=0))
