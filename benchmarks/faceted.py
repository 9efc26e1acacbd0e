"""Meshes as masters: projections onto 80,000 triangles beside FCPW, and what facets cost in errors.

The errors are those of a ball of radius 1 that turns about its axis under a cap of points 0.01
deep: of the depth, of the direction of the normal, and of the force, which should stay the same.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import contiga as cg
from benchmarks.rivals import grid_mesh
from benchmarks.scene import Tracker, path, points, surface
from benchmarks.timing import median_seconds
from contiga_validation.rivals.comparison import Fcpw

POINTS = 500_000
STEPS = 5
SIDE = 200  # 2 · 200² = 80,000 triangles
TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5)
DEPTH = 0.01
TURNS = 24


def cap(n: int = 4000) -> np.ndarray:
    """(n, 3) points `DEPTH` under the top of a ball of radius 1, evenly spread, up to 40° off."""
    k = np.arange(n) + 0.5
    z = 1.0 - (1.0 - np.cos(np.radians(40.0))) * k / n
    r, a = np.sqrt(1.0 - z * z), np.pi * (1.0 + np.sqrt(5.0)) * k
    return (1.0 - DEPTH) * np.stack([r * np.cos(a), r * np.sin(a), z], axis=1)


class Errors(NamedTuple):
    """Largest errors of a master that stands in for the ball."""

    depth: float
    """Of the distance, over the radius."""
    degrees: float
    """Of the normal."""
    noise: float
    """Of the force over a turn, from least to greatest, over its mean."""


def errors_of(ball: cg.Body | cg.TriMesh) -> Errors:
    """Of a ball that turns by 15° in small steps under points at rest."""
    points = cap()
    depth, angle, force = 0.0, 0.0, []
    for k in range(TURNS):
        turned = ball.rotated("z", np.radians(15.0) * k / TURNS)
        feet = turned.project(points)
        depth = max(depth, np.abs(feet.gap + DEPTH).max())
        off = np.linalg.norm(feet.normal - points / (1.0 - DEPTH), axis=1).max()
        angle = max(angle, 2.0 * np.degrees(np.arcsin(0.5 * off)))
        force.append((-feet.gap * feet.normal[:, 2]).sum())
    return Errors(depth, angle, np.ptp(force) / np.mean(force))


def errors() -> list[str]:
    """The table of errors, by chord tolerance."""
    shape = cg.shapes.sphere(radius=1.0).rotated("x", 0.7)
    lines = ["tolerance  triangles  normals  depth    normal   noise of the force"]
    for tol in TOLERANCES:
        mesh = shape.tessellate(tol)
        for normals in ("facet", "vertex"):
            e = errors_of(cg.TriMesh(mesh.vertices, mesh.triangles, normals=normals))
            lines.append(
                f"{tol:9.0e}  {len(mesh.triangles):9d}  {normals:7s}  {e.depth:.1e}  "
                f"{e.degrees:.1e}°  {e.noise:.1e}"
            )
    e = errors_of(cg.Body([shape]))
    lines.append(f"{'exact':>31s}  {e.depth:.1e}  {e.degrees:.1e}°  {e.noise:.1e}")
    return lines


def speeds() -> list[str]:
    """The table of times, ratios last."""
    patch = surface()
    mesh = grid_mesh(patch, SIDE)
    rival, radii = Fcpw(mesh), np.full(POINTS, np.inf, dtype=np.float32)
    lines = [f"{len(mesh.triangles)} triangles, {POINTS} points; ns a point"]
    for order in ("sorted", "shuffled"):
        start = points(patch, POINTS, order)
        single = [np.asfortranarray(p, dtype=np.float32) for p in path(start, STEPS)]
        fcpw = 1e9 * median_seconds(lambda p: rival(p, radii), single) / POINTS
        cold = 1e9 * median_seconds(mesh.project, path(start, STEPS)) / POINTS
        tracked = 1e9 * median_seconds(Tracker(mesh, start), path(start, STEPS)) / POINTS
        exact = 1e9 * median_seconds(Tracker(cg.Body(patch), start), path(start, STEPS)) / POINTS
        lines += [
            f"{order:9s} FCPW {fcpw:6.0f}   cold {cold:6.0f}   tracked {tracked:6.0f}   "
            f"NURBS tracked {exact:6.0f}",
            f"{'':9s} cold takes {cold / fcpw:.2f} of FCPW's time, tracked {tracked / fcpw:.2f}",
        ]
    return lines


def run() -> list[str]:
    """Both tables."""
    return [*speeds(), "", *errors()]
