"""Comparison beyond the thesis: accuracy against time, both sides tuned and warm."""

from __future__ import annotations

from importlib import import_module
from itertools import pairwise
from math import ceil
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga import Body, Feature, Master, Projection, Status, TriMesh, clouds, shapes
from contiga_validation.engine.arrays import FloatArray, IntArray
from contiga_validation.rivals.rival_meshes import (
    SAMPLES,
    RivalMesh,
    fewest_triangles,
    rival_meshes,
)

POINTS = 100_000
STEPS = 4
ROUNDS = 3
"""Passes over the steps: forward, backward and forward again."""
DEPTH = 0.01
"""Largest depth of the points, in sizes of the body."""
STRIDE = 2e-3
"""Displacement of a point in a step, in sizes of the body."""
REACH = 2.5 * DEPTH
"""Depth down to which a point's foot must be the closest point of the body, in sizes of it."""
FOOT_TOL = 1e-9
"""Feet of a point that differ by less than this share of the size are one."""
MIN_PEER_ERROR = 1e-5
"""Smallest error of a mesh on which FCPW is run."""
NURBS = "NURBS"


class Row(NamedTuple):
    """Results of one master of one body."""

    body: str
    master: str
    target: float
    """Target Hausdorff error of the mesh over its size; zero for the exact master."""
    error: float | None
    """Measured Hausdorff error; None for a mesh that was not built."""
    elements: int
    fewest: float | None
    """Triangles of the best mesh with this error."""
    seconds: float | None
    """Time of a step of tracked points, kernels compiled."""
    exact_seconds: float
    """Time of the same step on the exact master, in turns with the mesh."""
    points: int
    depth_error: float | None
    """Error of the largest penetration, over the size."""
    worst_error: float | None
    """Largest error of a point's penetration, over the size."""
    force_error: float | None
    """Relative error of the sum of penetrations."""
    megabytes: float
    """Size of the search tables and the geometry; extrapolated for a mesh that was not built."""
    peer_seconds: float | None
    """Time of FCPW's closest points for the same step and mesh; None if it was not run."""


def bodies() -> dict[str, Body]:
    """Return the two bodies without a file, by name."""
    return {
        "bumpy plate": Body([shapes.bumpy_plate(width=1.0, length=1.0, amplitude=0.04, waves=2)]),
        "torus": Body([shapes.torus()]),
    }


class Path(NamedTuple):
    """Points on the body, and the path of points under its surface."""

    on: FloatArray
    """(m, 3) points on the body."""
    places: list[FloatArray]
    """Points (n, 3) at each step, from step 0."""
    feet: Projection
    """Feet of the first places on the body."""


def path(body: Body, n: int = POINTS, steps: int = STEPS) -> Path:
    """Return points under the surface at random depths, and their path in some steps.

    Points are omitted if at the start or the end their closest point is on an edge or a border, or
    if another part of the body is about as near: a mesh might find the penetration of that part.
    """
    rng = np.random.default_rng(7)
    on, feet = _points_on(body, n)
    depth = DEPTH * body.size * rng.random(len(on))
    start = feet.point - depth[:, None] * feet.normal
    turn = rng.standard_normal(3)
    away = STRIDE * body.size * np.cross(feet.normal, turn / np.linalg.norm(turn))
    places = [start + k * away for k in range(steps + 1)]
    first = followed = body.project(start, start=feet, mode="track")
    for place in places[1:]:
        followed = body.project(place, start=followed, mode="track")
    rows = np.flatnonzero(_alone(body, feet) & _alone(body, followed)).astype(np.int32)
    return Path(on, [np.ascontiguousarray(place[rows]) for place in places], _rows_of(first, rows))


