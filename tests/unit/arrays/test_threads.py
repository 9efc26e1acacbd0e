"""Kernels over ranges of rows: every row once, whatever the number of threads."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from time import sleep

import numpy as np
import pytest
from numba import config

from contiga.arrays import threads


def anew() -> None:
    """Have no helpers left, as at the beginning."""
    if threads._helpers.cache_info().currsize:
        threads._helpers().shutdown()
    threads._helpers.cache_clear()


@pytest.fixture(autouse=True)
def _own_helpers() -> Iterator[None]:
    """Helpers by as many threads as a test says, and none left of it."""
    anew()
    yield
    anew()


def _count(rows: np.ndarray, start: int, stop: int) -> None:
    rows[start:stop] += 1


@pytest.mark.parametrize("n_threads", [1, 2, 5])
@pytest.mark.parametrize("n", [0, 1, 7, 8, 9, 100, 1001])
def test_every_row_is_done_once(monkeypatch: pytest.MonkeyPatch, n: int, n_threads: int) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: n_threads)
    rows = np.zeros(n, dtype=int)
    threads.run_ranges(_count, n, 8, rows)
    assert (rows == 1).all()


def test_ranges_start_at_multiples_of_the_grain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)
    starts: list[int] = []
    threads.run_ranges(lambda start, stop: starts.append(start), 1000, 16)
    assert len(starts) > 2
    assert all(start % 16 == 0 for start in starts)


@pytest.mark.parametrize("n_threads", [1, 3])
def test_calls_on_threads_come_back_in_order_and_hand_on_what_they_raise(
    monkeypatch: pytest.MonkeyPatch, n_threads: int
) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: n_threads)
    assert threads.map_threads(lambda k: k * k, range(50)) == [k * k for k in range(50)]
    with pytest.raises(ZeroDivisionError):
        threads.map_threads(lambda k: 1 // (k - 3), range(5))


def test_calls_within_calls_do_not_wait_for_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads.numba.config, "NUMBA_NUM_THREADS", 2)

    def fill(k: int) -> int:
        rows = np.zeros(1000, dtype=int)
        threads.run_ranges(_count, 1000, 8, rows)
        return int(rows.sum())

    assert threads.map_threads(fill, range(8)) == 8 * [1000]


def test_few_rows_stay_on_the_calling_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)

    rows = np.zeros(8, dtype=int)
    threads.run_ranges(_count, 8, 8, rows)
    assert (rows == 1).all()
    assert not threads._helpers.cache_info().currsize


def test_no_rows_call_no_kernel() -> None:
    threads.run_ranges(lambda start, stop: pytest.fail("called"), 0, 8)


def test_an_error_in_a_kernel_comes_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)

    def fail(start: int, stop: int) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        threads.run_ranges(fail, 100, 8)


@pytest.mark.parametrize("on_the_caller", [True, False])
@pytest.mark.parametrize("error", [IndexError, KeyboardInterrupt])
def test_an_error_comes_out_of_either_thread_and_none_works_on(
    monkeypatch: pytest.MonkeyPatch, error: type[BaseException], on_the_caller: bool
) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)
    caller, failed, ended = threading.current_thread(), threading.Event(), [0]

    def kernel(start: int, stop: int) -> None:
        if (threading.current_thread() is caller) == on_the_caller:
            failed.set()
            raise error
        assert failed.wait(20.0)
        ended[0] += 1

    with pytest.raises(error):
        threads.run_ranges(kernel, 100, 8)
    was = ended[0]
    done = np.zeros(100)
    threads.run_ranges(lambda start, stop: done.__setitem__(slice(start, stop), 1.0), 100, 8)
    assert done.all()
    assert ended[0] == was


def test_the_caller_takes_ranges_and_waits_for_no_thread_that_has_not_begun(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)
    hold = threading.Event()
    threads._helpers().submit(hold.wait, 20.0)
    rows = np.zeros(100, dtype=int)
    threads.run_ranges(_count, 100, 8, rows)
    assert (rows == 1).all()
    assert not hold.is_set()
    assert not hasattr(threads._local, "busy") or not threads._local.busy
    hold.set()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes are forked here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_has_threads_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)
    out = np.zeros(100)

    def kernel(start: int, stop: int) -> None:
        out[start:stop] += 1.0

    threads.run_ranges(kernel, 100, 1)
    child = os.fork()
    if child == 0:
        signal.alarm(20)  # ends a child that waits for threads which are not there
        threads.run_ranges(kernel, 100, 1)
        os._exit(0 if (out == 2.0).all() else 1)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@pytest.mark.parametrize(("n_threads", "n"), [(1, 100), (2, 8), (2, 100)])
def test_what_is_started_beside_gives_its_result(
    monkeypatch: pytest.MonkeyPatch, n_threads: int, n: int
) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: n_threads)
    names: list[str] = []

    def kernel(a: int, b: int) -> int:
        names.append(threading.current_thread().name)
        return a - b

    assert threads.started(kernel, n, 8, 5, 3)() == 2
    assert names[0].startswith("contiga") == (n_threads == 2 and n > 8)


def test_an_error_of_what_is_started_comes_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)

    def fail() -> None:
        raise ZeroDivisionError

    result = threads.started(fail, 100, 8)
    with pytest.raises(ZeroDivisionError):
        result()


def test_ranges_are_done_without_helpers_that_have_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)
    threads._helpers().shutdown()
    rows = np.zeros(100, dtype=int)
    threads.run_ranges(_count, 100, 8, rows)
    assert (rows == 1).all()
    assert threads.started(lambda: 3, 100, 8)() == 3


def test_callers_on_many_threads_share_the_helpers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads.numba.config, "NUMBA_NUM_THREADS", 3)
    sums: list[int] = []

    def call() -> None:
        for _ in range(50):
            rows = np.zeros(200, dtype=int)
            threads.run_ranges(_count, 200, 8, rows)
            sums.append(int(rows.sum()))

    callers = [threading.Thread(target=call) for _ in range(4)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(60.0)
    assert sums == 200 * [200]


@pytest.mark.parametrize("on_the_caller", [True, False])
def test_after_an_error_no_more_ranges_are_begun(
    monkeypatch: pytest.MonkeyPatch, on_the_caller: bool
) -> None:
    monkeypatch.setattr(threads, "thread_count", lambda: 2)
    caller, ended = threading.current_thread(), [0]
    begun, failed = threading.Event(), threading.Event()

    def kernel(start: int, stop: int) -> None:
        if (threading.current_thread() is caller) == on_the_caller:
            assert begun.wait(20.0)
            failed.set()
            raise ZeroDivisionError
        begun.set()
        assert failed.wait(20.0)
        sleep(0.05)
        ended[0] += 1

    with pytest.raises(ZeroDivisionError):
        threads.run_ranges(kernel, 100, 8)
    assert ended[0] <= 2


def test_what_runs_on_a_thread_has_that_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(threads.numba.config, "NUMBA_NUM_THREADS", 2)
    counts: dict[str, int] = {}

    def kernel(start: int, stop: int) -> None:
        sleep(0.01)
        counts[threading.current_thread().name] = threads.thread_count()

    threads.run_ranges(kernel, 100, 8)
    assert len(counts) == 2
    assert set(counts.values()) == {1}
    assert threads.thread_count() == 2


@pytest.mark.skipif(config.DISABLE_JIT, reason="numba starts no threads")
@pytest.mark.parametrize("asked", [1, 2])
def test_threads_are_as_many_as_numba_is_told(asked: int) -> None:
    code = (
        "import numba\nfrom contiga.arrays.threads import thread_count\nprint(thread_count())\n"
        f"numba.set_num_threads({asked})\nprint(thread_count())"
    )
    env = os.environ | {"NUMBA_NUM_THREADS": "2"}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=env)
    assert run.stdout.split() == ["2", str(asked)], run.stderr
