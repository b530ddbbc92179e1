"""The torque that a gear carries, as the literature reads it in several ways."""

from .candidate import Family

SHARES = (1.0, 0.7, 0.4)  # of a joint's inertia, that its rotor is a part of: the rotor's own torque does not pass the gear
SHARE_STEP, LEAST_SHARE, WHOLE = 0.3, 0.05, 1.0


def carried_loads(at):
    """Readings of `the torque that the gear carries` that the literature has: name, and shares of the rotor, of friction and of a
    constant torque in it."""
    if at.dataset.load_sensor:  # the gear carries what the drive gives
        yield "link", {"rotor_share": 1.0, "friction_share": 0.0}
        return
    if at.has_rotor:
        yield "link", {"rotor_share": 0.0, "friction_share": 0.0}
        yield "link and rotor", {"rotor_share": 1.0, "friction_share": 0.0}
    else:
        yield from _of_shares(at)
    yield "all", {"rotor_share": 1.0, "friction_share": 1.0}


def _of_shares(at):
    """The rotor a part of the inertia that is not known; a constant torque of the joint's, or of the current's alone."""
    for share in SHARES:
        name = "link" if share == WHOLE else f"{share:g} of the inertia"
        yield name, {"rotor_share": share, "friction_share": 0.0}
        if at.has_offset:
            yield f"{name}, constant torque", {"rotor_share": share, "friction_share": 0.0, "offset_share": 1.0}


def of_other_shares(at, shares, make):
    """Family of the candidates `make(shares)` by the share of the joint's inertia that the gear carries; None where that is known."""
    if at.dataset.load_sensor or at.has_rotor or shares["friction_share"]:
        return None
    moved = lambda share: make({**shares, "rotor_share": share})
    return Family(moved, (shares["rotor_share"],), (SHARE_STEP,), (LEAST_SHARE,), (WHOLE,),
                  start="constant torque" if shares.get("offset_share") else "")  # fmt: skip
