"""Sheets and their true curvatures."""

from __future__ import annotations

import numpy as np


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