def _points_on(body: Body, n: int) -> tuple[FloatArray, Projection]:
    """Return about `n` random points (m, 3) on the trimmed faces, and their feet.

    Points of patches beyond the faces are left out; the draw is repeated once to make up for them.
    """

    def draw(count: int) -> tuple[FloatArray, Projection, IntArray]:
        areas = np.array([patch.net_area() for patch in body.patches])
        counts = np.floor(count * areas / areas.sum()).astype(int)
        counts[np.argmax(counts)] += count - counts.sum()
        on = np.concatenate(
            [clouds.random_on(p, int(c), seed=3) for p, c in zip(body.patches, counts, strict=True)]
        )
        feet = body.project(on)
        return on, feet, np.flatnonzero(np.abs(feet.gap) <= FOOT_TOL * body.size).astype(np.int32)

    on, feet, rows = draw(n)
    if len(rows) < len(on):  # patches reach beyond their faces
        on, feet, rows = draw(ceil(n * len(on) / max(1, len(rows))))
    return on[rows], _rows_of(feet, rows)


def _rows_of(feet: Projection, rows: IntArray) -> Projection:
    """Return the projection of some points, by their rows."""
    return Projection._make(column[rows] for column in feet)


def _alone(body: Body, feet: Projection) -> np.ndarray:
    """Return a mask (n,) of the feet on a face that are closest to points `REACH` below them."""
    reach = REACH * body.size
    below = body.project(feet.point - reach * feet.normal)
    on_face = (feet.status == Status.OK) & (feet.feature == Feature.FACE)
    return np.asarray(on_face & (np.abs(below.gap + reach) <= FOOT_TOL * body.size))


class Tracker:
    """Follows points over a master; `feet` are those of the last step.

    Without `feet`, those of the first places are searched.
    """

    def __init__(
        self, master: Master, places: list[FloatArray], feet: Projection | None = None
    ) -> None:
        self.master, self.places = master, places
        self.feet = master.project(places[0]) if feet is None else feet

    def __call__(self, k: int) -> None:
        """Follow the points to step k."""
        self.feet = self.master.project(self.places[k], start=self.feet, mode="track")


class Fcpw:
    """FCPW's vectorised closest points on a mesh, in its single precision."""

    def __init__(self, mesh: TriMesh) -> None:
        fcpw = import_module("fcpw")
        self.scene = fcpw.scene_3D()
        self.scene.set_object_count(1)
        self.scene.set_object_vertices(np.asfortranarray(mesh.vertices, dtype=np.float32), 0)
        self.scene.set_object_triangles(np.asfortranarray(mesh.triangles, dtype=np.int32), 0)
        self.scene.build(fcpw.aggregate_type.bvh_surface_area, True)
        self.found = fcpw.interaction_3D_list()

    def __call__(self, points: NDArray[np.float32], radii: NDArray[np.float32]) -> None:
        """Find the closest points of `points` (n, 3), in Fortran order, within √`radii` (n,).

        They are stored in `found`.
        """
        self.scene.find_closest_points(points, radii, self.found)


def has_peer() -> bool:
    """Return whether FCPW is installed."""
    try:
        import_module("fcpw")
    except ImportError:
        return False
    return True


def race(runners: list[Tracker], steps: int, rounds: int) -> list[float]:
    """Return the least time of a step of each runner, seconds.

    The runners alternate, so that a slow moment of the machine hits all. The steps are run forward
    and backward in turn, in an odd number `rounds` of passes, so that runners end at the last step.
    """
    forward, backward = range(1, steps + 1), range(steps - 1, -1, -1)
    best = [np.inf] * len(runners)
    for k in (k for n in range(rounds) for k in (backward if n % 2 else forward)):
        for i, runner in enumerate(runners):
            start = perf_counter()
            runner(k)
            best[i] = min(best[i], perf_counter() - start)
    return best


def _peer_seconds(mesh: TriMesh, places: list[FloatArray]) -> float:
    """Return the least time of FCPW for a step, seconds.

    It starts anew each time, with an upper bound of the distance: that of the step before plus the
    displacement since. The time to compute the bound is not counted.
    """
    runner, best = Fcpw(mesh), np.inf
    for before, place in pairwise(places):
        displacement = np.linalg.norm(place - before, axis=1)
        distance = np.abs(mesh.project(before).gap) + displacement
        radii = np.square(1.001 * distance).astype(np.float32)
        points = np.asfortranarray(place, dtype=np.float32)
        start = perf_counter()
        runner(points, radii)
        best = min(best, perf_counter() - start)
    return best


