"""Meshes of a body with given Hausdorff errors, as fair rivals of its exact geometry.

A tessellation keeps its tolerance and may be finer than necessary. Here its distance from the body
is measured, and the tolerance is adjusted until the measured distance is the target: the same kind
of mesh with as few triangles as necessary.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from contiga import Body, TriMesh
from contiga_validation.engine.arrays import FloatArray

ERRORS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Target Hausdorff errors, relative to the size of the body."""
N_CELLS = 96
"""Cells in each direction of a patch for its integral of curvature."""
SAMPLES = 30_000
"""Points of the body at which the distance is measured."""
LOG_TOL = 0.1
"""Accepted natural logarithm of measured over target error."""


class RivalMesh(NamedTuple):
    """A mesh, or an estimate of one that was not built."""

    target: float
    """Hausdorff error over size."""
    error: float | None
    """Measured Hausdorff distance of the body from the mesh over its size; None if not built."""
    triangles: int
    """Number of triangles, or an extrapolation: it is proportional to one over the error."""
    mesh: TriMesh | None


def rival_meshes(body: Body, on: FloatArray, max_triangles: int) -> Iterator[RivalMesh]:
    """Yield meshes of `body`, one for each of `ERRORS`, coarse to fine.

    Meshes finer than 1e-3 with more than `max_triangles` expected triangles, and all after them,
    are estimates without a mesh.

    Parameters
    ----------
    on : (n, 3) points of the body at which the distance of a mesh is measured
    max_triangles : of the largest mesh that is built
    """
    last: RivalMesh | None = None
    slack = 1.0
    for target in ERRORS:
        if last is not None:
            expected = ceil(last.triangles * last.target / target)
            # A coarse mesh may have more triangles than its tolerance needs.
            if last.mesh is None or (last.target <= 1e-3 and expected > max_triangles):
                last = RivalMesh(target, None, expected, None)
                yield last
                continue
        mesh, error, slack = _calibrated(body, on, target, slack)
        last = RivalMesh(target, error, len(mesh.triangles), mesh)
        yield last


def _calibrated(
    body: Body, on: FloatArray, target: float, slack: float
) -> tuple[TriMesh, float, float]:
    """Return a mesh with about the `target` error, its error, and tolerance over error.

    The tolerance is `slack` times the target. If the error is off by more than `LOG_TOL`, a second
    mesh is made by the measured slack, and the better of both is returned, so its error may still
    be off. Errors are over the size of the body.
    """

    def at(slack: float) -> tuple[TriMesh, float, float]:
        mesh = body.tessellate(target * slack * body.size)
        error = hausdorff(mesh, on) / body.size
        return mesh, error, target * slack / error

    first = at(slack)
    if abs(np.log(first[1] / target)) < LOG_TOL:
        return first
    second = at(first[2])
    return min(first, second, key=lambda trial: abs(np.log(trial[1] / target)))


def hausdorff(mesh: TriMesh, on: FloatArray) -> float:
    """Return the largest distance of the points `on` (n, 3) from the mesh: a one-sided bound."""
    return float(np.linalg.norm(on - mesh.project(on).point, axis=1).max())


def fewest_triangles(body: Body, error: float) -> float:
    """Return the least number of triangles with corners on the body for a small Hausdorff `error`.

    Over a piece of surface with Gauss curvature K the largest triangle that stays within a small
    distance e has the area 3√3/2 · e/√K where K > 0 and 2√5 · e/√|K| where K < 0 (Pottmann,
    Krasauskas, Hamann, Joy, Seibold: On piecewise linear approximation of quadratic functions,
    2000). Trims are not considered.
    """
    total = 0.0
    for patch in body.patches:
        # Midpoint rule on cells of the domain.
        middles = (np.arange(N_CELLS) + 0.5) / N_CELLS
        (u0, u1), (v0, v1) = patch.domain
        u, v = u0 + (u1 - u0) * middles, v0 + (v1 - v0) * middles
        uv = np.stack(np.meshgrid(u, v), -1).reshape(-1, 2)
        weight = (u1 - u0) * (v1 - v0) / N_CELLS**2
        d = patch.derivatives(uv, 2)
        cross = np.cross(d[:, 1, 0], d[:, 0, 1])
        jacobian = np.linalg.norm(cross, axis=1)
        good = jacobian > 1e-9 * jacobian.max()
        n = cross[good] / jacobian[good, None]
        second = [(d[good, a, b] * n).sum(axis=1) for a, b in ((2, 0), (1, 1), (0, 2))]
        # √|K| dA = √|LN − M²| du dv
        discriminant = second[0] * second[2] - second[1] ** 2
        share = np.where(discriminant > 0.0, 2.0 / (3.0 * sqrt(3.0)), 1.0 / (2.0 * sqrt(5.0)))
        total += float((weight * share * np.sqrt(np.abs(discriminant))).sum())
    return total / error
