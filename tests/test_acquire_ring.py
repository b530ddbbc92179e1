"""The ring between a source and the writer: every execution of a small one under C's memory model (tests/ring_model.c says how), and
that the model finds each fault that is put into ring.c."""

import re
import subprocess

import pytest
from support import REPOSITORY

pytestmark = pytest.mark.release  # compiled here, not from the build

RING = REPOSITORY / "apps/acquire/source/ring.c"
SOURCE = RING.read_text(encoding="utf-8")
ORDERS = [m.start() for m in re.finditer("__ATOMIC_(ACQUIRE|RELEASE)", SOURCE)]
BEFORE_2_32 = 2**32 - 2  # both counters pass 2^32 on the way

FILL = "  ring->item[ring->head & (ring->size - 1)] = *item;\n"
PUBLISH = "  __atomic_store_n(&ring->head, ring->head + 1, __ATOMIC_RELEASE);\n"
FAULTS = {
    "published before it is filled": (FILL + PUBLISH, PUBLISH + FILL.replace("ring->head", "(ring->head - 1)")),
    "filled by half": (FILL, FILL.replace("= *item", ".real_ns = item->real_ns")),
    "never full": ("if (ring_room(ring) == 0) return 0;", ""),
    "full too early": ("ring_room(ring) == 0", "ring_room(ring) <= 1"),
    "pushed twice": ("ring->head + 1", "ring->head + 2"),
    "dropped twice": ("ring->tail + n", "ring->tail + n + 1"),
    "never dropped": ("ring->tail + n", "ring->tail + 0"),
    "the one behind the oldest": ("ring->tail + i", "ring->tail + i + 1"),
    "tail without an atomic": ("__atomic_load_n(&ring->tail, __ATOMIC_ACQUIRE)", "ring->tail"),
    "head without an atomic": ("__atomic_load_n(&ring->head, __ATOMIC_ACQUIRE)", "ring->head"),
}  # fmt: skip


def weakened(at):
    """ring.c with the order that stands at this place made relaxed."""
    return SOURCE[:at] + re.sub("__ATOMIC_[A-Z]+", "__ATOMIC_RELAXED", SOURCE[at:], count=1)


def faulty(name):
    right, wrong = FAULTS[name]
    assert SOURCE.count(right) == 1, f"ring.c no longer has {right!r}"
    return SOURCE.replace(right, wrong)


