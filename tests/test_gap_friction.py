"""tools/talus/diagnosis/effects/presliding.py, on a bench that shares no code with the library."""

from hidden_effect import bench_with, diagnosed

from talus.blind import effects

TRAVEL_RAD = 0.02


def test_presliding_that_is_most_of_the_friction_is_named(tmp_path):
    """An ankle that hardly ever slides leaves the plain model next to no Coulomb friction to tell the effect's size by.
    Iwan's friction, of which the library knows Dahl's: all of it like a spring over 20 mrad."""
    shape = {"pre_form": 3.0, "pre_share": 1.0, "pre_travel": TRAVEL_RAD, "pre_power": 0.5, "pre_rise": 0.0077, "pre_speed": 0.18}
    found = diagnosed(bench_with(tmp_path, "presliding", "ankle", effects.of("ankle", **shape)), "presliding", "ankle")
    assert TRAVEL_RAD / 2 < found["travel_rad"] < 2 * TRAVEL_RAD  # another form's: the same size
