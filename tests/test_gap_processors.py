"""Work on both processors: results stand in their items' order, and nothing is lost."""

import multiprocessing
import threading
from concurrent.futures import ProcessPoolExecutor

import pytest
from talus.diagnosis import processors

WAIT_S = 20.0


def test_results_stand_in_the_items_order_whichever_is_ready_first():
    second_done = threading.Event()

    def work(item):
        if item == 0:
            assert second_done.wait(WAIT_S)
        second_done.set()
        return item**2

    assert processors.each(work, range(9)) == [item**2 for item in range(9)]
    assert processors.each(work, ()) == [] and processors.each(work, [3]) == [9]


def test_as_many_work_at_once_as_there_are_processors(monkeypatch):
    for count in (1, 2, 4):
        monkeypatch.setattr(processors, "COUNT", count)
        together = threading.Barrier(count)
        processors.each(lambda item, all_here=together: all_here.wait(WAIT_S), range(3 * count))  # breaks unless so many wait at once
    assert processors.are_free()


@pytest.mark.parametrize("faulty", range(4))
def test_what_one_raises_is_raised(faulty):
    done = []

    def work(item):
        if item == faulty:
            raise ValueError(f"item {item}")
        done.append(item)

    with pytest.raises(ValueError, match=f"^item {faulty}$"):
        processors.each(work, range(4))
    assert faulty not in done


def are_free_here(_):
    return processors.are_free()


def test_a_process_of_several_works_alone():
    with ProcessPoolExecutor(2, multiprocessing.get_context("fork")) as pool:
        assert list(pool.map(are_free_here, range(4))) == [False] * 4
