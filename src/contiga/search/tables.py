"""Everything the search knows about a body, worked out once: elements, neighbours, hierarchy.

The tables of a body are kept as long as the body lives (`tables_of`).
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from contiga.errors import GeometryError
from contiga.geometry import _trim_nb, bezier, trim
from contiga.geometry.body import Body
from contiga.geometry.slits import gaping_edges, stitches
from contiga.records import FloatArray
from contiga.search.branch import build_rings
from contiga.search.hierarchy import build_hierarchy
from contiga.search.neighbours import join
from contiga.search.records import (
    BORDER,
    CUBIC,
    ELEMENT,
    GENERAL,
    JOINT,
    PATCH,
    RATIONAL_CUBIC,
    SHARED,
    Elements,
    Grid,
    Joints,
    Records,
    Tables,
)
from contiga.search.trimmed_edges import build_joints
from contiga.search.widths import edge_widths

# Monomials lose digits above this degree: such elements are evaluated in Bernstein form.
MONOMIAL_DEGREE = 5
# They lose digits too where weights of one element differ by more than this factor.
MONOMIAL_WEIGHTS = 1e3
# Rounding of each of the steps in which a point is evaluated.
ROUNDING = 2.0 * float(np.finfo(float).eps)
# Tangential miss accepted at a foot, relative to the body's size.
RELATIVE_TOLERANCE = 1e-12
# Sizes of bodies whose lengths can be taken to the fourth power and back.
SMALLEST, LARGEST = 1e-60, 1e60
# A trimming curve this close to a side of its patch's rectangle, as a share of it, runs along it.
NEAR = 1e-3


_KEPT: WeakKeyDictionary[Body, Tables] = WeakKeyDictionary()


def tables_of(body: Body) -> Tables:
    """The search tables of `body`, built at the first call."""
    tables = _KEPT.get(body)
    if tables is None:
        tables = _KEPT[body] = _build(body)
    return tables


def check_size(body: Body) -> None:
    """Refuse a body that is a point, or so large or small that products of lengths are lost.

    Raises
    ------
    GeometryError
        As said.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        size = body.size
    if not SMALLEST <= size <= LARGEST:
        raise GeometryError(
            "the body's size cannot be computed with",
            where=body.name,
            found=size,
            allowed=f"{SMALLEST:g} to {LARGEST:g}",
        )


def _build(body: Body) -> Tables:
    check_size(body)
    trims = body.trim_tables
    elements, grid = _elements(body, trims)
    grid = join(elements, grid, body)
    is_open = _open_pieces(body, trims)
    _share_trimmed_sides(elements, trims, is_open)
    piece_width = edge_widths(body, elements, trims)
    leaves, tree = build_hierarchy(elements, grid, trims)
    scale = np.array([body.size, RELATIVE_TOLERANCE * body.size])
    rings = build_rings(elements)
    none = Joints(np.zeros(0, JOINT), np.zeros((0, 4), np.int32))
    tables = Tables(elements, grid, leaves, tree, trims, is_open, piece_width, scale, rings, none)
    return tables._replace(joints=build_joints(body, tables))


def _open_pieces(body: Body, trims: trim.TrimTables) -> FloatArray:
    joins = np.array([len(edge.uses) > 1 for edge in body.edges], dtype=bool)
    ends = ~joins | gaping_edges(body)
    edge = np.asarray(trims.piece_edge)
    known = edge >= 0
    is_open = stitches(body)[1].astype(np.float64)
    is_open[known] = ends[edge[known]]
    return is_open


def _share_trimmed_sides(elements: Elements, trims: trim.TrimTables, is_open: FloatArray) -> None:
    """Sides of a trimmed patch's rectangle end the surface where its open trimming curves run.

    Elsewhere another face goes on, across the edge of the trimming curve that runs there.
    """
    table = elements.table
    ends = trims.piece_ends.reshape(-1, 2, 2)
    for k in np.unique(table["patch"][trims.trimmed[table["patch"]] != 0]):
        rows = np.flatnonzero(table["patch"] == k)
        low, high = trims.domain[k].reshape(2, 2).T
        own = ends[np.flatnonzero((trims.piece_patch == k) & (is_open != 0.0))]
        for side in range(4):
            along, end = side // 2, (low, high)[side % 2][side // 2]
            near = np.abs(own[:, :, along] - end).max(axis=1) <= NEAR * (high - low)[along]
            first, last = np.sort(own[near][:, :, 1 - along], axis=1).T
            box = table["box"][rows][:, 2 * (1 - along) :][:, :2]
            meets = (first < box[:, 1:]) & (last > box[:, :1])
            shared = (table["kind"][rows, side] == BORDER) & ~meets.any(axis=1)
            table["kind"][rows[shared], side] = SHARED


