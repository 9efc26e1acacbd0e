"""Loads: forces and moments on a body, constant or over time."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contiga.arrays.layout import read_only
from contiga.curves.tables import table_of
from contiga.dynamics.pieces import Pieces, pieces_between
from contiga.errors import InputError
from contiga.records import FloatArray
from contiga.rigid.transform import vector

_COLUMNS = {"force": ("t", "Fx", "Fy", "Fz"), "moment": ("t", "Mx", "My", "Mz")}


@dataclass(frozen=True, init=False, eq=False)
class Load:
    """A force and a moment on a body.

    Parameters
    ----------
    body : its name
    force, moment : (3,), or (n, 4) rows t, x, y, z with n ≥ 2 and t strictly increasing; world
        axes. One of the two may be left out.
    at : (3,) the body's point that the force acts at, world coordinates at the start of the run;
        the centre of mass if None
    follow : force and moment turn with the body
    smooth : monotone cubics between the rows in place of straight lines

    Notes
    -----
    A load over time is not extrapolated: it is zero outside its rows. The point `at` moves with
    the body, whether the force turns with it or not.

    Raises
    ------
    InputError
        Neither force nor moment, a point for a moment alone, `smooth` without rows, no vector and
        no rows.

    Examples
    --------
    A push that fades

    >>> push = Load("sled", force=[[0.0, 100.0, 0.0, 0.0], [4.0, 0.0, 0.0, 0.0]])
    >>> push.force_at(1.0).tolist(), push.moment_at(1.0).tolist(), push.span
    ([75.0, 0.0, 0.0], [0.0, 0.0, 0.0], (0.0, 4.0))
    """

    body: str
    force: FloatArray | Pieces
    moment: FloatArray | Pieces
    at: FloatArray | None
    follow: bool

    def __init__(
        self,
        body: str,
        *,
        force: ArrayLike | None = None,
        moment: ArrayLike | None = None,
        at: ArrayLike | None = None,
        follow: bool = False,
        smooth: bool = False,
    ) -> None:
        if not isinstance(body, str) or not body:
            raise InputError("must name a body", where="body", found=body)
        if force is None and moment is None:
            raise InputError(
                "a load needs a force or a moment",
                where="force",
                found="neither",
                allowed="[x, y, z], or rows [t, x, y, z]",
            )
        if at is not None and force is None:
            raise InputError(
                "a moment has no point that it acts at",
                where="at",
                found=at,
                remedy="Remove it, or give the force that acts there",
            )
        put = object.__setattr__
        put(self, "body", body)
        put(self, "force", vector_over_time(force, "force", smooth))
        put(self, "moment", vector_over_time(moment, "moment", smooth))
        put(self, "at", None if at is None else read_only(vector(at, "at")))
        put(self, "follow", bool(follow))
        if smooth and self.span is None:
            raise InputError(
                "there are no rows to be smooth between",
                where="smooth",
                found=smooth,
                remedy="Remove it, or give the force or the moment as rows over time",
            )

    def at_time(self, t: float) -> Load:
        """Return a constant load with the force and moment at time `t`."""
        constant = copy(self)
        object.__setattr__(constant, "force", read_only(self.force_at(t).copy()))
        object.__setattr__(constant, "moment", read_only(self.moment_at(t).copy()))
        return constant

    @property
    def span(self) -> tuple[float, float] | None:
        """First and last time that both its tables cover, or its one; None for a constant load."""
        tables = [table for table in (self.force, self.moment) if isinstance(table, Pieces)]
        if not tables:
            return None
        return max(table.times[0] for table in tables), min(table.times[-1] for table in tables)

    @property
    def kinks(self) -> FloatArray:
        """Times at which steps must end so that none of its impulse is lost."""
        tables = [table for table in (self.force, self.moment) if isinstance(table, Pieces)]
        return np.concatenate([np.zeros(0), *(table.kinks() for table in tables)])

    def force_at(self, t: float) -> FloatArray:
        """Return the force (3,) at time `t`.

        It is in world axes; with `follow` in the body axes that were the world's at the start.
        """
        return value_at(self.force, t)

    def moment_at(self, t: float) -> FloatArray:
        """Return the moment (3,) at time `t`, in the axes of the force.

        It excludes the moment of the force about the centre of mass.
        """
        return value_at(self.moment, t)


def value_at(load: FloatArray | Pieces, t: float) -> FloatArray:
    """Return a constant vector (3,), or a vector over time at `t`: zero outside its rows."""
    if not isinstance(load, Pieces):
        return load
    return load.value(t) if load.times[0] <= t <= load.times[-1] else np.zeros(3)


def vector_over_time(values: ArrayLike | None, name: str, smooth: bool) -> FloatArray | Pieces:
    """Return a constant vector (3,), zero for None, or the vector over time of a table.

    `name` is "force" or "moment". An `InputError` is raised for neither a vector nor two rows or
    more.
    """
    if values is None:
        return read_only(np.zeros(3))
    try:
        is_constant = np.ndim(values) == 1
    except ValueError:  # rows of several lengths, which `table_of` reports
        is_constant = False
    if is_constant:
        return read_only(vector(values, name))
    rows = table_of(values, _COLUMNS[name], where=name, at_least=2)
    return pieces_between(read_only(rows[:, 0]), rows[:, 1:], smooth=smooth)
