"""Cases on Dask distributed: a cluster on this machine, or any running scheduler."""

from __future__ import annotations

import logging
import warnings
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from secrets import token_hex
from time import perf_counter, sleep
from typing import Any, NamedTuple

import dask
from distributed import Client, Event, Future, KilledWorker, LocalCluster, Security, wait
from distributed.comm import connect
from distributed.utils import LoopRunner

from contiga.errors import ContigaWarning, InputError, RunError
from contiga.studies.cases import StudyCase
from contiga.studies.one_case import Base, run_one
from contiga.studies.row import DONE, LOST, Row
from contiga.version import __version__

_ENVIRONMENT = {"NUMBA_NUM_THREADS": "1", "DASK_LOGGING__DISTRIBUTED": "critical"}
"""Environment of local workers.

Kernels run on one thread each, and killed workers are reported in rows, not in the log.
"""
_SETTINGS = {
    "distributed.worker.daemon": False,  # readers of CAD have processes of their own
    "distributed.scheduler.allowed-failures": 0,  # retries are counted here
}
_ANSWER_SECONDS = 5
_LOOK_SECONDS = 1.0
_STRANDED_SECONDS = 3.0
"""Time after which the scheduler has reported a lost worker, seconds."""
QUIET_SECONDS = 10.0
"""Time without compiling after which the first case of a machine has all kernels, seconds."""


@contextmanager
def local_client(workers: int) -> Iterator[Client]:
    """Provide a cluster on this machine for the duration of the block.

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
    """Provide a client of a running scheduler.

    Raises
    ------
    InputError
        Nobody answers there, or somebody else than a scheduler.
    """
    try:
        # A client that fails to connect tries to close itself for 20 s, and prints a traceback.
        LoopRunner().run_sync(_reach, address)
        client = Client(address, timeout=_ANSWER_SECONDS, set_as_default=False)
    except Exception as error:  # anything may answer at an address
        raise InputError(
            "no scheduler answers at this address",
            where="scheduler",
            found=address,
            allowed="that of a running one, such as tcp://host:8786",
            remedy="Start one with: dask scheduler",
        ) from error
    with client:
        yield client


async def _reach(address: str) -> None:
    """Connect to a scheduler, and let it go."""
    how = Security().get_connection_args("client")
    comm = await connect(address, timeout=_ANSWER_SECONDS, **how)
    comm.abort()


class _Sent(NamedTuple):
    """A submitted case."""

    case: StudyCase
    workers: frozenset[str]
    """Addresses of workers that may run it."""


class OnDask:
    """Engine that sends each case to the next free worker of a scheduler.

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
        """Part of the names of its tasks: others may use the same scheduler."""
        self._cold: dict[str, Event] | None = None
        """Hosts whose kernels may have to be compiled, or None before they are known."""
        self._fit: dict[str, bool] = {}
        """Whether a worker may be used, by address, for all workers asked so far."""
        self._tries = count()
        self._stranded: dict[Future, float] = {}
        """Time since which no worker may run a case."""

    def run(self, cases: Sequence[StudyCase]) -> Iterator[Row]:
        """Yield the rows as they come. A machine that compiles kernels runs one case at a time."""
        waiting, running = deque(cases), dict[Future, _Sent]()
        try:
            while waiting or running:
                self._submit(waiting, running)
                self._wait(running)
                for future in [future for future in running if future.done()]:
                    case = running.pop(future).case
                    row = self._row(future, case)
                    if row is None:
                        waiting.append(case)
                    else:
                        yield row
        finally:
            self._client.cancel(list(running), force=True)

    def _wait(self, running: dict[Future, _Sent]) -> None:
        """Wait until a case is done, or until it is time to look for new workers."""
        if not running:  # there is no worker at present
            sleep(_LOOK_SECONDS)
            return
        with suppress(TimeoutError), self._client.as_current():
            wait(list(running), timeout=_LOOK_SECONDS, return_when="FIRST_COMPLETED")

    def _submit(self, waiting: deque[StudyCase], running: dict[Future, _Sent]) -> None:
        """Submit as many cases as there are free threads: a dying worker loses no other case."""
        there = self._workers()
        if self._cold is None:
            self._cold = self._hosts(there)
        self._take_back(there, waiting, running)
        for host, warm in list(self._cold.items()):
            workers = there.get(host, [])
            if warm.is_set() or not workers:
                del self._cold[host]
            elif waiting and not any(_host_of(future) == host for future in running):
                sent = _Sent(waiting.popleft(), frozenset(workers))
                running[self._first(sent.case, host, warm, workers)] = sent
        threads = self._client.nthreads()
        workers = [address for addresses in there.values() for address in addresses]
        room = 0 if self._cold else sum(threads.get(w, 0) for w in workers) - len(running)
        for _ in range(min(room, len(waiting))):
            sent = _Sent(waiting.popleft(), frozenset(workers))
            key = self._key(sent.case)
            options = {"key": key, "pure": False, "workers": workers}
            running[self._client.submit(run_one, self._base, sent.case, **options)] = sent

    def _take_back(
        self,
        there: dict[str, list[str]],
        waiting: deque[StudyCase],
        running: dict[Future, _Sent],
    ) -> None:
        """Take back cases whose workers left before they began; report lost cases."""
        workers = {address for addresses in there.values() for address in addresses}
        now = perf_counter()
        self._stranded = {
            future: self._stranded.get(future, now)
            for future, sent in running.items()
            if not future.done() and not sent.workers & workers
        }
        for future, since in self._stranded.items():
            if now - since > _STRANDED_SECONDS:
                self._client.cancel([future], force=True)
                waiting.append(running.pop(future).case)

    def _first(self, case: StudyCase, host: str, warm: Event, workers: list[str]) -> Future:
        """Submit the first case of a machine to a worker of it."""
        return self._client.submit(
            _first_on_host,
            self._base,
            case,
            warm.name,
            workers=workers,
            key=f"{host}{self._key(case)}",
            pure=False,
        )

    def _key(self, case: StudyCase) -> str:
        return f"|{self._token}|{case.name}|{next(self._tries)}"

    def _hosts(self, there: dict[str, list[str]]) -> dict[str, Event]:
        """Return the machines; wait for the first of them."""
        while not there:
            self._client.wait_for_workers(1)
            there.update(self._workers())
            if not there:  # reported workers are unusable, or were just lost
                sleep(_LOOK_SECONDS)
        return {host: Event(f"contiga-{self._token}-{host}", client=self._client) for host in there}

    def _workers(self) -> dict[str, list[str]]:
        """Return the addresses of usable workers, by host; new workers are asked first."""
        infos = self._client.scheduler_info(n_workers=-1)["workers"]
        new = [address for address in infos if address not in self._fit]
        if new:
            self._ask(new)
        workers: dict[str, list[str]] = {}
        for address, one in infos.items():
            if self._fit.get(address, False):
                workers.setdefault(one["host"], []).append(address)
        return workers

    def _ask(self, workers: list[str]) -> None:
        """Ask workers whether they see the folder and have this version.

        Raises
        ------
        InputError
            One that is there from the start has not; of one that comes later a warning is given,
            and no case.
        """
        answers = self._client.run(_sees, self._base.folder, workers=workers, on_error="return")
        for address, answer in answers.items():
            if isinstance(answer, OSError):  # it has been lost in the meantime
                continue
            wrong = _unfit(address, answer, self._base.folder)
            self._fit[address] = wrong is None
            if wrong is not None:
                if self._cold is None:
                    raise wrong
                warnings.warn(f"{wrong}. It gets no case", ContigaWarning, stacklevel=2)

    def _row(self, future: Future, case: StudyCase) -> Row | None:
        """Return the row of a case; None if the case is to be restarted."""
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
    """Return the machine of a first case; "" for other cases."""
    return str(future.key).partition("|")[0]


