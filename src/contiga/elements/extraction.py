"""Bézier elements of a set of faces: coefficients, boxes, states against the trims.

Coefficients of an element are relative to a point of its own, and its powers are those of the
distance from its middle. Of an element with a side that is one point, a pole, they are relative to
the pole and of the distance from that side, and the coefficients that vanish there are exactly
zero. With τ that distance, S − pole = τ C and S_s = τ C_s are then evaluated to a few units in the
last place *of themselves*, however small τ is, so the direction of S_s, the normal and the
tangential miss of a foot keep all their digits up to the pole. About another point S_s would be a
difference of numbers of the size of the element: of its direction 1e-16/τ is lost.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import CUBIC, GENERAL, RATIONAL_CUBIC
from contiga.elements.element_arrays import ELEMENT, PATCH, Elements, Grid, Records
from contiga.geometry import bezier
from contiga.geometry.faces import Faces
from contiga.geometry.kernels import trim_nb
from contiga.geometry.surface import NurbsSurface
from contiga.geometry.trim import TrimTables
from contiga.records import FloatArray

# Monomials lose digits above this degree: such elements are evaluated in Bernstein form.
MONOMIAL_DEGREE = 5
# They lose digits too where weights of one element differ by more than this factor.
MONOMIAL_WEIGHTS = 1e3
# Sides shorter than this share of their element are a pole.
POLE = 1e-12
# Rounding of each of the steps in which a point is evaluated.
ROUNDING = 2.0 * float(np.finfo(float).eps)


def monomial_matrix(degree: int, about: float = 0.0) -> FloatArray:
    """(degree+1, degree+1) from Bernstein coefficients on [0, 1] to powers of x − 1/2 − about."""
    matrix = np.zeros((degree + 1, degree + 1))
    low, high = np.array([0.5 - about, -1.0]), np.array([0.5 + about, 1.0])  # 1 − x and x in them
    for k in range(degree + 1):
        poly = np.ones(1)
        for _ in range(k):
            poly = np.convolve(poly, high)
        for _ in range(degree - k):
            poly = np.convolve(poly, low)
        binomial = np.prod([(degree - m) / (m + 1) for m in range(k)])
        matrix[:, k] = binomial * poly
    return matrix


def elements_of(body: Faces, trims: TrimTables) -> tuple[Elements, Grid]:
    """The elements of `body`, their sides not joined yet, and where they stand."""
    grids = [_extracted(patch) for patch in body.patches]
    counts = [g.coefs.shape[0] * g.coefs.shape[1] for g in grids]
    first = np.concatenate(([0], np.cumsum(counts)))
    table = np.zeros(int(first[-1]), ELEMENT)
    patches = np.zeros(len(grids), PATCH)
    coefs: list[FloatArray] = []
    breaks: list[FloatArray] = []
    used = places = 0
    for k, (patch, g) in enumerate(zip(body.patches, grids, strict=True)):
        rows = table[first[k] : first[k + 1]]
        rows["patch"] = k
        rows["degree"] = patch.degrees
        rows["components"] = 4 if patch.is_rational else 3
        rows["box"] = g.boxes()
        rows["trim"] = [trim_nb.box_state(trims, k, *b) for b in rows["box"].tolist()]
        for part in _fill(rows, g.coefs, used):
            coefs.append(part)
            used += part.size
        u, v = len(g.u_breaks), len(g.v_breaks)
        patches["u"][k] = places, places + u
        patches["v"][k] = places + u, places + u + v
        patches["first"][k] = first[k]
        breaks += [g.u_breaks, g.v_breaks]
        places += u + v
    nothing = np.zeros(0, np.int32), np.zeros(0, np.int8)
    grid = Grid(patches, np.concatenate(breaks), *nothing)
    return Elements(table, np.concatenate(coefs)), grid


def _extracted(patch: NurbsSurface) -> bezier.BezierGrid:
    """The elements of a patch, each with at most one of two opposite sides a pole: others are
    halved."""
    grid = bezier.extract(patch)
    poles = _poles(grid.coefs)
    halves = []
    for axis, breaks in enumerate((grid.u_breaks, grid.v_breaks)):
        both = (poles[..., 2 * axis] & poles[..., 2 * axis + 1]).any(axis=1 - axis)
        halves.append(0.5 * (breaks[:-1] + breaks[1:])[both])
    return bezier.extract(patch, *halves) if any(len(cuts) for cuts in halves) else grid


def _poles(coefs: FloatArray) -> NDArray[np.bool_]:
    """(…, 4) the sides of elements whose control points are one point, to what a foot is exact to.

    A side that is merely short stays what it is in the file; an element that is as thin all along
    is a line, and has no pole.
    """
    p, q = coefs.shape[-3] - 1, coefs.shape[-2] - 1
    points = coefs[..., :3] / coefs[..., 3:]
    rounding = ROUNDING * (p + q + 2) * np.abs(points).max(axis=(-3, -2, -1))
    near = np.maximum(rounding, POLE * np.ptp(points, axis=(-3, -2)).max(axis=-1))
    point = [np.ptp(points, axis=axis).max(axis=-1) <= near[..., None] for axis in (-2, -3)]
    poles = [each[..., end] & ~each.all(axis=-1) for each in point for end in (0, -1)]
    return np.stack(poles, axis=-1)


def _fill(rows: Records, coefs: FloatArray, used: int) -> list[FloatArray]:
    """Coefficients of a patch's elements about an origin of each element's own.

    Fills the rows' origin, cubic, form and places; returns what is to stand in the flat array
    from place `used` on.
    """
    p, q = coefs.shape[2] - 1, coefs.shape[3] - 1
    net = coefs.reshape(-1, p + 1, q + 1, 4).copy()
    points = net[..., :3] / net[..., 3:]
    origin = points.mean(axis=(1, 2))
    poles = _poles(net)
    for side, end in enumerate((points[:, 0], points[:, -1], points[:, :, 0], points[:, :, -1])):
        origin[poles[:, side]] = end[poles[:, side], 0]
        rows["about"][poles[:, side], side // 2] = (-0.5, 0.5)[side % 2]
    net[..., :3] -= net[..., 3:] * origin[:, None, None, :]
    for side, end in enumerate((net[:, 0], net[:, -1], net[:, :, 0], net[:, :, -1])):
        end[poles[:, side], :, :3] = 0.0
    rows["origin"] = origin
    stride = 4 * (p + 1) * (q + 1)
    rows["bernstein"] = used + stride * np.arange(len(rows))
    rows["monomial"] = -1
    extent = np.abs(net[..., :3] / net[..., 3:]).max(axis=(1, 2, 3))
    rows["noise"] = ROUNDING * (p + q + 2) * extent
    if max(p, q) > MONOMIAL_DEGREE:
        return [net.ravel()]
    monomial = np.empty_like(net)
    for s, t in np.unique(rows["about"], axis=0).tolist():
        there = (rows["about"] == (s, t)).all(axis=1)
        rows_of_s = np.einsum("bj,eijc->eibc", monomial_matrix(q, t), net[there])
        monomial[there] = np.einsum("ai,eibc->eabc", monomial_matrix(p, s), rows_of_s)
    rows["monomial"] = used + net.size + stride * np.arange(len(rows))
    weights = net[..., 3].reshape(len(net), -1)
    uneven = weights.max(axis=1) > MONOMIAL_WEIGHTS * weights.min(axis=1)
    rows["monomial"][uneven] = -1
    rows["noise"] *= np.where(uneven, 1.0, weights.max(axis=1) / weights.min(axis=1))
    # Powers of the distance from a side are as large as their coefficients at the other one.
    far = ~uneven & poles.any(axis=1)
    largest = np.abs(monomial[far]).sum(axis=(1, 2))
    rows["noise"][far] = np.maximum(
        rows["noise"][far],
        ROUNDING * (p + q + 2) * largest[:, :3].max(axis=1) / weights[far].min(axis=1),
    )
    if max(p, q) <= 3:
        cubic = np.zeros((len(net), 4, 4, 4))  # element, component, power of s, power of t
        cubic[:, :, : p + 1, : q + 1] = np.moveaxis(monomial, 3, 1)
        rows["cubic"] = cubic.reshape(-1, 64)
        form = np.where(rows["components"] == 4, RATIONAL_CUBIC, CUBIC)
        rows["form"] = np.where(uneven, GENERAL, form)
    return [net.ravel(), monomial.ravel()]
