"""Work in processes of one core each, of which one that dies or hangs costs its own piece alone."""

import multiprocessing
import os
import time
from collections.abc import Callable, Iterator, Sequence
from multiprocessing.connection import Connection, wait
from typing import Generic, TypeVar

Job = TypeVar("Job")
Result = TypeVar("Result")

_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")


class _Worker(Generic[Job, Result]):
    """A process, and the job that it works on."""

    def __init__(self, work: Callable[[Job], Result], core: int) -> None:
        context = multiprocessing.get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._core, self._work = core, work
        self._process = context.Process(target=_run, args=(theirs, work, core), daemon=True)
        self._process.start()
        theirs.close()
        self.job: Job | None = None
        self.since = 0.0

    def begin(self, job: Job) -> None:
        self.job, self.since = job, time.monotonic()
        self.connection.send(job)

    def ended(self) -> str:
        """Return how the process ended."""
        self._process.join(5.0)
        return f"the process ended with {self._process.exitcode}"

    def another(self) -> "_Worker[Job, Result]":
        """End this process, and return one in its place."""
        self.stop()
        return _Worker(self._work, self._core)

    def stop(self) -> None:
        self._process.kill()
        self._process.join()
        self.connection.close()


def each(
    work: Callable[[Job], Result],
    jobs: Sequence[Job],
    count: int,
    limit: float,
    failed: Callable[[Job, str], Result],
) -> Iterator[Result]:
    """Yield the result of each job as it comes.

    Args:
        work: a function of a module; what it raises is its own to handle.
        jobs: what it is called with.
        count: of processes.
        limit: a job that takes longer [s] is given up.
        failed: gives the result of a job whose process died, or that was given up, from the job and the reason.
    """
    cores = sorted(os.sched_getaffinity(0))
    before = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(_ONE_THREAD)
    workers: list[_Worker[Job, Result]] = [_Worker(work, cores[k % len(cores)]) for k in range(min(count, len(jobs)))]
    left = list(reversed(jobs))
    try:
        while True:
            for worker in workers:
                if worker.job is None and left:
                    worker.begin(left.pop())
            busy = [worker for worker in workers if worker.job is not None]
            if not busy:
                return
            ready = wait([worker.connection for worker in busy], timeout=1.0)
            for place, worker in enumerate(workers):
                job = worker.job
                if job is None:
                    continue
                if worker.connection in ready:
                    try:
                        result: Result = worker.connection.recv()
                        worker.job = None
                    except (EOFError, ConnectionError):
                        result = failed(job, worker.ended())
                        workers[place] = worker.another()
                    yield result
                elif time.monotonic() - worker.since > limit:
                    workers[place] = worker.another()
                    yield failed(job, f"there was no result after {limit:.0f} s")
    finally:
        for worker in workers:
            worker.stop()
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _run(connection: Connection, work: Callable[[Job], Result], core: int) -> None:
    os.sched_setaffinity(0, {core})
    while True:
        try:
            job = connection.recv()
        except EOFError:
            return
        connection.send(work(job))
