"""What each effect alone would take away of the gap, and what it takes away of replicates that have none."""

import math

from .calibration.gains import gains_beside

MOST = 6


def nearest(search):
    """The (effect, joint) that gain most, each by its best shape of the grid: `gain` in chi-square, `replicates` the median of the
    same there (None without any), `closes` the share of the plain model's excess."""
    calibration = search.calibration
    own = calibration.own if calibration else gains_beside(search, [])
    ranked = sorted(((gain, key) for key, gain in own.items() if gain > 0 and not search.is_outside(key)), reverse=True)[:MOST]
    return [{"effect": effect, "joint": joint, "gain": gain,
             "replicates": replicates_gain(calibration, (effect, joint)) if calibration else None,
             "closes": min(gain / search.plain.excess, 1.0) if search.plain.excess > 0 else 0.0}
            for gain, (effect, joint) in ranked]  # fmt: skip


def replicates_gain(calibration, key):
    """The middle of what an (effect, joint) gains in replicates, on the scale of Calibration.width: never below nothing."""
    gains = [max(gains.get(key, 0.0), 0.0) for gains in calibration.gains]
    return calibration.chance * math.expm1(sum(math.log1p(gain / calibration.chance) for gain in gains) / len(gains))
