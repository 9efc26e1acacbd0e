"""Every triangle against every point in extended precision, written apart from the kernels."""

from __future__ import annotations

import numpy as np

from contiga import TriMesh, shapes


def _to_segments(p, a, b):
    e = b - a
    t = np.clip(((p - a) * e).sum(-1) / (e * e).sum(-1), 0.0, 1.0)
    return np.linalg.norm(p - a - t[..., None] * e, axis=-1)


def distances(mesh: TriMesh, points: np.ndarray) -> np.ndarray:
    """(n, m) distance of each point to each triangle."""
    p = np.asarray(points, dtype=np.longdouble)[:, None]
    a, b, c = mesh.corners().astype(np.longdouble).transpose(1, 0, 2)
    n = np.cross(b - a, c - a)
    nn = (n * n).sum(-1)
    w = p - a
    u = (np.cross(w, c - a) * n).sum(-1) / nn
    v = (np.cross(b - a, w) * n).sum(-1) / nn
    height = np.abs((w * n).sum(-1)) / np.sqrt(nn)
    rim = np.minimum.reduce([_to_segments(p, *s) for s in ((a, b), (b, c), (c, a))])
    return np.where((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0), height, rim).astype(float)


def windings(mesh: TriMesh, points: np.ndarray) -> np.ndarray:
    """(n,) how often a closed mesh goes around each point: the sum of the solid angles of its
    triangles (Van Oosterom and Strackee 1983)."""
    a, b, c = mesh.corners().transpose(1, 0, 2)[:, None] - np.asarray(points)[:, None]
    x, y, z = (np.linalg.norm(side, axis=-1) for side in (a, b, c))
    cosine = x * y * z + (a * b).sum(-1) * z + (b * c).sum(-1) * x + (c * a).sum(-1) * y
    return np.arctan2((a * np.cross(b, c)).sum(-1), cosine).sum(axis=1) / (2.0 * np.pi)


def entries(mesh: TriMesh, p0: np.ndarray, p1: np.ndarray) -> np.ndarray:
    """(n, m) fraction at which each path crosses each triangle from its free side, or infinity."""
    p, q = np.asarray(p0, dtype=float)[:, None], np.asarray(p1, dtype=float)[:, None]
    a, b, c = mesh.corners().transpose(1, 0, 2)
    n = np.cross(b - a, c - a)
    d = q - p
    rate = (d * n).sum(-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        tau = -((p - a) * n).sum(-1) / rate
        x = p + tau[..., None] * d
        nn = (n * n).sum(-1)
        u = (np.cross(x - a, c - a) * n).sum(-1) / nn
        v = (np.cross(b - a, x - a) * n).sum(-1) / nn
    e = 1e-9
    hit = (rate < 0.0) & (u >= -e) & (v >= -e) & (u + v <= 1.0 + e) & (tau >= 0.0) & (tau <= 1.0)
    return np.where(hit, tau, np.inf)


def on_triangles(mesh: TriMesh, patch: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """(n, 3) points of triangles by their barycentric coordinates."""
    a, b, c = mesh.corners()[patch].transpose(1, 0, 2)
    u, v = uv[:, :1], uv[:, 1:]
    return (1.0 - u - v) * a + u * b + v * c


def box(size: float = 1.0) -> TriMesh:
    """A cube about the origin, normals outward."""
    x = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - 0.5
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return TriMesh(size * x, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def together(*meshes: TriMesh) -> TriMesh:
    """Several meshes as one."""
    first = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return TriMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.triangles + n for mesh, n in zip(meshes, first, strict=False)]),
    )


def star(seed: int, spread: float) -> TriMesh:
    """A ball whose vertices are moved outward and inward at random: sharp edges of both kinds."""
    ball = shapes.sphere(radius=1.0).tessellate(0.05)
    away = np.exp(spread * np.random.default_rng(seed).normal(size=(len(ball.vertices), 1)))
    return TriMesh(ball.vertices * away, ball.triangles)


def rough(seed: int, side: int = 9) -> TriMesh:
    """An open, bumpy sheet over the square [0, 1]²."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0.0, 1.0, side)
    grid = np.stack([*np.meshgrid(x, x, indexing="ij"), 0.2 * rng.normal(size=(side, side))], -1)
    i = np.arange(side * side).reshape(side, side)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return TriMesh(
        grid.reshape(-1, 3), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    )
