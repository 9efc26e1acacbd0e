"""Sheets and their true curvatures."""

from __future__ import annotations

import numpy as np

import contiga as cg


def truth(patch, uv):
    """Extreme normal curvatures (towards the normal, away), |S_u|, |S_v| and their widths."""
    D, n = patch.derivatives(uv, order=2), patch.normal(uv)
    u, v = D[:, 1, 0], D[:, 0, 1]
    E, F, G = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    L, M, N = ((d * n).sum(1) for d in (D[:, 2, 0], D[:, 1, 1], D[:, 0, 2]))
    mean = (E * N - 2 * F * M + G * L) / (2 * (E * G - F * F))
    spread = np.sqrt(np.maximum(mean**2 - (L * N - M * M) / (E * G - F * F), 0.0))
    area = np.sqrt(E * G - F * F)
    return (
        mean + spread,
        spread - mean,
        np.sqrt(E),
        np.sqrt(G),
        area / np.sqrt(G),
        area / np.sqrt(E),
    )


def inside(patch, tables, e, cell, rng):
    """Points of a cell of an element: patch parameters, and what those span there."""
    box = tables.elements.table[e]["box"]
    span = np.array([box[1] - box[0], box[3] - box[2]])
    st = rng.uniform([cell[0], cell[2]], [cell[1], cell[3]], (400, 2))
    return np.array([box[0], box[2]]) + (st + 0.5) * span, span


def quadratic(rng, bent, twisted):
    """A sheet of one element over the unit square, of second order in each of its parameters."""
    u, v = np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0], indexing="ij")
    net = np.stack([u + 0.3 * rng.normal() * v, v, 0 * u], axis=-1)
    at = np.array([0.0, 0.0, 1.0])
    net += bent * (at * rng.normal(size=3))[:, None, None] * rng.normal(size=3)
    net += bent * (at * rng.normal(size=3))[None, :, None] * rng.normal(size=3)
    net += twisted * (u * v)[..., None] * rng.normal(size=3)
    knots = [0, 0, 0, 1, 1, 1]
    return cg.NurbsSurface((2, 2), (knots, knots), net)


def third_order(rng):
    """A sheet x = u, y = v, z = a u² v, about its middle."""
    x = [-0.5, 0.0, 0.5]
    z = np.multiply.outer([0.25, -0.25, 0.25], x) * rng.uniform(1.0, 3.0)
    u, v = np.meshgrid(x, x, indexing="ij")
    knots = [0, 0, 0, 1, 1, 1]
    return cg.NurbsSurface((2, 2), (knots, knots), np.stack([u, v, z], axis=-1))


SHEETS = {
    "flat": lambda rng: quadratic(rng, 0.0, 0.0),
    "bent": lambda rng: quadratic(rng, 0.5, 0.0),
    "twisted": lambda rng: quadratic(rng, 0.0, 0.8),
    "rough": lambda rng: quadratic(rng, 0.5, 0.5),
    "of third order": third_order,
}