def compile_c(*arguments):
    subprocess.run(["gcc", "-std=gnu11", "-O1", f"-I{REPOSITORY}/apps", f"-I{RING.parent}", *map(str, arguments)], check=True)


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A function (text of ring.c) -> function (attempts, polls, at once, first) -> (status, what it printed)."""
    folder = tmp_path_factory.mktemp("ring")
    compile_c("-Wall", "-Wextra", "-c", "-o", folder / "model.o", REPOSITORY / "tests/ring_model.c")

    def build(text):
        source, program = folder / "ring.c", folder / "model"
        source.write_text(text, encoding="utf-8")
        compile_c("-fsanitize=thread", "-c", "-o", folder / "ring.o", source)
        compile_c("-o", program, folder / "model.o", folder / "ring.o")  # without the sanitizer: the model answers for it

        def run(*numbers):
            done = subprocess.run([program, *map(str, numbers)], check=False, capture_output=True, text=True, timeout=120)
            return done.returncode, done.stdout

        return run

    return build


def figures(printed):
    """[states, ends, ends with refusals, loads of old values]"""
    return [int(n) for n in re.findall(r" (\d+)", printed)]


def test_every_execution(model):
    """Four pushes into two places and five looks; the writer takes one at a time, or all there are."""
    run = model(SOURCE)
    for numbers in ((4, 5, 1, 0), (4, 5, 2, BEFORE_2_32)):
        status, printed = run(*numbers)
        print(f"ring_model {numbers}: {printed}", end="")
        assert status == 0, printed
        states, ends, refusals, old = figures(printed)
        assert states > 10_000 and 0 < refusals < ends and old > 0


@pytest.mark.parametrize("at", ORDERS)
def test_no_order_can_be_weaker(model, at):
    status, printed = model(weakened(at))(4, 4, 2, 0)
    assert status == 1 and printed.startswith("violation: "), printed
    assert "data race in an item" in printed or "before the watermark" in printed


def test_every_atomic_has_an_order_that_is_tried():
    assert len(ORDERS) == SOURCE.count("__atomic_") == 6


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_found(model, name):
    status, printed = model(faulty(name))(4, 4, 2, BEFORE_2_32)
    assert status == 1 and printed.startswith("violation: "), printed


def test_a_comparison_instead_of_a_difference_is_wrong_at_2_32_only(model):
    right = "return __atomic_load_n(&ring->head, __ATOMIC_ACQUIRE) - ring->tail;"
    wrong = right.replace("return", "const uint32_t head =").replace(" - ring->tail", "") + " return head > ring->tail ? head - ring->tail : 0;"
    assert SOURCE.count(right) == 1
    run = model(SOURCE.replace(right, wrong))
    assert run(3, 3, 2, 0)[0] == 0
    assert run(3, 3, 2, BEFORE_2_32)[0] == 1


# ---- is every execution among them? The same threads once more, as plain steps, and all their states counted ----


def producer(found, attempts):
    """What follows these loads: its heads and marks so far as (head, tail known), and whether it looks, stores, or has ended."""
    steps, accepted = [], 0
    for look in range(attempts):
        if look == len(found):
            return steps, "load"
        steps.append(("load", found[look]))
        if accepted - found[look] < 2:
            accepted += 1
            steps += [("head", accepted), ("mark", accepted)]
    return steps, "end"


def consumer(found, polls):
    """The same for one that takes what there is; its loads are by turns of a mark and of a head."""
    steps, taken = [], 0
    for look in range(2 * polls):
        if look == len(found):
            return steps, "mark" if look % 2 == 0 else "load"
        steps.append(("load", found[look]))
        if look % 2 and found[look] > taken:
            taken = found[look]
            steps.append(("tail", taken))
    return steps, "end"


def after(state, attempts, polls):
    """All states one step behind this one: (producer's steps done, tails found, consumer's steps done, marks and heads found)."""
    done, tails, taken, finds = state
    mine, next_mine = producer(tails, attempts)
    other, next_other = consumer(finds, polls)
    put = {kind: [0] + [v for k, v in mine[:done] if k == kind] for kind in ("head", "mark")}
    out = [0] + [v for k, v in other[:taken] if k == "tail"]
    if done < len(mine):
        yield done + 1, tails, taken, finds
    elif next_mine == "load":  # any tail that is not older than the one found before
        for tail in (t for t in out if t >= max(tails, default=0)):
            yield done + 1, (*tails, tail), taken, finds
    if taken < len(other):
        yield done, tails, taken + 1, finds
    elif next_other != "end":
        kind = "mark" if next_other == "mark" else "head"
        least = max(finds, default=0) if kind == "head" else max(finds[::2], default=0)
        # an acquired mark carries the head before it; an acquired head carries the marks before the one of its own
        least = max(least, *(h - 1 for h in finds[1::2]), 0) if kind == "mark" and finds else least
        for value in (v for v in put[kind] if v >= least):
            yield done, tails, taken + 1, (*finds, value)


def all_states(attempts, polls):
    states, waiting = set(), [(0, (), 0, ())]
    while waiting:
        state = waiting.pop()
        if state not in states:
            states.add(state)
            waiting += after(state, attempts, polls)
    return states


@pytest.mark.parametrize(("attempts", "polls"), [(1, 1), (2, 2), (3, 3), (4, 3)])
def test_the_model_sees_all_states(model, attempts, polls):
    status, printed = model(SOURCE)(attempts, polls, 2, 0)
    assert status == 0 and figures(printed)[0] == len(all_states(attempts, polls))
