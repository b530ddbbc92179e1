"""Recordings that cannot carry a diagnosis."""

from ..gate import Finding

LEAST_TIME_S = 8.0
LEAST_ROWS = 500


def too_poor(processed_recordings):
    """The finding why these recordings cannot carry a diagnosis, or None."""
    usable = [processed for processed in processed_recordings if processed.parts]
    time_s = sum(processed.grid_t_s[-1] - processed.grid_t_s[0] for processed in usable)
    if time_s < LEAST_TIME_S:
        return Finding("too_short", True, "time_s", f"only {time_s:.1f} s of usable motion, and a diagnosis needs {LEAST_TIME_S:g} s: "
                       "nothing can be held out", "at least a minute that crosses the whole range at several speeds")  # fmt: skip
    for joint in range(usable[0].joints):
        # with a sensor at the output a joint that stands says something, too
        rows = sum(int((processed.kind[joint] != 0 if "joint_load_Nm" in processed.columns else processed.kind[joint] == 1).sum())
                   for processed in usable)  # fmt: skip
        if rows < LEAST_ROWS:
            name = usable[0].model.joints[joint]
            return Finding("too_little_motion", True, "", f"only {rows} samples of the {name} lie outside standstill, and a diagnosis "
                           f"needs {LEAST_ROWS}", f"a trajectory in which the {name} moves throughout")  # fmt: skip
    return None
