"""Files are read in a worker process, so that no file can crash, hang or swamp the caller.

`read_in_worker` sends a request to a worker and returns plain records. A reader that crashes,
takes too long or needs too much memory becomes one `FileError`. Both sides of the pipe are here:
`serve` runs in the worker. It imports a reader's libraries once and forks for every file, so that
one file has no effect on the next.

macOS and Windows differ. There the worker reads file after file itself, until one ends it, because
Apple's libraries do not survive a fork and Windows has none. Time is limited everywhere: processor
time by the system on Linux and macOS, wall-clock time by the caller. Memory is limited on Linux
only: macOS does not enforce its limit, and Windows has none without job objects.

A worker is kept for the next file. It ends after a minute without work, or with its caller. Where
none can be started, files are read in this process, without limits.
"""

from __future__ import annotations

import atexit
import contextlib
import gc
import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import traceback
import warnings
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

from contiga.errors import ContigaError, ContigaWarning, FileError
from contiga.io.limits import limits_for, too_large, too_slow

_BOOT = "import sys; sys.path[:] = sys.argv[1:]; from contiga.io.worker import serve; serve()"
_START_SECONDS = 60.0
_LOAD_SECONDS = 900.0
"""Time to load a reader's libraries, and to compile its kernels once on a machine."""
_IDLE_SECONDS = 60
_CLOCK_FACTOR = 4.0
"""Wall-clock time allowed for one second of processor time, on a busy machine."""
_MAX_IDLE = 2
"""Workers kept for the next file; callers with threads have more at work."""
_MEMORY_SHARE = 0.7
"""A crash with this share of the memory in use is attributed to the memory limit."""
_MAX_MESSAGE = 300
"""Characters of a foreign exception that are passed on."""


class Request(NamedTuple):
    """One file to read."""

    target: str
    """"module:function", called with `path` and `args`."""
    path: Path
    args: tuple[object, ...]
    seconds: float
    memory: int
    folder: str
    """Relative paths start here."""
    modules: list[str]
    """``sys.path`` of the caller."""


class Outcome(NamedTuple):
    """Result of reading one file."""

    content: Any = None
    """Result of the reader; None if it raised."""
    error: Exception | None = None
    trace: str = ""
    """Traceback of a reader that failed with an exception of its own."""
    warnings: tuple[str, ...] = ()
    """Texts of its `ContigaWarning`s; others are dropped."""

    def value(self) -> Any:
        """Return what the reader returned, or raise its error."""
        if self.error is not None:
            raise self.error from (RuntimeError(self.trace) if self.trace else None)
        return self.content


def read_in_worker(target: str, path: Path, *args: object, needs: str = "numpy") -> Any:
    """Call a reader in a worker process and return its result.

    Parameters
    ----------
    target : "module:function", called with `path` and `args`; the module may have a `warm_up`,
        which loads its libraries before the time counts
    path : the file
    needs : module that the caller needs for the result, imported while the file is read;
        its `warm_up` is called if it has one

    Raises
    ------
    FileError
        The reader crashed, took too long, needed too much memory or failed with an exception of
        its own.
    ContigaError
        The reader's own refusal.
    ImportError
        The reader's libraries cannot be loaded.

    Warns
    -----
    ContigaWarning
        The reader's warnings, issued where this function's caller is called.
    """
    outcome = outcome_in_worker(target, path, *args, needs=needs)
    for message in outcome.warnings:
        warnings.warn(message, ContigaWarning, stacklevel=3)
    return outcome.value()


def outcome_in_worker(target: str, path: Path, *args: object, needs: str = "numpy") -> Outcome:
    """Call a reader as `read_in_worker` does, and return its `Outcome`: its error is not raised.

    Warnings are not issued. Where no worker can be started, the file is read in this process,
    without limits.

    Raises
    ------
    ImportError
        A new worker crashes while it loads the reader's libraries.
    """
    folder = os.curdir
    with contextlib.suppress(OSError):  # it may have been deleted
        folder = os.getcwd()
    request = Request(target, path, args, *limits_for(path), folder, _module_folders())
    while (worker := _pool.take()) is not None:
        try:
            outcome = worker.read(request, needs)
        except _WorkerEndedError as ended:
            worker.end()
            if worker.was_idle:  # it may have ended after a minute without work: try the next
                continue
            if not worker.started:
                _pool.can_start = False
                continue
            message = f"the libraries that read {path.suffix} files cannot be loaded"
            raise ImportError(f"{message} ({_exit_text(ended.code)})") from ended
        except BaseException:
            worker.end()
            raise
        _pool.put(worker)
        return outcome
    return _outcome(request)


