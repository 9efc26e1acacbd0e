"""A number that another thread writes is seen, and who waits for it in vain does not wait long."""

from __future__ import annotations

import threading
from time import monotonic, sleep

import numpy as np
import pytest
from numba import config, njit

from contiga.num.glance import glance
from contiga.num.kernels.watch_nb import watch

FOR_EVER = 10**12


@njit
def glance_at(numbers):
    return glance(numbers)


@pytest.mark.interpreted
def test_a_glance_is_at_the_first_number():
    assert glance_at(np.array([7, 8, 9])) == 7


@pytest.mark.interpreted
def test_who_waits_in_vain_or_for_what_is_there_goes_on():
    count = np.zeros(1, np.int64)
    watch(count, 0, 1000, 0)
    watch(count, 1, FOR_EVER, 10)
    watch(count, 1, 0, FOR_EVER)


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="the interpreter would look for hours")
def test_what_another_thread_writes_is_seen():
    count = np.zeros(1, np.int64)
    thread = threading.Thread(target=watch, args=(count, 0, FOR_EVER, 0), daemon=True)
    thread.start()
    sleep(0.05)
    assert thread.is_alive()
    count[0] += 1
    thread.join(20.0)
    assert not thread.is_alive()


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="the interpreter looks more slowly")
def test_looks_are_taken_after_it_was_seen_too():
    count = np.ones(1, np.int64)

    def seconds(more):
        took = []
        for _ in range(5):
            start = monotonic()
            watch(count, 0, 1, more)
            took.append(monotonic() - start)
        return min(took)

    assert seconds(3 * 10**6) > 3.0 * seconds(10**5)


@pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")
def test_it_is_read_anew_each_time():
    glance_at(np.zeros(1, np.int64))
    assert any("load atomic i64" in code for code in glance_at.inspect_llvm().values())
