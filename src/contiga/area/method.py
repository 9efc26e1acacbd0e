"""The protocol of area methods, with the records of their input and output."""

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
    """(m, 3) triangles, None for a cloud."""
    area: FloatArray | None
    """(n,) tributary areas, None if the slave has none."""
    body: Master | None = None
    """The master, None if it is not known yet."""


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
    """(n,) tributary areas of the slave, None if it has none."""
    on: str = "slave"
    """Side on which to measure the area: "slave" or "master"."""
    prepared: Any = None
    """Result of the method's `prepare` for the slave."""
    kept: dict[str, Any] | None = None
    """Cache of a method for the same points, so that areas and outlines use the same cuts."""
    half: FloatArray | None = None
    """(n,) half the thickness of a shell at its points: contact begins at this distance, and the
    feet are that far off the master. None if contact begins at the surface."""

    @property
    def exact(self) -> Faces:
        """The patches of the master; raises `InputError` for a mesh, which has none."""
        faces = self.body.faces
        if faces is None:
            raise no_patch()
        return faces


def no_patch() -> InputError:
    """Return the error of methods that need (u, v), for a master of triangles."""
    return InputError(
        "hulls and areas by the feet need the (u, v) of a patch, which a mesh does not have",
        where="area",
        allowed="FacetArea, CloudArea at rest or NodalArea for a master of triangles",
    )


def check_side(on: str | None) -> None:
    """Raise `InputError` for a side that is not "slave", "master" or None."""
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
    """Side on which the area was measured: "slave" or "master"."""


class Outlines(NamedTuple):
    """Closed lines around regions of contact, body frame: points[first[i]:first[i+1]] each."""

    points: FloatArray
    """(k, 3); a line does not repeat its first point at its end."""
    first: NDArray[np.int64]
    """(lines + 1,)."""
    clusters: IntArray
    """(lines,) number of the region that each bounds; a region with holes has several."""


@runtime_checkable
class AreaMethod(Protocol):
    """A method that measures the contact area of each point.

    A method that needs data about the slave (its neighbours, say) also has a method `prepare`,
    which is called once with the slave's `Rest`; every `AreaInput` contains its result. A method
    that can find where contact ends has `outlines(inp) -> Outlines`. A method with a fixed area
    of every point at rest has `weights(rest, prepared)`, (n,) or None. Methods never change.
    """

    def measure(self, inp: AreaInput) -> Areas:
        """Return the areas of the points in contact; empty arrays if there are none."""


def prepared(method: AreaMethod, rest: Rest) -> Any:
    """Return the data that `method` prepares for a slave; None for methods without `prepare`."""
    prepare = getattr(method, "prepare", None)
    return None if prepare is None else prepare(rest)


def outlines_of(method: AreaMethod, inp: AreaInput) -> Outlines | None:
    """Return where contact ends by `method`; None for methods without `outlines`."""
    outlines = getattr(method, "outlines", None)
    return None if outlines is None else outlines(inp)


def weights_of(method: AreaMethod, rest: Rest, kept: Any) -> FloatArray | None:
    """Return (n,) fixed areas of a slave's points at rest, of the method or else of the slave.

    None if neither has any.
    """
    weights = getattr(method, "weights", None)
    areas = None if weights is None else weights(rest, kept)
    return rest.area if areas is None else areas
