"""The condition of a mesh as a master, for users and for refusals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.codes import NO_TRIANGLE
from contiga.triangles.topology import topology_of
from contiga.triangles.triangle_arrays import TriangleArrays


class Condition(NamedTuple):
    """Counts of triangles, edges and vertices, after vertices at one place have been merged."""

    triangles: int
    """Number of triangles."""
    without_area: int
    """Triangles that do not count because their corners are on a line."""
    doubled: int
    """Repeated triangles of the same sense: the first counts."""
    back_to_back: int
    """Pairs of triangles with the same corners that face opposite ways; they are refused in a
    master."""
    turned_edges: int
    """Edges whose two triangles face opposite ways; they are refused in a master."""
    crowded_edges: int
    """Edges at which more than two triangles meet."""
    open_edges: int
    """Edges of one triangle only."""
    loose_vertices: int
    """Vertices of no triangle, which do not count."""
    volume: float | None
    """Enclosed volume, length³, negative if normals point inward; None if the mesh is open or has
    turned edges."""
    unit: str | None = None
    """Unit of length; None if unknown."""

    @property
    def closed(self) -> bool:
        """Whether there is a triangle with an area, and no edge of one triangle only."""
        return self.open_edges == 0 and self.triangles > self.without_area

    @property
    def rows(self) -> list[tuple[str, str]]:
        """Rows of a report (label, text): the surface, then each flaw that occurs."""
        texts = [
            (self.without_area, "triangles without area take no part"),
            (self.doubled, "triangles given twice count once"),
            (self.loose_vertices, "nodes of no triangle take no part"),
            (self.crowded_edges, "edges of more than two triangles"),
            (
                self.turned_edges,
                "edges with triangles that face opposite ways: no master "
                "unless orient = true turns them",
            ),
            (self.back_to_back, "pairs of triangles back to back: no master"),
        ]
        if self.triangles == self.without_area:
            surface = "none: no triangle has an area"
        elif self.volume is None:
            surface = f"open, {self.open_edges} edges of one triangle"
        else:
            inward = ", normals inward" if self.volume < 0.0 else ""
            unit = "" if self.unit is None else f" {self.unit}³"
            surface = f"closed, volume {self.volume:.6g}{unit}{inward}"
        return [("surface", surface), *(("", f"{count} {text}") for count, text in texts if count)]


def condition_of(mesh: TriangleArrays) -> Condition:
    """Return the condition of `mesh`, which may have no triangles; nothing is refused.

    >>> from contiga import TriMesh
    >>> ball = TriMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [1, 2, 0]])
    >>> condition_of(ball).doubled, condition_of(ball).open_edges
    (1, 3)
    """
    m = len(mesh.triangles)
    loose = len(mesh.vertices) - len(np.unique(mesh.triangles))
    if m == 0:
        return Condition(0, 0, 0, 0, 0, 0, 0, loose, None)
    t = topology_of(mesh)
    flat = int((t.twin < 0).sum())
    open_edges = int((t.neighbour == NO_TRIANGLE).sum())
    closed = open_edges == 0 and len(t.triangle) > 0 and t.turned == 0
    return Condition(
        triangles=m,
        without_area=flat,
        doubled=m - flat - len(t.triangle),
        back_to_back=len(t.back_to_back),
        turned_edges=t.turned,
        crowded_edges=t.crowded,
        open_edges=open_edges,
        loose_vertices=loose,
        volume=mesh.volume() if closed else None,
        unit=mesh.unit,
    )
