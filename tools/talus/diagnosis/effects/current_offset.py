"""A constant added to the measured current."""

from ..catalogue import drive
from .entry import Effect

EFFECT = Effect(
    id="current_offset",
    words="a constant error of the current",
    candidates=drive.current_offset,
    coordinates=("current", "velocity", "position"),
    needs="rest",
    one_form=True,
    in_offset=True,
)
