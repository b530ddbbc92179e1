"""What is in no catalogue, tried beside it. Else the entry that comes nearest takes such a gap up, and is named: a hose is no spring,
yet most of it is a spring's. Where one of these explains a gap best the verdict is `unknown`, and the report says what the gap looks
like. They are written down roughly, for nothing is predicted with them: they need only be nearer to their kind than the catalogue is.

A file of laws is one subject and defines ENTRIES.
"""

from . import changed_load, drive, held_reading, hysteresis, other_joint, vibration

OUTSIDE = {entry.id: entry for file in (hysteresis, changed_load, drive, held_reading, vibration, other_joint) for entry in file.ENTRIES}

__all__ = ["OUTSIDE"]
