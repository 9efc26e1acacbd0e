"""Processes compile what they are given, and end with the one that started them."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from contiga.jit.prebuilt import SWITCH
from contiga.warmup.compile_pool import CompilePool, Progress
from contiga.warmup.listing import listing
from contiga.warmup.plan import Plan

LISTED = listing().kernels


def only(*rows: int) -> Plan:
    """A plan in which nothing else is left."""
    plan = Plan([kernel.parts for kernel in LISTED])
    for row in range(len(LISTED)):
        if row not in rows:
            plan.done(row)
    return plan


def test_a_process_has_a_kernel_and_says_where_it_is_kept() -> None:
    told: list[Progress] = []
    hear, compiling = (lambda _, said: told.append(said)), os.environ | {SWITCH: "0"}
    with CompilePool(1, hear, only(0), compiling) as compile_pool:
        compile_pool.wait()
    begun, done = told
    name = LISTED[0].name
    assert (begun.row, begun.done, done.row, done.done, done.error) == (0, False, 0, True, "")
    assert Path(done.file).is_file()
    assert f".{name}-" in Path(done.file).name


def test_what_cannot_be_compiled_is_told_and_the_next_one_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rooms.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    lost = listing().kernels[0]._replace(module="rooms")
    code = (
        "import contiga.warmup.listing as at; "
        f"at.listing().kernels[0] = at.Listed{tuple(lost)!r}; "
        "from contiga.warmup.worker import compile_row; "
        "print(compile_row(0)); print(compile_row(1))"
    )
    env = os.environ | {"PYTHONPATH": str(tmp_path)}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env)
    first, second = run.stdout.splitlines()
    assert "AttributeError: module 'rooms' has no attribute" in first
    assert "file" in second


RUN = """
    from contiga.jit.cache import COMPILE_LISTENERS
    from contiga.warmup.compile_pool import CompilePool
    from contiga.warmup.listing import listing

    at = next(k for k, one in enumerate(listing().kernels) if one.name == "span_and_basis")
    compile_pool = CompilePool(1)
    COMPILE_LISTENERS.append(compile_pool)
    kernel = listing().compile(at)
    print(len(kernel.overloads), at in compile_pool._plan._unfinished)
    listing().compile(at)
    compile_pool.end()
    print(compile_pool._plan.take())
"""


def test_a_process_compiles_together_with_others(tmp_path: Path) -> None:
    name = next(one.name for one in LISTED if one.parts)
    code = textwrap.dedent(RUN).replace("span_and_basis", name)
    env = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), SWITCH: "0"}
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=env, timeout=300
    )
    assert run.stdout.split() == ["1", "False", "None"], run.stderr
    assert len(list(tmp_path.rglob(f"*.{name}-*.nbc"))) == 1


def test_processes_end_with_the_one_that_started_them() -> None:
    code = (
        "import os, time; from contiga.warmup.compile_pool import CompilePool; "
        "pool = CompilePool(1); "
        "print(pool._processes[0].pid, flush=True); time.sleep(1.0); os._exit(1)"
    )
    run = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid, end = int(run.stdout), time.monotonic() + 60.0
    while time.monotonic() < end:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    pytest.fail("it lives on")
