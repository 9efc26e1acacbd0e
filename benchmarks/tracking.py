"""Tracked projection of a million moving points beside splinepy and FCPW, on the same surface."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

import contiga as cg
from benchmarks.scene import path, points, surface
from benchmarks.timing import median_seconds
from contiga.num.threads import thread_count

POINTS = 1_000_000
STEPS = 6
SPLINEPY_POINTS = 50_000
TRIANGLES_A_SIDE = 200  # 2 · 200² = 80,000 triangles


class Row(NamedTuple):
    """One line of the table."""

    name: str
    nanoseconds: float
    error: float
    """Largest error of the distance where contiga's own check gives one, else NaN."""


class Tracker:
    """Continues a projection over the steps it is given."""

    def __init__(self, body: cg.Body, start: np.ndarray) -> None:
        self.body = body
        self.feet = body.project(start)

    def __call__(self, p: np.ndarray) -> None:
        self.feet = self.body.project(p, start=self.feet, mode="track")


def contiga_tracked(patch: cg.NurbsSurface, order: str) -> Row:
    """Nanoseconds a point of `Body.project(mode="track")`, records written included."""
    start = points(patch, POINTS, order)
    tracker = Tracker(cg.Body(patch), start)
    seconds = median_seconds(tracker, path(start, STEPS))
    last = list(path(start, STEPS))[-1]
    return Row(f"contiga track, {order}", 1e9 * seconds / POINTS, _worst(patch, tracker.feet, last))


def _worst(patch: cg.NurbsSurface, feet: cg.Projection, p: np.ndarray) -> float:
    """Largest tangential miss |S_u·(S − P)|/|S_u| of feet inside the patch, on a sample."""
    rows = np.flatnonzero(feet.feature == cg.Feature.FACE)[::97]
    d = patch.derivatives(feet.uv[rows], 1)
    r = d[:, 0, 0] - p[rows]
    misses = [
        np.abs((r * d[:, a, b]).sum(1)) / np.linalg.norm(d[:, a, b], axis=1)
        for a, b in ((1, 0), (0, 1))
    ]
    return float(np.max(misses))


def contiga_global(patch: cg.NurbsSurface) -> Row:
    """Cold closest points of the same cloud, a tenth of it."""
    p = points(patch, POINTS // 10, "shuffled")
    body = cg.Body(patch)
    seconds = median_seconds(body.project, path(p, 3))
    return Row("contiga global (cold), shuffled", 1e9 * seconds / len(p), float("nan"))


def splinepy_proximities(patch: cg.NurbsSurface) -> Row:
    """splinepy's point inversion on all threads, its k-d tree planted once."""
    import splinepy

    net = patch.control_points.transpose(1, 0, 2).reshape(-1, 3)  # its first parameter runs first
    other = splinepy.NURBS(
        degrees=list(patch.degrees),
        knot_vectors=[list(k) for k in patch.knots],
        control_points=net,
        weights=patch.weights.T.reshape(-1, 1),
    )
    start = points(patch, SPLINEPY_POINTS, "sorted")
    other.proximities(start[:1], initial_guess_sample_resolutions=[48, 48], nthreads=1)

    def work(p: np.ndarray) -> Any:
        return other.proximities(
            p,
            initial_guess_sample_resolutions=[-1, -1],
            tolerance=1e-10,
            nthreads=thread_count(),
            return_verbose=True,
        )

    seconds = median_seconds(work, path(start, 3))
    return Row("splinepy proximities", 1e9 * seconds / len(start), float("nan"))


def fcpw_closest(patch: cg.NurbsSurface, order: str) -> Row:
    """FCPW's vectorised closest points on a mesh of 80,000 triangles of the surface."""
    import fcpw

    x = np.linspace(0.0, 1.0, TRIANGLES_A_SIDE + 1)
    uv = np.stack(np.meshgrid(x, x, indexing="ij"), axis=-1).reshape(-1, 2)
    vertices = patch.evaluate(uv)
    index = np.arange(len(uv)).reshape(len(x), len(x))
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    triangles = np.concatenate(
        [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    )
    scene = fcpw.scene_3D()
    scene.set_object_count(1)
    scene.set_object_vertices(np.asfortranarray(vertices, dtype=np.float32), 0)
    scene.set_object_triangles(np.asfortranarray(triangles, dtype=np.int32), 0)
    scene.build(fcpw.aggregate_type.bvh_surface_area, True)
    start = points(patch, POINTS, order)
    radii = np.full(len(start), np.inf, dtype=np.float32)
    found = fcpw.interaction_3D_list()

    def work(p: np.ndarray) -> None:
        scene.find_closest_points(p, radii, found)

    moving = (np.asfortranarray(p, dtype=np.float32) for p in path(start, 4))
    seconds = median_seconds(work, moving)
    return Row(f"FCPW, 80,000 triangles, {order}", 1e9 * seconds / len(start), float("nan"))


def state_bytes(n: int = 10_000) -> float:
    """Bytes of state a slave point."""
    patch = surface()
    cloud = points(patch, n, "sorted")
    slave = cg.Slave(cloud, area=np.full(n, 1.0 / n))
    state = cg.Contact(cg.Body(patch), slave, law=cg.PenaltyLaw(1.0)).start(cloud)
    arrays = [v for v in vars(state).values() if isinstance(v, np.ndarray) and v.shape[:1] == (n,)]
    return sum(v.nbytes for v in arrays) / n


def run() -> list[str]:
    """The lines of the table, ratios last."""
    patch = surface()
    ours = {order: contiga_tracked(patch, order) for order in ("sorted", "shuffled")}
    cold = contiga_global(patch)
    rival = splinepy_proximities(patch)
    mesh = {order: fcpw_closest(patch, order) for order in ("sorted", "shuffled")}
    lines = [f"{'':34}{'ns a point':>12}{'worst miss':>14}"]
    for row in (*ours.values(), cold, rival, *mesh.values()):
        miss = "" if np.isnan(row.error) else f"{row.error:.1e}"
        lines.append(f"{row.name:34}{row.nanoseconds:12.0f}{miss:>14}")
    for order, row in ours.items():
        lines.append(
            f"track, {order}: {rival.nanoseconds / row.nanoseconds:.0f} × splinepy, "
            f"{mesh[order].nanoseconds / row.nanoseconds:.1f} × FCPW"
        )
    lines.append(f"state: {state_bytes():.0f} bytes a slave point")
    return lines
