"""Kernels that make no arrays count no references; those that do give all of theirs back."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import config, njit
from numba.core.runtime import _nrt_python, rtsys

from contiga.jit import inner, kernel
from contiga.jit.pipeline import KernelCompiler
from contiga.jit.scratch import scratch
from contiga.pointer_records import pass_by_pointer

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")


@pass_by_pointer
class Tables(NamedTuple):
    net: np.ndarray
    spans: np.ndarray
    size: float


def tables() -> Tables:
    return Tables(np.arange(12.0).reshape(4, 3), np.array([[0, 2], [2, 4]]), 2.0)


def counts(of: Any, *args: Any) -> bool:
    """Whether the code of a kernel counts references; compiled anew, as kept code is not shown."""
    anew = njit(pipeline_class=KernelCompiler)(of.py_func)
    anew(*args)
    return any("NRT_" in text for text in anew.inspect_llvm().values())


@inner()
def _row(t, k):
    """Sum of a row."""
    row = t.net[k]
    return row[0] + row[1] + row[2]


@kernel()
def reads(t, parts, k):
    """All that a kernel does with tables that it is handed, and none of it makes an array."""
    net, (values, flags) = t.net, parts
    work = scratch(3)
    total = 0.0
    for i in range(net.shape[0]):
        for c in range(3):
            work[c] = t.size * net[i, c]
        some = values if flags[0] else net[i]
        inside = net[1:3, ...]
        total += _row(t, i) + work[2] + some[0] + inside[k, 0]
    for span in t.spans:
        total += span[1]
    return total


def test_what_is_handed_on_is_not_counted() -> None:
    t, values, flags = tables(), np.array([5.0, 6.0]), np.array([True, False])
    held = [sys.getrefcount(array) for array in (t.net, t.spans, values, flags)]
    expected = t.net.sum() + 2.0 * t.net[:, 2].sum() + 4 * (5.0 + t.net[2, 0]) + 6.0
    for _ in range(5):
        assert reads(t, (values, flags), 1) == expected
    assert [sys.getrefcount(array) for array in (t.net, t.spans, values, flags)] == held
    assert not counts(reads, t, (values, flags), 1)


@kernel()
def makes(x, which):
    own = np.empty(x.shape[0])
    for k in range(x.shape[0]):
        own[k] = 2.0 * x[k]
    return own[0] + own[-1]


@inner(linked=False)
def _made(x):
    return 2.0 * x


@kernel()
def is_given(x, which):
    other = _made(x)
    return other[0] + other[-1]


@kernel()
def picks(x, which):
    some = x[x > 0.0]
    return some[0] + some[-1]


@kernel()
def picks_rows(x, which):
    some = x[which]
    return some[0] + some[-1]


@kernel()
def overwrites(x, which):
    x[1:] = x[:-1]
    return x[0] + x[-1]


@kernel()
def lists(x, which):
    some = [x, x]
    return some[0][0] + some[1][-1]


@kernel()
def in_a_tuple(x, which):
    pair = (x, np.array([1.0, 2.0]))
    return pair[0][0] + pair[1][-1]


@kernel()
def answers(x, which):
    return x[1:]


OWNERS = {
    makes: 10.0,
    is_given: 10.0,
    picks: 5.0,
    picks_rows: 5.0,
    overwrites: 3.0,
    lists: 5.0,
    in_a_tuple: 3.0,
    answers: [2.0, 4.0],
}


@pytest.fixture
def stats() -> Iterator[Callable[[], Any]]:
    """Asks numba how much memory its arrays have taken and given back."""
    _nrt_python.memsys_enable_stats()
    yield rtsys.get_allocation_stats
    _nrt_python.memsys_disable_stats()


@pytest.mark.parametrize(("of", "answer"), OWNERS.items(), ids=[o.__name__ for o in OWNERS])
def test_what_is_made_is_given_back(of: Any, answer: Any, stats: Callable[[], Any]) -> None:
    which = np.array([0, 2])

    def said() -> Any:
        return of(np.array([1.0, 2.0, 4.0]), which)

    np.testing.assert_array_equal(said(), answer)
    before = stats()
    for _ in range(100):
        said()
    after = stats()
    assert after.alloc - before.alloc == after.free - before.free
    assert after.mi_alloc - before.mi_alloc == after.mi_free - before.mi_free
    assert counts(of, np.array([1.0, 2.0, 4.0]), which)


def test_an_array_that_is_answered_outlives_the_one_it_is_a_part_of() -> None:
    part = answers(np.arange(1000.0), np.array([0]))
    others = [np.full(1000, -1.0) for _ in range(100)]
    np.testing.assert_array_equal(part, np.arange(1.0, 1000.0))
    assert len(others) == 100
