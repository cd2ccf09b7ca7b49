"""Analyse many recordings: in this process, in a pool of processes, or on a Dask cluster.

Every job runs the same function on plain values, so the results do not depend on where it ran.
A job that fails (or whose worker dies) becomes a result with one blocker; the others go on.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import importlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from mecanum_base.bag.analysis.analyze import Options, analyze, result_of
from mecanum_base.bag.analysis.findings import Finding
from mecanum_base.core.errors import BagError

Job = tuple[str, Options]
Update = Callable[[float, str], None]


def analyze_all(jobs: Sequence[Job], workers: int = 0, scheduler: str | None = None,
                update: Update = lambda share, rate: None) -> list[dict[str, Any]]:
    """Results in the order of the jobs; ``update(share, text)`` tells the progress."""
    if scheduler:
        return _on_cluster(jobs, scheduler, update)
    workers = min(workers or os.cpu_count() or 1, len(jobs))
    if workers <= 1:
        return [_one(job, update, index, len(jobs)) for index, job in enumerate(jobs)]
    return _in_pool(jobs, workers, update)


def run_job(job: Job) -> dict[str, Any]:
    """One job; anything that goes wrong is in the result."""
    try:
        return analyze(*job)
    except Exception as error:  # one bag's failure never loses the others
        return failed(job, f'{type(error).__name__}: {error}')


def failed(job: Job, reason: str) -> dict[str, Any]:
    """The result of a job that gave none."""
    path, options = job
    return result_of(path, options, None, [Finding(
        'blocker', 'failed', 'the analysis of this recording failed', reason,
        'please report this with the recording')])


def _one(job: Job, update: Update, index: int, total: int) -> dict[str, Any]:
    path, options = job
    try:
        return analyze(path, options, lambda share: update((index + share) / total,
                                                           f'{index + 1} of {total}'))
    except Exception as error:
        return failed(job, f'{type(error).__name__}: {error}')


def _in_pool(jobs: Sequence[Job], workers: int, update: Update) -> list[dict[str, Any]]:
    context = multiprocessing.get_context('spawn')
    others = set(multiprocessing.active_children())
    pool = concurrent.futures.ProcessPoolExecutor(workers, mp_context=context)
    try:
        with _interrupts_held():
            futures = [pool.submit(run_job, job) for job in jobs]
        for done, _ in enumerate(concurrent.futures.as_completed(futures), start=1):
            update(done / len(jobs), f'{done} of {len(jobs)}')
    except BaseException:  # Ctrl-C: wait for nothing
        for worker in set(multiprocessing.active_children()) - others:
            worker.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)
    results = []
    for job, future in zip(jobs, futures):
        error = future.exception()
        if error is None:
            results.append(future.result())
        else:  # the worker died: try once more here, alone
            results.append(run_job(job))
    return results


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Processes started meanwhile never see Ctrl-C, this one gets it afterwards.

    They inherit the mask. Here that is not enough: a thread of BLAS without it may take the
    signal, and Python then interrupts the main thread all the same.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    usual = signal.signal(signal.SIGINT, lambda number, _frame: came.append(number))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        signal.signal(signal.SIGINT, usual or signal.SIG_DFL)
        if came:
            signal.raise_signal(signal.SIGINT)


def _on_cluster(jobs: Sequence[Job], scheduler: str, update: Update) -> list[dict[str, Any]]:
    distributed: Any = importlib.import_module('dask.distributed')
    try:
        client = distributed.Client(scheduler, timeout='10s')
    except (OSError, ValueError) as error:
        raise BagError(f'{scheduler}: no Dask scheduler answers ({error})') from None
    with client:
        futures = client.map(run_job, jobs, pure=False, retries=1)
        for done, _ in enumerate(distributed.as_completed(futures), start=1):
            update(done / len(jobs), f'{done} of {len(jobs)}')
        return [future.result() if future.status == 'finished'
                else failed(job, f'the worker failed: {future.exception()}')
                for job, future in zip(jobs, futures)]
