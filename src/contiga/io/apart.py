"""Files read in a process of their own, so that no file can crash, hang or swamp the caller.

`read_apart` asks a child process (`contiga.io.child_process`) and waits for plain records of ours.
What happens to the child becomes one `FileError`: it crashed, took too long, wanted too much
memory. The child is kept for the next file and ends when it has had nothing to do for a minute, or
with this process. Where none can be started, files are read in this process, without bounds.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
import warnings
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from contiga.errors import ContigaWarning, FileError
from contiga.io import child_process
from contiga.io.child_process import Outcome, Request
from contiga.io.limits import limits_for, too_large, too_slow

_BOOT = (
    "import json, sys; sys.path[:] = json.loads(sys.stdin.buffer.readline()); "
    "from contiga.io.child_process import serve; serve()"
)
_START_SECONDS = 60.0
_LOAD_SECONDS = 900.0
"""For loading a reader's libraries, and compiling its kernels once on a machine."""
_KEPT = 2
"""Children kept for the next file: more were at work at a time only for callers with threads."""
_CLOCK_FACTOR = 4.0
"""On a busy machine a second of processor time takes several by the clock."""
_NEAR = 0.7
"""A crash with this share of the memory in use is put down to the bound on memory."""


@contextlib.contextmanager
def _no_broken_pipe_signal() -> Iterator[None]:
    """A pipe whose reader has ended raises here, and does not end this process.

    Python ignores the signal from its start; some libraries (gmsh) and callers let it be deadly
    again. It comes to the thread that writes: there it is held back, and taken if it came.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    broken = {signal.SIGPIPE}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, broken)
    try:
        yield
    finally:
        if not broken & before:
            if broken & signal.sigpending():
                signal.sigwait(broken)
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _GoneError(Exception):
    """The child has ended."""

    def __init__(self, code: int) -> None:
        super().__init__(code)
        self.code = code


class _Child:
    """A child process and the way to speak with it."""

    def __init__(self) -> None:
        quiet = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-c", _BOOT],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **quiet},  # a fork has one thread
            start_new_session=os.name == "posix",  # Ctrl-C is ours to hand on
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        self.expired = False
        try:
            self._write(json.dumps(_modules()).encode() + b"\n")
            with self._ended_after(_START_SECONDS):
                self._frame()
        except BaseException:
            self.end()
            raise

    def ask(self, request: Request, needs: str) -> Outcome:
        """What the child makes of a file.

        Raises
        ------
        _GoneError
            It ended before it had loaded the reader.
        """
        self._send(child_process.ASK, pickle.dumps(request))
        getattr(import_module(needs), "warm_up", lambda: None)()  # while the child is at work
        with self._ended_after(_LOAD_SECONDS):
            kind, content = self._frame()
        if kind == child_process.RESULT:
            return _outcome(content)
        clock = request.seconds * (_CLOCK_FACTOR if os.name == "posix" else 1.0)
        try:
            with self._ended_after(clock):
                kind, content = self._frame()
                if kind == child_process.RESULT and child_process.can_fork():
                    self._frame()
        except _GoneError as gone:
            if self.expired:
                return Outcome("error", too_slow(str(request.path), clock), [])
            return Outcome("error", _ended(request, gone.code, 0), [])
        if kind == child_process.RESULT:
            return _outcome(content)
        status, peak = pickle.loads(content)
        return Outcome("error", _ended(request, os.waitstatus_to_exitcode(status), peak), [])

    def load(self, target: str) -> None:
        """Have the child load a reader, without waiting for it."""
        self._send(child_process.LOAD, target.encode())

    def end(self) -> None:
        """End the child and what it has forked, at once."""
        with contextlib.suppress(OSError):
            if self.process.poll() is None:
                self._kill()
        for stream in (self.process.stdin, self.process.stdout):
            with contextlib.suppress(OSError), _no_broken_pipe_signal():
                if stream is not None:
                    stream.close()  # writes what is left
        self.process.wait()

    def _kill(self) -> None:
        if os.name == "posix":
            os.killpg(self.process.pid, signal.SIGKILL)
        else:
            self.process.kill()

    def forget(self) -> None:
        """Let go of a child that belongs to the process this one was forked from."""
        self.process.returncode = 0

    def _send(self, kind: bytes, content: bytes) -> None:
        self._write(child_process.HEADER.pack(kind, len(content)) + content)

    def _write(self, data: bytes) -> None:
        assert self.process.stdin is not None
        try:
            with _no_broken_pipe_signal():
                self.process.stdin.write(data)
                self.process.stdin.flush()
        except OSError as error:
            raise self._gone() from error

    def _frame(self) -> tuple[bytes, bytes]:
        assert self.process.stdout is not None
        head = self.process.stdout.read(child_process.HEADER.size)
        if len(head) < child_process.HEADER.size:
            raise self._gone()
        kind, size = child_process.HEADER.unpack(head)
        content = self.process.stdout.read(size)
        if len(content) < size:
            raise self._gone()
        return kind, content

    def _gone(self) -> _GoneError:
        return _GoneError(self.process.wait())

    @contextlib.contextmanager
    def _ended_after(self, seconds: float) -> Iterator[None]:
        """End the child if what is done meanwhile takes longer."""

        def expire() -> None:
            self.expired = True
            self._kill()

        timer = threading.Timer(seconds, expire)
        timer.daemon = True
        timer.start()
        try:
            yield
        finally:
            timer.cancel()


class _Idle:
    """Children that wait for the next file."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._children: list[_Child] = []
        self._coming: threading.Thread | None = None
        self._owner = os.getpid()
        self._cannot_start = False

    def prepare(self, target: str) -> None:
        """Have a child load a reader from now on; nothing where one is at hand or coming."""
        if self._coming is None and not self._children:
            self._coming = threading.Thread(target=self._start, args=(target,), daemon=True)
            self._coming.start()

    def _start(self, target: str) -> None:
        child = self._new()
        if child is not None:
            with contextlib.suppress(_GoneError):
                child.load(target)
            self.put(child)

    def take(self) -> _Child | None:
        """A child at hand or a new one; None where none can be started."""
        with self._lock:
            if self._owner != os.getpid():  # they belong to the process this was forked from
                for child in self._children:
                    child.forget()
                self._children, self._coming, self._owner = [], None, os.getpid()
        self._wait()
        with self._lock:
            if self._children:
                return self._children.pop()
        return self._new()

    def _wait(self) -> None:
        """Until the child that is coming is there, which takes as long as Python's start."""
        if self._coming is not None:
            self._coming.join()

    def _new(self) -> _Child | None:
        if self._cannot_start or not _is_python():
            return None
        try:
            return _Child()
        except (OSError, _GoneError):
            self._cannot_start = True
            return None

    def put(self, child: _Child) -> None:
        """Keep a child for the next file, or end it where that is not to be."""
        with self._lock:
            kept = child.process.poll() is None and len(self._children) < _KEPT
            if kept:
                self._children.append(child)
        if not kept:
            child.end()

    def end(self) -> None:
        """End all."""
        if self._owner == os.getpid():
            self._wait()
        with self._lock:
            children, self._children = self._children, []
        if self._owner == os.getpid():
            for child in children:
                child.end()


