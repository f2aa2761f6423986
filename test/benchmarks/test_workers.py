"""A process that dies or hangs costs its own piece of work alone."""

import math
import os
import time

from benchmarks._workers import each


def failed(job, why):
    return f"{job}: {why}"


def test_each_job_is_done_once():
    assert sorted(each(math.sqrt, [1.0, 4.0, 9.0, 16.0, 25.0], 2, 60.0, failed)) == [1.0, 2.0, 3.0, 4.0, 5.0]


def test_a_process_that_dies_fails_its_own_job():
    # Nothing comes back of the first, so that the second one is left to a process in its place.
    assert list(each(os._exit, [3, 4], 1, 60.0, failed)) == [
        "3: the process ended with 3",
        "4: the process ended with 4",
    ]


def test_what_takes_too_long_is_given_up():
    assert list(each(time.sleep, [600.0], 1, 2.0, failed)) == ["600.0: there was no result after 2 s"]


def test_processes_have_one_core_and_leave_the_environment_as_it_was():
    before = dict(os.environ)
    (cores,) = each(os.sched_getaffinity, [0], 1, 60.0, failed)
    assert len(cores) == 1
    assert dict(os.environ) == before
