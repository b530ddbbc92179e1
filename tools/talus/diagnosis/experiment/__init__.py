"""What to record next.

    path.py     smooth paths within what the recordings show
    menu.py     the menu: trajectories, and what needs more than one
    planned.py  a trajectory as a recording without readings
    gain.py     the evidence that it would bring between two explanations
    camera.py   what a camera that sees the links would add
    choice.py   the choice
    words.py    the report's words and the trajectory's file
    steps.py    the steps to it, with their commands
    poor.py     recordings that cannot carry a diagnosis
"""

from .choice import propose
from .poor import too_poor
from .steps import steps

__all__ = ["propose", "steps", "too_poor"]
