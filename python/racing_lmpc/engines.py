"""Campaigns on engines that exist: processes of this machine, Dask and Ray.

>>> from racing_lmpc import engines
>>> engines.study("grip.toml", "out/grip", engines.processes(4))

An engine is a function of ``(function, jobs)`` that yields ``(job, function(job))`` in the order in
which they end. A run is a function of its job, so that an engine may do it again, on another worker
too: the table has each run once.
"""

from __future__ import annotations

import concurrent.futures
import itertools
import multiprocessing
import os
from collections.abc import Callable, Iterable, Iterator
from typing import Any, TypeVar

import racing_lmpc as lmpc

_Job = TypeVar("_Job")
_Result = TypeVar("_Result")
#: What drives jobs: see the module.
Engine = Callable[[Callable[[Any], Any], Iterable[Any]], Iterator[tuple[Any, Any]]]

#: How often a job is given out again when its workers are lost under it.
ATTEMPTS = 10


def processes(count: int | None = None) -> Engine:
    """Processes of this machine.

    Args:
        count: how many; by default one for each processor.
    """

    def run(function: Callable[[_Job], _Result], jobs: Iterable[_Job]) -> Iterator[tuple[_Job, _Result]]:
        context = multiprocessing.get_context("spawn")
        with concurrent.futures.ProcessPoolExecutor(count, mp_context=context) as pool:
            running = {pool.submit(function, job): job for job in jobs}
            for future in concurrent.futures.as_completed(running):
                yield running[future], future.result()

    return run


def dask(client: Any, attempts: int = ATTEMPTS) -> Engine:
    """Workers of a Dask cluster, which need this package in the same version.

    Args:
        client: a ``distributed.Client``.
        attempts: how often a job is given out again when its workers are lost under it. Dask
            itself moves jobs of a lost worker to another one, a few times each.
    """

    def run(function: Callable[[_Job], _Result], jobs: Iterable[_Job]) -> Iterator[tuple[_Job, _Result]]:
        import distributed

        # Not pure: two equal jobs are two runs.
        running = {client.submit(function, job, pure=False): (job, 1) for job in jobs}
        ended = distributed.as_completed(running)
        for future in ended:
            job, attempt = running.pop(future)
            lost = future.status == "cancelled"
            if future.status == "error":
                error = future.exception()
                lost = isinstance(error, (distributed.scheduler.KilledWorker, distributed.CancelledError))
                if not lost or attempt >= attempts:
                    raise error
            if lost:
                again = client.submit(function, job, pure=False)
                running[again] = (job, attempt + 1)
                ended.add(again)
                continue
            yield job, future.result()

    return run


def ray(count: int | None = None) -> Engine:
    """Workers of the Ray cluster that ``ray.init`` joined. Ray gives the jobs of a lost worker to
    another one.

    Args:
        count: jobs that are given out at the same time; by default four for each processor.
    """

    def run(function: Callable[[_Job], _Result], jobs: Iterable[_Job]) -> Iterator[tuple[_Job, _Result]]:
        import ray

        remote = ray.remote(max_retries=-1)(function)
        most = count or max(1, 4 * int(ray.cluster_resources().get("CPU", 1)))
        waiting = iter(jobs)
        running: dict[Any, _Job] = {}
        while True:
            for job in itertools.islice(waiting, most - len(running)):
                running[remote.remote(job)] = job
            if not running:
                return
            ended, _ = ray.wait(list(running), num_returns=1)
            for reference in ended:
                yield running.pop(reference), ray.get(reference)

    return run


_last: tuple[tuple[str, int], lmpc.Campaign] | None = None


def _campaign(path: str) -> lmpc.Campaign:
    """The campaign of a file; a worker reads it once, and anew when the file has changed."""
    global _last
    key = (path, os.stat(path).st_mtime_ns)
    if _last is None or _last[0] != key:
        _last = key, lmpc.Campaign(path)
    return _last[1]


def drive(job: tuple[str, int, str]) -> list[str]:
    """Drives one run: what a worker does.

    Args:
        job: file of the campaign, number of the run, fingerprint of its settings.

    Raises:
        CampaignError: the worker's package or files give the run other settings.
    """
    path, run, settings = job
    campaign = _campaign(path)
    found = campaign.settings(run)
    if found != settings:
        raise lmpc.CampaignError(
            f"run {run} of {path} has the settings {found} here, expected {settings}: install the same "
            f"version of racing_lmpc (here {lmpc.__version__}) and the same files on every worker"
        )
    return campaign.drive(run)


def study(
    file: str | os.PathLike[str],
    out: str | os.PathLike[str],
    engine: Engine | None = None,
    *,
    fresh: bool = False,
    on_row: Callable[[dict[str, str]], object] | None = None,
) -> int:
    """Runs what is missing of a campaign: ``lmpc study FILE --out OUT``, to the same table.

    Every row is written as soon as it arrives, so that the same call goes on where it stopped.

    Args:
        file: file of the campaign, at a path that the workers read as well.
        out: folder of the table.
        engine: `processes`, `dask` or `ray`; by default a process for each processor.
        fresh: begins a new table; the earlier one stays as ``runs.before.csv``.
        on_row: called with each row as it arrives.

    Returns:
        How many runs were driven.
    """
    path = os.path.abspath(file)
    campaign = lmpc.Campaign(path)
    table = campaign.open(out, fresh)
    try:
        jobs = [(path, run, campaign.settings(run)) for run in table.missing]
        for _, fields in (engine or processes())(drive, jobs):
            table.add(fields)
            if on_row is not None:
                on_row(dict(zip(campaign.columns, fields)))
    finally:
        table.close()
    return len(jobs)
