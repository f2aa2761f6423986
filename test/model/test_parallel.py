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
