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
_POLL_SECONDS = 1.0
_STRANDED_SECONDS = 3.0
"""Time within which the scheduler reports a lost worker, seconds."""
QUIET_SECONDS = 10.0
"""Time without compiling after which the first case on a machine has all kernels, seconds."""


@contextmanager
def local_client(workers: int) -> Iterator[Client]:
    """Provide a client of a cluster on this machine, of `workers` processes with one thread each.

    The cluster ends with the block.

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
    """Provide a client of a running scheduler for the duration of the block.

    Raises
    ------
    InputError
        No scheduler answers at the address within 5 s.
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


class _Submission(NamedTuple):
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
    retries : number of restarts of a case whose worker was lost
    """

    def __init__(self, client: Client, base: Base, retries: int) -> None:
        self._client, self._base, self._retries = client, base, retries
        self._n_lost: Counter[int] = Counter()
        """How often the worker of a case was lost, by its number."""
        self._token = token_hex(4)
        """Part of the names of its tasks: others may use the same scheduler."""
        self._cold: dict[str, Event] | None = None
        """Signals of hosts that may have to compile kernels, set when they have; None at first."""
        self._usable: dict[str, bool] = {}
        """Whether a worker may be used, by address, for all workers asked so far."""
        self._tries = count()
        self._stranded: dict[Future, float] = {}
        """Time since which no usable worker may run a case, seconds."""

    def run(self, cases: Sequence[StudyCase]) -> Iterator[Row]:
        """Yield the rows as they come. A machine that compiles kernels runs one case at a time.

        No case goes to free threads while any machine still compiles. A case whose worker was lost
        is queued again; after all retries it is a row with the status `LOST`. Cases still running
        when the caller stops are cancelled.

        Raises
        ------
        InputError
            A worker of the start cannot be used (`_workers`).
        RunError
            The scheduler was lost, or a case fails without a row.
        """
        waiting, running = deque(cases), dict[Future, _Submission]()
        try:
            while waiting or running:
                self._submit(waiting, running)
                if running:
                    # Wait for a case, or until it is time to look for new workers.
                    with suppress(TimeoutError), self._client.as_current():
                        wait(list(running), timeout=_POLL_SECONDS, return_when="FIRST_COMPLETED")
                else:  # there is no worker at present
                    sleep(_POLL_SECONDS)
                for future in [future for future in running if future.done()]:
                    case = running.pop(future).case
                    row = self._row(future, case)
                    if row is None:
                        waiting.append(case)
                    else:
                        yield row
        finally:
            self._client.cancel(list(running), force=True)

    def _submit(self, waiting: deque[StudyCase], running: dict[Future, _Submission]) -> None:
        """Move cases from `waiting` to `running`, one for each free thread of a usable worker.

        A dying worker then loses no other case. While machines compile, each gets one case only.
        Cases whose workers left before they began wait again after `_STRANDED_SECONDS`; the
        scheduler reports lost cases itself.
        """
        by_host = self._workers()
        if self._cold is None:
            self._cold = self._hosts(by_host)
        workers = [address for addresses in by_host.values() for address in addresses]
        now = perf_counter()
        self._stranded = {
            future: self._stranded.get(future, now)
            for future, submission in running.items()
            if not future.done() and submission.workers.isdisjoint(workers)
        }
        for future, since in self._stranded.items():
            if now - since > _STRANDED_SECONDS:
                self._client.cancel([future], force=True)
                waiting.append(running.pop(future).case)
        for host, warm in list(self._cold.items()):
            workers_of_host = by_host.get(host, [])
            if warm.is_set() or not workers_of_host:
                del self._cold[host]
            elif waiting and not any(_host_of(future) == host for future in running):
                case = waiting.popleft()
                future = self._client.submit(
                    _first_on_host,
                    self._base,
                    case,
                    warm.name,
                    workers=workers_of_host,
                    key=f"{host}{self._key(case)}",
                    pure=False,
                )
                running[future] = _Submission(case, frozenset(workers_of_host))
        threads = self._client.nthreads()
        n_free = 0 if self._cold else sum(threads.get(w, 0) for w in workers) - len(running)
        for _ in range(min(n_free, len(waiting))):
            case = waiting.popleft()
            options = {"key": self._key(case), "pure": False, "workers": workers}
            future = self._client.submit(run_one, self._base, case, **options)
            running[future] = _Submission(case, frozenset(workers))

    def _key(self, case: StudyCase) -> str:
        return f"|{self._token}|{case.name}|{next(self._tries)}"

    def _hosts(self, by_host: dict[str, list[str]]) -> dict[str, Event]:
        """Return an event for each host, set once its kernels are compiled; wait for one worker.

        Workers that come meanwhile are added to `by_host`.
        """
        while not by_host:
            self._client.wait_for_workers(1)
            by_host.update(self._workers())
            if not by_host:  # reported workers are unusable, or were just lost
                sleep(_POLL_SECONDS)
        names = {host: f"contiga-{self._token}-{host}" for host in by_host}
        return {host: Event(name, client=self._client) for host, name in names.items()}

    def _workers(self) -> dict[str, list[str]]:
        """Return the addresses of usable workers, by host; new workers are checked first.

        Raises
        ------
        InputError
            A worker that exists from the start does not see the folder, or has another version. One
            that comes later gives a warning, and gets no case.
        """
        infos = self._client.scheduler_info(n_workers=-1)["workers"]
        new = [address for address in infos if address not in self._usable]
        answers = {}
        if new:
            answers = self._client.run(_sees, self._base.folder, workers=new, on_error="return")
        for address, answer in answers.items():
            if isinstance(answer, OSError):  # it has been lost in the meantime
                continue
            error = _unfit(address, answer, self._base.folder)
            self._usable[address] = error is None
            if error is not None:
                if self._cold is None:
                    raise error
                warnings.warn(f"{error}. It gets no case", ContigaWarning, stacklevel=2)
        workers: dict[str, list[str]] = {}
        for address, info in infos.items():
            if self._usable.get(address, False):
                workers.setdefault(info["host"], []).append(address)
        return workers

    def _row(self, future: Future, case: StudyCase) -> Row | None:
        """Return the row of a finished task; None if the case is to restart on another worker.

        After all retries a row with the status `LOST` is written and returned. Any other failure
        raises a RunError. A first case that ends well marks its host as compiled.
        """
        if future.status == "finished":
            row: Row = future.result()
            host = _host_of(future)
            if self._cold and row.status == DONE:
                self._cold.pop(host, None)
            return row
        error = future.exception() if future.status == "error" else None
        if not isinstance(error, KilledWorker):
            reason = f"{future.status}: {error or 'no scheduler'}"
            raise RunError(
                f"the cluster lost case {case.number} ({reason}); --resume runs what is missing"
            )
        self._n_lost[case.number] += 1
        if self._n_lost[case.number] <= self._retries:
            return None
        message = f"its worker was lost {self._n_lost[case.number]} times"
        collected = dict.fromkeys(self._base.quantities, float("nan"))
        row = Row(case.number, LOST, message, case.values, collected, 0.0)
        folder = self._base.folder_of(case)
        folder.mkdir(parents=True, exist_ok=True)
        row.write(folder)
        return row


def _host_of(future: Future) -> str:
    """Return the host whose first case a task is; empty for other tasks."""
    return str(future.key).partition("|")[0]


def _unfit(address: str, answer: Any, folder: str) -> InputError | None:
    """Return the error for a worker, from its answer to `_sees`; None if it can be used."""
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
    """Run a case, set the event when no kernel was compiled for `QUIET_SECONDS`; return the row.

    The event is set at most once, after a step; a case that ends earlier does not set it.
    """
    from numba.core import event as numba_event

    class Compiling(numba_event.Listener):  # type: ignore[misc]
        last = perf_counter()

        def on_start(self, _: Any) -> None:
            self.last = perf_counter()

        def on_end(self, _: Any) -> None:
            self.last = perf_counter()

    listener, is_signalled = Compiling(), False

    def progress(done: int, steps: int, contacts: int) -> None:
        nonlocal is_signalled
        if not is_signalled and perf_counter() - listener.last > QUIET_SECONDS:
            is_signalled = True
            Event(event).set()

    with numba_event.install_listener("numba:compile", listener):
        return run_one(base, case, progress)
