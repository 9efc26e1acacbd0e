"""Trim tables of a body: which part of each patch belongs to it, exactly and fast.

Every p-curve is cut into rational Bézier segments, every segment into pieces monotone in u and
in v. A grid of IN, OUT and CUT cells over each trimmed patch decides most points at once; in a
CUT cell the few pieces that meet it decide by a crossing test on the exact curve.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contiga.errors import GeometryError
from contiga.geometry.bezier import extract_curve
from contiga.geometry.curve import NurbsCurve
from contiga.geometry.edges import BodyEdge
from contiga.geometry.kernels import trim_build_nb as build_nb
from contiga.geometry.kernels.trim_nb import TrimTables as TrimTables
from contiga.geometry.surface import NurbsSurface
from contiga.records import FloatArray

Loop = tuple[NurbsCurve, ...]
Domain = tuple[tuple[float, float], tuple[float, float]]

SNAP_TOL = 1e-9
"""Gaps in a loop up to this share of the domain are rounding: the ends are moved together."""
LARGEST_GAP = 1e-3
"""Gaps up to this share of the domain are closed by a straight piece; larger ones are errors."""
MAX_EXCESS = 1e-2
"""Largest excess of a p-curve over the rectangle, which clips it, as a share of the domain."""


class _Pieces(NamedTuple):
    """Pieces of one loop in order."""

    coefs: list[FloatArray]
    """(degree + 1, 3) homogeneous Bernstein coefficients (wu, wv, w) of each."""
    ends: FloatArray
    """(n, 4) u, v at the start and u, v at the end."""
    curve: list[int]
    """Number of the p-curve of each; −1 for a bridge."""


def check_loops(loops: tuple[Loop, ...], domain: Domain, where: str) -> None:
    """Raise GeometryError unless every loop closes, with ends of p-curves in the patch's rectangle.

    Gaps up to `LARGEST_GAP` of the domain count as closed, ends up to `MAX_EXCESS` of it outside as
    inside. A loop without p-curves is an error, too.

    Parameters
    ----------
    loops : p-curves head to tail, loop by loop
    domain : ((u0, u1), (v0, v1)) of the patch
    where : what to call the patch in the message
    """
    low = np.array([domain[0][0], domain[1][0]])
    span = np.array([domain[0][1], domain[1][1]]) - low
    for k, loop in enumerate(loops):
        place = f"{where}, loop {k}"
        if not loop:
            raise GeometryError("a trimming loop needs at least one p-curve", where=place)
        ends = np.array([curve.control_points[[0, -1], :2] for curve in loop])
        gaps = np.abs(np.roll(ends[:, 0], -1, axis=0) - ends[:, 1]) / span
        if gaps.max() > LARGEST_GAP:
            raise GeometryError(
                "a trimming loop must close: its p-curves do not meet head to tail",
                where=f"{place}, after p-curve {int(gaps.max(axis=1).argmax())}",
                found=float(gaps.max()),
                allowed=f"gaps up to {LARGEST_GAP:g} of the patch's parameter range",
            )
        reach = (ends.reshape(-1, 2) - low) / span
        if reach.min() < -MAX_EXCESS or reach.max() > 1.0 + MAX_EXCESS:
            raise GeometryError(
                "trimming loops must lie in the patch's parameter rectangle",
                where=place,
                found=(float(reach.min()), float(reach.max())),
                allowed="0 to 1 of the parameter range",
            )


def parameter_box(
    patch: NurbsSurface, loops: tuple[Loop, ...] | None
) -> tuple[FloatArray, FloatArray]:
    """Return the lower and upper (u, v) of a patch's domain, cut to the box of its loops.

    That is the box of the p-curves' control points: it may be larger than the trimmed part.
    """
    low, high = np.array(patch.domain).T
    if loops is None:
        return low, high
    reach = np.concatenate([curve.bounds()[:, :2] for loop in loops for curve in loop])
    return np.maximum(low, reach.min(axis=0)), np.minimum(high, reach.max(axis=0))


def loop_pieces(tables: TrimTables, patch: int) -> list[np.ndarray]:
    """Return the numbers of the pieces of each loop of a patch, in their order along it."""
    first, last = tables.patch_start[patch], tables.patch_start[patch + 1]
    pieces = np.arange(first, last)
    loops = tables.piece_loop[first:last, 0]
    return [pieces[loops == number] for number in np.unique(loops)]


def _monotone_pieces(loop: Loop, low: FloatArray, high: FloatArray) -> _Pieces:
    """Return the monotone pieces of one loop, whose `ends` meet exactly.

    Ends are clipped to the domain, from `low` to `high`, and made one up to `SNAP_TOL` of it apart;
    coefficients are not changed. Straight pieces, of p-curve −1, bridge larger gaps.
    """
    by_curve = []
    for curve in loop:
        segments = np.ascontiguousarray(extract_curve(curve).coefs[:, :, [0, 1, 3]])
        degrees = np.full(len(segments), segments.shape[1] - 1, dtype=np.int32)
        by_curve.append(build_nb.monotone_pieces(segments, degrees)[0])
    coefs = [piece for pieces in by_curve for piece in pieces]
    curve_of = np.repeat(np.arange(len(loop)), [len(pieces) for pieces in by_curve]).tolist()
    ends = np.concatenate([pieces[:, [0, -1]] for pieces in by_curve])
    ends = np.clip(ends[..., :2] / ends[..., 2:], low, high)
    following = np.roll(ends[:, 0], -1, axis=0)
    has_gap = (np.abs(following - ends[:, 1]) > SNAP_TOL * (high - low)).any(axis=1)
    gaps = np.flatnonzero(has_gap)
    bridges = np.stack([ends[gaps, 1], following[gaps]], axis=1)
    ends[~has_gap, 1] = following[~has_gap]
    for k, bridge in zip(gaps[::-1] + 1, bridges[::-1], strict=True):
        coefs.insert(k, np.column_stack([bridge, np.ones(2)]))
        curve_of.insert(k, -1)
    return _Pieces(coefs, np.insert(ends, gaps + 1, bridges, axis=0).reshape(-1, 4), curve_of)


def build_trim_tables(
    patches: Sequence[NurbsSurface],
    trims: Sequence[tuple[Loop, ...] | None],
    edges: Sequence[BodyEdge] = (),
) -> TrimTables:
    """Return tables for `point_in_trim` and `box_state` over all patches of a body, or a few.

    Parameters
    ----------
    patches : patches of the body
    trims : for each patch None, or its loops
    edges : of the body, to name the edge of each piece

    Returns
    -------
    TrimTables
        Flat arrays; patches without trims take no cells and are inside everywhere.
    """
    edge_of = {(use[0], use[1], use[2]): k for k, edge in enumerate(edges) for use in edge.uses}
    coefs: list[FloatArray] = []
    ends: list[FloatArray] = [np.empty((0, 4))]
    keys: list[tuple[int, int, int, int]] = []
    """By piece patch, loop, p-curve and edge."""
    counts = np.zeros(len(patches), dtype=np.int64)
    for k, (patch, loops) in enumerate(zip(patches, trims, strict=True)):
        (u0, u1), (v0, v1) = patch.domain
        for m, loop in enumerate(loops or ()):
            pieces = _monotone_pieces(loop, np.array([u0, v0]), np.array([u1, v1]))
            coefs += pieces.coefs
            ends.append(pieces.ends)
            keys += [(k, m, c, edge_of.get((k, m, c), -1)) for c in pieces.curve]
            counts[k] += len(pieces.coefs)
    key_array = np.array(keys, dtype=np.int32).reshape(-1, 4)
    degree = np.array([len(c) - 1 for c in coefs], dtype=np.int32)
    padded = np.zeros((len(coefs), int(degree.max(initial=1)) + 1, 3))
    for row, c in zip(padded, coefs, strict=True):
        row[: len(c)] = c
    trimmed = np.array([loops is not None for loops in trims], dtype=np.int8)
    # Grids grow with the number of pieces, so that few pieces meet in a cell.
    side = [min(max(math.ceil(3.0 * math.sqrt(c)), 4), 512) if c else 0 for c in counts]
    grid_shape = np.array([[s, s] for s in side], dtype=np.int64)
    n_cells = np.where(trimmed > 0, grid_shape.prod(axis=1), 0)
    total = int(n_cells.sum())
    tables = TrimTables(
        piece_coefs=padded,
        piece_degree=degree,
        piece_ends=np.concatenate(ends),
        piece_patch=key_array[:, 0].copy(),
        piece_edge=key_array[:, 3].copy(),
        piece_loop=key_array[:, 1:3].copy(),
        patch_start=np.concatenate([[0], np.cumsum(counts)]),
        trimmed=trimmed,
        domain=np.array([[*p.domain[0], *p.domain[1]] for p in patches]),
        grid_shape=grid_shape,
        grid_start=np.concatenate([[0], np.cumsum(n_cells)]),
        cell_state=np.zeros(total, dtype=np.int8),
        cell_parity=np.zeros(total, dtype=np.int8),
        cell_start=np.zeros(total + 1, dtype=np.int64),
        cell_pieces=np.zeros(0, dtype=np.int32),
        toggle_start=np.zeros(total + 1, dtype=np.int64),
        toggles=np.zeros(0),
    )
    cell_start, cell_pieces, toggle_start, toggles = build_nb.fill_cells(tables)
    return tables._replace(
        cell_start=cell_start, cell_pieces=cell_pieces, toggle_start=toggle_start, toggles=toggles
    )
