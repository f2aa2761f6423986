# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Work in other processes, of which one that dies costs its own piece of work alone.

All of it goes through `concurrent.futures.Executor`: `Processes` is one on this machine, a Dask client has one for
those of a cluster.
"""

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from cdp_ident.errors import OptionError
from cdp_ident.machine.parallel import use_one_core
from cdp_ident.outside_text import shown
from cdp_ident.start import keep_freed_memory

Job = TypeVar("Job")
Result = TypeVar("Result")

_ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""Read by the libraries of a process as they are loaded."""
_PATIENCE = 5.0
"""How long the end of a process is waited for that has closed its side [s]."""


class WorkerDiedError(Exception):
    """A process ended with its work undone."""


def each(
    executor: Executor, work: Callable[[Job], Result], jobs: Sequence[Job], failed: Callable[[Job, str], Result]
) -> Iterator[Result]:
    """Yield the result of each job as it comes.

    A job that comes to nothing is tried once more when no other is left: alone, so that it cannot be another's fault.

    Args:
        executor: where the work is done, each piece on one core.
        work: a function of a module; what it raises is its own to handle.
        jobs: what it is called with.
        failed: gives the result of a job that failed twice, or took too long, from the job and the reason.
    """
    futures = {executor.submit(_on_one_core, work, job): job for job in jobs}
    undone = []
    for future in as_completed(futures):
        try:
            result = future.result()
        except TimeoutError as error:
            result = failed(futures[future], str(error))
        except Exception:  # noqa: BLE001 - each executor has its own for a worker that died
            undone.append(futures[future])
            continue
        yield result
    for job in undone:
        try:
            result = executor.submit(_on_one_core, work, job).result()
        except Exception as error:  # noqa: BLE001
            result = failed(job, shown(error) or type(error).__name__)
        yield result


def _on_one_core(work: Callable[[Job], Result], job: Job) -> Result:
    use_one_core()
    keep_freed_memory()
    return work(job)


class Processes(ThreadPoolExecutor):
    """Threads that have a process of this machine each do what is asked; one that dies is replaced."""

    def __init__(self, count: int, limit: float | None = None) -> None:
        """Start so many; what takes longer than the limit [s] is given up with a `TimeoutError`."""
        super().__init__(count, thread_name_prefix="worker")
        self._limit = limit
        self._all = [_Process() for _ in range(count)]
        self._idle = self._all.copy()

    def submit(self, fn: Callable[..., Result], /, *args: Any, **kwargs: Any) -> "Future[Result]":
        """Have a function called as soon as a process is idle; its future raises `WorkerDiedError` where that died."""
        return super().submit(self._call, fn, args, kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes; unless it is to `wait`, what they do is given up."""
        super().shutdown(wait, cancel_futures=cancel_futures or not wait)
        for process in self._all:
            process.end()
        # The threads have nothing to wait for any more; until they have noticed, the connections are theirs.
        super().shutdown()
        for process in self._all:
            process.close()

    def _call(self, *call: Any) -> Any:
        process = self._idle.pop()
        try:
            return process.call(call, self._limit)
        finally:
            self._idle.append(process)


class _Process:
    """A process that can be begun anew."""

    def __init__(self) -> None:
        self._ended = False
        self._begin()

    def _begin(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs,), daemon=True)
        # Ctrl-C reaches all processes of a terminal; what becomes of the work is for the one that gave it to say.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        theirs.close()

    def call(self, call: tuple[Any, ...], limit: float | None) -> Any:
        try:
            self._connection.send(call)
            answered = self._connection.poll(limit)
            error, result = self._connection.recv() if answered else (None, None)
        except (EOFError, OSError) as end:
            self._process.join(_PATIENCE)
            code = self._process.exitcode
            self._again()
            raise WorkerDiedError(f"the process ended with {code}") from end
        if not answered:
            self._again()
            raise TimeoutError(f"there was no result after {limit:.0f} s")
        if error is not None:
            raise error
        return result

    def _again(self) -> None:
        self.close()
        if not self._ended:
            self._begin()

    def end(self) -> None:
        """End the process, for good; a call that waits for it fails."""
        self._ended = True
        self._process.kill()

    def close(self) -> None:
        """End the process and let go of it."""
        self._process.kill()
        self._process.join()
        self._connection.close()


def _serve(connection: Connection) -> None:
    """Do what comes over a connection until it is closed."""
    os.environ.update(_ONE_THREAD)
    while True:
        try:
            function, arguments, named = connection.recv()
        except EOFError:
            return
        try:
            connection.send((None, function(*arguments, **named)))
        except Exception as error:  # noqa: BLE001 - it is raised where the work was asked for
            connection.send((error, None))


@contextmanager
def processes(count: int, limit: float | None = None) -> Iterator[Executor]:
    """Give processes of this machine; however it is left, they end."""
    executor = Processes(count, limit)
    try:
        yield executor
    finally:
        executor.shutdown(wait=False)


@contextmanager
def cluster(address: str, patience: float = 10.0) -> Iterator[Executor]:
    """Give the workers of the Dask scheduler at an address, such as `tcp://10.0.0.1:8786`.

    Its answer is waited for with `patience` [s]. Raises `OptionError` where `distributed` is not installed, or none
    answers.
    """
    try:
        from distributed import Client  # noqa: PLC0415 - an optional dependency
    except ImportError as error:
        raise OptionError(
            "there is no way to a Dask cluster without `distributed`: apt install python3-distributed, or pip install "
            "distributed"
        ) from error
    try:
        client = Client(address, timeout=patience, set_as_default=False)
    except (OSError, ValueError, ImportError) as error:
        raise OptionError(f"no Dask scheduler answers at {shown(address)}: {shown(error)}") from error
    with client:
        # Not pure: the same piece again is to be done again, not answered with what came of it before.
        executor = client.get_executor(pure=False)
        try:
            yield executor
        finally:
            executor.shutdown(wait=False)
