"""Recordings that cannot carry a diagnosis."""

LEAST_TIME_S = 8.0
LEAST_ROWS = 500


def too_poor(tracks):
    """The reason why these recordings cannot carry a diagnosis, or None."""
    usable = [track for track in tracks if track.parts]
    time_s = sum(track.grid_t_s[-1] - track.grid_t_s[0] for track in usable)
    if time_s < LEAST_TIME_S:
        return (f"only {time_s:.1f} s of usable motion, and a diagnosis needs {LEAST_TIME_S:g} s: nothing can be held out. "
                f"Next: at least a minute that crosses the whole range at several speeds.")
    for joint in range(usable[0].joints):
        # with a sensor at the output a joint that stands says something, too
        rows = sum(int((track.kind[joint] != 0 if "joint_load_Nm" in track.columns else track.kind[joint] == 1).sum())
                   for track in usable)  # fmt: skip
        if rows < LEAST_ROWS:
            name = usable[0].model.joints[joint]
            return (f"only {rows} samples of the {name} lie outside standstill, and a diagnosis needs {LEAST_ROWS}. "
                    f"Next: a trajectory in which the {name} moves throughout.")
    return None
