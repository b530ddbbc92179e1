"""A joint that effects are tried at: what its recordings show, and its columns."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..kinds import kind_of
from .candidate import Candidate
from .law import column

COULOMB_OF_A_LEG = (5, 7)  # among the base parameters
LEAST_HALF_RANGE_RAD = 0.05
TWIST_BELOW_RAD = math.pi  # half the range: beyond, a joint has turned, whatever its torque
LEFT_BY_TWIST = 0.2  # of the angle's variance, that a held joint's torque does not explain
TWIST_POWERS = 3
WITHIN = (0.02, 0.98)  # quantiles of an angle, beyond which are its extremes
LEAST_WAY = 0.05  # of the squared load, that must be driven, and as much that must drive


@dataclass(frozen=True)
class Place:
    """A joint that effects are tried at."""

    number: int
    name: str
    dataset: object
    extent: object
    all_terms: list

    @property
    def kinds(self):
        return self.dataset.kinds

    @property
    def coulomb_Nm(self):
        return max(abs(self.all_terms[0].coulomb_Nm[self.number]), 1e-12)

    @property
    def usual_coulomb_Nm(self):
        """Where an effect stands in for dry friction, little of that is left to the plain model: on a leg the given one, then."""
        given = abs(self.dataset.prior[COULOMB_OF_A_LEG[self.number]]) if self.dataset.at_motor else 0.0
        return max(self.coulomb_Nm, given)

    @property
    def sign(self):
        """With a sensor at the output, what a joint takes is missing from the reading."""
        return -1.0 if self.dataset.load_sensor else 1.0

    @property
    def gear(self):
        """Motor turns for one of the joint where torques and angles are the joint's; else 1."""
        return self.all_terms[0].gear

    @cached_property
    def motor_range(self):
        """Range of the motor's angle over all recordings but for its extremes [rad]; 0 where only its torque twists it."""
        if self.is_held:
            return 0.0
        ends = [np.quantile(terms.motor_rad[self.number][terms.processed.inside], WITHIN) for terms in self.all_terms]
        return abs(self.gear) * (max(high for _, high in ends) - min(low for low, _ in ends))

    @property
    def is_straight(self):
        """Does the joint move along a line, in m, and not about an axis?"""
        return self.dataset.model.coordinate_unit == "m"

    @property
    def has_rotor(self):
        """Has its motor a rotor of its own in the model? Else the joint's inertia holds it."""
        return self.all_terms[0].has_rotor(self.number)

    @property
    def load_is_free(self):
        """Do inertia and gravity take up any share of the load? A leg's are seen from both joints, and a sensor shows the load."""
        return not self.dataset.at_motor and not self.dataset.load_sensor

    @property
    def has_offset(self):
        """Is a constant torque among what is identified?"""
        return self.offset_Nm != 0.0

    @property
    def offset_Nm(self):
        """The constant torque that is identified."""
        return float(self.all_terms[0].instants(self.number)["offset_Nm"][0])

    @property
    def travels(self):
        """Does the joint turn far enough for position to be told from load?"""
        if self.is_straight:
            return True
        return self.extent.half_range[self.number] > LEAST_HALF_RANGE_RAD and not self.is_held

    @cached_property
    def carries_both_ways(self):
        """Does the drive both drive its load and hold it back? Where it only drives, friction that grows with the load is
        a share of the drive's torque, that a constant or a droop beside a sensor could be as well."""
        if not self.dataset.load_sensor:
            return True
        j, shares = self.number, np.zeros(2)
        for terms in self.all_terms:
            power = (terms.drive_Nm[j] * terms.slip[j])[terms.processed.inside]
            shares += [np.sum(power[power > 0] ** 2), np.sum(power[power < 0] ** 2)]
        return bool(shares.min() >= LEAST_WAY * shares.sum())

    @cached_property
    def is_held(self):
        """Is the output held, beside its torque sensor, so that its angle is the twist under the torque?"""
        j = self.number
        if not self.dataset.load_sensor or self.extent.half_range[j] > TWIST_BELOW_RAD:
            return False
        left = whole = 0.0
        for terms in self.all_terms:
            q, drive = terms.q[j][terms.processed.inside], terms.drive_Nm[j][terms.processed.inside]
            low, high = np.quantile(q, WITHIN)  # but for extremes: a shaft may be let go at the begin or the end
            kept = (q >= low) & (q <= high)
            q, drive = q[kept], drive[kept]
            powers = (drive / (np.abs(drive).max() + 1e-12))[:, None] ** np.arange(TWIST_POWERS + 1)
            twist = powers @ np.linalg.lstsq(powers, q, rcond=None)[0]
            left, whole = left + np.sum((q - twist) ** 2), whole + np.sum((q - q.mean()) ** 2)
        return left < LEFT_BY_TWIST * whole

    # ---- columns -------------------------------------------------------------------

    def of_law(self, effect, form, columns, shapes=None, *, saved=None, session=False, **more):
        """A candidate whose columns are those of an effect of the library. `columns` says of each what one of its strength
        stands for, as {parameter: amount}; `shapes` are the effect's, by name. What a model file then says follows from
        both, or from `saved`, other columns and shapes. `session`: time counts over all recordings; `more`: as in
        Candidate."""
        shapes = shapes or {}
        file_columns, file_shapes = saved or (columns, shapes)

        def entry(strengths):
            out = {p.name: 0.0 for p in kind_of(effect).strengths if p.default_value is None}
            for strength, amounts in zip(strengths, file_columns):
                for name, amount in amounts.items():
                    out[name] = out.get(name, 0.0) + float(strength) * amount
            return out | file_shapes

        made = tuple(column(effect, (self.number,), amounts, shapes, self.sign, session) for amounts in columns)
        return Candidate(effect, self.name, form, made, more.pop("parameters", entry), saved=entry, **more)

    def reading_column(self, function):
        """A column of the reading itself."""
        j = self.number
        return lambda terms: {f"T{j}": terms.processed.operate(function(terms), j)}
