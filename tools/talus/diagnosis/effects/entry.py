"""What the diagnosis must know of an effect beside its law, which is the library's (lib/effects)."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True, eq=False)
class Effect:
    """One effect of the catalogue. Only `id`, `words` and `candidates` must be given."""

    id: str
    words: str
    """What it is, as it stands after "The gap comes from": "friction that is higher near standstill"."""

    candidates: Callable
    """candidates(at) yields every Candidate that is tried at the joint `at` (a Place; its name is "base" for an effect of
    the mount). It is asked at those joints only where the library's law can stand."""

    size: Callable = lambda parameters: ""  # noqa: E731
    """How large it is in words, from the report's parameters; "" where no words say more than these."""

    coordinates: tuple = ()
    """Coordinates over which its residual stands out. Of maps that are nearly as strong, such a one is reported first."""

    trajectory: str = "slow_ramps"
    """The trajectory of experiment/menu.py that shows it best, where none can be simulated beforehand."""

    needs: str | None = None
    """What parts it from its rivals where no trajectory does: a key of experiment/menu.py's BEYOND."""

    several: bool = False
    """Two of its shapes may act at once: two orders, two modes."""

    integrated: bool = False
    """Each shape is an equation of motion to be integrated: only some are tried in the first search."""

    scales_drive: bool = False
    """Its strength is the error of the torque constant, and other effects are computed from the corrected torque."""

    in_offset: bool = False
    """A constant, which a model with an offset parameter absorbs."""

    turns_gravity: bool = False
    """Its strength is an angle by which gravity is turned, as an encoder whose zero is off by it would have it."""

    stiffness: Callable | None = None
    """stiffness(parameters, q) of what pushes back: where that is below 0 over most of the motion it is something else."""

    of_load_sensor: bool = False
    """An error of the torque sensor at the output itself."""

    outside: bool = False
    """It is in no catalogue (diagnosis/outside): a gap that it explains best is `unknown`."""
