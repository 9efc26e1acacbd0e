"""Named tuples that kernels are handed by one pointer."""

from __future__ import annotations

import sys
from typing import NamedTuple

import numpy as np
import pytest
from numba import config, njit, typeof

from contiga.jit import inner, kernel
from contiga.jit.reference import Reference
from contiga.pointer_records import PASSED_BY_POINTER, pass_by_pointer

pytestmark = pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")


class Plain(NamedTuple):
    values: np.ndarray
    counts: np.ndarray


@pass_by_pointer
class Inner(NamedTuple):
    values: np.ndarray
    size: float


@pass_by_pointer
class Outer(NamedTuple):
    inner: Inner
    plain: Plain
    flags: np.ndarray
    closed: bool


def outer(n: int) -> Outer:
    values = np.arange(float(n))
    plain = Plain(values + 0.5, np.arange(n))
    return Outer(Inner(values, 2.0), plain, np.ones((n, 2), bool), True)


@njit
def total(t):
    s = 0.0
    for k in range(t.inner.values.shape[0]):
        if t.flags[k, 1]:
            s += t.inner.size * t.inner.values[k] + t.plain.values[k] + t.plain.counts[k]
    return s if t.closed else -s


@njit
def first_of(part):
    return part.values[0] * part.size


@njit
def through(t):
    near = (t.inner, t.flags, 1.0)
    return first_of(near[0]) + near[2]


@njit
def write(t, x):
    t.inner.values[:] = x
    t.plain.counts[1:] = t.plain.counts[:-1].copy()


def test_members_are_read_at_any_depth():
    t = outer(5)
    assert total(t) == total.py_func(t) == 2.0 * 10 + 12.5 + 10
    assert total(t._replace(closed=False)) == -total(t)


def test_a_part_is_handed_on_and_put_into_other_tuples():
    t = outer(3)
    t.inner.values[0] = 4.0
    assert through(t) == 9.0


def test_what_is_written_is_seen_by_python():
    t = outer(4)
    write(t, 7.0)
    assert (t.inner.values == 7.0).all()
    assert t.plain.counts.tolist() == [0, 0, 1, 2]


def test_no_reference_is_lost_or_kept():
    """Members that are arrays, and arrays in members that are tuples."""
    t = outer(6)
    arrays = [t.inner.values, t.plain.values, t.plain.counts, t.flags]
    before = [sys.getrefcount(array) for array in arrays]
    for _ in range(200):
        total(t)
        through(t)
        write(t, 1.0)
    assert [sys.getrefcount(array) for array in arrays] == before


def test_the_type_is_of_the_class_and_of_what_is_in_it():
    assert isinstance(typeof(outer(2)), Reference)
    assert typeof(outer(2)) == typeof(outer(9))
    other = outer(2)._replace(flags=np.ones(2, bool))
    assert typeof(other) != typeof(outer(2))
    assert len(str(typeof(outer(2)))) < 40
    assert not isinstance(typeof(outer(2).plain), Reference)


def test_classes_of_one_name_and_other_members_are_two_types():
    """To numba types of one name are one."""
    fields = [("values", np.ndarray), ("size", float)]
    other = pass_by_pointer(NamedTuple("Inner", [("weights", np.ndarray), ("share", float)]))
    same = pass_by_pointer(NamedTuple("Inner", fields))
    own = typeof(Inner(np.zeros(2), 1.0))
    assert typeof(same(np.zeros(2), 1.0)).name == own.name
    assert typeof(other(np.zeros(2), 1.0)).name != own.name


def test_a_name_that_is_none_is_refused_as_ever():
    @njit
    def wrong(t):
        return t.radius

    with pytest.raises(Exception, match="radius"):
        wrong(outer(2))


def test_marks_are_of_the_class_alone():
    assert {Inner, Outer} <= PASSED_BY_POINTER
    assert Plain not in PASSED_BY_POINTER


def test_rows_that_are_written_between_reads_are_read_anew():
    """The places of arrays are kept while a kernel runs, not what is in them."""

    @inner()
    def grow(t, k):
        t.inner.values[k] += t.inner.values[k - 1]

    @kernel()
    def sums(t):
        for k in range(1, t.inner.values.shape[0]):
            grow(t, k)
        return t.inner.values[-1]

    t = outer(10)
    assert sums(t) == 45.0


def test_an_array_of_numbers_of_another_size_is_refused_wherever_it_stands() -> None:
    record = outer(3)
    assert total(record) == total.py_func(record)
    way_in = next(iter(total.overloads.values())).entry_point
    narrow = record.inner.values.astype(np.float32)
    for wrong in (
        record._replace(inner=record.inner._replace(values=narrow)),
        record._replace(plain=record.plain._replace(values=narrow)),
        record._replace(flags=narrow),
    ):
        with pytest.raises(TypeError, match="numbers have another size than the kernel"):
            way_in(wrong)
    with pytest.raises(TypeError):
        way_in(record._replace(flags=[True]))
    assert way_in(record) == total.py_func(record)
