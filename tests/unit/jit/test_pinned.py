"""Records laid out once: read in kernels as they are, and refused where they cannot be."""

from __future__ import annotations

import gc
import pickle
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba import config, njit, typeof

from contiga.contact.kernels import touching_nb
from contiga.jit.pinned import AT_ADDRESS, TYPES, Pinned, reader, types_read
from contiga.num.kernels import rigid_nb
from contiga.pointer_records import pass_by_pointer

pytestmark = pytest.mark.interpreted


@pass_by_pointer
class Inner(NamedTuple):
    """What an outer record holds."""

    weight: np.ndarray
    share: float


@pass_by_pointer
class Outer(NamedTuple):
    """Arrays of several kinds and shapes, numbers, a record."""

    points: np.ndarray
    cells: np.ndarray
    inner: Inner
    count: int
    size: float
    rows: np.ndarray


@pass_by_pointer
class Other(NamedTuple):
    """One that no kernel knows."""

    value: Any


class Plain(NamedTuple):
    """One that is not by reference."""

    value: np.ndarray


CELL = np.dtype([("kind", "i4"), ("box", "f8", 4)], align=True)
outer_at = reader(f"{__name__}.Outer")


def outer(seed: int) -> Outer:
    rng = np.random.default_rng(seed)
    cells = np.zeros(5, CELL)
    cells["kind"], cells["box"] = rng.integers(0, 9, 5), rng.random((5, 4))
    inner = Inner(rng.random(7), -float(rng.random()))
    rows = rng.integers(0, 9, (2, 3, 4)).astype(np.int32)
    return Outer(rng.random((6, 3)), cells, inner, -3 - seed, float(rng.random()), rows)


@njit
def looked_up(place):
    """Something of every member."""
    own = outer_at(place)
    return (
        own.points[4, 2],
        own.points.shape[0],
        own.cells[3]["box"][1],
        own.cells[2]["kind"],
        own.inner.weight.sum(),
        own.inner.share,
        own.count,
        own.size,
        own.rows[1, 2, 3],
        own.rows.shape[1],
    )


@njit
def written(place, value):
    outer_at(place).points[1, 1] = value


def test_kernels_read_what_the_record_has() -> None:
    kept = [Pinned(outer(seed)) for seed in range(3)]
    for seed, pinned in enumerate(kept):
        own = outer(seed)
        assert looked_up(pinned.address) == (
            own.points[4, 2],
            6,
            own.cells[3]["box"][1],
            own.cells[2]["kind"],
            pytest.approx(own.inner.weight.sum(), rel=1e-15),
            own.inner.share,
            own.count,
            own.size,
            own.rows[1, 2, 3],
            3,
        )


def test_numbers_in_its_arrays_may_change() -> None:
    pinned = Pinned(outer(1))
    written(pinned.address, 7.5)
    assert pinned.record.points[1, 1] == 7.5
    pinned.record.points[4, 2] = -2.0
    assert looked_up(pinned.address)[0] == -2.0


def test_it_is_gone_with_what_holds_it() -> None:
    pinned = Pinned(outer(2))
    place = pinned.address
    assert AT_ADDRESS[place] is pinned
    del pinned
    gc.collect()
    assert place not in AT_ADDRESS


def test_copies_lie_elsewhere() -> None:
    pinned = Pinned(outer(1))
    other = pickle.loads(pickle.dumps(pinned))
    assert other.address != pinned.address
    assert looked_up(other.address) == looked_up(pinned.address)


def test_what_cannot_be_laid_out_is_refused() -> None:
    with pytest.raises(TypeError, match="not by reference"):
        Pinned(Plain(np.zeros(3)))
    with pytest.raises(TypeError, match="bool cannot be laid out"):
        Pinned(Other(True))
    with pytest.raises(TypeError, match="other types"):
        Pinned(Other(np.zeros(3)))
    Pinned(outer(0))
    with pytest.raises(TypeError, match="other types"):
        Pinned(outer(0)._replace(rows=np.zeros((2, 2), np.int32)))


@pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is kept")
def test_kernels_that_read_records_are_kept_by_the_types_of_those(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    kept = touching_nb.advance
    ((name, before), *_) = types_read(kept.py_func)
    assert name == "contiga.contact.step_buffers.StepBuffers"
    assert types_read(rigid_nb.to_body.py_func) == ()
    key = kept._cache._index_key((), kept.targetctx.codegen())
    monkeypatch.setitem(TYPES, name, typeof(outer(1)))
    assert dict(types_read(kept.py_func))[name] != before
    assert kept._cache._index_key((), kept.targetctx.codegen()) != key
