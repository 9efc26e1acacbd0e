"""Cases on Dask distributed: a cluster on this machine, or any scheduler that runs already."""

from __future__ import annotations

import logging
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex
from time import perf_counter, sleep
from typing import Any

import dask
from distributed import Client, Event, Future, KilledWorker, LocalCluster, wait

from contiga.errors import InputError, RunError
from contiga.studies.cases import StudyCase
from contiga.studies.one_case import Base, run_one
from contiga.studies.row import DONE, LOST, Row
from contiga.version import __version__

_ENVIRONMENT = {"NUMBA_NUM_THREADS": "1", "DASK_LOGGING__DISTRIBUTED": "critical"}
"""Of local workers: the kernels run on one thread each, and who was killed is told in rows."""
_SETTINGS = {
    "distributed.worker.daemon": False,  # readers of CAD have processes of their own
    "distributed.scheduler.allowed-failures": 0,  # retries are counted here
}
_ANSWER_SECONDS = 10
_LOOK_SECONDS = 1.0
QUIET_SECONDS = 10.0
"""A machine whose first case has compiled nothing for so long has its kernels."""


@contextmanager
def local_client(workers: int) -> Iterator[Client]:
    """A cluster on this machine for as long as the block lasts.

    Raises
    ------
    RunError
        Its processes cannot be started.
    """
    with dask.config.set(_SETTINGS):
        try:
            cluster = LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                dashboard_address="127.0.0.1:0",
                memory_limit=0,
                silence_logs=logging.CRITICAL,
                env=_ENVIRONMENT,
            )
        except RuntimeError as error:
            raise RunError(
                f"the workers cannot be started ({error}). They import the program: in a script "
                'cg.study stands under if __name__ == "__main__":'
            ) from error
        with cluster, Client(cluster, set_as_default=False) as client:
            yield client


