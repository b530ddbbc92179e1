"""How the recorder reads its clocks on a machine whose calls last as long as it likes: the real clocks.c over clocks that are made here."""

import ctypes
import subprocess

import pytest
from support import REPOSITORY

pytestmark = pytest.mark.release  # compiled here, not from the build

FAKE = """
#include <time.h>
#include "acquire/host/clocks.h"
static long long now_ns, calls;
static long long (*lasts)(long long);
int clock_gettime(clockid_t clock, struct timespec *t) {
  const long long read_ns = now_ns + (clock == CLOCK_REALTIME ? 5000000000 : 0);
  now_ns += lasts(calls++);
  *t = (struct timespec){read_ns / 1000000000, read_ns % 1000000000};
  return 0;
}
long long read_one(long long (*each_lasts)(long long), long long answer[5]) {
  lasts = each_lasts, calls = 0, now_ns = 1000000000;
  const struct clock_triple best = clock_read_triple();
  answer[0] = best.mono_ns, answer[1] = best.real_ns, answer[2] = best.width_ns, answer[3] = now_ns - 1000000000, answer[4] = calls;
  return 0;
}
"""
LASTS = ctypes.CFUNCTYPE(ctypes.c_longlong, ctypes.c_longlong)


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clocks")
    (folder / "fake.c").write_text(FAKE)
    subprocess.run(["gcc", "-std=gnu11", "-shared", "-fPIC", "-Dclock_gettime=clock_made_here", f"-I{REPOSITORY}/apps", "-o", folder / "clocks.so", folder / "fake.c",
                    REPOSITORY / "apps/acquire/host/clocks.c"], check=True)  # fmt: skip
    call = ctypes.CDLL(str(folder / "clocks.so")).read_one

    def ask(lasts):
        """(how far the offset is off, width, how long it took [ns], calls)."""
        answer = (ctypes.c_longlong * 5)()
        call(LASTS(lasts), answer)
        mono, real, width, took, calls = answer
        return abs(real - mono - 5 * 10**9), width, took, calls

    return ask


def test_quick_calls_are_read_five_times(read):
    off, width, took, calls = read(lambda k: 40)
    assert off <= width / 2 and width <= 200 and took < 2_000 and calls < 25


def test_a_call_that_was_held_up_is_not_the_one_that_counts(read):
    """Ten tries in a row are held up by 50 us each, as by another process."""
    off, width, took, _ = read(lambda k: 50_000 if k % 4 == 1 and k < 40 else 300)
    assert off <= width / 2 and width <= 20_000 and 500_000 < took < 1_000_000


def test_where_every_call_is_slow_it_gives_up_after_a_millisecond(read):
    """It says how wide the best was."""
    off, width, took, _ = read(lambda k: 30_000 + 1000 * (k % 7))
    assert 90_000 <= width < 100_000 and off <= width / 2 and 1_000_000 <= took < 1_300_000