def accuracy(name: str, body: Body, max_triangles: int, n: int = POINTS) -> list[Row]:
    """Return time, error and memory of every master of a body, the exact one first.

    The exact master runs beside each mesh; its own row has the best of these times. Its errors are
    bounds (`foot_miss`).

    Parameters
    ----------
    name, body : the body, and its name in the rows
    max_triangles : number of triangles of the largest mesh that is built
    n : number of points
    """
    on, places, start = path(body, n)
    exact = Tracker(body, places, start)
    (seconds,) = race([exact], STEPS, ROUNDS)
    feet = exact.feet
    depth = np.maximum(-feet.gap, 0.0)
    miss = foot_miss(body, places[-1], feet)
    bound = miss / body.size
    count, memory = body.surface.n_elements, body.surface.nbytes / 1e6
    share = miss * len(depth) / float(depth.sum())
    first = Row(name, NURBS, 0.0, 0.0, count, None, seconds, seconds, len(depth),
                bound, bound, share, memory, None)  # fmt: skip
    rows = [first]
    for rival in rival_meshes(body, on[:: max(1, len(on) // SAMPLES)], max_triangles):
        rows.append(_mesh_row(rows[-1], rival, body, exact))
    best = min(row.exact_seconds for row in rows)
    return [first._replace(seconds=best, exact_seconds=best), *rows[1:]]


def _mesh_row(last: Row, rival: RivalMesh, body: Body, exact: Tracker) -> Row:
    """Return the row of a mesh; `last` is the row before, from which memory is extrapolated.

    Only the extrapolated row of a mesh that was not built has infinite `exact_seconds`.
    """
    title, count = f"mesh {rival.target:.0e}", rival.triangles
    fewest = fewest_triangles(body, rival.target * body.size)
    if rival.mesh is None:
        memory = last.megabytes * count / last.elements
        return Row(last.body, title, rival.target, None, count, fewest, None, np.inf, last.points,
                   None, None, None, memory, None)  # fmt: skip
    mesh, places = rival.mesh, exact.places
    tracker = Tracker(mesh, places)
    seconds, exact_seconds = race([tracker, exact], STEPS, ROUNDS)
    peer = has_peer() and rival.target >= MIN_PEER_ERROR
    peer_seconds = _peer_seconds(mesh, places) if peer else None
    depth, mesh_depth = (np.maximum(-t.feet.gap, 0.0) for t in (exact, tracker))
    memory = (mesh.surface.nbytes + mesh.vertices.nbytes + mesh.triangles.nbytes) / 1e6
    return Row(
        last.body, title, rival.target, rival.error, count, fewest, seconds, exact_seconds,
        len(depth), float(abs(mesh_depth.max() - depth.max()) / body.size),
        float(np.abs(mesh_depth - depth).max() / body.size),
        float(abs(mesh_depth.sum() / depth.sum() - 1.0)),
        memory, peer_seconds,
    )  # fmt: skip


def foot_miss(body: Body, points: FloatArray, feet: Projection) -> float:
    """Return a bound of the errors of penetrations on the exact master, length.

    Feet are evaluated anew on the untrimmed patches. The bound is the largest tangential offset of
    a point from its foot, which changes the distance by less than itself, or the largest error of a
    gap.
    """
    worst = 0.0
    for k, patch in enumerate(body.patches):
        rows = feet.patch == k
        if not rows.any():
            continue
        place, normal = patch.evaluate(feet.uv[rows]), patch.normal(feet.uv[rows])
        offset = points[rows] - place
        tangential = offset - (offset * normal).sum(axis=1)[:, None] * normal
        gap_error = np.abs((offset * normal).sum(axis=1) - feet.gap[rows])
        # A foot that is off by t changes the distance by t²/2d; t itself bounds both.
        worst = max(worst, float(np.linalg.norm(tangential, axis=1).max()), float(gap_error.max()))
    return worst