@contextmanager
def remote_client(address: str) -> Iterator[Client]:
    """A client of a scheduler that runs already.

    Raises
    ------
    InputError
        Nobody answers there.
    """
    try:
        client = Client(address, timeout=_ANSWER_SECONDS, set_as_default=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(
            "no scheduler answers at this address",
            where="scheduler",
            found=address,
            allowed="that of a running one, such as tcp://host:8786",
            remedy="Start one with: dask scheduler",
        ) from error
    with client:
        yield client


class OnDask:
    """The cases on the workers of a scheduler, the next to whoever is free.

    Parameters
    ----------
    client : of the scheduler
    base : of the cases
    retries : how often a case is begun again whose worker was lost
    """

    def __init__(self, client: Client, base: Base, retries: int) -> None:
        self._client, self._base, self._retries = client, base, retries
        self._lost: Counter[int] = Counter()
        self._token = token_hex(4)
        """In the names of its tasks: others may use the same scheduler."""
        self._cold: dict[str, Event] | None = None
        """Hosts whose kernels may have to be compiled, once they are known."""

    def run(self, cases: Sequence[StudyCase]) -> Iterator[Row]:
        """The rows as they come. While a machine may compile kernels it runs one case."""
        waiting, running = deque(cases), dict[Future, StudyCase]()
        try:
            while waiting or running:
                self._submit(waiting, running)
                self._wait(running)
                for future in [future for future in running if future.done()]:
                    case = running.pop(future)
                    row = self._row(future, case)
                    if row is None:
                        waiting.append(case)
                    else:
                        yield row
        finally:
            self._client.cancel(list(running), force=True)

    def _wait(self, running: dict[Future, StudyCase]) -> None:
        """Until a case is done, or it is time to look whether more may run."""
        if not running:  # no worker is there just now
            sleep(_LOOK_SECONDS)
            return
        with suppress(TimeoutError), self._client.as_current():
            wait(list(running), timeout=_LOOK_SECONDS, return_when="FIRST_COMPLETED")

    def _submit(self, waiting: deque[StudyCase], running: dict[Future, StudyCase]) -> None:
        """As many as there are free threads: who dies takes no other case with it."""
        if self._cold is None:
            self._cold = self._hosts()
        for host, warm in list(self._cold.items()):
            workers = self._workers().get(host, [])
            if warm.is_set() or not workers:
                del self._cold[host]
            elif waiting and not any(_host_of(future) == host for future in running):
                case = waiting.popleft()
                running[self._first(case, host, warm, workers)] = case
        room = 0 if self._cold else sum(self._client.nthreads().values()) - len(running)
        for _ in range(min(room, len(waiting))):
            case = waiting.popleft()
            key = self._key(case)
            running[self._client.submit(run_one, self._base, case, key=key, pure=False)] = case

    def _first(self, case: StudyCase, host: str, warm: Event, workers: list[str]) -> Future:
        """The first case of a machine, on one worker of it."""
        return self._client.submit(
            _first_on_host,
            self._base,
            case,
            warm.name,
            workers=workers[:1],
            allow_other_workers=True,
            key=f"{host}{self._key(case)}",
            pure=False,
        )

    def _key(self, case: StudyCase) -> str:
        return f"|{self._token}|{case.name}|{self._lost[case.number]}"

    def _hosts(self) -> dict[str, Event]:
        """The machines there are, each seen to see the folder; waits for the first of them."""
        self._client.wait_for_workers(1)
        try:
            seen = self._client.run(_sees, self._base.folder)
        except ImportError as error:
            raise InputError(
                f"a worker cannot load contiga ({error})",
                where="scheduler",
                allowed=f"workers with contiga {__version__} and what studies need of its extras",
            ) from error
        for address, (sees, version) in seen.items():
            if not sees or version != __version__:
                raise InputError(
                    "a worker does not see the folder of the study"
                    if not sees
                    else "a worker has another version of contiga",
                    where=f"worker {address}",
                    found=version if sees else self._base.folder,
                    allowed=__version__ if sees else "a folder that all machines share",
                )
        return {
            host: Event(f"contiga-{self._token}-{host}", client=self._client)
            for host in self._workers()
        }

    def _workers(self) -> dict[str, list[str]]:
        """Addresses of workers by host."""
        found: dict[str, list[str]] = {}
        for address, told in self._client.scheduler_info(n_workers=-1)["workers"].items():
            found.setdefault(told["host"], []).append(address)
        return found

    def _row(self, future: Future, case: StudyCase) -> Row | None:
        """What came of a case; None where it is to be begun again."""
        if future.status == "finished":
            row: Row = future.result()
            host = _host_of(future)
            if self._cold and row.status == DONE:
                self._cold.pop(host, None)
            return row
        error = future.exception() if future.status == "error" else None
        if not isinstance(error, KilledWorker):
            why = f"{future.status}: {error or 'no scheduler'}"
            raise RunError(
                f"the cluster lost case {case.number} ({why}); --resume runs what is missing"
            )
        self._lost[case.number] += 1
        if self._lost[case.number] <= self._retries:
            return None
        message = f"its worker was lost {self._lost[case.number]} times"
        none = dict.fromkeys(self._base.quantities, float("nan"))
        row = Row(case.number, LOST, message, case.values, none, 0.0)
        folder = self._base.folder_of(case)
        folder.mkdir(parents=True, exist_ok=True)
        row.write(folder)
        return row


def _host_of(future: Future) -> str:
    """The machine that a first case was given to; "" of others."""
    return str(future.key).partition("|")[0]


def _sees(folder: str) -> tuple[bool, str]:
    """Whether a worker sees the folder of the study, and its version of contiga."""
    return Path(folder).is_dir(), __version__


def _first_on_host(base: Base, case: StudyCase, event: str) -> Row:
    """Run a case, and tell once it seems that no kernel has to be compiled any more."""
    from numba.core import event as numba_event

    class Compiling(numba_event.Listener):  # type: ignore[misc]
        last = perf_counter()

        def on_start(self, _: Any) -> None:
            self.last = perf_counter()

        def on_end(self, _: Any) -> None:
            self.last = perf_counter()

    listener, told = Compiling(), False

    def progress(done: int, steps: int, contacts: int) -> None:
        nonlocal told
        if not told and perf_counter() - listener.last > QUIET_SECONDS:
            told = True
            Event(event).set()

    with numba_event.install_listener("numba:compile", listener):
        return run_one(base, case, progress)
