"""Stress, strain and stored energy of shells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.matter.element_fields import ElementFields
from contiga.matter.kernels.lanes_nb import LANES
from contiga.matter.kernels.shell_nb import INSIDE
from contiga.matter.stress import COMPONENTS
from contiga.records import FloatArray


class GaussPoints(NamedTuple):
    """Strains, forces and moments of e elements at g Gauss points, in axes of the rest surface."""

    axes: FloatArray
    """(e, g, 3, 2) F = [f₁, f₂], the deformed axes."""
    strain: FloatArray
    """(e, g, 3) E₁₁, E₂₂, E₁₂ of the middle surface."""
    curvature: FloatArray
    """(e, g, 3) κ₁₁, κ₂₂, κ₁₂: curvature at rest less the deformed one."""
    force: FloatArray
    """(e, g, 3) n₁₁, n₂₂, n₁₂ by length at rest."""
    moment: FloatArray
    """(e, g, 3) m₁₁, m₂₂, m₁₂ by length at rest."""
    energy: FloatArray
    """(e, g) stored energy by area at rest."""


def gauss_points(blocks: FloatArray, elements: int) -> GaussPoints:
    """Return the record of rows (b, points · INSIDE · LANES) that kernels write."""
    rows = blocks.reshape(len(blocks), -1, INSIDE, LANES).transpose(0, 3, 1, 2)
    each = rows.reshape(-1, *rows.shape[2:])[:elements]
    axes = each[..., :6].reshape(*each.shape[:2], 3, 2)
    strain, curvature, force, moment = (each[..., k : k + 3] for k in (6, 9, 12, 15))
    return GaussPoints(axes, strain, curvature, force, moment, each[..., 18])


def fields_at(now: GaussPoints, rest: GaussPoints, thickness: float, height: float) -> FloatArray:
    """Return columns (e, g, 13) of `ElementFields` at a height, −1 … 1 of half the thickness.

    Stresses are by the thickness at rest, linear across it by the moment; zero without area.
    Strains are those of the surface at rest, in the axes of space.
    """
    force = now.force + (6.0 * height / thickness) * now.moment
    area = np.cross(now.axes[..., 0], now.axes[..., 1])
    size = np.sqrt(np.sum(area * area, axis=-1))
    has_area = size > 0.0
    inverse = np.where(has_area, 1.0, 0.0) / (np.where(has_area, size, 1.0) * thickness)
    stress = _in_space(now.axes, force) * inverse[..., None]
    strain = now.strain + (0.5 * height * thickness) * now.curvature
    energy = now.energy / thickness
    return np.concatenate([stress, _in_space(rest.axes, strain), energy[..., None]], axis=-1)


def as_fields(columns: FloatArray) -> ElementFields:
    """Return columns (n, 13) as a record."""
    return ElementFields(columns[:, :6], columns[:, 6:12], columns[:, 12])


def _in_space(axes: FloatArray, tensor: FloatArray) -> FloatArray:
    """Return T = Σ T_ij f_i ⊗ f_j (…, 6) of axes (…, 3, 2) and T₁₁, T₂₂, T₁₂ (…, 3)."""
    a, b = axes[..., 0], axes[..., 1]
    t_11, t_22, t_12 = (tensor[..., k] for k in range(3))
    columns = [
        t_11 * a[..., i] * a[..., j]
        + t_22 * b[..., i] * b[..., j]
        + t_12 * (a[..., i] * b[..., j] + b[..., i] * a[..., j])
        for i, j in COMPONENTS
    ]
    return np.stack(columns, axis=-1)
