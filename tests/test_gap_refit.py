"""tools/talus/diagnosis/machine/physical.py and refit.py: physical parameters and effects fitted together."""

import numpy as np
import pytest
import talus
import yaml
from talus.diagnosis.catalogue.candidate import Family
from talus.diagnosis.machine.physical import constrained, physical
from support import REPOSITORY


def leg():
    return talus.Model.from_tree(yaml.safe_load((REPOSITORY / "models/leg.yaml").read_text()))


def base_of(model, **changes):
    other = model.copy()
    other.set_parameters(**changes)
    return np.array(list(other.base.values()))


NO_LIMITS = np.zeros(0), np.zeros(0)


def test_parameters_of_base_parameters_predict_the_same():
    model = leg()
    base = base_of(model, shank_com_m=0.18, foot_inertia_kg_m2=0.003, knee_coulomb_Nm=0.4)
    assert base_of(model, **physical(model, base)) == pytest.approx(base, rel=1e-6)


@pytest.mark.parametrize("moment", [0.01, 0.3, 20.0])
def test_gravity_is_found_whichever_way_the_model_file_has_it(moment):
    """Across it there is no straight way: on 360 directions of a pendulum that hangs at 0 in its file, by atan2."""
    model = talus.Model.from_tree(yaml.safe_load((REPOSITORY / "models/pendulum.yaml").read_text()))
    for zero in np.radians(np.arange(-180.0, 180.0)):
        base = base_of(model, gravity_moment_kg_m=moment, gravity_zero_rad=zero)
        found = physical(model, base)
        size, angle = found["gravity_moment_kg_m"], found["gravity_zero_rad"]
        assert size * np.exp(1j * angle) == pytest.approx(moment * np.exp(1j * zero), rel=1e-5)


def test_a_physical_optimum_is_met():
    model = leg()
    best = base_of(model, shank_com_m=0.18, foot_inertia_kg_m2=0.003, knee_coulomb_Nm=0.4)
    values, others, lost = constrained(model, np.diag(1e4 / np.abs(best)), best, *NO_LIMITS)
    assert base_of(model, **values) == pytest.approx(best, rel=1e-6) and lost < 1e-3 and len(others) == 0


def test_what_is_not_physical_ends_at_its_bound_and_the_rest_follows():
    """Viscous friction and an effect's strength stand for each other but for a little: the strength takes over."""
    model, names = leg(), list(leg().base)
    best, k = np.append(base_of(model), 0.1), names.index("knee_viscous")
    best[k] = -0.2
    root = np.diag(np.append(1e4 / np.abs(best[:-1]), 1.0))
    root[k, k], root[k, -1], root[-1, -1] = 1e3, 1e3, 1.0
    values, others, lost = constrained(model, root, best, np.array([-np.inf]), np.array([np.inf]))
    assert 0 <= values["knee_viscous_Nms_rad"] < 1e-3
    assert others[0] == pytest.approx(-0.1, abs=2e-3)  # by the sum, which the data know well
    assert lost == pytest.approx(0.2**2, rel=0.05)


def test_limits_of_strengths_hold():
    model = leg()
    best = np.append(base_of(model), 0.9)
    root = np.diag(np.append(1e4 / np.abs(best[:-1]), 100.0))
    _, others, lost = constrained(model, root, best, np.array([0.0]), np.array([0.6]))
    assert others[0] == pytest.approx(0.6, abs=1e-6) and lost == pytest.approx(30.0**2, rel=1e-3)


def test_shapes_move_by_factors_or_differences_within_their_limits():
    family = Family(lambda *values: values, (4.0, 0.3), (2.0, 0.5), (1.0, 0.0), (10.0, 1.0))
    assert family.beside(0, 1.0, 1) == (8.0, 0.3) and family.beside(0, 0.5, -1) == pytest.approx((2.0 * 2**0.5, 0.3))
    assert family.beside(1, 0.2, -1) == pytest.approx((4.0, 0.2))
    assert family.beside(1, 1.0, -1) is None and family.beside(0, 2.0, 1) is None
