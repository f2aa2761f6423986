# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest

from cdp_ident.machine import parallel


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


@pytest.mark.parametrize("broken", [0, 1])
def test_an_error_in_any_part_reaches_the_caller(monkeypatch, broken):
    monkeypatch.setattr(parallel, "core_count", lambda: 2)

    def work(first, last):
        if first == broken:
            raise ArithmeticError(f"part {first}")

    with pytest.raises(ArithmeticError, match=f"part {broken}"):
        parallel.parallel_for(work, 2)


@pytest.mark.parametrize("cores", [1, 2, 3])
def test_results_come_in_the_order_of_the_items(monkeypatch, cores):
    monkeypatch.setattr(parallel, "core_count", lambda: cores)
    assert list(parallel.parallel_map(lambda item: 2 * item, range(20))) == list(range(0, 40, 2))


def test_parts_and_items_are_worked_on_at_the_same_time():
    if parallel.core_count() == 1:
        pytest.skip("this process may use one core only")
    both = threading.Barrier(2, timeout=30)
    parallel.parallel_for(lambda first, last: both.wait(), 2)
    list(parallel.parallel_map(lambda item: both.wait(), range(2)))


@pytest.mark.parametrize("cores", [2, 3])
def test_what_works_on_one_of_several_items_may_share_it_out_again(monkeypatch, cores):
    monkeypatch.setattr(parallel, "core_count", lambda: cores)

    def sums(item):
        return sum(parallel.parallel_map(lambda part: item * sum(parallel.parallel_map(abs, range(part))), range(9)))

    expected = [item * sum(sum(range(part)) for part in range(9)) for item in range(20)]
    assert list(parallel.parallel_map(sums, range(20))) == expected


def test_a_core_that_has_no_item_left_takes_part_in_the_work_on_another():
    if parallel.core_count() == 1:
        pytest.skip("this process may use one core only")
    both = threading.Barrier(2, timeout=30)

    def work(item):
        if item == 1:
            parallel.parallel_for(lambda first, last: both.wait(), 2)

    list(parallel.parallel_map(work, range(2)))


def test_items_that_nobody_asks_for_are_given_up(monkeypatch):
    monkeypatch.setattr(parallel, "core_count", lambda: 2)
    begun, go_on = [], threading.Event()
    with ThreadPoolExecutor(max_workers=1) as pool:
        monkeypatch.setattr(parallel, "_pool", lambda: pool)
        results = parallel.parallel_map(
            lambda item: (begun.append(item), item == 0 or go_on.wait(timeout=30)), range(5)
        )
        next(results)
        results.close()
        go_on.set()
    assert begun in ([0], [0, 1])


@pytest.mark.parametrize("cores", [1, 2])
def test_what_a_call_raises_is_raised_in_its_turn(monkeypatch, cores):
    monkeypatch.setattr(parallel, "core_count", lambda: cores)
    results = parallel.parallel_map(lambda item: 1 // item, [1, 1, 0])
    assert [next(results), next(results)] == [1, 1]
    with pytest.raises(ZeroDivisionError):
        next(results)
