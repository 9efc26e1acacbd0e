"""What the certificate of trimmed edges says of a strip along one holds for all within bounds."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from contiga.search.kernels import edge_nb

from .strips import creases, turned

pytestmark = pytest.mark.interpreted


@njit
def reach_of(tangent, strand, joint, ends):
    nothing = (0.0, 0.0, 0.0)
    frame = (nothing, tangent, nothing, nothing)
    return edge_nb._reach_of((True, frame, frame, 0.0, strand, (0, 0.0, 0.0), joint), ends)


@njit
def seen_along(bend, b, ends, reach, bent):
    nothing = (0.0, 0.0, 0.0)
    return edge_nb._seen_along(bend, (nothing, nothing, b, nothing), ends, reach, bent)


def test_what_is_seen_from_an_edge_is_no_farther_off_and_leads_no_more_along_it_than_told():
    """From a strand within its bend, off by its width, whose tangents are off by its slip or turn.

    A face that is off by one of these and not by the other is not off by more.
    """
    rng = np.random.default_rng(0)
    n = 300
    bent, arc = rng.choice([0.0, 1.0], n), 10.0 ** rng.uniform(-3.0, 0.0, n)
    x, e, _, _ = creases(rng, n, bent, np.zeros((2, n)), arc)
    w = rng.normal(size=(2, n, 3))
    w[:, rng.random(n) < 0.5, 0] *= 0.01
    give = rng.choice([0.0, 0.01, 0.3], n)
    axis = rng.normal(size=(n, 1, 3))
    axis *= give[:, None, None] / np.linalg.norm(axis, axis=-1, keepdims=True)
    width = rng.choice([0.0, 0.01, 0.3], n)
    off = rng.normal(size=(n, 1, 3))
    off *= width[:, None, None] / np.linalg.norm(off, axis=-1, keepdims=True)
    far = np.linalg.norm(w[:, :, None] - x - off, axis=-1).max(axis=(0, 2))
    along = np.abs(((w[:, :, None] - x) * turned(e, axis)).sum(-1)).max(axis=(0, 2))
    for k in range(n):
        ends = (tuple(w[0, k]), tuple(w[1, k]))
        for joint in ((width[k], give[k], 1.0), (width[k], 1.0, give[k])):
            told = reach_of((1.0, 0.0, 0.0), (arc[k], bent[k], 1), joint, ends)
            assert told[0] == arc[k]
            assert told[1] >= far[k] - 1e-12
            assert told[2] >= along[k] - 1e-9


def test_a_face_is_seen_along_an_edge_within_what_is_told():
    rng = np.random.default_rng(1)
    n = 300
    bent, arc = rng.choice([0.0, 1.0], n), 10.0 ** rng.uniform(-3.0, 0.0, n)
    torsion = rng.choice([0.0, 1.0], (2, n))
    x, e, _, b = creases(rng, n, bent, torsion, arc)
    w = rng.normal(size=(2, n, 3))
    at = w[:, :, None] - x
    far = np.linalg.norm(at, axis=-1).max(axis=(0, 2))
    along = np.abs((at * e).sum(-1)).max(axis=(0, 2))
    seen = (at * b[0]).sum(-1)
    for k in range(n):
        bend = np.array([2.0, 0.0, 0.0, 0.0, 0.0, 0.0]) * torsion[0, k]
        ends = (tuple(w[0, k]), tuple(w[1, k]))
        told = seen_along(bend, tuple(b[0, k, 0]), ends, (arc[k], far[k], along[k]), bent[k])
        for (low, high), truth in zip(told, seen[:, k], strict=True):
            assert low <= truth.min() + 1e-9
            assert high >= truth.max() - 1e-9