def monomial_matrix(degree: int) -> FloatArray:
    """(degree+1, degree+1) from Bernstein coefficients on [0, 1] to powers of x − 1/2."""
    matrix = np.zeros((degree + 1, degree + 1))
    low, high = np.array([0.5, -1.0]), np.array([0.5, 1.0])  # 1 − x and x in powers of x − 1/2
    for k in range(degree + 1):
        poly = np.ones(1)
        for _ in range(k):
            poly = np.convolve(poly, high)
        for _ in range(degree - k):
            poly = np.convolve(poly, low)
        binomial = np.prod([(degree - m) / (m + 1) for m in range(k)])
        matrix[:, k] = binomial * poly
    return matrix


def _elements(body: Body, trims: trim.TrimTables) -> tuple[Elements, Grid]:
    grids = [bezier.extract(patch) for patch in body.patches]
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
        rows["box"] = _parameter_boxes(g.u_breaks, g.v_breaks)
        rows["trim"] = [_trim_nb.box_state(trims, k, *b) for b in rows["box"].tolist()]
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


def _fill(rows: Records, coefs: FloatArray, used: int) -> list[FloatArray]:
    """Coefficients of a patch's elements about an origin of each element's own.

    Fills the rows' origin, cubic, form and places; returns what is to stand in the flat array
    from place `used` on.
    """
    p, q = coefs.shape[2] - 1, coefs.shape[3] - 1
    net = coefs.reshape(-1, p + 1, q + 1, 4).copy()
    origin = (net[..., :3] / net[..., 3:]).mean(axis=(1, 2))
    net[..., :3] -= net[..., 3:] * origin[:, None, None, :]
    rows["origin"] = origin
    stride = 4 * (p + 1) * (q + 1)
    rows["bernstein"] = used + stride * np.arange(len(rows))
    rows["monomial"] = -1
    extent = np.abs(net[..., :3] / net[..., 3:]).max(axis=(1, 2, 3))
    rows["noise"] = ROUNDING * (p + q + 2) * extent
    if max(p, q) > MONOMIAL_DEGREE:
        return [net.ravel()]
    rows_of_s = np.einsum("bj,eijc->eibc", monomial_matrix(q), net)
    monomial = np.einsum("ai,eibc->eabc", monomial_matrix(p), rows_of_s)
    rows["monomial"] = used + net.size + stride * np.arange(len(rows))
    weights = net[..., 3].reshape(len(net), -1)
    uneven = weights.max(axis=1) > MONOMIAL_WEIGHTS * weights.min(axis=1)
    rows["monomial"][uneven] = -1
    rows["noise"] *= np.where(uneven, 1.0, weights.max(axis=1) / weights.min(axis=1))
    if max(p, q) <= 3:
        cubic = np.zeros((len(net), 4, 4, 4))  # element, component, power of s, power of t
        cubic[:, :, : p + 1, : q + 1] = np.moveaxis(monomial, 3, 1)
        rows["cubic"] = cubic.reshape(-1, 64)
        form = np.where(rows["components"] == 4, RATIONAL_CUBIC, CUBIC)
        rows["form"] = np.where(uneven, GENERAL, form)
    return [net.ravel(), monomial.ravel()]


def _parameter_boxes(u: FloatArray, v: FloatArray) -> FloatArray:
    """(nu*nv, 4) u0, u1, v0, v1 of the elements between the breaks."""
    low_u, low_v = np.meshgrid(u[:-1], v[:-1], indexing="ij")
    high_u, high_v = np.meshgrid(u[1:], v[1:], indexing="ij")
    return np.stack([a.ravel() for a in (low_u, high_u, low_v, high_v)], axis=1)
