"""tools/talus/diagnosis/effects/elasticity.py: springs behind the knee's gear, on a bench that shares no code with the library."""

import pytest
from hidden_effect import bench_with, diagnosed

from talus.blind import effects

pytestmark = [pytest.mark.long, pytest.mark.spread]
STIFFNESS_NM_RAD = 900.0
COMMON = {"stiffness": STIFFNESS_NM_RAD, "damping": 0.0012, "rotor_share": 0.35, "link_share": 0.0, "viscous_share": 0.0}
FORMS = {
    "linear": {"elastic_form": 1},
    "hardening": {"elastic_form": 2, "hardening": 1.2e7, "link_share": 0.4},
    "soft at first": {"elastic_form": 3, "soft_share": 0.35, "soft_zone": 0.003, "link_share": 0.3},
}
SHOWN = {"linear": {}, "hardening": {"hardening_Nm_rad3": 1.2e7}, "soft at first": {"soft_rad": 0.003, "soft_share": 0.35}}


@pytest.mark.parametrize("form", FORMS)
def test_a_soft_spring_behind_the_knees_gear_is_named_whatever_its_form(form, tmp_path):
    """Its link swings at some 20 Hz, unseen: of a wrong form the torque is out of phase."""
    bench = bench_with(tmp_path, "elasticity", "knee", effects.of("knee", **{**COMMON, **FORMS[form]}))
    spring = diagnosed(bench, "elasticity", "knee")
    hidden = {"compliance_rad_Nm": 1 / STIFFNESS_NM_RAD, **SHOWN[form]}
    assert spring == pytest.approx(hidden, rel=0.2)


def test_a_spring_of_a_light_link_is_named_though_it_is_much_softer_than_a_gear(tmp_path):
    """An ankle's foot swings at some 12 Hz on it."""
    soft = {"stiffness": 22.0, "damping": 6e-4, "elastic_form": 1, "link_share": 0.0, "viscous_share": 0.4}
    bench = bench_with(tmp_path, "elasticity", "ankle", effects.of("ankle", **soft))
    assert 1 / diagnosed(bench, "elasticity", "ankle")["compliance_rad_Nm"] == pytest.approx(22.0, rel=0.1)
