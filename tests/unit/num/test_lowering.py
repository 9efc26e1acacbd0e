"""Kernels written with values: they do what Python does, and with less written for it."""

from __future__ import annotations

from collections.abc import Callable
from sys import getrefcount
from typing import Any

import llvmlite.ir as ll
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from llvmlite.ir import builder as llvm_builder
from numba import njit

from contiga.num.compiler import InnerCompiler, KernelCompiler
from contiga.num.lowering import Builder, Values

compiled = njit(pipeline_class=KernelCompiler, error_model="numpy")
inner = njit(pipeline_class=InnerCompiler, error_model="numpy", no_cpython_wrapper=True)
"""Kernels that are kept nowhere: each test compiles its own."""
INT = ll.IntType(64)
PAIR = ll.LiteralStructType([INT, ll.LiteralStructType([INT, INT])])
NODE = np.dtype([("link", "i4", (3, 2)), ("mark", "i1"), ("at", "f8", 3)])
small = st.integers(-4, 4)
COMPILES = settings(deadline=None, derandomize=True)
"""The first example compiles, on a busy machine for seconds."""


def _builder() -> Builder:
    function = ll.Function(ll.Module(), ll.FunctionType(INT, [PAIR, INT, INT]), "f")
    return Builder(function.append_basic_block())


def test_a_member_of_what_was_put_together_is_what_went_in() -> None:
    builder = _builder()
    pair, a, b = builder.function.args
    one = builder.insert_value(pair, a, 0)
    both = builder.insert_value(one, b, (1, 1))
    count = len(builder.block.instructions)
    assert builder.extract_value(both, 0) is a
    assert builder.extract_value(both, [1, 1]) is b
    assert len(builder.block.instructions) == count
    # Of the argument itself nothing is known; a part that was changed within is put together.
    assert builder.extract_value(both, (1, 0)).aggregate is pair
    assert builder.extract_value(both, 1).aggregate is both
    inside = builder.insert_value(pair, builder.extract_value(both, 1), 1)
    assert builder.extract_value(inside, (1, 1)).indices == [1]


@pytest.mark.parametrize("content", [ll.Undefined, None])
def test_members_of_nothing(content: Any) -> None:
    found = _builder().extract_value(ll.Constant(PAIR, content), (1, 0))
    assert isinstance(found, ll.Constant)
    assert found.type == INT
    assert found.constant == ll.Constant(INT, content).constant


def _written(monkeypatch: pytest.MonkeyPatch, function: Callable[..., Any], *args: Any) -> int:
    """How many instructions are written for a kernel and its way in from Python."""
    count = 0
    own = llvm_builder.IRBuilder._insert

    def counted(self: Any, instruction: Any) -> Any:
        nonlocal count
        count += 1
        return own(self, instruction)

    with monkeypatch.context() as patch:
        patch.setattr(llvm_builder.IRBuilder, "_insert", counted)
        compiled(function)(*args)
    return count


def _product(a, b, out):
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            value = 0.0
            for k in range(a.shape[1]):
                value += a[i, k] * b[k][j]
            out[i, j] = value


def test_half_as_much_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    a, b, out = np.ones((3, 4)), np.ones((4, 5)), np.zeros((3, 5))
    few = _written(monkeypatch, _product, a, b, out)
    assert np.array_equal(out, a @ b)
    find = Values._find_singly_assigned_variable

    def all_places(self: Any) -> None:
        find(self)
        self._lean = False

    monkeypatch.setattr(Values, "_find_singly_assigned_variable", all_places)
    many = _written(monkeypatch, _product, a, b, out)
    assert few < 0.6 * many


@compiled
def _picked(a, i, j):
    return a[i, j], a[i][j], a[-1, 0], a[i, -2], a[0, 1]


@COMPILES
@given(small, small)
@pytest.mark.parametrize("order", ["C", "F", "A"])
def test_items_of_arrays(order: str, i: int, j: int) -> None:
    whole = np.arange(80.0).reshape(8, 10, order="F" if order == "F" else "C")
    a = whole[::2, ::2] if order == "A" else whole[:4, :5].copy(order=order)  # type: ignore[call-overload]
    if -4 <= i < 4:
        assert _picked(a, i, j) == _picked.py_func(a, i, j)


@compiled
def _set(a, i, j, value):
    a[i, j] = value
    row = a[i]
    row[j] += a[i, j]
    a[-1][-1] = 7
    a[0] = value - 1
    return row.shape[0], a[1:].shape, row.size, row.strides[0]


@COMPILES
@given(small, small)
@pytest.mark.parametrize("order", ["C", "F"])
@pytest.mark.parametrize("kind", [np.float64, np.int32, np.bool_])
def test_items_that_are_written(kind: Any, order: Any, i: int, j: int) -> None:
    one, other = (np.zeros((5, 6), kind, order=order) for _ in range(2))
    if kind is np.bool_:
        one[i, j] = other[i, j] = True
        return
    assert _set(one, i, j, 3) == _set.py_func(other, i, j, 3)
    assert np.array_equal(one, other)


@compiled
def _of_records(table, e, s):
    total = table[e]["at"][s] + table[e]["link"][s, 1] + table[e]["link"][-1][0]
    return total + table["mark"][e] + table[-1]["at"].shape[0] + table[e]["link"].size


