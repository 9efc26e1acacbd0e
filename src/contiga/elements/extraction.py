"""Bézier elements of a set of faces: coefficients, boxes, states against the trims.

Coefficients of an element are relative to its own origin, and its powers are expanded about its
middle. If a side is one point, a pole, the origin is the pole, the powers are expanded about that
side, and the coefficients that vanish there are exactly zero. With the distance τ from the side,
S − pole = τ C and S_s = τ C_s are then evaluated to a few units in the last place *of themselves*,
however small τ is, so that the direction of S_s, the normal and the tangential miss of a foot keep
all their digits up to the pole. About another point S_s would be a difference of numbers of the
size of the element, and its direction would have an error of 1e-16/τ.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import CUBIC, GENERAL, RATIONAL_CUBIC
from contiga.elements.element_arrays import ELEMENT, PATCH, Elements, Grid, Records
from contiga.geometry import bezier
from contiga.geometry.faces import Faces
from contiga.geometry.kernels import trim_nb
from contiga.geometry.trim import TrimTables
from contiga.records import FloatArray

# Monomials lose digits above this degree: elements are then evaluated in Bernstein form.
MAX_MONOMIAL_DEGREE = 5
# Monomials also lose digits if the weights of one element differ by more than this factor.
MAX_WEIGHT_RATIO = 1e3
# Sides shorter than this share of their element are a pole.
POLE_TOL = 1e-12
# Rounding of each step in the evaluation of a point.
ROUNDING = 2.0 * float(np.finfo(float).eps)


def monomial_matrix(degree: int, about: float = 0.0) -> FloatArray:
    """Return the matrix from Bernstein coefficients on [0, 1] to powers of x − 1/2 − about.

    Its rows are powers from 0 on, its columns Bernstein polynomials.
    """
    matrix = np.zeros((degree + 1, degree + 1))
    one_minus_x, x = np.array([0.5 - about, -1.0]), np.array([0.5 + about, 1.0])
    for k in range(degree + 1):
        poly = np.ones(1)
        for factor in [x] * k + [one_minus_x] * (degree - k):
            poly = np.convolve(poly, factor)
        binomial = np.prod([(degree - m) / (m + 1) for m in range(k)])
        matrix[:, k] = binomial * poly
    return matrix


def elements_of(body: Faces, trims: TrimTables) -> tuple[Elements, Grid]:
    """Return the elements of `body`, without neighbours yet, and the grid of their places.

    Elements are in the order of the patches, with v inner; patches with an element between two
    poles have more than their knots make. The grid has no adjacent patches yet.
    """
    grids = [bezier.extract(patch) for patch in body.patches]
    patches_by_degrees: defaultdict[tuple[int, int], list[int]] = defaultdict(list)
    for k, patch in enumerate(body.patches):
        patches_by_degrees[patch.degrees].append(k)
    groups = list(patches_by_degrees.values())
    nets = [_split_between_poles(body, grids, group) for group in groups]

    breaks = [part for g in grids for part in (g.u_breaks, g.v_breaks)]
    end = np.cumsum([len(part) for part in breaks])
    spans = np.column_stack([end - [len(part) for part in breaks], end]).reshape(-1, 2, 2)
    first = np.cumsum([0] + [len(g.coefs) * len(g.coefs[0]) for g in grids])
    patches = np.zeros(len(grids), PATCH)
    patches["u"], patches["v"], patches["first"] = spans[:, 0], spans[:, 1], first[:-1]

    table = np.zeros(first[-1], ELEMENT)
    of_patch = np.repeat(np.arange(len(grids), dtype=np.int32), np.diff(first))
    box = np.concatenate([g.boxes() for g in grids])
    table["patch"], table["box"] = of_patch, box
    table["components"] = np.where([p.is_rational for p in body.patches], 4, 3)[of_patch]
    table["trim"] = trim_nb.box_states(trims, of_patch, box)
    coefs: list[FloatArray] = []
    n_coefs = 0
    for group, (net, poles) in zip(groups, nets, strict=True):
        rows = np.concatenate([np.arange(first[k], first[k + 1]) for k in group])
        records = table[rows]
        for part in fill(records, net, poles, n_coefs):
            coefs.append(part)
            n_coefs += part.size
        table[rows] = records
    no_adjacency = np.zeros(0, np.int32), np.zeros(0, np.int8)
    grid = Grid(patches, np.concatenate(breaks), *no_adjacency)
    return Elements(table, np.concatenate(coefs)), grid


def _split_between_poles(
    body: Faces, grids: list[bezier.BezierGrid], group: list[int]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return coefficients (n, p + 1, q + 1, 4) and poles (n, 4) of the elements of some patches.

    The patches `group` have the same degrees. Before, their `grids` are replaced where elements
    have poles on two opposite sides: whole rows and columns with such elements are halved.
    """

    def net() -> FloatArray:
        parts = [grids[k].coefs for k in group]
        return np.concatenate([part.reshape(-1, *part.shape[2:]) for part in parts])

    poles = _poles(net())
    opposite = poles[:, ::2] & poles[:, 1::2]
    if not opposite.any():
        return net(), poles
    first = 0
    for k in group:
        _, u, v = grids[k]
        n, m = len(u) - 1, len(v) - 1
        in_patch = opposite[first : first + n * m].reshape(n, m, 2)
        first += n * m
        if in_patch.any():
            u_cuts = (0.5 * (u[:-1] + u[1:]))[in_patch[..., 0].any(axis=1)]
            v_cuts = (0.5 * (v[:-1] + v[1:]))[in_patch[..., 1].any(axis=0)]
            grids[k] = bezier.extract(body.patches[k], u_cuts, v_cuts)
    return net(), _poles(net())


