"""What was once lost without a word when interfaces were pulled and renamed, with the cure and without it in one run; what needs no interface
is in tests/test_acquire_cures.py, which says how this is judged."""

import time

import pytest
from recording import Recording, ip
from test_acquire_plugging import numbers_of, plug_in, send_some
from uncured import BOUND, OTHER_NOT_FOLLOWED, uncured

pytestmark = [pytest.mark.rig, pytest.mark.release]


@pytest.fixture(params=["cured", "uncured"])
def program_of(request, tmp_path):
    """(the program or None for the whole one, is it cured) for what would be taken out."""
    return lambda changes: (None, True) if request.param == "cured" else (uncured(tmp_path / "uncured", changes), False)


def assert_silent(recording, printed):
    assert "nothing lost" in printed and recording.end()["lost"] == 0


def test_pulled_out_and_plugged_in(vcan, tmp_path, program_of):
    path, cured = program_of(BOUND)
    (name,) = vcan()
    with Recording(tmp_path / "q", name, path=path) as recording:
        for k in range(3):
            send_some(name, 100 * k, 50)
            ip("del", name)
            plug_in(name)
            send_some(name, 100 * k + 50, 50)
            time.sleep(0.1)
        assert_silent(recording, recording.stop(status=0))
    assert len(numbers_of(recording)) == 300 if cured else len(numbers_of(recording)) <= 50


def test_another_takes_the_name(vcan, tmp_path, program_of):
    path, cured = program_of(OTHER_NOT_FOLLOWED)
    first, second = vcan(2)
    with Recording(tmp_path / "n", first, path=path) as recording:
        send_some(first, 0, 100)
        for before, now in ((first, "tlaway"), (second, first)):
            ip("set", before, "down")
            ip("set", before, "name", now)
            ip("set", now, "up")
        time.sleep(0.2)
        send_some(first, 100, 200)
        time.sleep(0.1)
        assert_silent(recording, recording.stop(status=0))
    ip("del", "tlaway")
    assert len(numbers_of(recording)) == (300 if cured else 100)
