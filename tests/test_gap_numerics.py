"""tools/talus/diagnosis/numerics.py against SciPy."""

import numpy as np
import pytest
from scipy.interpolate import BarycentricInterpolator
from scipy.stats import chi2
from talus.diagnosis.numerics import interpolated, median_of_chi2


@pytest.mark.parametrize("freedom", [0.2, 0.79, 1.0, 2.5, 7.0, 40.0, 333.0])
def test_the_median_of_chi_square_is_scipys(freedom):
    assert median_of_chi2(freedom) == pytest.approx(chi2.median(freedom), rel=1e-10)


def test_between_instants_stands_the_polynomial_through_the_six_about_them():
    values = np.random.default_rng(0).standard_normal(40)
    for at, first in ((17.3, 15), (17.0, 15), (0.2, 0), (1.9, 0), (38.6, 34), (39.0, 34)):
        want = BarycentricInterpolator(np.arange(first, first + 6), values[first:first + 6])(at)
        assert interpolated(values, np.array([at]))[0] == pytest.approx(want, abs=1e-9)


def test_a_smooth_series_is_met_and_a_short_one_is_straight():
    at = np.linspace(0, 199, 997)
    assert interpolated(np.sin(0.2 * np.arange(200)), at) == pytest.approx(np.sin(0.2 * at), abs=2e-6)
    assert interpolated(np.array([1.0, 3.0]), np.array([0.25])) == pytest.approx(1.5)