_idle = _Idle()
atexit.register(_idle.end)


def prepare(target: str) -> None:
    """Have a process load a reader, beside what this one does until a file is to be read.

    Returns at once. What goes wrong with it is told when a file is read.

    Parameters
    ----------
    target : as for `read_apart`
    """
    _idle.prepare(target)


def read_apart(target: str, path: Path, *args: object, needs: str = "numpy") -> Any:
    """Call a reader in a process of its own and hand back what it returns.

    Parameters
    ----------
    target : "module:function", called with `path` and `args`; its module may have a `warm_up`,
        which loads what it needs
    path : the file
    needs : module that the result is made of or looked at with, imported while the file is read;
        its `warm_up` is called if it has one

    Raises
    ------
    FileError
        The reader crashed, took too long, wanted too much memory or failed in a way of its own.
    ContigaError
        What the reader raises.

    Warns
    -----
    ContigaWarning
        What the reader warns of, as if the caller's caller had been warned.
    """
    outcome = ask_apart(target, path, *args, needs=needs)
    for said in outcome.warnings:
        warnings.warn(said, ContigaWarning, stacklevel=3)
    return outcome.value(path)


def ask_apart(target: str, path: Path, *args: object, needs: str = "numpy") -> Outcome:
    """What becomes of a call of `read_apart`, with what the reader warns of; nothing is raised."""
    request = Request(target, path, args, *limits_for(path), _folder(), _modules())
    while True:
        child = _idle.take()
        if child is None:
            return child_process.attempt(target, path, args)
        try:
            outcome = child.ask(request, needs)
        except _GoneError as gone:
            child.end()
            if gone.code != child_process.IDLE_CODE:
                message = f"the libraries that read {path.suffix} files cannot be loaded"
                raise ImportError(f"{message} ({_how(gone.code)})") from gone
        except BaseException:
            child.end()
            raise
        else:
            _idle.put(child)
            return outcome


def _outcome(content: bytes) -> Outcome:
    outcome: Outcome = pickle.loads(content)
    return outcome


def _ended(request: Request, code: int, peak: int) -> FileError:
    """What is said of a file that ended its reader."""
    where = str(request.path)
    if code == -getattr(signal, "SIGXCPU", 0):
        return too_slow(where, request.seconds)
    if code == -getattr(signal, "SIGKILL", 0) or peak > _NEAR * request.memory:
        return too_large(where, request.memory)
    return FileError(
        f"the reader crashed on this file ({_how(code)})",
        where=where,
        allowed=f"an undamaged {request.path.suffix} file",
        remedy=(
            "It is damaged, or uses something that the library which reads it cannot; "
            "export it anew"
        ),
    )


def _how(code: int) -> str:
    """A signal or an exit code in words."""
    try:
        return f"signal {-code}, {signal.Signals(-code).name}"
    except ValueError:
        return f"exit code {code}"


def _is_python() -> bool:
    """Whether ``sys.executable`` is an interpreter, and not a program that embeds one."""
    if getattr(sys, "frozen", False) or not sys.executable:
        return False
    return Path(sys.executable).stem.lower().startswith("python")


def _folder() -> str:
    try:
        return os.getcwd()
    except OSError:  # it was deleted
        return os.curdir


def _modules() -> list[str]:
    return [os.path.abspath(entry) for entry in sys.path if isinstance(entry, str)]
