"""Cold and tracked projection onto a mesh of 80,000 triangles beside FCPW, on moving points."""

from __future__ import annotations

from typing import Any

import numpy as np

import contiga as cg
from benchmarks.scene import path, points, surface
from benchmarks.timing import median_seconds

POINTS = 500_000
STEPS = 5
SIDE = 200  # 2 · 200² = 80,000 triangles


def grid_mesh(patch: cg.NurbsSurface, side: int = SIDE) -> cg.TriMesh:
    """Two triangles a cell of an even grid of parameters."""
    x = np.linspace(0.0, 1.0, side + 1)
    uv = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    i = np.arange(len(uv)).reshape(len(x), len(x))
    a, b, c, d = i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]
    triangles = [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    return cg.TriMesh(patch.evaluate(uv), np.concatenate(triangles))


class Tracker:
    """Continues a projection over the steps it is given."""

    def __init__(self, master: cg.Body | cg.TriMesh, start: np.ndarray) -> None:
        self.master = master
        self.feet = master.project(start)

    def __call__(self, p: np.ndarray) -> None:
        self.feet = self.master.project(p, start=self.feet, mode="track")


class Fcpw:
    """FCPW's vectorised closest points; a mesh with single precision, as it keeps it."""

    def __init__(self, mesh: cg.TriMesh) -> None:
        import fcpw

        self.scene = fcpw.scene_3D()
        self.scene.set_object_count(1)
        self.scene.set_object_vertices(np.asfortranarray(mesh.vertices, dtype=np.float32), 0)
        self.scene.set_object_triangles(np.asfortranarray(mesh.triangles, dtype=np.int32), 0)
        self.scene.build(fcpw.aggregate_type.bvh_surface_area, True)
        self.found = fcpw.interaction_3D_list()
        self.radii = np.full(POINTS, np.inf, dtype=np.float32)

    def __call__(self, p: Any) -> None:
        self.scene.find_closest_points(p, self.radii, self.found)


def run() -> list[str]:
    """The lines of the table, ratios last."""
    patch = surface()
    mesh = grid_mesh(patch)
    rival = Fcpw(mesh)
    lines = [f"{len(mesh.triangles)} triangles, {POINTS} points; ns a point"]
    for order in ("sorted", "shuffled"):
        start = points(patch, POINTS, order)
        single = [np.asfortranarray(p, dtype=np.float32) for p in path(start, STEPS)]
        fcpw = 1e9 * median_seconds(rival, single) / POINTS
        cold = 1e9 * median_seconds(mesh.project, path(start, STEPS)) / POINTS
        tracked = 1e9 * median_seconds(Tracker(mesh, start), path(start, STEPS)) / POINTS
        exact = 1e9 * median_seconds(Tracker(cg.Body(patch), start), path(start, STEPS)) / POINTS
        lines += [
            f"{order:9s} FCPW {fcpw:6.0f}   cold {cold:6.0f}   tracked {tracked:6.0f}   "
            f"NURBS tracked {exact:6.0f}",
            f"{'':9s} cold takes {cold / fcpw:.2f} of FCPW's time, tracked {tracked / fcpw:.2f}",
        ]
    return lines
