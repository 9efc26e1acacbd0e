"""Faces compared with the render meshes that a 3DM file stores of them.

A render mesh is coarse, but the program that wrote the file made it from the intended face. A
difference in area reveals a face that is cut along the wrong border; vertices, which lie on the
face, show where.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from contiga.geometry.kernels.trim_nb import points_in_trim
from contiga.geometry.trim_area import patch_areas
from contiga.io.cad.chart import Chart
from contiga.masters.body import Body
from contiga.records import FloatArray, IntArray

MAX_VERTICES = 100
"""Vertices of each face that are compared."""
N_BORDER = 65
"""Points of each p-curve of a border."""
AREA_TOL = 0.1
"""Largest relative difference of areas; flat facets have less area than a curved face."""
DISTANCE_TOL = 0.01
"""Largest distance of vertices from a face, over its size."""


class RenderMesh(NamedTuple):
    """The stored render mesh of a face: vertices (n, 3), triangles (m, 3) as rows of these."""

    vertices: FloatArray
    triangles: IntArray

    @property
    def area(self) -> float:
        """The area of its triangles."""
        a, b, c = (self.vertices[self.triangles[:, k]] for k in range(3))
        return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def render_mesh(face: Any) -> RenderMesh | None:
    """Return the stored render mesh of a rhino3dm.BrepFace; None if there is none, or an empty one.

    Quadrilaterals become two triangles; a triangle there has its last corner twice and gives a
    second one without area.
    """
    import rhino3dm

    mesh = face.GetMesh(rhino3dm.MeshType.Render)
    if mesh is None or len(mesh.Faces) == 0:
        return None
    vertices = np.array([(p.X, p.Y, p.Z) for p in mesh.Vertices.ToPoint3dArray()])
    corners = np.array([mesh.Faces[i] for i in range(len(mesh.Faces))])
    triangles = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    return RenderMesh(vertices, triangles)


def find_mismatches(body: Body, meshes: list[RenderMesh | None]) -> Iterator[tuple[int, str]]:
    """Yield index and difference, in words, of each patch that differs from its render mesh.

    It differs by more than `AREA_TOL` in area or `DISTANCE_TOL` in place. `meshes` are by patch;
    patches without a mesh, or with one without area, are not compared.
    """
    if not any(meshes):
        return
    areas = patch_areas(body, 1e-3)
    for k, mesh in enumerate(meshes):
        if mesh is None or not mesh.area > 0.0:
            continue
        size = float(np.ptp(mesh.vertices, axis=0).max())
        distance = _largest_distance(body, k, mesh)
        texts = []
        if abs(areas[k] - mesh.area) > AREA_TOL * mesh.area:
            texts.append(f"its area is {areas[k]:.6g}, that of its render mesh {mesh.area:.6g}")
        if distance > DISTANCE_TOL * size:
            texts.append(f"its render mesh is up to {distance:.3g} off it")
        if texts:
            yield k, " and ".join(texts)


def _largest_distance(body: Body, k: int, mesh: RenderMesh) -> float:
    """Return the largest distance of up to `MAX_VERTICES` vertices from patch `k` with its trims.

    For a vertex whose foot is outside the trims the distance to the nearest border counts, if that
    is larger.
    """
    used = np.unique(mesh.triangles)
    used = used[np.linspace(0, len(used) - 1, min(MAX_VERTICES, len(used))).astype(int)]
    points = mesh.vertices[used]
    chart = Chart(body.patches[k])
    uv = chart.project(points)
    distance = np.linalg.norm(chart.points(uv) - points, axis=1)
    loops = body.trims[k]
    if loops is not None:
        is_outside = ~points_in_trim(body.trim_tables, k, uv)
        to_border = np.full(len(points), np.inf)
        for curve in (curve for loop in loops for curve in loop) if is_outside.any() else ():
            border = chart.points(curve.evaluate(np.linspace(*curve.domain, N_BORDER))[:, :2])
            to_border[is_outside] = np.minimum(
                to_border[is_outside], distances_to_polyline(points[is_outside], border)
            )
        distance[is_outside] = np.maximum(distance[is_outside], to_border[is_outside])
    return float(distance.max())


def distances_to_polyline(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return the distances (n,) of points (n, 3) from a chain of lines (m, 3)."""
    start, side = corners[:-1], np.diff(corners, axis=0)
    offset = points[:, None] - start
    square = np.maximum(np.einsum("mi,mi->m", side, side), 1e-300)
    share = np.clip(np.einsum("nmi,mi->nm", offset, side) / square, 0.0, 1.0)
    distances: FloatArray = np.linalg.norm(offset - share[..., None] * side, axis=2).min(axis=1)
    return distances
