"""What makes a diagnosis worthless, found before any cause is looked for: `findings` of GAP.json.

    for finding in gate.findings(model, names, recordings):
        print(finding.id, finding.grave, finding.column, finding.evidence, finding.remedy)

    times.py      the time column        samples.py    each column by itself      rows.py   rows that stand twice
    angles.py     columns that tell one angle              machine.py   columns against the model's machine
    excerpt.py    what of long recordings is looked at
"""

import talus

from .angles import angle_findings
from .finding import Finding, worst_first
from .machine import Read, joint_findings
from .rows import row_findings
from .samples import sample_findings
from .times import time_findings

__all__ = ["Finding", "findings"]


def findings(model, names, recordings):
    """All findings on these recordings under a model, worst first."""
    found = []
    for name, recording in zip(names, recordings, strict=True):
        found += time_findings(name, recording)
        found += sample_findings(name, recording)
    found += row_findings(names, recordings)
    if any(f.grave and f.id in ("units", "clock", "too_slow") for f in found):
        return worst_first(found)  # nothing that needs velocities can be told
    for name, recording in zip(names, recordings, strict=True):
        found += angle_findings(model, name, recording)
    # beside a sensor at the output torque constant and friction may be anything: finding them is the diagnosis
    spoiled = any(f.grave for f in found) or any("joint_load_Nm" in r.columns for r in recordings)
    return worst_first([*found, *([] if spoiled else _machine_findings(model, names, recordings))])


def _machine_findings(model, names, recordings):
    """Findings of the joints' columns under the model."""
    try:
        read = Read(model, recordings)
        return [one for joint in range(len(model.joints)) for one in joint_findings(model, names, recordings, read, joint)]
    except talus.TalusError:
        return []  # too little motion to fit anything: said elsewhere
