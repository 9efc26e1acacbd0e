"""Body: a rigid master of exact geometry."""

from __future__ import annotations

import math
from importlib import import_module
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.disk_cache import DiskCache
from contiga.arrays.layout import as_points, positive
from contiga.arrays.queries import Queries
from contiga.errors import GeometryError
from contiga.geometry import trim_area
from contiga.geometry.body_key import key_of
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.faces import Faces
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim_area import body_moments
from contiga.records import (
    FloatArray,
    Hit,
    IndexArray,
    IntArray,
    MassProperties,
    Projection,
)
from contiga.rigid.inertia import of_volume

if TYPE_CHECKING:
    from contiga.geometry.net import ControlNet
    from contiga.search.borders.openings import Openings
    from contiga.search.exact_surface import ExactSurface
    from contiga.triangles.trimesh import TriMesh

# The search is imported at its first use: that takes longer than reading a small file.

_MOMENTS = DiskCache("moments", trim_area.__file__)


class Body(Faces, Queries):
    """A rigid master: one or more NURBS patches, oriented so that normals point to the free side.

    Parameters
    ----------
    patches : NurbsSurface, one or more
    name : name in reports and messages
    trims : one entry a patch: None for the whole natural rectangle, else loops of p-curves in the
        patch's (u, v), head to tail. The even-odd rule decides what is inside. All None if omitted.
    edges : `BodyEdge`, which patches share which edge
    unit : length unit of the coordinates, None if unknown
    reference_point : (3,) point about which the wrench is taken, length, body frame

    Raises
    ------
    GeometryError
        No patches, a count of trims that does not fit, loops that do not close or leave the
        patch's rectangle, edges that name patches which do not exist.

    Bodies are immutable; methods return new ones. They compare and hash by identity.

    Examples
    --------
    >>> import contiga as cg
    >>> tube = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0)])
    >>> tube.project([[3.0, 4.0, 1.0]]).point.round(12).tolist()
    [[0.6, 0.8, 1.0]]
    >>> tube.closed, cg.Body([cg.shapes.sphere(radius=1.0)]).closed
    (False, True)
    """

    @classmethod
    def from_profile(cls, curve: NurbsCurve, depth: float = 1.0, *, name: str = "profile") -> Self:
        """Return the body of a plane problem: `curve` at z = 0, with half the `depth` on each side.

        The free side is to the right of the curve's direction: a closed curve that runs
        counter-clockwise is a solid with normals outward. Forces are per `depth`.

        Raises
        ------
        GeometryError
            The curve leaves z = 0, or the depth is not positive.
        """
        points = curve.control_points
        if not (math.isfinite(depth) and depth > 0.0):
            raise GeometryError("depth must be positive", where="Body.from_profile", found=depth)
        reach = float(np.abs(points[:, :2]).max(initial=0.0))
        if np.abs(points[:, 2]).max() > 1e-12 * reach:
            raise GeometryError(
                "a profile must lie in the plane z = 0",
                where="Body.from_profile",
                found=float(np.abs(points[:, 2]).max()),
            )
        half = np.array([0.0, 0.0, 0.5 * depth])
        net = np.stack([points - half, points + half], axis=1)
        weights = None if curve.weights is None else np.stack([curve.weights] * 2, axis=1)
        knots_v = np.array([-0.5, -0.5, 0.5, 0.5]) * depth
        patch = NurbsSurface((curve.degree, 1), (curve.knots, knots_v), net, weights)
        return cls([patch], name=name)

    @property
    def openings(self) -> Openings:
        """Borders, gaps, and faces of opposite senses; worked out at first use."""
        from contiga.search.borders.openings import openings_of

        return openings_of(self)

    @property
    def net(self) -> ControlNet:
        """The control points of all patches in one array, in the order that `Contact.step` expects.

        Points that patches share, along edges, seams and at poles, occur once.

        >>> import contiga as cg
        >>> ball = Body([cg.shapes.sphere(radius=1.0)])
        >>> ball.patches[0].control_points.shape, ball.net.points.shape
        ((9, 5, 3), (26, 3))
        >>> ball.net.control[0][0].tolist(), ball.net.control[0][-1].tolist()
        ([0, 1, 2, 3, 4], [0, 1, 2, 3, 4])
        """
        from contiga.geometry.net import net_of

        return net_of(self)

    @property
    def pieces(self) -> list[IndexArray]:
        """Numbers of the patches of each piece that is connected by shared edges.

        >>> import contiga as cg
        >>> balls = [cg.shapes.sphere(centre=(x, 0.0, 0.0)) for x in (0.0, 3.0)]
        >>> [piece.tolist() for piece in Body(balls).pieces]
        [[0], [1]]
        """
        from contiga.search.borders.openings import pieces_of

        return pieces_of(self)

    @property
    def closed(self) -> bool:
        """Whether the surface has no border and its faces agree on the free side.

        Each edge is then used by two faces that meet there within its tolerance.
        """
        return self.openings.closed

    def mass_properties(self, density: float) -> MassProperties:
        """Return mass, centre and inertia of the solid that a closed body encloses.

        By the divergence theorem over the exact trimmed faces, to about 1e-9 (after Mirtich, Fast
        and accurate computation of polyhedral mass properties, 1996); if faces gape within the
        tolerance of their edges, to the volume of the gaps. `density` is a mass per length³.

        Raises
        ------
        InputError
            The density is not positive and finite.
        GeometryError
            The body is open.
        InputError
            Its normals point inward.

        >>> import contiga as cg
        >>> torus = cg.Body(cg.shapes.torus(major=3.0, minor=1.0)).mass_properties(density=1.0)
        >>> abs(torus.mass - 6.0 * math.pi**2) < 1e-9
        True
        """
        rho = positive(density, f"{self.name}, density")
        if not self.closed:
            raise GeometryError(
                "only a closed body has a mass of its own",
                where=self.name,
                found="; ".join(self.flaws) or "an open surface",
                allowed="a body that is closed, with normals outward",
                remedy="Give its mass, centre and inertia as numbers",
            )
        middle = self.bounds().mean(axis=0)
        moments = _MOMENTS.get_or_build(key_of(self), lambda: body_moments(self, middle))
        return of_volume(moments, middle, rho, self.name)

    def tessellate(
        self, tol: float, *, method: str = "chord", size: float | None = None
    ) -> TriMesh:
        """Return triangles of the faces inside their trims, without cracks at shared edges.

        `tol` is a length for "chord" and an area by patch for "net", as for patches. Sides longer
        than `size`, a length, are divided; if omitted, triangles are as large as the tolerance
        allows, so that a flat face has the points of its border only.

        Raises
        ------
        InputError, GeometryError
            Tolerance or size are not positive, or take more than 40 million triangles.
        """
        mesh = super().tessellate(tol, method=method)
        if size is None:
            return mesh
        from contiga.masters.sampling import refined

        return refined(self, mesh, size)

    def split(self, plane: tuple[ArrayLike, ArrayLike]) -> tuple[Body, Body]:
        """Cut the body in two by a plane, by OpenCASCADE.

        Closed pieces stay closed, by new flat faces in the plane; open ones are cut along it.

        Parameters
        ----------
        plane : a point (3,) of the plane, length, and its normal (3,)

        Returns
        -------
        Two bodies, on the side that the normal points to and on the other, in the body's unit and
        about its reference point.

        Raises
        ------
        InputError
            The plane is not a point and a normal.
        GeometryError
            The plane misses the body.
        MissingPackageError
            OpenCASCADE is not installed (extra ``cad``).

        Examples
        --------
        >>> import contiga as cg
        >>> ball = cg.Body([cg.shapes.sphere(radius=1.0)])
        >>> above, below = ball.split(([0.0, 0.0, 0.5], [0.0, 0.0, 1.0]))
        >>> above.closed, round(above.volume() / math.pi, 6), round(below.volume() / math.pi, 6)
        (True, 0.208333, 1.125)
        """
        # Imported by name: the room for OpenCASCADE is above this one, and loaded only here.
        parts: tuple[Body, Body] = import_module("contiga.io.cad.split_body").split(self, plane)
        return parts

    def project(
        self,
        points: ArrayLike,
        *,
        start: Projection | None = None,
        mode: str = "global",
        out: Projection | None = None,
    ) -> Projection:
        """Return feet of `points` (n, 3); see `contiga.search.track.project.project`."""
        from contiga.search.track.project import project

        return project(self, points, start, mode, out)

    def first_hit(self, p0: ArrayLike, p1: ArrayLike) -> Hit:
        """Return first entries on paths from `p0` to `p1` (n, 3); see `search.first_hit`."""
        from contiga.search.first_hit import first_hit

        return first_hit(self, as_points(p0, "p0"), as_points(p1, "p1"))

    def _normals_at(self, patch: IntArray, uv: FloatArray) -> FloatArray:
        """Return (k, 3) unit normals at places (patch, uv)."""
        out = np.empty((len(patch), 3))
        for index in np.unique(patch):
            rows = patch == index
            out[rows] = self.patches[index].normal(uv[rows])
        return out

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return which points (n, 3) are inside, or behind the nearest face of an open body.

        It is a mask (n,); points on the surface count.
        """
        from contiga.search.inside import contains

        return contains(self, as_points(points))

    @property
    def surface(self) -> ExactSurface:
        """The search on the body that contact uses; built at first use and kept."""
        from contiga.search.exact_surface import exact_surface

        return exact_surface(self)

    @property
    def faces(self) -> Faces:
        """The exact geometry: the body itself."""
        return self

    @property
    def n_pieces(self) -> int:
        """Number of patches."""
        return len(self.patches)

    @property
    def flaws(self) -> list[str]:
        """Faults where faces meet, a sentence each."""
        return self.openings.flaws

    def check(self) -> None:
        """Refuse a body that is a point, or so large or small that products of lengths overflow.

        Raises
        ------
        GeometryError
            It is such a body.
        """
        from contiga.search.tables import check_size

        check_size(self)

    def facts(self) -> dict[str, Any]:
        """Return facts on the body for a run's summary."""
        return {
            "kind": "body",
            "patches": len(self.patches),
            "trimmed": sum(trims is not None for trims in self.trims),
            "elements": self.surface.n_elements,
            "closed": self.closed,
            "size": self.size,
        }

    def condition_rows(self) -> list[tuple[str, str]]:
        """Return whether the body is closed, and the faults where its faces meet: (label, text)."""
        return self.openings.rows