def _poles(net: FloatArray) -> NDArray[np.bool_]:
    """Return which sides (n, 4) of elements have one point as control points.

    Their control points differ by rounding, or `POLE_TOL` of the element's extent, at most. An
    element that is as thin over its full length is a line, and has no pole.
    """
    p, q = net.shape[1] - 1, net.shape[2] - 1
    points = np.ascontiguousarray(np.moveaxis(net[..., :3] / net[..., 3:], 0, -1))
    rounding = ROUNDING * (p + q + 2) * np.abs(points).max(axis=(0, 1, 2))
    tol = np.maximum(rounding, POLE_TOL * np.ptp(points, axis=(0, 1)).max(axis=0))
    collapsed = [np.ptp(points, axis=axis).max(axis=1) <= tol for axis in (1, 0)]
    return np.stack([c[end] & ~c.all(axis=0) for c in collapsed for end in (0, -1)], axis=1)


def fill(rows: Records, net: FloatArray, poles: NDArray[np.bool_], used: int) -> list[FloatArray]:
    """Compute the coefficients of elements of the same degrees, each about its own origin.

    Writes degree, origin, about, cubic, form, noise and places of the records `rows`; returns the
    parts of the flat array of coefficients from place `used` on: Bernstein coefficients and, up to
    `MAX_MONOMIAL_DEGREE`, monomials, which elements of uneven weights do not use.

    Parameters
    ----------
    rows : (n,) `ELEMENT`
    net : (n, p + 1, q + 1, 4) homogeneous Bernstein coefficients; changed
    poles : (n, 4) sides that are one point
    used : number of coefficients in the flat array before these
    """
    p, q = net.shape[1] - 1, net.shape[2] - 1
    rows["degree"] = p, q
    points = net[..., :3] / net[..., 3:]
    origin = points.mean(axis=(1, 2))
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
    if max(p, q) > MAX_MONOMIAL_DEGREE:
        return [net.ravel()]
    monomial = np.empty_like(net)
    for s, t in np.unique(rows["about"], axis=0).tolist():
        is_about = (rows["about"] == (s, t)).all(axis=1)
        powers_of_t = np.einsum("bj,eijc->eibc", monomial_matrix(q, t), net[is_about])
        monomial[is_about] = np.einsum("ai,eibc->eabc", monomial_matrix(p, s), powers_of_t)
    rows["monomial"] = used + net.size + stride * np.arange(len(rows))
    weights = net[..., 3].reshape(len(net), -1)
    is_uneven = weights.max(axis=1) > MAX_WEIGHT_RATIO * weights.min(axis=1)
    rows["monomial"][is_uneven] = -1
    rows["noise"] *= np.where(is_uneven, 1.0, weights.max(axis=1) / weights.min(axis=1))
    # Powers of the distance from a side reach 1 at the opposite side, with all coefficients there.
    from_pole = ~is_uneven & poles.any(axis=1)
    largest = np.abs(monomial[from_pole]).sum(axis=(1, 2))
    rows["noise"][from_pole] = np.maximum(
        rows["noise"][from_pole],
        ROUNDING * (p + q + 2) * largest[:, :3].max(axis=1) / weights[from_pole].min(axis=1),
    )
    if max(p, q) <= 3:
        cubic = np.zeros((len(net), 4, 4, 4))  # element, component, power of s, power of t
        cubic[:, :, : p + 1, : q + 1] = np.moveaxis(monomial, 3, 1)
        rows["cubic"] = cubic.reshape(-1, 64)
        form = np.where(rows["components"] == 4, RATIONAL_CUBIC, CUBIC)
        rows["form"] = np.where(is_uneven, GENERAL, form)
    return [net.ravel(), monomial.ravel()]
