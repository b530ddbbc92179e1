"""What the steps of the ankle's two encoders leave between them, at the recorded motion itself.

Replicates move nearly as the recordings do. Where a joint goes a whole number of an encoder's counts from sample to sample,
rounding errors hardly change between samples and pass the low-pass; at a speed a little off they do not (Widrow and Kollar,
Quantization Noise, ch. 20).
"""

import numpy as np

REPEATS = 3  # draws of where the encoders' grids lie


def excess(dataset, sensors, random):
    """{kind: chi-square over its freedom} that both encoders' steps and noise make of the angle between them: the mean over some draws.
    `sensors` are those of each recording; without an encoder at the ankle's output there is nothing to tell."""
    channels = [c for c in dataset.channels if c.kind == "E"]
    if not channels:
        return {}
    found = []
    for _ in range(REPEATS):
        between = np.concatenate([_between(dataset, c, sensors[c.record], random) for c in channels])
        found.append(np.sum((between - np.mean(between)) ** 2) if len(between) else 0.0)  # a fit has a constant of its own
    return {"E": float(dataset.thin * np.mean(found) / dataset.sigma["E"] ** 2) - dataset.freedom("E")}


def _between(dataset, channel, sensors, random):
    """One encoder's reading less the other's [rad], in the rows that count."""
    processed, transmission = dataset.processed_recordings[channel.record], dataset.transmissions[1]
    angle = processed.q[1]
    motor = transmission.joint_rad(sensors.seen("ankle_motor_rad", transmission.motor_rad(angle), random))
    return processed.operate(sensors.seen("ankle_joint_rad", angle, random) - motor)[channel.thinned]
