"""Engines that run the cases of a study: Dask, or this process in turn.

Both yield the same rows, whatever the number of workers, and however many of them are lost.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Protocol

from contiga.errors import InputError
from contiga.extras import require
from contiga.studies.cases import StudyCase
from contiga.studies.one_case import Base, run_one
from contiga.studies.row import Row


class Engine(Protocol):
    """Protocol of what runs cases."""

    def run(self, cases: Sequence[StudyCase]) -> Iterator[Row]:
        """Yield the rows of cases as they finish, in any order."""


class InTurn:
    """Engine that runs the cases in turn in this process: the plain rival of Dask."""

    def __init__(self, base: Base) -> None:
        self._base = base

    def run(self, cases: Iterable[StudyCase]) -> Iterator[Row]:
        """Yield the rows in the order of the cases."""
        for case in cases:
            yield run_one(self._base, case)


@contextmanager
def engine_for(
    base: Base, *, scheduler: str | None, workers: int | None, retries: int
) -> Iterator[Engine]:
    """Provide the engine for the cases; processes that it starts have ended when the block ends.

    Parameters
    ----------
    base : common data of the cases
    scheduler : address of a running Dask scheduler; a cluster on this machine if omitted
    workers : processes of that cluster, a core each if omitted; 0 runs the cases in this process
    retries : number of restarts of a case whose worker was lost

    Raises
    ------
    InputError
        `workers` is negative, or given with a scheduler; no scheduler answers at the address. While
        it runs: a worker does not see the folder of the study, or has another version.
    MissingPackageError
        Dask is not installed.
    RunError
        The processes of this machine cannot be started.
    """
    if workers is not None and (isinstance(workers, bool) or workers < 0):
        raise InputError("must be a whole number", where="workers", found=workers, allowed=">= 0")
    if scheduler is not None and workers is not None:
        raise InputError(
            "a scheduler has its own workers",
            where="workers",
            found=workers,
            allowed="workers, or the address of a scheduler",
        )
    if workers == 0:
        yield InTurn(base)
        return
    require("a study on several processes", "dask", "distributed")
    from contiga.studies.on_dask import OnDask, local_client, remote_client

    if scheduler is not None:
        with remote_client(scheduler) as client:
            yield OnDask(client, base, retries)
    else:
        with local_client(cores() if workers is None else workers) as client:
            yield OnDask(client, base, retries)


def cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
