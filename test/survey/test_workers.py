# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A process that dies or hangs costs its own piece of work alone."""

import math
import os
import time

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.survey.workers import WorkerDiedError, cluster, each, processes
from scenarios.work import cores_and_threads, root_or_death


def failed(job, why):
    return f"{job}: {why}"


@pytest.mark.parametrize(
    ("work", "jobs", "limit", "done"),
    [
        (math.sqrt, [1.0, 4.0, 9.0, 16.0], None, [1.0, 2.0, 3.0, 4.0]),
        (os._exit, [3, 4], None, ["3: the process ended with 3", "4: the process ended with 4"]),
        (time.sleep, [600.0], 2.0, ["600.0: there was no result after 2 s"]),
        (cores_and_threads, [0], None, [(1, "1")]),
    ],
    ids=["each job is done once", "one that dies twice fails alone", "too long is given up", "one core, one thread"],
)
def test_jobs_are_done_in_processes(work, jobs, limit, done):
    with processes(2, limit) as executor:
        assert sorted(each(executor, work, jobs, failed)) == done


def test_a_job_whose_process_was_killed_is_tried_again(tmp_path):
    with processes(2) as executor:
        done = list(each(executor, root_or_death, [(n, tmp_path / "died") for n in (0, 1, 4, 9)], failed))
    assert sorted(done) == [0.0, 1.0, 2.0, 3.0]
    assert done[-1] == 0.0  # when nothing else was left


def test_what_the_work_raises_comes_back():
    with processes(1) as executor, pytest.raises(ValueError, match="math domain"):
        executor.submit(math.sqrt, -1.0).result()


def test_what_runs_is_given_up_when_the_processes_are_left():
    with processes(1) as executor:
        future = executor.submit(time.sleep, 600.0)
    assert isinstance(future.exception(), WorkerDiedError)


def test_a_cluster_does_the_same_though_a_worker_is_killed(tmp_path):
    distributed = pytest.importorskip("distributed")
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
        ) as local,
        cluster(local.scheduler_address) as executor,
    ):
        done = list(each(executor, root_or_death, [(n, tmp_path / "died") for n in (0, 1, 4, 9)], failed))
    assert sorted(done) == [0.0, 1.0, 2.0, 3.0]
    assert (tmp_path / "died").exists()


def test_a_scheduler_that_is_not_there_is_one_sentence():
    pytest.importorskip("distributed")
    nowhere = cluster("tcp://127.0.0.1:1", patience=1.0)
    with pytest.raises(OptionError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:1"):
        nowhere.__enter__()
