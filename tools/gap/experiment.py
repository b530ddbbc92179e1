"""What to record next: from a menu, what separates the causes that this data leaves open."""

FRICTION = {"stribeck", "load_friction", "directional_efficiency", "asymmetric_friction", "nonlinear_viscous",
            "position_friction", "presliding", "friction_drift"}  # fmt: skip
LEAST_TIME_S = 8.0
LEAST_ROWS = 500

MENU = {
    "rest": "10 s at rest with the drive unpowered, then held at three angles: the current's zero shows without motion",
    "slow_ramps": "slow ramps in both directions over the whole range, at 0.02, 0.05 and 0.1 rad/s: friction near "
                  "standstill and over position shows without inertia",
    "fast_multisine": "a multisine up to 8 Hz at small amplitude: compliance and delay part in their phase, and a mount that "
                      "sways shows its resonance",
    "known_payload": "the same trajectory with a known mass at the foot: what grows with load parts from what does not",
    "base_turned": "the same trajectory with the base turned by 90 degrees: gravity's part changes, a constant does not",
    "warm_repeat": "the same trajectory again after ten minutes of motion: what changes with warmth shows",
    "camera": "the same trajectory with the camera's angles recorded: the link's own angle parts encoder from linkage",
}  # fmt: skip


def choose(effects):
    """The menu's entry for a set of effects that are still open."""
    effects = set(effects)
    for group, entry in (
        ({"linkage_error", "encoder_eccentricity"}, "camera"),
        ({"friction_drift"}, "warm_repeat"),
        ({"gravity_tilt", "parallel_spring"}, "base_turned"),
        ({"current_offset"}, "rest"),
        ({"load_friction", "directional_efficiency", "torque_saturation", "torque_constant"}, "known_payload"),
        ({"elasticity", "backlash", "delay", "base_compliance", "kinematic_error", "cogging"}, "fast_multisine"),
    ):
        if effects & group:
            return entry
    return "slow_ramps"


def propose(verdict):
    """`next_experiment` of the report. No trajectory is written."""
    others = verdict.confusable()
    if others:
        names = [verdict.effect, *(effect for _, effect, _ in others)]
        why = f"{' and '.join(names)} are not told apart by these recordings. Next: {MENU[choose(names)]}."
    elif verdict.effect == "unknown":
        why = ("A systematic gap remains that no known effect explains. Next: " + MENU["slow_ramps"]
               + "; then " + MENU["fast_multisine"] + ".")  # fmt: skip
    elif verdict.effect == "none":
        why = "The model explains the recordings down to their noise; nothing needs to be told apart."
    else:
        why = f"{verdict.effect} stands alone. To confirm it: {MENU[choose([verdict.effect])]}."
    return {"why": why, "trajectory": None}


def too_poor(tracks):
    """The reason why these recordings cannot carry a diagnosis, or None."""
    usable = [track for track in tracks if track.parts]
    time_s = sum(track.grid_t_s[-1] - track.grid_t_s[0] for track in usable)
    if time_s < LEAST_TIME_S:
        return (f"only {time_s:.1f} s of usable motion, and a diagnosis needs {LEAST_TIME_S:g} s: nothing can be held out. "
                f"Next: at least a minute that crosses the whole range at several speeds.")
    for joint in range(usable[0].joints):
        rows = sum(int((track.kind[joint] == 1).sum()) for track in usable)
        if rows < LEAST_ROWS:
            name = usable[0].model.joints[joint]
            return (f"only {rows} samples of the {name} lie outside standstill, and a diagnosis needs {LEAST_ROWS}. "
                    f"Next: a trajectory in which the {name} moves throughout.")
    return None
