"""Processes that compile the kernels of a list, each taking the next one when it is done."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Self

from contiga.warmup.listing import Row, listing
from contiga.warmup.plan import Plan

_BOOT = (
    "import json, sys; sys.path[:] = json.loads(sys.stdin.readline()); "
    "from contiga.warmup.worker import serve; serve()"
)


class Progress(NamedTuple):
    """Start or end of compiling a kernel."""

    row: Row
    done: bool = False
    """Whether compiling has ended."""
    is_compiled: bool = False
    """Whether it was compiled, and not cached already."""
    file: str = ""
    """Its cache file; empty if it is not cached."""
    error: str = ""
    """Error message; empty without an error."""


Hear = Callable[[int, Progress], None]
"""Called with the number of a process and its message, on a thread for each process."""


class CompilePool:
    """Processes at work on the kernels of the package's list.

    Parameters
    ----------
    jobs : number of processes
    hear : called with their messages
    plan : kernels to compile; all if omitted
    environment : environment of the processes; that of this one if omitted
    """

    def __init__(
        self,
        jobs: int,
        hear: Hear = lambda process, progress: None,
        plan: Plan | None = None,
        environment: Mapping[str, str] = os.environ,
    ) -> None:
        self._plan = plan or Plan([kernel.parts for kernel in listing().kernels])
        self._own_rows: set[Row] = set()
        """Rows that this process compiles itself."""
        self._hear = hear
        self._processes: list[subprocess.Popen[str]] = []
        self._threads: list[threading.Thread] = []
        for number in range(jobs):
            process = _start_process(environment)
            self._processes.append(process)
            thread = threading.Thread(target=self._keep_busy, args=(number, process), daemon=True)
            self._threads.append(thread)
            thread.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def wait(self) -> None:
        """Wait until all kernels of the plan are finished, or all processes have ended."""
        for thread in self._threads:
            thread.join()

    def end(self) -> None:
        """Kill the processes, whatever they compile, and wait for them and their threads."""
        self._plan.end()
        for process in self._processes:
            process.kill()
        for process in self._processes:
            process.wait()
        self.wait()

    def before(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """Compile the parts of a kernel that this process is about to compile.

        Other processes may compile some of the parts, or the kernel itself; while they do, this
        process compiles other ready kernels, or waits. A kernel that is not listed, or that this
        process compiles already, is left alone. Errors of parts are suppressed.
        """
        row = listing().find(module, name, arguments)
        if row is None or row in self._own_rows:
            return
        while (next_row := self._plan.take_towards(row)) is not None:
            self._own_rows.add(next_row)
            if next_row == row:
                return
            with contextlib.suppress(Exception):  # the caller that needs it gets the error
                listing().compile(next_row)
            self._plan.done(next_row)

    def after(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """Mark a kernel, if it is listed, as compiled or as impossible to compile."""
        row = listing().find(module, name, arguments)
        if row is not None:
            self._plan.done(row)

    def _keep_busy(self, number: int, process: subprocess.Popen[str]) -> None:
        """Send a process one kernel after the other, and call `hear` before and after each.

        It returns when the plan or the process ends; the kernel at which a process ended gets an
        error and is not tried again.
        """
        requests, replies = process.stdin, process.stdout
        assert requests is not None
        assert replies is not None

        def send(line: str) -> None:
            with contextlib.suppress(OSError):  # an ended process gives no reply
                requests.write(line + "\n")
                requests.flush()

        with contextlib.suppress(OSError), requests, replies:
            send(json.dumps([os.path.abspath(entry) for entry in sys.path]))
            while (row := self._plan.take()) is not None:
                self._hear(number, Progress(row))
                send(str(row))
                if reply := replies.readline():
                    progress = Progress(row, True, **json.loads(reply))
                else:
                    error = f"its process ended with code {process.wait()}"
                    progress = Progress(row, True, error=error)
                self._plan.done(row)
                self._hear(number, progress)
                if process.poll() is not None:
                    return


def _start_process(environment: Mapping[str, str]) -> subprocess.Popen[str]:
    """Start a worker on one thread, with pipes for requests and replies; its errors are dropped."""
    threads = dict.fromkeys(("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    return subprocess.Popen(
        [sys.executable, "-P", "-c", _BOOT],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        encoding="utf-8",
        env={**environment, **threads},
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )
