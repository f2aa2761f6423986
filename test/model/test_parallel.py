import threading

import pytest

from cdp_ident.model import parallel


@pytest.mark.parametrize("cores", [1, 2, 3, 8])
@pytest.mark.parametrize("count", [0, 1, 2, 7, 100])
def test_every_item_is_worked_on_once(monkeypatch, cores, count):
    monkeypatch.setattr(parallel, "core_count", lambda: cores)
    done, lock = [], threading.Lock()

    def work(first, last):
        with lock:
            done.extend(range(first, last))

    parallel.parallel_for(work, count)
    assert sorted(done) == list(range(count))


def test_parts_are_worked_on_at_the_same_time(monkeypatch):
    monkeypatch.setattr(parallel, "core_count", lambda: 2)
    both = threading.Barrier(2, timeout=30)
    parallel.parallel_for(lambda first, last: both.wait(), 2)


@pytest.mark.parametrize("broken", [0, 1])
def test_an_error_in_any_part_reaches_the_caller(monkeypatch, broken):
    monkeypatch.setattr(parallel, "core_count", lambda: 2)

    def work(first, last):
        if first == broken:
            raise ArithmeticError(f"part {first}")

    with pytest.raises(ArithmeticError, match=f"part {broken}"):
        parallel.parallel_for(work, 2)


def test_there_is_a_core():
    assert parallel.core_count() >= 1


@pytest.mark.parametrize("cores", [1, 2, 3])
def test_results_come_in_the_order_of_the_items(monkeypatch, cores):
    monkeypatch.setattr(parallel, "core_count", lambda: cores)
    assert list(parallel.parallel_map(lambda item: 2 * item, range(20))) == list(range(0, 40, 2))


def test_items_are_worked_on_at_the_same_time():
    if parallel.core_count() == 1:
        pytest.skip("this process may use one core only")
    both = threading.Barrier(2, timeout=30)
    list(parallel.parallel_map(lambda item: both.wait(), range(2)))


def test_what_works_on_one_of_several_items_has_one_core():
    several = min(parallel.core_count(), 2)
    assert list(parallel.parallel_map(lambda item: parallel.core_count(), range(2))) == [1, 1]
    assert list(parallel.parallel_map(lambda item: min(parallel.core_count(), 2), range(1))) == [several]


def test_an_error_is_raised_in_its_turn():
    def work(item):
        if item == 2:
            raise ArithmeticError(f"item {item}")
        return item

    results, done = parallel.parallel_map(work, range(4)), []
    with pytest.raises(ArithmeticError, match="item 2"):
        done.extend(iter(results))
    assert done == [0, 1]


def test_items_that_nobody_waits_for_are_given_up():
    begun, lock, go_on = [], threading.Lock(), threading.Event()

    def work(item):
        with lock:
            begun.append(item)
        if item:
            go_on.wait(30)

    results = parallel.parallel_map(work, range(100))
    next(results)
    results.close()
    go_on.set()
    list(parallel.parallel_map(lambda item: None, range(10)))  # what had begun has ended
    assert len(begun) < 50
