"""Currents and angles that are sampled at different instants."""

from .entry import Effect

# the delay itself is a strength: these are where it is linear
DELAYS_S = (-0.020, -0.015, -0.010, -0.006, -0.003, -0.001, 0.001, 0.003, 0.006, 0.010, 0.015, 0.020)
LEAST_S = 0.0005  # half a tick of a drive at 1 kHz: a torque that is held between ticks is seen so early or late by any recording
MOST_OF_A_LEG_S = 0.010  # more than two samples of its recordings is no sampling


def candidates(at):
    """A current that is later than the angles; beside a sensor at the output, where the current is known and a late one tells
    of an earlier instant, also both later than the sensor."""
    most = MOST_OF_A_LEG_S if at.dataset.at_motor else max(DELAYS_S)
    for near_s in (s for s in DELAYS_S if abs(s) <= most):
        near, limits = f"near {1e3 * near_s:g} ms", ((LEAST_S,), (most,)) if near_s > 0 else ((-most,), (-LEAST_S,))
        for form, saved in ((near, {}), (f"{near}, angles too", {"angles_too": 1.0}))[:2 if at.dataset.load_sensor else 1]:
            yield at.of_law("delay", form, [{"delay_s": 1.0}], {"near_s": near_s, **saved}, saved=([{"delay_s": 1.0}], saved), low=limits[0],
                            high=limits[1])  # fmt: skip


def size(p):
    if p.get("angles_too"):
        return f"current and angles are {1e3 * p['delay_s']:.3g} ms later than the torque sensor"
    return f"the current is {1e3 * abs(p['delay_s']):.3g} ms {'later' if p['delay_s'] > 0 else 'earlier'} than the angles"


EFFECT = Effect(
    id="delay",
    words="currents and angles taken at different instants",
    candidates=candidates,
    size=size,
    coordinates=("acceleration", "frequency", "reversal"),
    trajectory="fast_multisine",
)
