"""Processes that go through exercises, each taking the next one when it is done with its last.

Once there is none left, each compiles the fallbacks of the kernels that it has by then.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Self

from contiga.warmup import LAST

_BOOT = (
    "import json, sys; sys.path[:] = json.loads(sys.stdin.readline()); "
    "from contiga.warmup.worker import serve; serve()"
)
Hear = Callable[[int, dict[str, Any]], None]
"""Called with the number of a process and what it tells, on a thread for each process."""


def _unheard(process: int, told: dict[str, Any]) -> None:
    """Nobody listens."""


class Crew:
    """Processes at work.

    Parameters
    ----------
    names : exercises, in the order they are handed out
    jobs : how many processes
    hear : told what they say: ``compiling`` a kernel, having ``compiled`` one, ``done`` with an
        exercise, or ``lost``: the process ended in it
    """

    def __init__(self, names: Sequence[str], jobs: int, hear: Hear = _unheard) -> None:
        self._waiting = deque(names)
        self._hear = hear
        self._ended = False
        self._processes: list[subprocess.Popen[str]] = []
        self._threads: list[threading.Thread] = []
        for number in range(min(jobs, len(names))):
            process = _started()
            self._processes.append(process)
            keep = threading.Thread(target=self._keep_busy, args=(number, process), daemon=True)
            self._threads.append(keep)
            keep.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def wait(self) -> None:
        """Until all exercises are done."""
        for thread in self._threads:
            thread.join()

    def end(self) -> None:
        """End them, whatever they are at."""
        self._ended = True
        self._waiting.clear()
        for process in self._processes:
            process.kill()
        for process in self._processes:
            process.wait()
        self.wait()

    def _keep_busy(self, number: int, process: subprocess.Popen[str]) -> None:
        """Hand one exercise after the other to a process, and hear what it says."""
        assert process.stdin is not None
        assert process.stdout is not None
        with contextlib.suppress(OSError), process.stdin, process.stdout:
            self._say(process, json.dumps(_modules()))
            for name in self._handed_out():
                if not self._one(number, process, name):
                    code = process.wait()
                    if not self._ended:
                        self._hear(number, {"lost": name, "code": code})
                    return

    def _handed_out(self) -> Iterator[str]:
        """What one process does: what it takes of what is waiting, and the last of all."""
        with contextlib.suppress(IndexError):
            while True:
                yield self._waiting.popleft()
        yield LAST

    def _one(self, number: int, process: subprocess.Popen[str], name: str) -> bool:
        """Whether the process came to the end of an exercise."""
        assert process.stdout is not None
        self._say(process, name)
        for line in process.stdout:
            told = json.loads(line)
            self._hear(number, told)
            if "done" in told:
                return True
        return False

    @staticmethod
    def _say(process: subprocess.Popen[str], line: str) -> None:
        """A line to a process; one that is gone does not answer."""
        assert process.stdin is not None
        with contextlib.suppress(OSError):
            process.stdin.write(line + "\n")
            process.stdin.flush()


def _started() -> subprocess.Popen[str]:
    one = dict.fromkeys(("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    return subprocess.Popen(
        [sys.executable, "-P", "-c", _BOOT],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        encoding="utf-8",
        env={**os.environ, **one},
        creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
    )


def _modules() -> list[str]:
    """Where this process finds its modules."""
    return [os.path.abspath(entry) for entry in sys.path]
