"""An encoder's error that is periodic in the turn of the joint or of the motor."""

from ..catalogue import leg
from .entry import Effect

EFFECT = Effect(
    id="encoder_eccentricity",
    words="an encoder that is mounted off its centre",
    candidates=leg.encoder_eccentricity,
    coordinates=("encoder", "position", "motor_angle"),
    needs="camera",
)
