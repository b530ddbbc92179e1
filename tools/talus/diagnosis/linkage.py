"""An ankle's transmission over whole arrays: motor angle, ratio, and the joint angle back from the motor's."""

import numpy as np

NEWTON_STEPS = 12  # the linkage is nearly linear: 12 steps end at rounding


class ScrewLinkage:
    """Screw and four-bar linkage, (1) to (6); `dimensions` can be changed to see what an error does."""

    names = ("lead_m", "AB_m", "BO_m", "AC_m", "BOF_rad")

    def __init__(self, dimensions):
        self.dimensions = np.asarray(dimensions, float)

    @classmethod
    def from_tree(cls, tree):
        return cls([tree["lead_m"], tree["AB_m"], tree["BO_m"], tree["AC_m"], np.deg2rad(tree["BOF_deg"])])

    def changed(self, name, step):
        """The same linkage with one dimension longer by `step`."""
        other = self.dimensions.copy()
        other[self.names.index(name)] += step
        return ScrewLinkage(other)

    def motor_rad(self, joint_rad):
        lead, AB, BO, AC, BOF = self.dimensions

        def slide_m(phi):
            return BO * np.cos(phi) + np.sqrt(AB**2 - (AC - BO * np.sin(phi)) ** 2)

        return 2 * np.pi / lead * (slide_m(np.pi - BOF - joint_rad) - slide_m(np.pi - BOF))

    def ratio(self, joint_rad):
        lead, AB, BO, AC, BOF = self.dimensions
        phi = np.pi - BOF - joint_rad
        rest = AC - BO * np.sin(phi)
        return 2 * np.pi / lead * (BO * np.sin(phi) - rest * BO * np.cos(phi) / np.sqrt(AB**2 - rest**2))

    def joint_rad(self, motor_rad, start=None):
        return invert(self, motor_rad, start)


class FourierTransmission:
    """Motor angle as a series of the joint angle, (10)."""

    def __init__(self, omega, a, b):
        self.omega, self.a, self.b = omega, np.asarray(a, float), np.asarray(b, float)

    def _waves(self, joint_rad):
        order = np.arange(1, len(self.b) + 1)[:, None] * self.omega
        return order, np.cos(order * joint_rad), np.sin(order * joint_rad)

    def motor_rad(self, joint_rad):
        _, cosine, sine = self._waves(joint_rad)
        return self.a[0] + self.a[1:] @ cosine + self.b @ sine

    def ratio(self, joint_rad):
        order, cosine, sine = self._waves(joint_rad)
        return -(self.a[1:] * order[:, 0]) @ sine + (self.b * order[:, 0]) @ cosine

    def joint_rad(self, motor_rad, start=None):
        return invert(self, motor_rad, start)


class FixedRatio:
    """A gear: motor angle = ratio x joint angle."""

    def __init__(self, ratio):
        self.value = float(ratio)

    def motor_rad(self, joint_rad):
        return self.value * joint_rad

    def ratio(self, joint_rad):
        return np.full(np.shape(joint_rad), self.value)

    def joint_rad(self, motor_rad, start=None):
        return motor_rad / self.value


def invert(transmission, motor_rad, start=None):
    """Joint angle of a motor angle, by Newton's method from `start`."""
    joint_rad = np.zeros_like(motor_rad) if start is None else start.copy()
    for _ in range(NEWTON_STEPS if start is None else 4):
        joint_rad = joint_rad - (transmission.motor_rad(joint_rad) - motor_rad) / transmission.ratio(joint_rad)
    return joint_rad


def transmission(tree):
    """The transmission of a model file's mapping."""
    if tree["type"] == "fixed":
        return FixedRatio(tree["ratio"])
    if tree["type"] == "fourier":
        return FourierTransmission(tree["omega"], tree["a"], tree["b"])
    return ScrewLinkage.from_tree(tree)
