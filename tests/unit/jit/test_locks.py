"""What several processes would do one of them does; one that dies or stands still blocks none."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

from contiga.jit import locks
from contiga.jit.locks import alone

HOLD = """
import sys, time
from pathlib import Path
from contiga.jit.locks import alone

with alone(Path(sys.argv[1]), "kernel"):
    print("held", flush=True)
    time.sleep(60.0)
"""
COMPILE = """
import sys, time
from pathlib import Path

folder = Path(sys.argv[1])
sys.path.insert(0, str(folder))
from numba.core import event
from numba.core.caching import IndexDataCacheFile
from contiga.jit.pipeline import KernelCompiler
from contiga.jit.stamps import PACKAGES

PACKAGES.append(folder / "tiny")
from tiny.outer import inmost, outer

own = KernelCompiler.compile_extra

def slow(self, function):
    time.sleep(0.5)
    return own(self, function)

KernelCompiler.compile_extra = slow
save = IndexDataCacheFile._save_index

def slow_save(self, read):
    time.sleep(0.3)
    save(self, read)

IndexDataCacheFile._save_index = slow_save
counts = {"compiled": 0, "waited": 0}

class Count(event.Listener):
    def on_start(self, found):
        counts["compiled" if "dispatcher" in found.data else "waited"] += 1

    def on_end(self, found):
        pass

event.register("numba:compile", Count())
print("ready", flush=True)
sys.stdin.readline()
value = outer(2) if sys.argv[2] == "int" else outer(2.0)
print(value, counts["compiled"], counts["waited"], flush=True)
"""
TINY = """
from contiga.jit import inner, kernel


@inner()
def inmost(x):
    return 3 * x


@kernel(linked=True)
def outer(x):
    return inmost(x) + 1
"""


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """The folder of a package of a kernel and one that it calls."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "outer.py").write_text(TINY)
    return tmp_path


@contextmanager
def holder(folder: Path):
    """A process that holds the lock of "kernel"."""
    run = [sys.executable, "-c", HOLD, str(folder)]
    with subprocess.Popen(run, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout.readline() == "held\n"
            yield process
        finally:
            process.kill()


def at_once(folder: Path, *kinds: str) -> list[list[str]]:
    """What processes print that call a kernel at the same time."""
    env = {k: v for k, v in os.environ.items() if k != "NUMBA_DISABLE_JIT"}
    env |= {"NUMBA_CACHE_DIR": str(folder / "kept")}
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "env": env}
    runs = [
        subprocess.Popen([sys.executable, "-c", COMPILE, str(folder), kind], **pipes)
        for kind in kinds
    ]
    for run in runs:
        assert run.stdout.readline() == "ready\n"
    for run in runs:
        run.stdin.write("\n")
        run.stdin.flush()
    return [run.communicate()[0].split() for run in runs]


def test_two_processes_that_want_a_kernel_compile_it_once(tiny: Path) -> None:
    one, other = sorted(at_once(tiny, "int", "int"), key=lambda found: found[1])
    assert one == ["7", "0", "1"]
    assert other == ["7", "2", "0"]


def test_two_versions_of_a_kernel_made_at_once_are_both_kept(tiny: Path) -> None:
    assert [found[:2] for found in at_once(tiny, "int", "float")] == [["7", "2"], ["7.0", "2"]]
    assert at_once(tiny, "int", "float") == [["7", "0", "0"], ["7.0", "0", "0"]]


def test_one_waits_for_another_and_says_so(tmp_path: Path) -> None:
    said = []

    @contextmanager
    def waiting():
        said.append("begins")
        yield
        said.append("ends")

    with holder(tmp_path) as process:
        with alone(tmp_path, "another kernel", waiting):
            assert not said
        threading.Timer(0.3, process.kill).start()  # nothing frees its locks but its death
        with alone(tmp_path, "kernel", waiting, patience=60.0):
            assert process.wait() == -signal.SIGKILL
    assert said == ["begins", "ends"]
    assert [file.name for file in tmp_path.iterdir()] == [locks.FILE]


def test_one_that_stands_still_is_not_waited_for_without_end(tmp_path: Path) -> None:
    start = time.monotonic()
    with holder(tmp_path), alone(tmp_path, "kernel", patience=0.2):
        pass
    assert time.monotonic() - start < 30.0


def test_without_locks_all_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with alone(tmp_path / "not there", "kernel"):
        pass

    def refuse(*_: object) -> None:
        raise OSError(37, "no locks available")

    monkeypatch.setattr(locks, "_lock", refuse)
    with alone(tmp_path, "kernel"):
        pass


def test_a_lock_is_let_go_after_an_error(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), alone(tmp_path, "kernel"):
        raise ZeroDivisionError
    with holder(tmp_path):
        pass
