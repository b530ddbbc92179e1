"""The torque that a gear carries, as the literature reads it in several ways."""


def carried_loads(at):
    """Readings of `the torque that the gear carries` that the literature has: name, and shares of the rotor and of friction
    in it."""
    rotor = 0.0 if at.dataset.at_motor and at.number == 1 else 1.0  # the others have no rotor of their own
    yield "link", {"rotor_share": rotor, "friction_share": 0.0}
    if at.dataset.load_sensor:  # the gear carries what the drive gives
        return
    if rotor == 0.0:
        yield "link and rotor", {"rotor_share": 1.0, "friction_share": 0.0}
    yield "all", {"rotor_share": 1.0, "friction_share": 1.0}
