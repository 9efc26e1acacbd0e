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

# Monomials lose digits above this degree: such elements are evaluated in Bernstein form.
MONOMIAL_DEGREE = 5
# They lose digits too where weights of one element differ by more than this factor.
MONOMIAL_WEIGHTS = 1e3
# Sides shorter than this share of their element are a pole.
POLE = 1e-12
# Rounding of each of the steps in which a point is evaluated.
ROUNDING = 2.0 * float(np.finfo(float).eps)


def monomial_matrix(degree: int, about: float = 0.0) -> FloatArray:
    """Return the map from Bernstein coefficients on [0, 1] to powers of x − 1/2 − about.

    It is (degree + 1, degree + 1).
    """
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
    grids = [bezier.extract(patch) for patch in body.patches]
    of_degrees: defaultdict[tuple[int, int], list[int]] = defaultdict(list)
    for k, patch in enumerate(body.patches):
        of_degrees[patch.degrees].append(k)
    nets = [_halved_between_poles(body, grids, alike) for alike in of_degrees.values()]

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
    used = 0
    for alike, (net, poles) in zip(of_degrees.values(), nets, strict=True):
        where = np.concatenate([np.arange(first[k], first[k + 1]) for k in alike])
        rows = table[where]
        for part in fill(rows, net, poles, used):
            coefs.append(part)
            used += part.size
        table[where] = rows
    nothing = np.zeros(0, np.int32), np.zeros(0, np.int8)
    return Elements(table, np.concatenate(coefs)), Grid(patches, np.concatenate(breaks), *nothing)


def _halved_between_poles(
    body: Faces, grids: list[bezier.BezierGrid], alike: list[int]
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the coefficients (n, p + 1, q + 1, 4) and the poles of the elements of some patches.

    The patches are `alike` in degrees. Elements with poles on two opposite sides are halved in
    `grids` before.
    """

    def net() -> FloatArray:
        parts = [grids[k].coefs for k in alike]
        return np.concatenate([part.reshape(-1, *part.shape[2:]) for part in parts])

    poles = _poles(net())
    both = poles[:, ::2] & poles[:, 1::2]
    if not both.any():
        return net(), poles
    first = 0
    for k in alike:
        _, u, v = grids[k]
        n, m = len(u) - 1, len(v) - 1
        here = both[first : first + n * m].reshape(n, m, 2)
        first += n * m
        if here.any():
            cuts = (0.5 * (u[:-1] + u[1:]))[here[..., 0].any(axis=1)]
            others = (0.5 * (v[:-1] + v[1:]))[here[..., 1].any(axis=0)]
            grids[k] = bezier.extract(body.patches[k], cuts, others)
    return net(), _poles(net())


def _poles(net: FloatArray) -> NDArray[np.bool_]:
    """Return which sides (n, 4) of elements have one point as control points, within rounding.

    A side that is merely short stays what it is in the file; an element that is as thin all along
    is a line, and has no pole.
    """
    p, q = net.shape[1] - 1, net.shape[2] - 1
    points = np.ascontiguousarray(np.moveaxis(net[..., :3] / net[..., 3:], 0, -1))
    rounding = ROUNDING * (p + q + 2) * np.abs(points).max(axis=(0, 1, 2))
    near = np.maximum(rounding, POLE * np.ptp(points, axis=(0, 1)).max(axis=0))
    point = [np.ptp(points, axis=axis).max(axis=1) <= near for axis in (1, 0)]
    return np.stack([each[end] & ~each.all(axis=0) for each in point for end in (0, -1)], axis=1)


def fill(rows: Records, net: FloatArray, poles: NDArray[np.bool_], used: int) -> list[FloatArray]:
    """Coefficients of elements of the same degrees about an origin of each element's own.

    `net` (n, p + 1, q + 1, 4) are homogeneous Bernstein coefficients, which are changed; `poles`
    (n, 4) tell which sides are one point. Fills the rows' degree, origin, cubic, form and places;
    returns what is to stand in the flat array from place `used` on.
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
