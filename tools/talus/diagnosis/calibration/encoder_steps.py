"""What the steps of the ankle's two encoders leave between them, at the recorded motion itself.

Replicates move nearly as the recordings do. Where a joint goes a whole number of an encoder's counts from sample to sample,
rounding errors hardly change between samples and pass the low-pass; at a speed one percent off they are noise (Widrow and
Kollar, Quantization Noise, ch. 20).
"""

import numpy as np

REPEATS = 3  # grids of the encoder that are tried


def excess(dataset, sensors, random):
    """{kind: chi-square over its freedom} that both encoders' steps and noise make of the angle between them, on grids that lie anywhere:
    the mean over some. `sensors` are those of each recording."""
    if "E" not in dataset.kinds:
        return {}
    channels = [c for c in dataset.channels if c.kind == "E"]
    found = [sum(_power(dataset, c, sensors[c.record], random) for c in channels) for _ in range(REPEATS)]
    return {"E": dataset.thin * float(np.mean(found)) - dataset.freedom("E")}


def _power(dataset, channel, sensors, random):
    """Sum of squares of what one encoder differs from the other, over the noise's, in the rows that count."""
    processed, transmission = dataset.processed_recordings[channel.record], dataset.transmissions[1]
    angle = processed.q[1]
    motor = transmission.joint_rad(sensors.seen("ankle_motor_rad", transmission.motor_rad(angle), random))
    rows = processed.operate(sensors.seen("ankle_joint_rad", angle, random) - motor)[channel.thinned]
    return float(np.sum((rows - rows.mean()) ** 2)) / dataset.sigma["E"] ** 2 if len(rows) else 0.0
