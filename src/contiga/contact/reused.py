"""Arrays of a state that nobody needs any more, for the next one to be written into."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.contact.checks import kind
from contiga.contact.state import Owner, State
from contiga.contact.tracked import Columns
from contiga.errors import InputError
from contiga.num.query_checks import check_apart, check_fillable
from contiga.records import FloatArray


def given_up(out: State, state: State, p_W: FloatArray, owner: Owner) -> tuple[Columns, FloatArray]:
    """The arrays of `out` that say something of all points, and its points, which it has no more.

    Raises
    ------
    InputError
        It is no state of `owner`, or the one that is stepped from, or its arrays are not its own,
        or are those of the points p_W (n, 3) or of `state`.
    """
    kind("out", out, State)
    if out is state:
        raise InputError(
            "out must not be the state that the step goes on from, which is read all through",
            where="out",
            allowed="a state of an earlier step",
        )
    if not out.is_of(owner):
        raise InputError(
            "out must be a state of this contact", where="out", allowed="what its steps answered"
        )
    n = len(p_W)
    likes: tuple[Any, ...] = Columns.of(0)
    for name, like in zip(Columns._fields, likes, strict=True):
        check_fillable(getattr(out, name), (n, *like.shape[1:]), like.dtype, f"out.{name}")
    check_fillable(out.points_B, (n, 3), np.float64, "out.points_B")
    columns, points = Columns(*(getattr(out, name) for name in Columns._fields)), out.points_B
    read = [p_W, state.points_B, *(getattr(state, name) for name in Columns._fields)]
    check_apart([*columns, points], read, "a state whose arrays are not those of state or points")
    out.spend()
    return columns, points