def prepare(target: str) -> None:
    """Let a worker load a reader while this process continues, unless one is at hand.

    An error in loading is reported when a file is read.

    Parameters
    ----------
    target : as for `read_in_worker`
    """
    if not _pool.workers and (worker := _pool.take()) is not None:
        with contextlib.suppress(_WorkerEndedError):
            worker.send(target)
        _pool.put(worker)


class _WorkerEndedError(Exception):
    """The worker has ended."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


class _Worker:
    """A worker process as its caller sees it."""

    def __init__(self) -> None:
        one_thread = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", _BOOT, *_module_folders()],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **one_thread},  # a fork keeps one thread alone
            start_new_session=os.name == "posix",  # Ctrl-C reaches the caller alone
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self.started = self.was_idle = self.expired = False

    def read(self, request: Request, needs: str) -> Outcome:
        """Return the outcome of reading a file; if the reader crashes or is too slow, that error.

        The worker has ended then. `needs` is imported, and its `warm_up` called, in the meantime.

        Raises
        ------
        _WorkerEndedError
            The worker ended, or was ended by a limit, before it had loaded the reader.
        """
        self.send(request)
        getattr(import_module(needs), "warm_up", lambda: None)()  # while the worker is loading
        if not self.started:
            self._receive(_START_SECONDS)
            self.started = True
        outcome: Outcome | None = self._receive(_LOAD_SECONDS)
        if outcome is not None:  # the reader cannot be loaded
            return outcome
        clock = request.seconds * (_CLOCK_FACTOR if os.name == "posix" else 1.0)
        try:
            outcome = self._receive(clock)
            assert outcome is not None
            return outcome
        except _WorkerEndedError as ended:
            where = str(request.path)
            return Outcome(
                error=too_slow(where, clock) if self.expired else _crash_error(request, ended.code)
            )

    def send(self, message: Request | str) -> None:
        """Send a request, or the target of a reader to load.

        Raises `_WorkerEndedError` if the worker has ended.
        """
        assert self.process.stdin is not None
        try:
            with _no_broken_pipe_signal():
                self.process.stdin.write(pickle.dumps(message))
                self.process.stdin.flush()
        except OSError as error:
            raise _WorkerEndedError(self.process.wait()) from error

    def _receive(self, seconds: float) -> Any:
        """Return the next reply; a worker that takes longer than `seconds` is killed.

        It is then `expired`. Raises `_WorkerEndedError` with its exit code if it ends.
        """
        assert self.process.stdout is not None

        def expire() -> None:
            self.expired = True
            self._kill()

        timer = threading.Timer(seconds, expire)
        timer.daemon = True
        timer.start()
        try:
            return pickle.load(self.process.stdout)
        except (EOFError, pickle.UnpicklingError) as error:
            raise _WorkerEndedError(self.process.wait()) from error
        finally:
            timer.cancel()

    def _kill(self) -> None:
        with contextlib.suppress(OSError):
            if os.name == "posix":
                os.killpg(self.process.pid, signal.SIGKILL)
            else:
                self.process.kill()

    def end(self) -> None:
        """End the worker and its forks at once."""
        if self.process.poll() is None:
            self._kill()
        for stream in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError), _no_broken_pipe_signal():
                if stream is not None:
                    stream.close()  # which writes the rest of its buffer
        self.process.wait()


@contextlib.contextmanager
def _no_broken_pipe_signal() -> Iterator[None]:
    """Let a pipe whose reader has ended raise an error, and not end this process.

    Python ignores the signal from its start, but some libraries (gmsh) and callers make it fatal
    again. The thread that writes gets it: it blocks the signal here, and removes a pending one.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    broken_pipe = {signal.SIGPIPE}
    old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, broken_pipe)
    try:
        yield
    finally:
        if not broken_pipe & old_mask:
            if broken_pipe & signal.sigpending():
                signal.sigwait(broken_pipe)
            signal.pthread_sigmask(signal.SIG_SETMASK, old_mask)


