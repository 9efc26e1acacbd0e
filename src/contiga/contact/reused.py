"""Reuse the arrays of a state that is no longer needed for the next one."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import numpy as np

from contiga.arrays.query_checks import check_apart, check_fillable
from contiga.contact.checks import check_type
from contiga.contact.search_records import Columns
from contiga.contact.state import Owner, State
from contiga.errors import InputError
from contiga.records import FloatArray

_arrays: Any = attrgetter(*Columns._fields, "points_B")
"""Arrays of a state that are overwritten."""


def reusable_arrays(
    out: State, state: State, p_W: FloatArray, owner: Owner
) -> tuple[Columns, FloatArray]:
    """Return the columns of `out` and its `points_B`, to be overwritten; `out` is emptied.

    Raises
    ------
    InputError
        `out` is not a state of `owner`, or is `state` itself, or shares memory with `state` or the
        points p_W (n, 3), or has an array of another shape or type, or one that is read-only.
        `out` is unchanged then.
    """
    check_type("out", out, State)
    if out is state:
        raise InputError(
            "out must not be the state that the step goes on from, which is read all through",
            where="out",
            allowed="a state of an earlier step",
        )
    if vars(out).get("_contact") is not owner:
        raise InputError(
            "out must be a state of this contact", where="out", allowed="what its steps answered"
        )
    arrays = _arrays(out)
    if not _are_obviously_separate(out, state, arrays, p_W):
        n = len(p_W)
        likes: tuple[Any, ...] = Columns.of(0)
        for name, array, like in zip(Columns._fields, arrays, likes, strict=False):
            check_fillable(array, (n, *like.shape[1:]), like.dtype, f"out.{name}")
        check_fillable(arrays[-1], (n, 3), np.float64, "out.points_B")
        read = [p_W, *_arrays(state)]
        check_apart(arrays, read, "a state whose arrays are not those of state or points")
    vars(out).clear()  # its arrays will be overwritten
    return Columns._make(arrays[:-1]), arrays[-1]


def _are_obviously_separate(out: State, state: State, columns: Any, p_W: FloatArray) -> bool:
    """Return whether the arrays of `out` certainly share no memory; if False, compare them.

    True is for states made by steps: their arrays are separate from each other and from arrays
    of users, unless a user locked one, and only copies of a state share whole arrays. Comparing all
    pairs of arrays of two states would take longer than a small step.
    """
    if out._maker is None or state._maker is None:
        return False
    # Arrays that own their memory share none, and views name the one that does.
    owner = p_W if p_W.base is None else p_W.base
    for array, read in zip(columns, _arrays(state), strict=True):
        if array is read or array is owner or array.base is not None or not array.flags.carray:
            return False
    return owner is p_W or (type(owner) is np.ndarray and owner.base is None)
