"""Meshes of a body at wanted Hausdorff errors, as the fair rival of its exact geometry.

A tessellation keeps to its tolerance and may be finer than it need be. Here its distance from the
body is measured, and the tolerance is changed until the measured distance is the wanted one: the
same kind of mesh with as few triangles as it takes.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from contiga import Body, TriMesh
from contiga_validation.engine.arrays import FloatArray

ERRORS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Wanted Hausdorff errors, relative to the size of the body."""
SAMPLES = 30_000
"""Points of the body the distance is measured at."""
NEAR = 0.1
"""Natural logarithm of measured over wanted error that is let pass."""


class RivalMesh(NamedTuple):
    """A mesh, or what is known of it where it was not built."""

    wanted: float
    error: float | None
    """Measured Hausdorff distance of the body from the mesh over its size; None if not built."""
    triangles: int
    """Of the mesh, or extrapolated: their number goes with one over the error."""
    mesh: TriMesh | None


def rival_meshes(body: Body, on: FloatArray, most: int) -> Iterator[RivalMesh]:
    """Meshes of `body`, one for each of `ERRORS`, coarse to fine.

    Parameters
    ----------
    on : (n, 3) points of the body, where the distance of a mesh is measured
    most : triangles of the largest mesh that is built
    """
    last: RivalMesh | None = None
    slack = 1.0
    for wanted in ERRORS:
        if last is not None:
            expected = ceil(last.triangles * last.wanted / wanted)
            # A coarse mesh may have triangles that its tolerance does not ask for.
            if last.mesh is None or (last.wanted <= 1e-3 and expected > most):
                last = RivalMesh(wanted, None, expected, None)
                yield last
                continue
        mesh, error, slack = _calibrated(body, on, wanted, slack)
        last = RivalMesh(wanted, error, len(mesh.triangles), mesh)
        yield last


def _calibrated(
    body: Body, on: FloatArray, wanted: float, slack: float
) -> tuple[TriMesh, float, float]:
    """A mesh with about the `wanted` error, its error, and tolerance over error."""

    def at(slack: float) -> tuple[TriMesh, float, float]:
        mesh = body.tessellate(wanted * slack * body.size)
        error = hausdorff(mesh, on) / body.size
        return mesh, error, wanted * slack / error

    first = at(slack)
    if abs(np.log(first[1] / wanted)) < NEAR:
        return first
    second = at(first[2])
    return min(first, second, key=lambda found: abs(np.log(found[1] / wanted)))


def hausdorff(mesh: TriMesh, on: FloatArray) -> float:
    """Largest distance of the points `on` from the mesh."""
    return float(np.linalg.norm(on - mesh.project(on).point, axis=1).max())


def fewest_triangles(body: Body, error: float) -> float:
    """The least number of triangles with corners on the body for a small Hausdorff `error`.

    Over a piece of surface with Gauss curvature K the largest triangle that stays within a small
    distance e has the area 3√3/2 · e/√K where K > 0 and 2√5 · e/√|K| where K < 0 (Pottmann,
    Krasauskas, Hamann, Joy, Seibold: On piecewise linear approximation of quadratic functions,
    2000). Trims are left out of account.
    """
    total = 0.0
    for patch in body.patches:
        uv, weight = _quadrature(patch.domain, 96)
        d = patch.derivatives(uv, 2)
        cross = np.cross(d[:, 1, 0], d[:, 0, 1])
        jacobian = np.linalg.norm(cross, axis=1)
        good = jacobian > 1e-9 * jacobian.max()
        n = cross[good] / jacobian[good, None]
        second = [(d[good, a, b] * n).sum(axis=1) for a, b in ((2, 0), (1, 1), (0, 2))]
        # √|K| dA = √|LN − M²| du dv
        discriminant = second[0] * second[2] - second[1] ** 2
        share = np.where(discriminant > 0.0, 2.0 / (3.0 * sqrt(3.0)), 1.0 / (2.0 * sqrt(5.0)))
        total += float((weight[good] * share * np.sqrt(np.abs(discriminant))).sum())
    return total / error


def _quadrature(
    domain: tuple[tuple[float, float], tuple[float, float]], count: int
) -> tuple[FloatArray, FloatArray]:
    """Mid-points of `count` × `count` cells of a rectangle, and their areas."""
    middles = (np.arange(count) + 0.5) / count
    (u0, u1), (v0, v1) = domain
    uv = np.stack(np.meshgrid(u0 + (u1 - u0) * middles, v0 + (v1 - v0) * middles), -1)
    return uv.reshape(-1, 2), np.full(count * count, (u1 - u0) * (v1 - v0) / count**2)
