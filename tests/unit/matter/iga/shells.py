"""Shells of tests: surfaces, what is held, and where they come to rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse.linalg import splu

from contiga import NurbsSurface, shapes
from contiga.geometry.knots import greville
from contiga.materials import Elastic
from contiga.matter.iga import Shell, assemble_shell
from contiga.patches.basis import VALUE, basis_at

ELASTIC = Elastic(young=3.0, poisson=0.3)


def refined(surface: NurbsSurface, degree: int, counts: tuple[int, int]) -> NurbsSurface:
    """Of a degree in u and v, with so many elements."""
    inner = [
        low + (high - low) * np.arange(1, n) / n
        for (low, high), n in zip(surface.domain, counts, strict=True)
    ]
    return surface.k_refined(tuple(degree - p for p in surface.degrees), *inner)


def plate(degree: int, counts: tuple[int, int], size: tuple[float, float]) -> NurbsSurface:
    """A flat one from 0 to `size` in x and y."""
    middle = (0.5 * size[0], 0.5 * size[1], 0.0)
    flat = shapes.plane(width=size[0], length=size[1], centre=middle)
    return refined(flat, degree, counts)


def crooked(degree: int, counts: tuple[int, int], seed: int = 0) -> NurbsSurface:
    """A rational one whose control points and weights are those of a plate, pushed about."""
    random = np.random.default_rng(seed)
    flat = plate(degree, counts, (2.0, 1.0))
    points = np.array(flat.control_points)
    points += 0.1 * random.normal(size=points.shape)
    weights = 1.0 + 0.3 * random.random(points.shape[:2])
    return NurbsSurface(flat.degrees, flat.knots, points, weights)


def made(surfaces: Sequence[NurbsSurface], **more: object) -> Shell:
    """A shell, elastic and a tenth thick if nothing else is said."""
    given = {"material": ELASTIC, "density": 2.0, "thickness": 0.1} | more
    return assemble_shell(surfaces, **given)


def arc(radius: float, start: float, stop: float) -> tuple[np.ndarray, np.ndarray]:
    """(3, 2) control points and (3,) weights of an arc between two angles, below π apart."""
    middle, half = 0.5 * (start + stop), 0.5 * (stop - start)
    angles, reach = np.array([start, middle, stop]), np.array([1.0, 1.0 / np.cos(half), 1.0])
    points = radius * reach[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points, np.array([1.0, np.cos(half), 1.0])


def tube(
    radius: float, length: float, angles: tuple[float, float], degree: int, counts: tuple[int, int]
) -> NurbsSurface:
    """A part of a cylinder about y: u along the angle in (x, z), v along y."""
    round_points, round_weights = arc(radius, *angles)
    points = np.empty((3, 2, 3))
    points[:, :, 0], points[:, :, 2] = round_points[:, :1], round_points[:, 1:]
    points[:, :, 1] = [0.0, length]
    weights = np.repeat(round_weights[:, None], 2, axis=1)
    knots = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0], [0.0, 0.0, 1.0, 1.0]
    return refined(NurbsSurface((2, 1), knots, points, weights), degree, counts)


def through(shell: Shell, places: np.ndarray) -> np.ndarray:
    """Control points of the surface of one patch that takes its sites to `places` (m, 3)."""
    patch = shell.net.pieces[0]
    means = [greville(knots, p) for knots, p in zip(patch.knots, patch.degrees, strict=True)]
    at = basis_at(patch, np.stack(np.meshgrid(*means, indexing="ij"), axis=2).reshape(-1, 2))
    matrix = np.zeros((len(places), len(places)))
    np.put_along_axis(matrix, at.control.astype(np.int64), at.values[:, VALUE], axis=1)
    return np.linalg.solve(matrix, places)


def still(shell: Shell, q: np.ndarray) -> tuple[np.ndarray, float]:
    """Forces and what is stored at q, from the start."""
    answer = shell.forces(shell.start(), q, np.zeros_like(q), 0.0)
    return answer.force, answer.energy.strain


def dead(shell: Shell, load: Sequence[float]) -> np.ndarray:
    """(m, 3) forces of a load by area at rest."""
    return shell.spread(shell.contact.weight[:, None] * np.asarray(load))


def free_ways(shell: Shell, *held: tuple[np.ndarray, str]) -> np.ndarray:
    """Numbers of the degrees of freedom that are not held: control points, and letters of ways."""
    free = np.ones(shell.nodes.shape, bool)
    for rows, ways in held:
        for way in ways:
            free[rows, "xyz".index(way)] = False
    return np.flatnonzero(free.ravel())


def bent_little(shell: Shell, free: np.ndarray, load: np.ndarray) -> np.ndarray:
    """(m, 3) displacements of linear theory."""
    stiffness = shell.tangent(shell.start())[free][:, free].tocsc()
    u = np.zeros(load.size)
    u[free] = splu(stiffness).solve(load.ravel()[free])
    return u.reshape(load.shape)


def settled(
    shell: Shell, free: np.ndarray, load: np.ndarray, parts: int, q: np.ndarray | None = None
) -> np.ndarray:
    """Control points at rest under a load that is put on in parts, by Newton's method."""
    q = shell.nodes.copy() if q is None else q.copy()
    start = shell.start()
    for part in range(1, parts + 1):
        for _ in range(40):
            miss = (still(shell, q)[0] + load * part / parts).ravel()[free]
            if np.abs(miss).max() < 1e-7 * np.abs(load).max():
                break
            stiffness = shell.tangent(start._replace(points=q))[free][:, free].tocsc()
            step = np.zeros(q.size)
            step[free] = splu(stiffness).solve(miss)
            q = q + step.reshape(q.shape)
        else:
            raise AssertionError("does not come to rest")
    return q
