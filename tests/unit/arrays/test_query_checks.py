"""Projections that searches start from, and that they fill."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.arrays.kernels.query_nb import highest_patch
from contiga.arrays.query_checks import checked_feet, checked_out, checked_start
from contiga.errors import InputError
from contiga.records import Projection, empty_projection


def feet(n: int = 4) -> Projection:
    found = empty_projection(n)
    for array in found:
        array[:] = 0
    return found


def test_a_start_that_fits_is_not_copied():
    start = feet()
    for own, given in zip(checked_start(start, 4, 1, "patch"), start, strict=True):
        assert own is given


def test_a_start_of_other_layouts_is_laid_out():
    start = feet()
    start.point.flags.writeable = False
    other = start._replace(
        patch=[0, 0, -1, 0],
        uv=np.zeros((2, 4)).T,
        normal=np.zeros((4, 6))[:, ::2],
        gap=np.zeros(4, np.float32),
    )
    own = checked_start(other, 4, 1, "patch")
    for array, like in zip(own, feet(), strict=True):
        assert (array.dtype, array.shape) == (like.dtype, like.shape)
        assert array.flags.carray
    assert own.patch.tolist() == [0, 0, -1, 0]


def _unaligned(array: np.ndarray) -> np.ndarray:
    memory = np.zeros(array.nbytes + 1, np.uint8)[1:]
    memory[:] = array.view(np.uint8).reshape(-1)
    return memory.view(array.dtype).reshape(array.shape)


@pytest.mark.parametrize(
    "as_other",
    [
        lambda a: a.astype(a.dtype.newbyteorder(">")),
        lambda a: a.astype(np.float32),
        lambda a: a.astype(object),
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a.tolist(),
        lambda a: a.view(type("Own", (np.ndarray,), {})),
        _unaligned,
    ],
    ids=["bytes turned", "narrow", "objects", "strided", "list", "own class", "unaligned"],
)
def test_arrays_of_a_start_that_kernels_do_not_take_are_made_ones_that_they_do(as_other):
    start = feet()
    for k, array in enumerate(start):
        array[...] = k % 2
    own = checked_start(Projection(*map(as_other, start)), 4, 2, "patch")
    for array, like in zip(own, start, strict=True):
        assert array.dtype == like.dtype
        assert array.flags.carray
        np.testing.assert_array_equal(array, like)
    assert len(getattr(highest_patch, "signatures", "1")) == 1


@pytest.mark.parametrize("highest", [-1, 0, 3])
def test_the_highest_patch_of_a_start_is_one_there_is(highest):
    start = feet(40)
    start.patch[:], start.patch[33] = -1, highest
    assert checked_start(start, 40, highest + 1, "patch") is start
    for given in (start, start._replace(patch=start.patch.tolist())):
        if highest >= 0:
            with pytest.raises(InputError, match="a face that is not there") as error:
                checked_start(given, 40, highest, "face")
            assert error.value.found == highest
    assert len(checked_start(feet(0), 0, 0, "patch").gap) == 0


def test_a_start_has_as_many_rows_as_there_are_points():
    for n in (3, 5):
        with pytest.raises(InputError, match="one row a point"):
            checked_start(feet(n), 4, 1, "patch")


@pytest.mark.parametrize("name", ["uv", "point", "normal"])
def test_the_rows_of_a_start_are_as_wide_as_those_of_feet(name):
    wide = np.zeros((4, 4))
    with pytest.raises(InputError, match="one row a point"):
        checked_start(feet()._replace(**{name: wide}), 4, 1, "patch")


@pytest.mark.parametrize("name", Projection._fields)
def test_every_array_of_a_start_needs_one_row_a_point(name):
    few = getattr(feet(3), name)
    with pytest.raises(InputError, match="one row a point") as error:
        checked_start(feet()._replace(**{name: few}), 4, 1, "patch")
    assert name in str(error.value.allowed)
    with pytest.raises(InputError, match="arrays of numbers") as error:
        checked_start(feet()._replace(**{name: "feet"}), 4, 1, "patch")
    assert error.value.where == f"start.{name}"


def test_what_is_filled_is_what_was_given_or_new():
    points, out = np.zeros((4, 3)), feet()
    assert checked_out(out, points, None) is out
    assert checked_out(out, points, out) is out
    assert checked_out(out, points, feet()) is out
    assert len(checked_out(None, points, out).gap) == 4


@pytest.mark.parametrize(
    "wrong",
    [
        {"gap": np.zeros(3)},
        {"uv": np.zeros((2, 4)).T},
        {"status": np.zeros(4)},
        {"point": [[0.0] * 3] * 4},
        {"normal": np.broadcast_to(0.0, (4, 3))},
    ],
)
def test_what_cannot_be_filled_is_refused(wrong):
    with pytest.raises(InputError, match="out must have arrays of one row") as error:
        checked_out(feet()._replace(**wrong), np.zeros((4, 3)), None)
    assert error.value.where == f"out.{next(iter(wrong))}"


def test_what_is_filled_is_a_projection_that_shares_nothing_with_what_is_read():
    with pytest.raises(InputError, match="out must be a Projection"):
        checked_out(tuple(feet()), np.zeros((4, 3)), None)  # type: ignore[arg-type]
    out, start = feet(), feet()
    with pytest.raises(InputError, match="shares memory"):
        checked_out(out._replace(status=out.certified), np.zeros((4, 3)), None)
    for points, other in (
        (out.point, None),
        (np.zeros((4, 3)), start._replace(uv=out.uv)),
        (out.normal, out),
        (out.normal[:], None),
        (out.normal[::-1][::-1], out),
    ):
        with pytest.raises(InputError, match="shares memory"):
            checked_out(out, points, other)


def test_what_is_filled_and_started_from_is_looked_at_as_both():
    points, start, out = np.zeros((4, 3)), feet(), feet()
    assert checked_feet(start, start, points, 1, "patch") == (start, start)
    last, filled = checked_feet(start, out, points, 1, "patch")
    assert last is not filled
    assert filled is out
    assert len(checked_feet(start, None, points, 1, "patch")[1].gap) == 4


def test_what_is_started_from_and_cannot_be_filled_is_refused():
    start = feet()
    start.gap.flags.writeable = False
    with pytest.raises(InputError, match="can be written") as error:
        checked_feet(start, start, np.zeros((4, 3)), 1, "patch")
    assert error.value.where == "out.gap"
    start = feet()
    with pytest.raises(InputError, match="shares memory"):
        checked_feet(start, start, start.normal, 1, "patch")
    with pytest.raises(InputError, match="not there"):
        checked_feet(start, start, np.zeros((4, 3)), 0, "patch")
