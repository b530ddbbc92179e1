"""The trajectory that the rig's tests play, and its limits.

Nothing here needs a package with code for newer processors: the guest with GPIO has an old one.
"""

import math

LIMITS = "knee.position=-0.9:0.9,knee.speed=5,ankle.position=-0.5:0.5,ankle.speed=5"
PATIENT = ("--play-latest", 60)  # the guest's clock stands still while the machine is busy; that is not judged here


def write_trajectory(path, rows=5000, amplitude=0.3):
    """A sine of 1 Hz with both joints, 1 kHz."""
    lines = ["time_s,knee_rad,ankle_rad,knee_velocity_rad_s,ankle_velocity_rad_s"]
    for k in range(rows):
        phase = 2 * math.pi * k / 1000
        speed = 2 * math.pi * amplitude * math.cos(phase)
        lines.append(f"{5 + k / 1000:.3f},{amplitude * math.sin(phase):.9f},{amplitude / 2 * math.sin(phase):.9f},{speed:.9f},{speed / 2:.9f}")
    path.write_text("\n".join(lines) + "\n")
    return rows
