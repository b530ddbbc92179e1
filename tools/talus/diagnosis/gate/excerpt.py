"""What of long recordings is looked at: stretches of them, evenly spread, at their full rate.

Columns, replicates and the gate cost time and memory in step with the samples, and what an hour tells of a machine its tenth
part tells nearly as well. So that both stay the same however long the recordings are, no more than MOST_SAMPLES are taken.
Every stretch is a recording of its own, that knows its place in the file; the sensors, the rate and the motion between its
ends are as they were recorded.
"""

from contextlib import ExitStack
from pathlib import Path

from talus.recording import Recording, RecordingFile

from .finding import Finding

MOST_SAMPLES = 120_000  # of all joints, over all recordings
STRETCH_S = 30.0  # about so long: three periods of most test motions
MOST_STRETCHES = 6  # of a file: longer ones take their place, because each costs something by itself
FEWEST_ROWS = 2


def read(paths, model):
    """([name of each], [Recording], [Finding]) of recordings by the programs' own reader; InputError says what is wrong."""
    with ExitStack() as opened:
        files = [opened.enter_context(RecordingFile(path, model)) for path in paths]
        share = MOST_SAMPLES / (len(model.joints) * sum(file.rows for file in files))
        names, recordings, findings = [], [], []
        for file in files:
            if share >= 1:
                names.append(file.path)
                recordings.append(Recording(file.columns()))
                continue
            own = _stretches_of(file, share)
            names += [f"{file.path}, {r.t[0]:.0f} to {r.t[-1]:.0f} s" for r in own]
            recordings += own
            findings.append(_finding(file, own))
    return names, recordings, findings


def stretches(rows, share, rows_each):
    """[(first row, rows)] of a file of which a share is looked at: stretches of about so many rows, each in the middle of its
    part of the file.

    >>> stretches(1000, 0.2, 100)
    [(200, 100), (700, 100)]
    """
    kept = min(rows, max(FEWEST_ROWS, int(share * rows)))
    count = min(MOST_STRETCHES, max(1, round(kept / rows_each)))
    each = kept // count
    return [(int((k + 0.5) * rows / count) - each // 2, each) for k in range(count)]


def _stretches_of(file, share):
    """Recordings of a file's stretches."""
    origin, out = file.origin(), []
    for first, rows in stretches(file.rows, share, STRETCH_S * file.rows / max(origin.length_s, 1e-9)):
        out.append(Recording(file.columns(first, rows)))
        out[-1].origin = origin
    return out


def _finding(file, own):
    """What the report says of a file of which not all was looked at."""
    origin = own[0].origin
    used_s, several = sum(r.t[-1] - r.t[0] for r in own), "s, evenly spread" if len(own) > 1 else ""
    return Finding("excerpt", False, "", f"{Path(file.path).name}: {used_s:.0f} of {origin.length_s:.0f} s are looked at, at the full "
                   f"rate, in {len(own)} stretch{'e' if several else ''}{several}",
                   "where something happens once, give that part as a recording of its own")  # fmt: skip
