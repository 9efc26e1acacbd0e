"""The protocol of a master: the same methods for exact geometry and for triangles."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.digest import Digest
from contiga.arrays.layout import as_points, checked_choice
from contiga.arrays.ordered import length
from contiga.errors import GeometryError, InputError
from contiga.geometry.faces import Faces
from contiga.records import (
    ByteArray,
    FacingLimits,
    FloatArray,
    FootSlopes,
    Hit,
    IntArray,
    MassProperties,
    Projection,
    Sides,
    SurfacePlaces,
    empty_projection,
)
from contiga.rigid.transform import PoseLike
from contiga.search.contact_tables import ContactTables
from contiga.triangles.trimesh import TriMesh


class Surface(Protocol):
    """A surface that can be searched. Points are in the master's frame; rows choose among them."""

    @property
    def closed(self) -> bool:
        """Whether the surface has no border."""

    @property
    def n_elements(self) -> int:
        """Number of elements that the search works on."""

    @property
    def nbytes(self) -> int:
        """Memory of the search's tables, bytes."""

    def closest(
        self,
        p_B: FloatArray,
        rows: IntArray,
        out: Projection,
        within: FloatArray | None = None,
    ) -> None:
        """Find the closest points to p_B[rows] and write them to the same rows of `out`.

        `within` (len(rows),) are upper bounds of the distances, infinite if unknown: they cut the
        search.
        """

    def closest_facing(
        self,
        p_B: FloatArray,
        guards: FloatArray,
        limits: FacingLimits,
        starts: SurfacePlaces,
        out: Projection,
    ) -> None:
        """Find the closest feet that do not face away from `guards` (n, 3), into `out`.

        Feet are local minima of the distance along the surface with the point behind them; rows
        without any get MAX_ITERATIONS. At a kink the normal leads from the point to the foot. The
        search begins around `starts`.
        """

    def track(
        self,
        p_B: FloatArray,
        patch: IntArray,
        uv: FloatArray,
        out: Projection,
        before: FloatArray | None = None,
    ) -> None:
        """Continue feet from (patch, uv), into `out`; rows of patch −1 by `closest`.

        `before` (n, 3) are the points whose feet (patch, uv) are; without it no tracked foot is
        certified.
        """

    def slopes(self, p_B: FloatArray, feet: Projection, out: FootSlopes) -> None:
        """Compute the derivatives of depth and normal at `feet` of points p_B (k, 3), into `out`.

        The gaps of the feet are their signed distances along their normals.
        """

    def entries(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> Hit:
        """Return the first entries of the segments a_B[rows] → b_B[rows], one row per segment."""

    def last_crossings(
        self, a_B: FloatArray, b_B: FloatArray, rows: IntArray
    ) -> tuple[Hit, ByteArray]:
        """Return the crossings of either sense nearest to the ends of a_B[rows] → b_B[rows].

        Also returns whether the path enters there (1), leaves (−1), or crosses nothing (0).
        """

    def safe_distance(self, p_B: FloatArray, rows: IntArray, lengths: FloatArray) -> None:
        """Write lower bounds of the distance of p_B[rows] to lengths[rows]; zero when near."""

    def sides(self, p_B: FloatArray, rows: IntArray) -> Sides:
        """Return the sides of p_B[rows] that need no search.

        A side is 1 outside, −1 inside, 0 unknown, as always for an open surface. A known side comes
        with a radius, greater than rounding, within which there is no surface.
        """

    def clear_paths(self, a_B: FloatArray, b_B: FloatArray, rows: IntArray) -> NDArray[np.bool_]:
        """Return (len(rows),) whether a_B[rows] → b_B[rows] is known to meet no surface."""

    @property
    def contact_tables(self) -> ContactTables | None:
        """Tables that kernels of contact may search directly; None if there are none."""


class Master(Protocol):
    """A rigid master: `Body`, `TriMesh`, or a class of a user's own that is derived from this one.

    A user's class must have `bounds` and `surface`, the search on it, which `closest_point_search`
    makes of its closest points. All other methods follow from these, or are optional: a master
    without `tessellate` is not drawn, one without `transformed` is moved by its pose only.
    """

    @property
    @abstractmethod
    def surface(self) -> Surface:
        """The search on it; its tables are built at first use."""

    @abstractmethod
    def bounds(self) -> FloatArray:
        """Return (2, 3) low and high corner of a box that holds it."""

    @property
    def name(self) -> str:
        """Name of the master in reports and messages."""
        return type(self).__name__

    @property
    def reference_point(self) -> FloatArray:
        """Point (3,) that the wrench is taken about, body axes."""
        return np.zeros(3)

    @property
    def size(self) -> float:
        """Length of the diagonal of `bounds`."""
        low, high = self.bounds()
        return length(high - low)

    @property
    def closed(self) -> bool:
        """Whether the surface has no border."""
        return self.surface.closed

    @property
    def n_pieces(self) -> int:
        """Number of patches or triangles, the range of the `patch` of a foot."""
        return 1

    @property
    def faces(self) -> Faces | None:
        """The exact geometry, for work in the (u, v) of patches; None for triangles."""
        return None

    @property
    def flaws(self) -> list[str]:
        """Faults where faces meet, a sentence each."""
        return []

    def check(self) -> None:
        """Raise a `GeometryError` or a `MeshError` if it cannot serve as a master."""
        box = np.asarray(self.bounds())
        if box.shape != (2, 3) or not np.isfinite(box).all() or (box[0] > box[1]).any():
            raise GeometryError(
                "must be the low and the high corner of a box",
                where=f"{self.name}, bounds",
                found=box.tolist(),
                allowed="(2, 3) finite numbers",
            )

    def project(
        self, points: ArrayLike, *, start: Projection | None = None, mode: str = "global"
    ) -> Projection:
        """Return feet of `points` (n, 3): the closest points, or feet continued from `start`.

        `mode` is "global" (the closest points) or "track", which needs `start`: without it the
        closest points are searched. Raises `InputError` for another mode.
        """
        p_B = as_points(points)
        feet = empty_projection(len(p_B))
        if checked_choice("mode", mode, ("global", "track")) == "track" and start is not None:
            self.surface.track(p_B, start.patch, start.uv, feet)
        else:
            self.surface.closest(p_B, np.arange(len(p_B), dtype=np.int32), feet)
        return feet

    def first_hit(self, p0: ArrayLike, p1: ArrayLike) -> Hit:
        """Return where points that move from `p0` to `p1` (n, 3) first enter."""
        a_B, b_B = as_points(p0, "p0"), as_points(p1, "p1")
        return self.surface.entries(a_B, b_B, np.arange(len(a_B), dtype=np.int32))

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return a mask (n,) of the points (n, 3) on the contact side, none on the surface."""
        return np.asarray(self.project(points).gap < 0.0)

    def tessellate(self, tol: float) -> TriMesh:
        """Return triangles at most `tol` off the surface, length.

        Without a method of the class there are no triangles, only the corners of the box, so that
        views have room for it.
        """
        corners = np.stack(np.meshgrid(*np.asarray(self.bounds()).T), axis=-1).reshape(-1, 3)
        return TriMesh(corners, np.zeros((0, 3), np.int64), name=self.name)

    def transformed(self, matrix: PoseLike) -> Master:
        """Return the same master moved by a regular affine (4, 4) matrix."""
        raise _missing(self, "transformed", "Give the body a motion, or the contact a pose")

    def with_reference_point(self, point: ArrayLike) -> Master:
        """Return the same master with another reference point (3,)."""
        raise _missing(self, "with_reference_point", "Give its class a reference_point")

    def mass_properties(self, density: float) -> MassProperties:
        """Return mass, centre and inertia of the solid that a closed master encloses."""
        raise _missing(self, "mass_properties", "Give its mass, centre and inertia as numbers")

    def digest(self, digest: Digest) -> None:
        """Add everything that decides results to a digest."""
        digest.add_value(self)

    def facts(self) -> dict[str, Any]:
        """Return facts on it for a run's summary."""
        return {"kind": self.name, "closed": self.closed, "size": self.size}

    def condition_rows(self) -> list[tuple[str, str]]:
        """Return a summary of its quality as a master: rows (label, text)."""
        return []


def _missing(master: Master, method: str, remedy: str) -> InputError:
    """Return the error of a user's master without an optional method."""
    return InputError(
        f"has no {method} of its own",
        where=master.name,
        found=type(master).__name__,
        allowed=f"a class with {method}, as Body and TriMesh have",
        remedy=remedy,
    )


_MASTER_NAMES = [name for name in vars(Master) if not name.startswith("_")]


def is_master(value: object) -> bool:
    """Return whether a value has all attributes of a master; no property is evaluated."""
    attributes = getattr(value, "__dict__", {})
    return all(hasattr(type(value), name) or name in attributes for name in _MASTER_NAMES)
