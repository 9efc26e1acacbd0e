"""Bézier elements of faces whose control points have moved: only coefficients change.

The map from control points to the coefficients of elements (Bézier extraction) depends on degrees
and knots alone. So do patches, parameters, neighbours, poles and trims. Coefficients, origins and
rounding depend on the shape, and are computed for each.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import CREASE, POLE, SMOOTH
from contiga.elements.element_arrays import Elements, Grid, Records
from contiga.elements.extraction import fill
from contiga.geometry.bezier import Extraction, extraction_of
from contiga.geometry.faces import Faces
from contiga.geometry.net import ControlNet
from contiga.records import FloatArray, IndexArray, IntArray


class PatchMap(NamedTuple):
    """The map from the control points of a body to the elements of a patch."""

    control: IntArray
    """(n, m) rows of its control points."""
    weights: FloatArray
    """(n, m, 1); ones for a polynomial patch."""
    extraction: Extraction
    """From control points to Bernstein coefficients, by the breaks of the elements."""

    def coefs(self, control_points: FloatArray) -> FloatArray:
        """Return (elements, p + 1, q + 1, 4) homogeneous Bernstein coefficients.

        `control_points` are those of the body.
        """
        points, w = control_points[self.control], self.weights
        coefs = self.extraction.of(np.concatenate([points * w, w], axis=2)).coefs
        return coefs.reshape(-1, *coefs.shape[2:])


class SameDegrees(NamedTuple):
    """Patches of the same degrees."""

    maps: tuple[PatchMap, ...]
    rows: IndexArray
    """Rows of their elements."""
    poles: NDArray[np.bool_]
    """(rows, 4) sides that are one point."""


class Refit(NamedTuple):
    """The elements of a body for any control points."""

    table: Records
    """(n,) `ELEMENT` at rest; fields that do not depend on the shape are always valid."""
    groups: tuple[SameDegrees, ...]

    def at(self, control_points: FloatArray, growth: float) -> Elements:
        """Return the elements for control points (m, 3); `growth` is size over size at rest.

        Coefficients, origins and rounding are new. Widths of edges grow with the body, and do not
        shrink with it.
        """
        table = self.table.copy()
        for name in ("width", "edge_tolerance"):  # they include rounding, which grows with the body
            table[name] *= max(growth, 1.0)
        coefs: list[FloatArray] = []
        n_coefs = 0
        for group in self.groups:
            net = np.concatenate([map_.coefs(control_points) for map_ in group.maps])
            records = table[group.rows]
            for part in fill(records, net, group.poles, n_coefs):
                coefs.append(part)
                n_coefs += part.size
            table[group.rows] = records
        return Elements(table, np.concatenate([part.ravel() for part in coefs]))


def refit_of(body: Faces, net: ControlNet, elements: Elements, grid: Grid) -> Refit:
    """Collect the data of `elements` that stay valid as the control points of `body` move.

    Across a knot line the surface stays as smooth as the knots allow: joined sides within a patch
    are SMOOTH there below full multiplicity. A joint of patches, a seam or a pole that is smooth at
    rest may get a kink, so that each counts as one: CREASE, not round.
    """
    table = elements.table.copy()
    maps = []
    for k, patch in enumerate(body.patches):
        record = grid.patches[k]
        u, v = (grid.breaks[record[name][0] : record[name][1]] for name in ("u", "v"))
        weights = np.ones(net.control[k].shape) if patch.weights is None else patch.weights
        map_ = PatchMap(net.control[k], weights[..., None].copy(), extraction_of(patch, u, v))
        maps.append(map_)
        rows = np.flatnonzero(table["patch"] == k)
        for side in range(4):
            knots, degree = patch.knots[side // 2], patch.degrees[side // 2]
            breaks = (u, v)[side // 2]
            multiplicity = (knots[:, None] == breaks).sum(axis=0)
            b = np.searchsorted(breaks, table["box"][rows, side])
            is_inner = (b > 0) & (b < len(breaks) - 1)
            is_joined = (table["neighbour"][rows, side] >= 0) & (table["kind"][rows, side] != POLE)
            kind = np.where(is_inner & (multiplicity[b] < degree), SMOOTH, CREASE)
            table["kind"][rows[is_joined], side] = kind[is_joined]
    table["round"] = 0
    groups = []
    for degrees in dict.fromkeys(patch.degrees for patch in body.patches):
        group = [k for k, patch in enumerate(body.patches) if patch.degrees == degrees]
        rows = np.concatenate([np.flatnonzero(table["patch"] == k) for k in group])
        about = table["about"][rows]
        poles = np.stack([about[:, 0], -about[:, 0], about[:, 1], -about[:, 1]], axis=1) < 0.0
        groups.append(SameDegrees(tuple(maps[k] for k in group), rows, poles))
    return Refit(table, tuple(groups))
