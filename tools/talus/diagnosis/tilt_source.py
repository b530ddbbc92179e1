"""The bench or the encoder's zero: what turned gravity, by a camera whose own zero is known.

An encoder whose zero is off by d makes torques as a bench does that leans by d, so no motion parts the two. A camera whose angles
are those of the leg against its bench sees the difference: it agrees with the encoder on a bench that leans, and is off it by
the tilt where the encoder's zero is off. With m the mean of the camera's shank angle less the knee encoder's, t and s the tilt and its standard
deviation, a that of the camera's zero, both causes as likely before,

    bench: m ~ N(0, a²),   encoder: m ~ N(t, a² + s²).
"""

import math

from .figures import standard_errors

CHANNEL = "K"
LARGEST = 700.0  # whose exponential there is


def camera_less_encoder_rad(search, fit):
    """Mean of the camera's shank angle less the knee encoder's, in the fit; None without a camera."""
    dataset = search.dataset
    if CHANNEL not in dataset.angle_kinds:
        return None
    place = dataset.bases + dataset.angle_kinds.index(CHANNEL)
    return float(search.gram.fold_strengths(search.columns(fit.chosen))[-1][place])


def of(search, fit):
    """{"bench", "encoder": probability (None where the camera's zero is not known), "camera_less_encoder_rad"} of the tilt among
    a fit's effects; None without a tilt or a camera."""
    mean, found = camera_less_encoder_rad(search, fit), tilt(search, fit)
    if mean is None or found is None:
        return None
    encoder = None
    if search.camera_zero_rad is not None:
        bench, zero = likelihoods(mean, *found, search.camera_zero_rad)
        encoder = 1.0 / (1.0 + math.exp(min(bench - zero, LARGEST)))
    return {"bench": None if encoder is None else 1.0 - encoder, "encoder": encoder, "camera_less_encoder_rad": mean}


def place_of(search, fit):
    """Which of a fit's effects turns gravity; None where none does."""
    return next((k for k, candidate in enumerate(fit.chosen) if search.dataset.effects[candidate.effect].turns_gravity), None)


def tilt(search, fit):
    """(tilt, its standard deviation) of a fit [rad]; None where it has none."""
    place = place_of(search, fit)
    return None if place is None else (fit.strengths[place][0], standard_errors(search, fit)[place][0])


def likelihoods(mean, found, deviation, zero_rad):
    """Logarithms of how likely the camera's mean is if the bench leans, and if the encoder's zero is off: the formula above."""
    wide = math.hypot(zero_rad, deviation)
    return -0.5 * (mean / zero_rad) ** 2 - math.log(zero_rad), -0.5 * ((mean - found) / wide) ** 2 - math.log(wide)


def witness(search, fit):
    """Logarithm of how likely the camera's mean is beside a fit: where nothing in it is tilted, camera and encoder agree. 0 where
    the camera's zero is not known."""
    if search.camera_zero_rad is None:
        return 0.0
    mean = camera_less_encoder_rad(search, fit)
    if mean is None:
        return 0.0
    found = tilt(search, fit)
    bench, zero = likelihoods(mean, *(found or (0.0, 0.0)), search.camera_zero_rad)
    return max(bench, zero) + math.log(0.5 + 0.5 * math.exp(-abs(bench - zero)))


def words(source):
    """What the report says of it, in plain words."""
    off = f"the camera's shank angle is {1e3 * source['camera_less_encoder_rad']:.3g} mrad off the knee encoder's"
    if source["encoder"] is None:
        return f"{off}; --camera-zero makes that tell the encoder's zero from the bench"
    cause = "the encoder's zero is off" if source["encoder"] >= 0.5 else "the bench leans"
    probability = max(source["encoder"], source["bench"])
    return f"{off}, so {cause} (probability {'over 0.99' if probability > 0.99 else f'{probability:.2f}'})"
