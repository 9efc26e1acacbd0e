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
    """A receiver of what becomes of a kernel that a process is given."""

    row: Row
    done: bool = False
    """False where it is begun."""
    made: bool = False
    """It was compiled, and not there already."""
    file: str = ""
    """Where it is kept; none where it is not."""
    error: str = ""
    """Why it cannot be had: words, none where it can."""


Hear = Callable[[int, Progress], None]
"""Called with the number of a process and what it tells, on a thread for each process."""


def _unheard(process: int, progress: Progress) -> None:
    """Nobody listens."""


class CompilePool:
    """Processes at work on the kernels of the package's list.

    Parameters
    ----------
    jobs : how many processes
    hear : told what they say
    plan : what is to be done, and by default everything
    environment : of the processes, and by default that of this one
    """

    def __init__(
        self,
        jobs: int,
        hear: Hear = _unheard,
        plan: Plan | None = None,
        environment: Mapping[str, str] = os.environ,
    ) -> None:
        self._plan = plan or _everything()
        self._own: set[Row] = set()
        """What this process has taken itself."""
        self._hear = hear
        self._processes: list[subprocess.Popen[str]] = []
        self._threads: list[threading.Thread] = []
        for number in range(jobs):
            process = _started(environment)
            self._processes.append(process)
            keep = threading.Thread(target=self._keep_busy, args=(number, process), daemon=True)
            self._threads.append(keep)
            keep.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def wait(self) -> None:
        """Until all kernels are there, or no process is left."""
        for thread in self._threads:
            thread.join()

    def end(self) -> None:
        """End them, whatever they are at."""
        self._plan.end()
        for process in self._processes:
            process.kill()
        for process in self._processes:
            process.wait()
        self.wait()

    def before(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """Have the parts of a kernel that this process is about to compile, or the kernel itself.

        This process compiles as well, what others are not at.
        """
        row = listing().find(module, name, arguments)
        if row is None or row in self._own:
            return
        while (taken := self._plan.take_towards(row)) is not None:
            self._own.add(taken)
            if taken == row:
                return
            with contextlib.suppress(Exception):  # whoever needs it hears of it
                listing().compile(taken)
            self._plan.done(taken)

    def after(self, module: str, name: str, arguments: tuple[Any, ...]) -> None:
        """A kernel is there, or cannot be compiled."""
        row = listing().find(module, name, arguments)
        if row is not None:
            self._plan.done(row)

    def _keep_busy(self, number: int, process: subprocess.Popen[str]) -> None:
        """Hand one kernel after the other to a process, and hear what it says."""
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(OSError), process.stdin, process.stdout:
            self._say(process, json.dumps(_modules()))
            while (row := self._plan.take()) is not None:
                self._hear(number, Progress(row))
                progress = self._one(process, row)
                self._plan.done(row)
                self._hear(number, progress)
                if process.poll() is not None:
                    return

    def _one(self, process: subprocess.Popen[str], row: Row) -> Progress:
        """Handle what a process says of a kernel, once it is done with it."""
        assert process.stdout is not None
        self._say(process, str(row))
        line = process.stdout.readline()
        if line:
            return Progress(row, True, **json.loads(line))
        return Progress(row, True, error=f"its process ended with code {process.wait()}")

    @staticmethod
    def _say(process: subprocess.Popen[str], line: str) -> None:
        """A line to a process; one that is gone does not answer."""
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.write(line + "\n")
            process.stdin.flush()


def _everything() -> Plan:
    return Plan([kernel.parts for kernel in listing().kernels])


def _started(environment: Mapping[str, str]) -> subprocess.Popen[str]:
    one = dict.fromkeys(("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    return subprocess.Popen(
        [sys.executable, "-P", "-c", _BOOT],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        encoding="utf-8",
        env={**environment, **one},
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )


def _modules() -> list[str]:
    """Return where this process finds its modules."""
    return [os.path.abspath(entry) for entry in sys.path]
