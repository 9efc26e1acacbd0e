"""Define what an area method is given, and what it answers."""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from contiga.errors import InputError
from contiga.geometry.faces import Faces
from contiga.masters.protocol import Master
from contiga.records import FloatArray, IntArray, Projection


class Rest(NamedTuple):
    """The part of a slave that never changes."""

    points: FloatArray
    """(n, 3) at rest."""
    facets: IntArray | None
    """(m, 3) triangles, where there are any."""
    area: FloatArray | None
    """(n,) tributary areas, where there are any."""
    body: Master | None = None
    """The master, where it is known already."""


class AreaInput(NamedTuple):
    """The points in contact, as an area method sees them."""

    body: Master
    """The master."""
    rows: IntArray
    """(n_c,) rows of the points in contact."""
    points: FloatArray
    """(n, 3) all slave points, body frame."""
    feet: Projection
    """n_c rows: the feet of the points in contact, body frame."""
    slave_area: FloatArray | None
    """(n,) tributary areas of the slave, where it has them."""
    on: str = "slave"
    """Whose area is wanted: "slave" or "master"."""
    prepared: Any = None
    """What the method's `prepare` made of the slave."""
    kept: dict[str, Any] | None = None
    """What one question to a method leaves for the next about the same points: areas and outlines
    come from the same cuts."""
    half: FloatArray | None = None
    """(n,) half the thickness of a shell at its points, from which on they are in contact; its feet
    are so far off the master. None where contact begins at the surface."""

    @property
    def exact(self) -> Faces:
        """The master where its patches are asked for; a mesh has none."""
        faces = self.body.faces
        if faces is None:
            raise no_patch()
        return faces


def no_patch() -> InputError:
    """Raise the error of methods that need (u, v) where the master is a mesh of triangles."""
    return InputError(
        "hulls and areas by the feet need the (u, v) of a patch, which a mesh does not have",
        where="area",
        allowed="FacetArea, CloudArea at rest or NodalArea for a master of triangles",
    )


def check_side(on: str | None) -> None:
    """Refuse what is no side to measure an area on."""
    if on not in (None, "slave", "master"):
        raise InputError(
            "unknown side to measure the area on",
            where="on",
            found=on,
            allowed='"slave", "master", or None',
        )


class Areas(NamedTuple):
    """Nodal contact areas, and the connected regions they belong to."""

    area: FloatArray
    """(n_c,) length²."""
    clusters: IntArray
    """(n_c,) number of the region, from 0."""
    on: str = "slave"
    """Whose area it is: "slave" or "master"."""


class Outlines(NamedTuple):
    """Closed lines around regions of contact, body frame: points[first[i]:first[i+1]] each."""

    points: FloatArray
    """(k, 3), the first of a line not repeated at its end."""
    first: NDArray[np.int64]
    """(lines + 1,)."""
    clusters: IntArray
    """(lines,) number of the region each bounds; a region with holes has several."""


@runtime_checkable
class AreaMethod(Protocol):
    """A method that measures the contact area of each point.

    A method that keeps something about the slave (its neighbours, say) has a method `prepare`
    beside `measure`, which is called once with the slave's `Rest`; what it returns comes back in
    every `AreaInput`. A method that can say where contact ends has `outlines(inp) -> Outlines`.
    One that knows a fixed area of every point at rest has `weights(rest, prepared)`, (n,) or None.
    Methods themselves never change.
    """

    def measure(self, inp: AreaInput) -> Areas:
        """Areas of the points in contact; empty arrays where there are none."""


def prepared(method: AreaMethod, rest: Rest) -> Any:
    """Return what `method` keeps about a slave; None for methods that keep nothing."""
    prepare = getattr(method, "prepare", None)
    return None if prepare is None else prepare(rest)


def outlines_of(method: AreaMethod, inp: AreaInput) -> Outlines | None:
    """Return where contact ends as `method` sees it; None for methods that do not say."""
    outlines = getattr(method, "outlines", None)
    return None if outlines is None else outlines(inp)


def weights_of(method: AreaMethod, rest: Rest, kept: Any) -> FloatArray | None:
    """Return (n,) fixed areas of a slave's points at rest; None where nothing tells them.

    Those of the method, where it has any of its own; else those of the slave.
    """
    weights = getattr(method, "weights", None)
    areas = None if weights is None else weights(rest, kept)
    return rest.area if areas is None else areas
