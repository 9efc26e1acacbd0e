"""Checkpoints damaged at random, and runs killed at random moments.

A damaged checkpoint is told in one message and never gone on from; a killed run goes on with the
bits of one that was let alone.
"""

from __future__ import annotations

import os
import shutil
import signal
import tempfile
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np
from tests.stress.tally import Clock, Tally
from tests.unit.simulation.conftest import StopError, make_simulation
from tests.unit.simulation.sameness import same_history, same_output

import contiga as cg
from contiga.errors import CheckpointError
from contiga.simulation import recorder
from contiga.simulation.checkpoint import read_checkpoint

SECTOR = 512


@contextmanager
def _after_every_step() -> Iterator[None]:
    """Checkpoints are left behind every step."""
    own = recorder.CHECKPOINT_SECONDS
    recorder.CHECKPOINT_SECONDS = -1.0
    try:
        yield
    finally:
        recorder.CHECKPOINT_SECONDS = own


def damaged(content: bytes, rng: np.random.Generator) -> bytes:
    """A file with a sector zeroed, bits flipped, or its end cut off, somewhere."""
    bytes_, at = bytearray(content), int(rng.integers(len(content)))
    kind = rng.integers(3)
    if kind == 0:
        first = at - at % SECTOR
        bytes_[first : first + SECTOR] = bytes(len(bytes_[first : first + SECTOR]))
    elif kind == 1:
        for place in rng.integers(len(content), size=rng.integers(1, 4)):
            bytes_[place] ^= 1 << int(rng.integers(8))
    else:
        del bytes_[at:]
    return bytes(bytes_)


def damage(count: int, seed: int) -> Tally:
    """So many damaged checkpoints of one stopped run."""

    def stop(done: int, *_: int) -> None:
        if done == 7:
            raise StopError

    rng, simulation = np.random.default_rng(seed), make_simulation()
    with Clock(Tally("damaged checkpoints")) as tally, tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        with _after_every_step(), suppress(StopError):
            simulation.run(out, progress=stop)
        path = out / "checkpoint.h5"
        content = path.read_bytes()
        for _ in range(count):
            other = damaged(content, rng)
            if other == content:  # what was zeroed was zero
                tally.doubtful += 1
                continue
            path.write_bytes(other)
            tally.count += 1
            try:
                read_checkpoint(path, simulation)
            except CheckpointError as error:
                if "is damaged; the one before is checkpoint.before.h5" in str(error):
                    tally.flagged += 1
                    continue
            tally.wrong += 1
    return tally


def kill(count: int, seed: int) -> Tally:
    """So many runs killed at random moments, one of four again in its second try."""
    rng = np.random.default_rng(seed)
    with (
        Clock(Tally("killed runs")) as tally,
        tempfile.TemporaryDirectory() as folder,
        _after_every_step(),
    ):
        whole = make_simulation().run(Path(folder) / "whole")
        begun = time.perf_counter()
        _count(tally, _in_process(Path(folder) / "parts", np.inf))
        longest = time.perf_counter() - begun
        for _ in range(count):
            shutil.rmtree(Path(folder) / "parts", ignore_errors=True)
            for _ in range(1 + int(rng.random() < 0.25)):
                _count(tally, _in_process(Path(folder) / "parts", longest * rng.random()))
            tally.count += 1
            try:
                _compare(Path(folder), whole)
            except (AssertionError, cg.errors.ContigaError) as error:
                tally.wrong += 1
                tally.faults.append({"kind": "other results", "text": str(error)[:500]})
        if not tally.notes.get("killed"):
            tally.wrong += 1
            tally.faults.append({"kind": "no run was killed"})
    return tally


def _count(tally: Tally, code: int) -> None:
    """Count how a process has ended: by itself, killed by us, or in an error of its own."""
    tally.note("killed", code == -signal.SIGKILL)
    if code not in (0, -signal.SIGKILL):
        tally.wrong += 1
        tally.faults.append({"kind": "a run failed by itself", "exit code": code})


def _resumable(out: Path) -> bool:
    return any((out / name).is_file() for name in ("checkpoint.h5", "checkpoint.before.h5"))


def _in_process(out: Path, seconds: float) -> int:
    """The exit code of a run in a process of its own, gone on with if it can be, and killed after
    so many seconds."""
    child = os.fork()
    if not child:
        code = 1
        try:
            make_simulation().run(out, resume=_resumable(out))
            code = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(code)
    if np.isfinite(seconds):
        time.sleep(seconds)
        os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _compare(folder: Path, whole: cg.Result) -> None:
    parts = folder / "parts"
    resumed = make_simulation().run(parts, resume=_resumable(parts))
    same_history(whole.history, resumed.history)
    same_output(folder)
    names = [{path.name for path in (folder / k).iterdir()} for k in ("whole", "parts")]
    assert names[0] == names[1], names