class _Pool:
    """Workers that wait for the next file."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self.workers: list[_Worker] = []
        # not a program that embeds an interpreter
        is_python = Path(sys.executable or "").stem.lower().startswith("python")
        self.can_start = is_python and not getattr(sys, "frozen", False)

    def take(self) -> _Worker | None:
        """Return a waiting worker, which may have ended since, or a new one; None if none starts.

        The waiting one is no longer in the pool. After one failed start none is tried again.
        """
        with self._lock:
            if self.workers:
                return self.workers.pop()
        if not self.can_start:
            return None
        try:
            return _Worker()
        except OSError:
            self.can_start = False
            return None

    def put(self, worker: _Worker) -> None:
        """Keep a worker for the next file; end it if `_MAX_IDLE` wait already, or it has ended."""
        with self._lock:
            worker.was_idle = worker.process.poll() is None and len(self.workers) < _MAX_IDLE
            if worker.was_idle:
                self.workers.append(worker)
        if not worker.was_idle:
            worker.end()

    def end(self) -> None:
        """End all waiting workers."""
        with self._lock:
            workers, self.workers = self.workers, []
        for worker in workers:
            worker.end()

    def forget(self) -> None:
        """Let go of the workers in a fork of this process: they belong to the parent."""
        for worker in self.workers:
            worker.process.returncode = 0
        self._lock, self.workers = threading.Lock(), []


_pool = _Pool()
atexit.register(lambda: _pool.end())
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=lambda: _pool.forget())


def _module_folders() -> list[str]:
    return [os.path.abspath(entry) for entry in sys.path if isinstance(entry, str)]


def _crash_error(request: Request, code: int, memory: int = 0) -> FileError:
    """Return the error for a file whose reader ended with an exit code, and used `memory` bytes.

    The signal of used-up processor time means too slow. A kill, or more than `_MEMORY_SHARE` of the
    limit in use, means too large; anything else is a crash.
    """
    where = str(request.path)
    if code == -getattr(signal, "SIGXCPU", 0):
        return too_slow(where, request.seconds)
    if code == -getattr(signal, "SIGKILL", 0) or memory > _MEMORY_SHARE * request.memory:
        return too_large(where, request.memory)
    return FileError(
        f"the reader crashed on this file ({_exit_text(code)})",
        where=where,
        allowed=f"an undamaged {request.path.suffix} file",
        remedy=(
            "It is damaged, or uses something that the library which reads it cannot; "
            "export it anew"
        ),
    )


def _exit_text(code: int) -> str:
    try:
        return f"signal {-code}, {signal.Signals(-code).name}"
    except ValueError:
        return f"exit code {code}"


def serve() -> None:
    """Read requested files in the worker until the caller closes the pipe.

    A worker without a request for a minute is ended by a signal, where the system has alarms.
    It sends None when it has started. A request is answered by None once its reader is loaded, then
    by its outcome; if the reader cannot be loaded, by an outcome alone. The name of a reader to
    load gets no answer.
    """
    requests, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):  # native libraries print as they please
        os.dup2(null, stream)
    set_alarm = getattr(signal, "alarm", lambda seconds: None)
    _send(replies, pickle.dumps(None))  # started
    while True:
        set_alarm(_IDLE_SECONDS)  # a worker that waits for long gives its memory back
        try:
            request: Request | str = pickle.load(requests)
        except EOFError:
            return
        set_alarm(0)
        if isinstance(request, str):
            with contextlib.suppress(Exception):  # reported when a file is read
                _load(request)
            continue
        sys.path[:] = request.modules
        with contextlib.suppress(OSError):
            os.chdir(request.folder)
        try:
            _load(request.target)
        except Exception as error:
            if not isinstance(error, ImportError):
                error = ImportError(f"{type(error).__name__}: {error}")
            _send(replies, pickle.dumps(Outcome(error=error)))
            continue
        _send(replies, pickle.dumps(None))  # loaded: from now on the time counts
        if hasattr(os, "fork") and sys.platform != "darwin":
            _send(replies, _read_in_fork(request, requests.fileno()))
        else:
            _limit(request.seconds)
            _send(replies, _pickled_outcome(request))


def _send(replies: io.BufferedWriter, content: bytes) -> None:
    replies.write(content)
    replies.flush()


def _load(target: str) -> None:
    """Import a reader's module, which loads its libraries in `warm_up`."""
    gc.disable()  # nothing loaded is garbage: the collector would take an eighth of the time
    try:
        module = import_module(target.partition(":")[0])
        getattr(module, "warm_up", lambda: None)()
        gc.freeze()  # forks share the memory as long as the collector does not touch it
    finally:
        gc.enable()


