"""A plain triangle mesh: the result of tessellation, and the faceted rival of an exact body."""

from __future__ import annotations

from typing import Any, Never, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from contiga.arrays.digest import Digest
from contiga.arrays.layout import positive
from contiga.arrays.queries import Queries
from contiga.display import Displayed, Facts
from contiga.errors import MeshError
from contiga.records import FloatArray, Hit, IntArray, MassProperties, Projection
from contiga.rigid import transform
from contiga.rigid.inertia import of_volume
from contiga.rigid.movable import Movable
from contiga.triangles.condition import Condition, condition_of
from contiga.triangles.exchange import Exchanged
from contiga.triangles.facet_feet import contains, project
from contiga.triangles.facet_hits import first_hit
from contiga.triangles.facet_surface import FacetedSurface, faceted_surface
from contiga.triangles.facet_tables import tables_of
from contiga.triangles.moments import moments
from contiga.triangles.orientation import turned_triangles


class TriMesh(Displayed, Movable, Queries, Exchanged):
    """Triangles over shared vertices. A mesh never changes; methods return new meshes.

    Parameters
    ----------
    vertices : (n, 3), finite
    triangles : (m, 3) indices into them, anticlockwise seen from the free side
    name : name in reports and messages
    normals : default kind of normals at feet: "facet" for the triangle's normal, "vertex" for the
        interpolated normals of its vertices
    unit : length unit of the coordinates, None if unknown
    reference_point : (3,) reference point of the wrench, length
    source : description of the cells that the triangles were made of

    Raises
    ------
    MeshError
        wrong shapes, coordinates that are not finite, indices that point at no vertex, an unknown
        kind of normals.

    >>> TriMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).area()
    0.5
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return _rebuild, (self.vertices, self.triangles, self._options())

    def _options(self) -> dict[str, Any]:
        """Return the arguments of a copy by name, except the arrays."""
        return {
            "name": self.name,
            "normals": self.normal_kind,
            "unit": self.unit,
            "reference_point": self.reference_point,
            "source": self.source,
        }

    def _with(
        self, vertices: ArrayLike | None = None, triangles: ArrayLike | None = None, **options: Any
    ) -> Self:
        """Return a copy with other vertices, triangles or options."""
        return type(self)(
            self.vertices if vertices is None else vertices,
            self.triangles if triangles is None else triangles,
            **(self._options() | options),
        )

    def _picture(self) -> bytes | None:
        from contiga.rendering.picture import picture_of  # kernels of its own

        return picture_of(self.vertices, self.triangles) if len(self.triangles) else None

    def _facts(self) -> Facts:
        return [("vertices", len(self.vertices)), ("triangles", len(self.triangles))]

    def mass_properties(self, density: float) -> MassProperties:
        """Return mass, centre and inertia of the solid inside a closed mesh, in closed form.

        They are sums of signed tetrahedra over the triangles. `density` is a mass per length³.

        Raises
        ------
        InputError
            The density is not positive and finite, or the normals point inward.
        MeshError
            The mesh is open, or cannot serve as a master: see `check`.
        """
        rho = positive(density, f"{self.name}, density")
        self.check()
        if not self.closed:
            raise MeshError(
                "only a closed mesh has a mass of its own",
                where=self.name,
                found=f"{len(self.open_edges())} edges of one triangle only",
                allowed="a mesh that is closed, with normals outward",
                remedy="Give its mass, centre and inertia as numbers",
            )
        middle = self.bounds().mean(axis=0)
        return of_volume(moments(self.corners() - middle), middle, rho, self.name)

    def flipped(self) -> Self:
        """Return the same mesh with its sides swapped: all triangles are reversed."""
        return self._with(triangles=self.triangles[:, ::-1])

    def renamed(self, name: str) -> Self:
        """Return the same mesh under another name."""
        return self._with(name=name)

    def compact(self) -> Self:
        """Return the same triangles over the vertices they use, in the same order."""
        used = np.zeros(len(self.vertices), dtype=bool)
        used[self.triangles] = True
        return self._with(self.vertices[used], (np.cumsum(used) - 1)[self.triangles])

    def oriented(self) -> Self:
        """Return the same triangles, reversed where needed for neighbours to face the same way.

        An open piece keeps the sense of most of its area; a closed piece faces outward.

        Raises
        ------
        MeshError
            A piece has one side only (a Möbius strip).
        """
        return self._with(triangles=turned_triangles(self.vertices, self.triangles, self.name))

    def with_reference_point(self, point: ArrayLike) -> Self:
        """Return the same mesh with another reference point (3,)."""
        return self._with(reference_point=point)

    def like(self, name: str, unit: str | None, reference_point: ArrayLike) -> Self:
        """Return the same mesh with the name, unit and reference point of a body it replaces."""
        return self._with(name=name, unit=unit, reference_point=reference_point)

    def tessellate(self, tol: float) -> Self:
        """Return the mesh itself: it has no finer shape, whatever `tol`."""
        return self

    def split(self, plane: object) -> Never:
        """Refuse: bodies of exact geometry are split (`Body.split`), meshes are not.

        Raises
        ------
        MeshError
            Always.
        """
        raise MeshError(
            "a mesh is not split by a plane",
            where=f"{self.name}.split(plane)",
            allowed="a body of exact geometry: cg.Body, cg.read_cad",
            remedy="Split the body that the mesh was made of, and mesh its parts: Body.tessellate",
        )

    def _moved(self, matrix: FloatArray) -> Self:
        """Return the mesh moved by a matrix (4, 4); a reflection keeps the sides of triangles."""
        order = -1 if transform.reflects(matrix) else 1
        return self._with(
            transform.apply(matrix, self.vertices),
            self.triangles[:, ::order],
            reference_point=transform.apply(matrix, self.reference_point[None, :])[0],
        )

    def project(
        self,
        points: ArrayLike,
        *,
        start: Projection | None = None,
        mode: str = "global",
        normals: str | None = None,
        out: Projection | None = None,
    ) -> Projection:
        """Return feet of `points` (n, 3); see `contiga.triangles.facet_feet.project`.

        `patch` is the triangle and `uv` the barycentric coordinates of the foot.
        """
        return project(self, points, start, mode, normals, out)

    def first_hit(self, p0: ArrayLike, p1: ArrayLike) -> Hit:
        """Return where points moving from `p0` to `p1` (n, 3) enter: see `facet_hits.first_hit`."""
        return first_hit(self, p0, p1)

    def _normals_at(self, patch: IntArray, uv: FloatArray) -> FloatArray:
        return self.normals()[patch]

    def condition(self) -> Condition:
        """Return counts of flaws of the mesh as a master (`Condition`); nothing is refused."""
        return condition_of(self)

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Return (n,) whether points are on the contact side of the closest triangle, or on it.

        A point beside an open mesh is not on that side: see
        `contiga.triangles.facet_feet.contains`.
        """
        return contains(self, points)

    @property
    def surface(self) -> FacetedSurface:
        """The search on the mesh that contact uses; its tables are built once and kept.

        Raises
        ------
        MeshError
            The mesh cannot serve as a master: see `check`.
        """
        return faceted_surface(self)

    @property
    def faces(self) -> None:
        """None: a mesh has no exact geometry."""
        return None

    @property
    def closed(self) -> bool:
        """Whether no edge belongs to one triangle only; MeshError if no triangle has an area."""
        return tables_of(self).closed

    @property
    def n_pieces(self) -> int:
        """Number of triangles."""
        return len(self.triangles)

    @property
    def flaws(self) -> list[str]:
        """Empty: faults of a mesh raise an error, or are in its `condition`."""
        return []

    def check(self) -> None:
        """Refuse a mesh that cannot serve as a master.

        Raises
        ------
        MeshError
            No triangle has an area, or neighbours face opposite ways or lie back to back.
        """
        faceted_surface(self)

    def digest(self, digest: Digest) -> None:
        """Add the arrays that decide results to a digest."""
        digest.arrays("about", np.asarray(self.reference_point))
        digest.arrays(f"mesh {self.normal_kind}", self.vertices, self.triangles)

    def facts(self) -> dict[str, Any]:
        """Return facts on the mesh for a run's summary, by name."""
        return {
            "kind": "mesh",
            "triangles": len(self.triangles),
            "source": self.source,
            "elements": self.surface.n_elements,
            "normals": self.normal_kind,
            "closed": self.closed,
            "size": self.size,
        }

    def condition_rows(self) -> list[tuple[str, str]]:
        """Return rows (label, text) of a report: source of the triangles, the surface, flaws.

        Vertices of no triangle are no flaw if the mesh is the skin of solids.
        """
        source = [("triangles", f"{len(self.triangles)} of {self.source}")] if self.source else []
        # The nodes inside solids are no flaw.
        mesh = self.compact() if "skinned" in self.source else self
        return [*source, *mesh.condition().rows]


def _rebuild(vertices: FloatArray, triangles: IntArray, options: dict[str, Any]) -> TriMesh:
    """Return the mesh of a pickle."""
    return TriMesh(vertices, triangles, **options)