def _unfit(address: str, answer: Any, folder: str) -> InputError | None:
    """Return the error for a worker, from its answer."""
    if isinstance(answer, BaseException):
        return InputError(
            f"a worker cannot load contiga ({answer})",
            where=f"worker {address}",
            allowed=f"workers with contiga {__version__} and what studies need of its extras",
        )
    sees, version = answer
    if sees and version == __version__:
        return None
    return InputError(
        "a worker does not see the folder of the study"
        if not sees
        else "a worker has another version of contiga",
        where=f"worker {address}",
        found=version if sees else folder,
        allowed=__version__ if sees else "a folder that all machines share",
    )


def _sees(folder: str) -> tuple[bool, str]:
    """Return whether a worker sees the folder of the study, and its version of contiga."""
    try:
        return Path(folder).is_dir(), __version__
    except OSError:  # a folder above it may not be entered, a network drive does not answer
        return False, __version__


def _first_on_host(base: Base, case: StudyCase, event: str) -> Row:
    """Run a case, and signal when no kernel seems to be left to compile."""
    from numba.core import event as numba_event

    class Compiling(numba_event.Listener):  # type: ignore[misc]
        last = perf_counter()

        def on_start(self, _: Any) -> None:
            self.last = perf_counter()

        def on_end(self, _: Any) -> None:
            self.last = perf_counter()

    listener, is_told = Compiling(), False

    def progress(done: int, steps: int, contacts: int) -> None:
        nonlocal is_told
        if not is_told and perf_counter() - listener.last > QUIET_SECONDS:
            is_told = True
            Event(event).set()

    with numba_event.install_listener("numba:compile", listener):
        return run_one(base, case, progress)
