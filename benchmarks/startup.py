"""What starting costs: the first run on a machine, and one whose kernels are cached."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from time import perf_counter

from benchmarks.sizes import Sizes
from benchmarks.table import Row, not_measured

ROOT = Path(__file__).resolve().parents[1]
DEMO = ROOT / "examples" / "01_headform.toml"
PART = ROOT / "examples" / "generated" / "headform.step"
FIRST = Row("first run of the demo, empty cache", "s", 45.0, None)
COMPILE = Row("of it, compiling", "s", 30.0, None)
SECOND = Row("second start of the demo, to its first step", "s", 4.0, None)
INFO = Row("contiga info of its part, 18 faces", "s", 1.5, None)
RUNS = 5
TO_FIRST_STEP = """
import os, sys

from contiga.cli import main
from contiga.running import run_case

run_case.Progress.step = lambda self, done, steps, contacts: os._exit(0)
sys.argv[1:] = ["run", sys.argv[1], "-o", sys.argv[2], "--quiet"]
main()
"""
"""``contiga run``, ended where it tells of its first step."""


def _seconds(*arguments: str, cache: str | None = None) -> tuple[float, float]:
    """Of a command of Python's from its start to its end: by the clock, and of processors."""
    environment = dict(os.environ) | ({} if cache is None else {"NUMBA_CACHE_DIR": cache})
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # compiled modules are kept, as ever
    start, before = perf_counter(), os.times()
    subprocess.run(
        [sys.executable, *arguments],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=environment,
    )
    after = os.times()
    spent = after.children_user + after.children_system
    return perf_counter() - start, spent - before.children_user - before.children_system


def first(_: Sizes) -> Iterator[Row]:
    """The demo with an empty cache: total, and share of compiling."""
    if not PART.is_file():
        yield from (not_measured(row, _NO_PART) for row in (FIRST, COMPILE))
        return
    with tempfile.TemporaryDirectory() as folder:
        cache, out = str(Path(folder) / "cache"), Path(folder) / "out"
        total, spent = _seconds(
            *("-m", "contiga", "run", str(DEMO), "-o", str(out), "--quiet"), cache=cache
        )
        summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
        kernels = len(list(Path(cache).rglob("*.nbi")))
    timings = {key: round(value, 2) for key, value in summary["timings"].items()}
    note = f"{spent:.0f} s of processor time, {kernels} kernels"
    yield FIRST._replace(value=total, note=note, detail={"timings": timings})
    yield COMPILE._replace(value=float(summary["timings"]["compile"]))


def second(_: Sizes) -> Iterator[Row]:
    """A run that ends with its first step, and what a file holds."""
    if not PART.is_file():
        yield from (not_measured(row, _NO_PART) for row in (SECOND, INFO))
        return
    with tempfile.TemporaryDirectory() as folder:
        run = ("-c", TO_FIRST_STEP, str(DEMO), folder)
        info = ("-m", "contiga", "info", str(PART))
        for row, command in ((SECOND, run), (INFO, info)):
            _seconds(*command)  # whatever is not cached yet
            found = [_seconds(*command) for _ in range(RUNS)]
            times, spent = sorted(t for t, _ in found), median(c for _, c in found)
            note = (
                f"median of {RUNS}, from {times[0]:.2f} to {times[-1]:.2f} s; "
                f"{spent:.2f} s of processor time"
            )
            detail = {"seconds": times, "processor": spent}
            yield row._replace(value=median(times), note=note, detail=detail)


_NO_PART = "make demo generates its part first"
