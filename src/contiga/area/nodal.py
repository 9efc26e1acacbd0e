"""The constant nodal area: each point stands for the same area as long as it touches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contiga.area.method import AreaInput, Areas, Rest
from contiga.arrays.layout import read_only, real
from contiga.errors import InputError
from contiga.records import FloatArray


@dataclass(frozen=True, init=False, eq=False)
class NodalArea:
    """Constant nodal areas, as MADYMO assigns them (thesis, 3.2 and 4.5.1).

    Parameters
    ----------
    value : area of every point, or (n,) one a point, length²; the slave's tributary areas (a
        third of each facet to each of its corners) if omitted

    Raises
    ------
    InputError
        Values that are negative or not finite, or (at a contact) do not fit the slave's points,
        or are omitted for a slave without facets.

    Notes
    -----
    The method does not distinguish contact regions: all points are of cluster 0.

    Examples
    --------
    >>> import contiga as cg
    >>> sheet = cg.Slave([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> ball = cg.Body([cg.shapes.sphere(radius=5.0, centre=(0.0, 0.0, 5.1))])
    >>> contact = cg.Contact(ball, sheet, law=cg.PenaltyLaw(1.0), area=cg.NodalArea(0.25))
    >>> state = contact.start(sheet.points)
    >>> contact.step(state, sheet.points + [0.0, 0.0, 1.0]).total_area
    0.75
    """

    value: FloatArray | None

    def __init__(self, value: ArrayLike | None = None) -> None:
        array = None
        if value is not None:
            real(value, "area")
            try:
                array = read_only(np.asarray(value, dtype=np.float64))
            except (TypeError, ValueError) as error:
                raise InputError("a nodal area must be a number", where="area") from error
            if array.ndim > 1 or not np.all(np.isfinite(array)) or np.any(array < 0.0):
                raise InputError(
                    "nodal areas must be finite and not negative",
                    where="area",
                    found=value,
                    allowed="a number ≥ 0, or one a point",
                )
        object.__setattr__(self, "value", array)

    def nodal(self, n: int, slave_area: FloatArray | None) -> FloatArray:
        """Return the areas (n,) of a slave's points: the given values, or else `slave_area`.

        A single value holds for all points. Arrays are returned themselves, not as copies.

        Raises
        ------
        InputError
            No areas at all, or given areas whose number is neither 1 nor n.
        """
        if self.value is None:
            if slave_area is None:
                raise InputError(
                    "the slave has no facets to take areas from",
                    where="area",
                    allowed="NodalArea(value), or a slave with facets or areas",
                )
            return slave_area
        if self.value.ndim == 0:
            return np.full(n, float(self.value))
        if self.value.shape != (n,):
            raise InputError(
                "nodal areas must have one entry a point",
                where="area",
                found=self.value.shape,
                allowed=f"({n},)",
            )
        return self.value

    def prepare(self, rest: Rest) -> FloatArray:
        """Return the areas (n,) of all points."""
        return self.nodal(len(rest.points), rest.area)

    def weights(self, _: Rest, prepared: FloatArray) -> FloatArray:
        """Return (n,) the areas, which never change."""
        return prepared

    def measure(self, inp: AreaInput) -> Areas:
        """Return the fixed areas of the points in contact, all in cluster 0."""
        areas = inp.prepared
        if areas is None:
            areas = self.nodal(len(inp.points), inp.slave_area)
        return Areas(areas[inp.rows], np.zeros(len(inp.rows), np.int32))
