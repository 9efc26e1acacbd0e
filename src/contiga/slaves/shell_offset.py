"""Points of contact half the thickness of a shell off its mid-surface, on one side of it.

A point x of a facet goes to x + h n, n = c / |c| the facet's normal, c = (x₁ − x₀) × (x₂ − x₀), and
h half the thickness there, below zero at the back. It follows the facet's turns, and forces go back
to the corners by the transpose of dx + h dn, so that they do the same work on the nodes, and have
the same sum and moment, as at the point.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.arrays.layout import locked
from contiga.arrays.threads import run_ranges
from contiga.records import FloatArray, IndexArray, IntArray
from contiga.slaves.kernels.shell_offset_nb import move_facet_points, move_nodes

SIDES = {"none": 0.0, "front": 0.5, "back": -0.5}
"""Where points stand, in thicknesses along the normals of the facets."""


class _Edges(NamedTuple):
    """Edges and normals of some facets, one row each."""

    first: FloatArray
    """(k, 3) x₁ − x₀."""
    second: FloatArray
    """(k, 3) x₂ − x₀."""
    normal: FloatArray
    """(k, 3) of length one, zero of a facet without area."""
    rate: FloatArray
    """(k,) 1 / |c|."""

    @classmethod
    def of(cls, nodal: FloatArray, corner: IntArray) -> _Edges:
        a, b, c = (nodal.take(corner[:, j], axis=0) for j in range(3))
        first, second = b - a, c - a
        normal = np.cross(first, second)
        length = np.linalg.norm(normal, axis=1)
        rate = np.zeros(len(length))
        np.divide(1.0, length, out=rate, where=length > 0.0)
        return cls(first, second, normal * rate[:, None], rate)

    def across(self, vectors: FloatArray) -> FloatArray:
        """(k, 3) the parts of `vectors` (k, 3) in the plane of the facet, over |c|."""
        along = (vectors * self.normal).sum(axis=1)
        return (vectors - along[:, None] * self.normal) * self.rate[:, None]


class ShellOffset:
    """How far the points of a `Sampling` stand off its nodes and facets.

    Parameters
    ----------
    facets : (m, 3)
    way : (n + m k,) of the nodes and then of k points on each facet, length, along the normals
    """

    def __init__(self, facets: IntArray, way: FloatArray, n_nodes: int) -> None:
        self._facets = facets
        self._at_nodes = way[:n_nodes].copy()
        self._inner = way[n_nodes:].copy()

    def move(self, nodal: FloatArray, points: FloatArray, facets_a_thread: int) -> None:
        """Move `points` (n + m k, 3) off the mid-surface whose nodes are at `nodal` (n, 3).

        Nodes go along the mean normal of the facets around them.
        """
        n = len(self._at_nodes)
        nodal, inner = locked(nodal), points[n:]
        given = nodal, self._facets, self._inner, inner
        run_ranges(move_facet_points, len(self._facets), facets_a_thread, *given)
        move_nodes(nodal, self._facets, self._at_nodes, np.empty((n, 3)), points[:n])

    def velocities(
        self, inner: IndexArray, corner: IntArray, nodal: FloatArray, velocity: FloatArray
    ) -> FloatArray:
        """(k, 3) h dn/dt of the points `inner` on facets with corners `corner` (k, 3), of nodes at
        `nodal` (n, 3) with `velocity` (n, 3)."""
        edges = _Edges.of(nodal, corner)
        a, b, c = (velocity.take(corner[:, j], axis=0) for j in range(3))
        change = np.cross(b - a, edges.second) + np.cross(edges.first, c - a)
        return self._inner[inner, None] * edges.across(change)

    def levers(self, inner: IndexArray, corner: IntArray, nodal: FloatArray) -> FloatArray:
        """(k, 3) how far the points `inner` go at most where a corner, of `corner` (k, 3), goes one
        length, beside their shares: |h| times the edge across over |c|."""
        edges = _Edges.of(nodal, corner)
        across = [edges.second - edges.first, edges.second, edges.first]
        lengths = np.stack([np.linalg.norm(edge, axis=1) for edge in across], axis=1)
        return np.abs(self._inner[inner] * edges.rate)[:, None] * lengths

    def corner_forces(
        self, inner: IndexArray, corner: IntArray, nodal: FloatArray, force: FloatArray
    ) -> FloatArray:
        """(k, 3, 3) what forces (k, 3) at the points give the corners beside their shares."""
        edges = _Edges.of(nodal, corner)
        turning = self._inner[inner, None] * edges.across(force)
        at_b = np.cross(edges.second, turning)
        at_c = np.cross(turning, edges.first)
        return np.stack([-(at_b + at_c), at_b, at_c], axis=1)
