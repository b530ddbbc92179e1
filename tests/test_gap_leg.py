"""tools/talus/diagnosis/effects/base_compliance.py: a mount with two modes, on a bench that shares no code with the library."""

import math

import pytest
from hidden_effect import bench_with, diagnosed, leg_mass_kg

MOUNT_KG, SIDEWAYS_HZ, UP_HZ, DAMPING_RATIO = 5.0, 4.2, 6.4, 0.05


def spring(mass_kg, frequency_Hz):
    """(stiffness, damping) of what swings with that mass at that frequency."""
    w = 2 * math.pi * frequency_Hz
    return mass_kg * w * w, 2 * DAMPING_RATIO * w * mass_kg


@pytest.mark.long
def test_a_mount_that_sways_and_rises_is_found_with_both_resonances(tmp_path):
    """The spring carries the mount and the leg that hangs from it."""
    mass = MOUNT_KG + leg_mass_kg()
    (x_k, x_c), (z_k, z_c) = spring(mass, SIDEWAYS_HZ), spring(mass, UP_HZ)
    hidden = {"x_mass": MOUNT_KG, "x_k": x_k, "x_c": x_c, "z_mass": MOUNT_KG, "z_k": z_k, "z_c": z_c}
    mount = diagnosed(bench_with(tmp_path, "base_compliance", "base", hidden), "base_compliance", "base")
    assert mount["frequency_Hz"] == pytest.approx(SIDEWAYS_HZ, rel=0.05)
    assert mount["frequency_Hz_2"] == pytest.approx(UP_HZ, rel=0.05)
    assert mount["sway_m_N"] == pytest.approx(1 / x_k, rel=0.2) and mount["rise_m_N_2"] == pytest.approx(1 / z_k, rel=0.2)