def _read_in_fork(request: Request, caller: int) -> bytes:
    """Return the pickled outcome of a file that a fork reads within the limits.

    A fork that ends without one makes the error of `_crash_error`. `caller` is the pipe of
    requests; it becomes readable only when the caller is gone, and then this process and the fork
    end.
    """
    import select

    resident = _process_memory()[1]
    pipe_end, fork_end = os.pipe()
    fork = os.fork()
    if fork == 0:
        code = 1
        try:
            _limit(request.seconds, request.memory)
            with os.fdopen(fork_end, "wb") as stream:
                stream.write(_pickled_outcome(request))
            code = 0
        finally:
            os._exit(code)
    os.close(fork_end)
    content = bytearray()
    with os.fdopen(pipe_end, "rb", buffering=0) as stream:
        while True:
            if caller in select.select([pipe_end, caller], [], [])[0]:
                os.killpg(0, signal.SIGKILL)
            piece = stream.read(1 << 20)
            if not piece:
                break
            content += piece
    _, status, usage = os.wait4(fork, 0)
    if status == 0:
        return bytes(content)
    growth = usage.ru_maxrss * 1024 - resident
    error = _crash_error(request, os.waitstatus_to_exitcode(status), growth)
    return pickle.dumps(Outcome(error=error))


def _pickled_outcome(request: Request) -> bytes:
    """Read the requested file and return the pickled outcome.

    An error that cannot be pickled is reduced to its text; content that cannot be pickled raises.
    Running out of memory becomes an outcome.
    """
    try:
        outcome = _outcome(request)
        try:
            return pickle.dumps(outcome, protocol=5)
        except (pickle.PicklingError, TypeError, AttributeError):
            if outcome.error is None:
                raise
            # An exception's `found` may be of any kind; its text contains it too.
            error = type(outcome.error)(str(outcome.error))
            return pickle.dumps(outcome._replace(error=error), protocol=5)
    except MemoryError:
        return pickle.dumps(Outcome(error=too_large(str(request.path), request.memory)))


def _outcome(request: Request) -> Outcome:
    """Call the reader and return its outcome.

    Its own refusals (`ContigaError`, ImportError) stay, memory that runs out is too large, any
    other exception becomes a `FileError`; only interruptions escape. Of warnings only those of
    contiga are kept.
    """
    content: Any = None
    error: Exception | None = None
    trace = ""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            module, _, name = request.target.partition(":")
            content = getattr(import_module(module), name)(request.path, *request.args)
        except (ContigaError, ImportError) as refusal:
            error = refusal
        except MemoryError:
            error = too_large(str(request.path), request.memory)
        except Exception as failure:
            message = " ".join(f"{type(failure).__name__} {failure}".split())[:_MAX_MESSAGE]
            trace = traceback.format_exc()
            error = FileError(
                f"cannot be read: {message}",
                where=str(request.path),
                allowed=f"an undamaged {request.path.suffix} file",
            )
    messages = [str(item.message) for item in caught if issubclass(item.category, ContigaWarning)]
    return Outcome(content, error, trace, tuple(messages))


def _limit(seconds: float, memory: int | None = None) -> None:
    """Limit this process to `seconds` more of processor time and `memory` more bytes (Linux).

    Core dumps are switched off. Limits that the system refuses are left out; on Windows all are.
    """
    if os.name != "posix":  # the caller watches the clock
        return
    import resource

    usage = resource.getrusage(resource.RUSAGE_SELF)
    limits = {
        resource.RLIMIT_CPU: int(usage.ru_utime + usage.ru_stime + seconds) + 1,
        resource.RLIMIT_CORE: 0,
    }
    if memory is not None and sys.platform == "linux":
        limits[resource.RLIMIT_AS] = _process_memory()[0] + memory
    for limit, value in limits.items():
        hard = resource.getrlimit(limit)[1]
        with contextlib.suppress(OSError, ValueError):
            resource.setrlimit(limit, (value if hard < 0 else min(value, hard), hard))


def _process_memory() -> tuple[int, int]:
    """Return the virtual and the resident size of this process, bytes (Linux; elsewhere 0)."""
    if sys.platform != "linux":
        return 0, 0
    virtual, resident, *_ = Path("/proc/self/statm").read_text(encoding="ascii").split()
    size = os.sysconf("SC_PAGE_SIZE")
    return int(virtual) * size, int(resident) * size
