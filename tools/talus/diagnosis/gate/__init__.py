"""What makes a diagnosis worthless, found before any cause is looked for: `findings` of GAP.json.

    for finding in gate.findings(model, names, recordings):
        print(finding.id, finding.grave, finding.column, finding.evidence, finding.remedy)

    times.py      the time column        samples.py    each column by itself      rows.py   rows that stand twice
    angles.py     columns that tell one angle              machine.py   columns against the model's machine
    load.py       a torque beside a sensor at the output       excerpt.py   what of long recordings is looked at
"""

import talus

from .angles import angle_findings
from .finding import Finding, worst_first
from .load import load_findings
from .machine import joint_findings
from .rows import row_findings, without_copy
from .samples import sample_findings, without_spikes
from .times import time_findings

__all__ = ["Finding", "findings"]


def findings(model, names, recordings):
    """All findings on these recordings under a model, worst first."""
    found = []
    for name, recording in zip(names, recordings, strict=True):
        found += time_findings(name, recording)
    if any(f.grave and f.id in ("units", "too_slow") for f in found):
        return worst_first(found)  # nothing that needs times can be told
    for name, recording in zip(names, recordings, strict=True):
        found += sample_findings(name, without_copy(recording))
    found += row_findings(names, recordings)
    if any(f.id == "repeated_rows" for f in found):
        return worst_first(found)  # nor what needs velocities
    for name, recording in zip(names, recordings, strict=True):
        found += angle_findings(model, name, recording)
        found += load_findings(model, name, recording)
    # beside a sensor at the output torque constant and friction may be anything: finding them is the diagnosis
    spoiled = any(f.grave or f.id == "clock" for f in found) or any("joint_load_Nm" in r.columns for r in recordings)
    unspiked = [without_spikes(recording) for recording in recordings]
    coarse = {f.column for f in found if f.id == "coarse"}
    for joint in range(len(model.joints) if not spoiled else 0):
        if coarse & {f"{model.joints[joint]}_{what}" for what in ("motor_rad", "rad")}:
            continue  # its speed and acceleration are noise
        try:
            found += joint_findings(model, names, unspiked, joint)
        except talus.TalusError:
            continue  # too little motion to fit anything: said elsewhere
    return worst_first(found)