def test_arrays_in_records() -> None:
    table = np.zeros(4, NODE)
    table["link"] = np.arange(24).reshape(4, 3, 2)
    table["at"], table["mark"] = np.arange(12.0).reshape(4, 3) / 8, [1, 0, 1, 0]
    for e in range(-4, 4):
        for s in range(3):
            assert _of_records(table, e, s) == _of_records.py_func(table, e, s)


@compiled
def _through_ranges(start, stop, step):
    seen = 0
    last = -100
    for i in range(start, stop):
        if i == 3:
            continue
        last = i
        seen = 10 * seen + i
        if i == 4:
            break
    else:
        seen += 1000
    for i in range(stop, start, -1):
        seen += 11 * i
    for i in range(start, stop, 2):
        seen += 13 * i
    for i in range(start, stop, step):
        seen += 7 * i
        for j in range(i):
            last += j
            i = -j
        seen += i
    both = range(stop)
    return seen, last, sum([i for i in both]) + len(both)  # noqa: C416


@COMPILES
@given(small, small, st.sampled_from([-3, -1, 1, 2, 3]))
def test_ranges(start: int, stop: int, step: int) -> None:
    assert _through_ranges(start, stop, step) == _through_ranges.py_func(start, stop, step)


def test_a_range_of_no_step_is_refused() -> None:
    with pytest.raises(ValueError, match="must not be zero"):
        _through_ranges(0, 3, 0)


@compiled
def _late(a, n):
    """Variables that some ways give a value, and some do not; a swap; one used after its loop."""
    found = -1
    x, y = a[0], a[1]
    k = 0
    while k < n:
        twice = 2 * k
        x, y = y, x + twice
        if x > 5:
            found = twice
            if y > 40:
                break
        k += 1
    return found, x, y, k


@compiled
def _on_some_ways(a):
    if a > 0:
        half = a / 2
    if a > 1:
        return half
    return 0.0


@COMPILES
@given(small)
def test_variables_that_some_ways_give_none(a: int) -> None:
    assert _on_some_ways(a) == _on_some_ways.py_func(a)


@COMPILES
@given(st.integers(0, 9), small, small)
def test_variables_of_several_values(n: int, x: int, y: int) -> None:
    a = np.array([x, y])
    assert _late(a, n) == _late.py_func(a, n)


@inner
def _checked(values, k):
    if values[k] < 0.0:
        raise ValueError("a negative value")
    return np.sqrt(values[k])


@inner
def _sum_of(values):
    total = 0.0
    for k in range(len(values)):
        total += _checked(values, k)
    return total


@compiled
def _sums(both):
    return _sum_of(both[0]) + _sum_of(both[1])


@compiled
def _sums_of_copies(both):
    """The same with arrays that are counted."""
    first = both[0].copy()
    second = both[1] + 1.0
    return _sum_of(first) + _sum_of(second)


@pytest.mark.parametrize("kernel", [_sums, _sums_of_copies])
def test_errors_go_up_through_all_callers(kernel: Any) -> None:
    good, bad = np.array([1.0, 4.0]), np.array([1.0, -4.0])
    assert np.isfinite(kernel((good, good)))
    for _ in range(3):
        with pytest.raises(ValueError, match="a negative value"):
            kernel((good, bad))
        with pytest.raises(ValueError, match="a negative value"):
            kernel((bad, good))
    assert np.isfinite(kernel((good, good)))


@compiled
def _caught(values):
    try:
        return _sum_of(values)
    except Exception:
        return -1.0


def test_a_kernel_that_catches_errors_is_written_as_numba_has_it() -> None:
    assert _caught(np.array([4.0])) == 2.0
    assert _caught(np.array([-4.0])) == -1.0


@compiled
def _found(values, of):
    for value in values:
        if value == of:
            return value
    return None


def test_what_may_be_nothing() -> None:
    assert _found(np.array([1.0, 2.0]), 2.0) == 2.0
    assert _found(np.array([1.0, 2.0]), 3.0) is None


@compiled
def _of_what_may_be(values):
    return _found(values, 2.0) is None


def test_nothing_from_a_kernel() -> None:
    assert _of_what_may_be(np.array([1.0]))
    assert not _of_what_may_be(np.array([2.0]))


def test_references_are_given_back() -> None:
    a = np.ones(3)
    kept = [_sums_of_copies((a, a)) for _ in range(100)]
    assert len(set(kept)) == 1
    assert getrefcount(a) == 2


@compiled
def _parts(a, n):
    """Views kept over loops, in kernels that count and make arrays."""
    best = a[0]
    made = np.zeros((n, a.shape[1]))
    kept = made[0]
    for k in range(n):
        row = a[k]
        made[k] += row
        kept = made[k]
        if row[0] > best[0]:
            best = row
    made = made[:1].copy()
    return best, made, kept


def test_views_outlive_their_loop() -> None:
    a = np.array([[1.0, 2.0], [5.0, 6.0], [3.0, 4.0]])
    best, made, kept = _parts(a, 3)
    assert np.array_equal(best, a[1])
    assert np.array_equal(made, a[:1])
    assert np.array_equal(kept, a[2])
    assert getrefcount(a) == 3
    del best
    assert getrefcount(a) == 2
