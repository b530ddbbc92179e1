"""A joint that a spring or a gap parts from its motor: where one can be told, and the library's shapes of it."""

import math

MOST_STEPS, LARGEST_STEP = 60, 1.0  # of a link for one sample; and beyond so many rad a stepped oscillation grows
STIFFNESSES_NM_RAD = (200, 400, 800, 1500, 3000, 6000, 12000)
SOFTER_NM_RAD = (25, 50, 100)  # of a link so light that it swings on them no slower than a single joint's does
STIFFEST_NM_RAD = 30000.0
# of a single joint or axis, which may be of any size: at which its own inertia swings on the spring
FREQUENCIES_HZ = (4.0, 7.0, 12.0, 20.0, 33.0, 55.0)
SOFTEST_HZ, STIFFEST_HZ = 2.0, 120.0
SOFTEST, STIFFEST = 0.1, 1e8
MOTOR_SHARE = 0.15  # of the joint's own inertia that turns with its motor: a knee's rotor through its ratio
MOTOR_SHARES = (0.15, 0.4)  # where it may be heavy, too


def motor_shares(at):
    """An ankle's rotor is known."""
    return MOTOR_SHARES if at.dataset.at_motor and at.number == 0 else (MOTOR_SHARE,)


def stiffness_at(at, frequency_Hz):
    """Of a spring on which the joint's inertia swings at a frequency [Nm/rad, N/m], within what a model file takes."""
    stiffness = (2 * math.pi * frequency_Hz / at.all_terms[0].link_rad_s(at.number, 0.0, 1.0)) ** 2
    return min(max(stiffness, SOFTEST), STIFFEST)


def stiffnesses(at):
    """The grid's, and the limits between which they are moved."""
    if at.dataset.at_motor:
        grid = (*(k for k in SOFTER_NM_RAD if k > stiffness_at(at, FREQUENCIES_HZ[0])), *STIFFNESSES_NM_RAD)
        return grid, (0.5 * grid[0], STIFFEST_NM_RAD)
    return tuple(stiffness_at(at, f) for f in FREQUENCIES_HZ), (stiffness_at(at, SOFTEST_HZ), stiffness_at(at, STIFFEST_HZ))


def is_out_of_sight(at):
    """Where no link behind the motor can be told: without an angle, or with the load measured before the link; or so
    light a link that its oscillation cannot be stepped."""
    if at.dataset.velocity_only or at.dataset.load_sensor:
        return True
    fastest = at.all_terms[0].link_rad_s(at.number, 0.0, max(stiffnesses(at)[0]))
    return not all(terms.step_s * fastest < MOST_STEPS * LARGEST_STEP for terms in at.all_terms)


def link_shapes(at, stiffness, dry, viscous, motor, damping_ratio, **form):
    """The library's shapes of a spring or a gap: damping over stiffness from the link's damping ratio."""
    damping_s = 2 * damping_ratio / at.all_terms[0].link_rad_s(at.number, motor, stiffness)
    return {"stiffness_Nm_rad": stiffness, "damping_s": damping_s, "friction_share": dry, "viscous_share": viscous,
            "motor_share": motor, **form}  # fmt: skip


def sides_in_words(dry, viscous, motor):
    """What of a joint stands on which side, in words."""
    return f", {dry:g} of dry and {viscous:g} of viscous friction at the link, rotor {motor:g}"
