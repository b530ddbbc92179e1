"""tools/talus/diagnosis/machine/pushes_back.py: a spring that pushes away is none."""

import numpy as np
import pytest
from support import REPOSITORY

import talus
from talus.diagnosis import kinds
from talus.diagnosis.calibration import thresholds
from talus.diagnosis.effects import EFFECTS

pytestmark = pytest.mark.spread

ROTOR = (REPOSITORY / "models/pendulum.yaml").read_text().replace("gravity_moment_kg_m: 0.15", "gravity_moment_kg_m: 0")


def test_stiffness_is_the_slope_of_the_law():
    """The torque of the report's parameters, by differences."""
    p, q = {"stiffness_Nm_rad": 1.5, "bend_Nm_rad2": -0.7, "stiffening_Nm_rad3": 2.0}, np.linspace(-1.0, 1.0, 9)
    torque = lambda q: p["stiffness_Nm_rad"] * q + p["bend_Nm_rad2"] * q**2 + p["stiffening_Nm_rad3"] * q**3
    assert set(p) < {one.name for one in kinds.kind_of("parallel_spring").parameters}
    assert EFFECTS["parallel_spring"].stiffness(p, q) == pytest.approx((torque(q + 1e-4) - torque(q - 1e-4)) / 2e-4, rel=1e-6)


@pytest.mark.parametrize(("line", "cube", "may"), [
    *(pytest.param(*one, True, marks=pytest.mark.long) for one in ((2.0, 1.0), (-1.0, 6.0))), (-3.0, 1.0, False)])
def test_what_pushes_away_over_most_of_the_motion_is_not_sure_to_be_a_spring(line, cube, may):
    """A rotor without gravity, which a spring could be taken for. The second does so in the middle alone: to 0.24 of 0.8 rad."""
    recording = talus.simulate(talus.Model.from_text(ROTOR), duration_s=40, rate_hz=250, encoder_bits=18)
    columns, drive = dict(recording.columns), 9 * 0.091
    q = columns["joint_rad"]
    columns["joint_current_A"] = columns["joint_current_A"] + (line * q + cube * q**3) / drive
    found = talus.diagnose(talus.Model.from_text(ROTOR), talus.Recording(columns))
    spring = [one["probability"] for one in found.effects if one["effect"] == "parallel_spring"]
    assert (spring[0] > 0.9) is may and (may or found.verdict["probability"] <= thresholds.NEARLY_HALF)


def test_a_spring_does_not_push_away_because_the_file_says_gravity_that_is_not_there():
    """The same rotor, with a file that gives it the gravity of 0.5 kg m: beside that the spring would have to hold it up. Gravity and a
    spring of any form hide each other, so that neither is known."""
    recording = talus.simulate(talus.Model.from_text(ROTOR), duration_s=40, rate_hz=250, encoder_bits=18)
    columns = dict(recording.columns)
    columns["joint_current_A"] = columns["joint_current_A"] + 2.0 * columns["joint_rad"] / (9 * 0.091)
    found = talus.diagnose(talus.Model.from_text(ROTOR.replace("gravity_moment_kg_m: 0", "gravity_moment_kg_m: 0.5")), talus.Recording(columns))
    spring = next(one for one in found.effects if one["effect"] == "parallel_spring")
    assert spring["probability"] > 0.9 and not spring["doubts"]
    low, high = spring["interval"]["stiffness_Nm_rad"]
    assert low < 2.0 < high
