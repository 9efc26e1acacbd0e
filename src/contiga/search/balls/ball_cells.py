"""Cells of the elements of a body, and the touching balls proved at their corners.

The grid of an element has cells small enough for nearly constant derivatives. Cells near poles are
halved until they are, and then the largest cells in which little was proved.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contiga.arrays.codes import CUT, OUT
from contiga.arrays.threads import run_ranges
from contiga.elements.element_arrays import Records
from contiga.geometry.kernels import trim_nb
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray
from contiga.search.balls.ball_caps import Caps, find_caps
from contiga.search.balls.ball_records import (
    BLOCK,
    CELL,
    BallLimits,
    CellBounds,
    CellTree,
    CentredSurface,
)
from contiga.search.balls.kernels import ball_block_nb, ball_bound_nb, ball_cell_nb, ball_plane_nb
from contiga.search.hierarchy.build import tree_over
from contiga.search.hierarchy.table_types import Tables

CAP, GOAL = 0.25, 0.01
"""Largest radius that is computed, and the one for which cells are cut, as shares of the size."""
CELL_TURN = (0.2, 0.28, 0.4)
GRID_BUDGET = 8000
"""Relative change of derivatives in a cell of the grid: the first value that needs no more cells
than the budget."""
MAX_TURN, MAX_ROUGH_LENGTH = 0.6, 5e-3
"""Cells with a larger relative change of derivatives, and longer than this share of the body's
size, are cut before any bound is computed."""
MAX_CELL_LENGTH = 1.0 / 12.0
"""Largest length of a cell of the grid, as a share of the body's size."""
MAX_CELLS = 16
"""Largest number of cells of an element in each direction."""
MAX_DEPTH, MIN_LENGTH = 12, 1e-3
"""Largest number of cuts of a cell, and least length of a cell that is cut, as a share of the size.
"""
ROUNDS, BUDGET = 12, 30000
"""Largest number of rounds in which cells are cut where too little was proved, and of new cells."""
MAX_UNPROVED, MAX_UNPROVED_IN_ALL = 0.25, 0.01
"""Unproved share above which a cell is cut, and that of the body above which any cell is."""
SURROUNDINGS = (2.0, 1.0, 0.0)
"""Margins of the surroundings of a cell that are tried as its smooth block, in its lengths."""
BLOCK_GOALS = 3.0
"""Radius of the balls that a smooth block should allow, in goals."""
MIN_CELLS = 16
"""Number of cells below which a second thread does not pay."""
SIDE_TOL = 1e-12
"""Distance below which sides are one, as a share of the body's size."""

GRID = np.dtype(
    [
        ("first", "i4"),  # first cell
        ("stride", "i4"),  # from cell (i, j) to (i + 1, j)
        ("cells", "i4", 2),
    ],
    align=True,
)


@pass_by_pointer
class Balls(NamedTuple):
    """Radii of touching balls over a body: a grid of cells per element, some of them halved."""

    elements: Records
    """(elements,) `GRID`."""
    child: IntArray
    """(cells,) twice the row of the first half of a cell, plus 1 if halved across t; or −1."""
    value: FloatArray
    """(cells, 2, 4) inner and outer radius at the corners, interpolated bilinearly."""


Rows = NDArray[np.intp]


class _Cells(NamedTuple):
    """Cells under construction: those of the grid first, then the halves of cut cells."""

    cells: Records
    blocks: Records
    child: IntArray
    value: FloatArray
    unproved: FloatArray
    depth: IntArray


class _Frame(NamedTuple):
    """The body that the cells lie on, and the frame and sizes they are measured in."""

    tables: Tables
    centre: FloatArray
    """Origin of all coordinates of cells."""
    size: float
    tolerance: float
    """Distance below which sides are one, length."""
    caps: Caps


def build_balls(tables: Tables) -> Balls:
    """Return the touching balls of a body.

    Cells with rough derivatives are halved first. Then, in at most `ROUNDS` rounds, the radii of
    new cells are bounded, and cells of which too little is proved are halved, those with the
    largest loss first, until the rest is small or `BUDGET` is spent.
    """
    root = tables.tree[0]
    centre, size = 0.5 * (root["low"] + root["high"]), float(tables.scale[0])
    rounding = np.finfo(float).eps * float(np.abs(centre).max())
    tolerance = SIDE_TOL * size + 8.0 * rounding
    elements, bases, cells = _grid(tables, centre, size)
    frame = _Frame(tables, centre, size, tolerance, find_caps(tables, cells, tolerance))
    _measure(frame, cells)
    # The smooth blocks around the cells of the grids.
    n, blocks = len(cells), np.zeros(len(cells), BLOCK)
    blocks["patch"] = cells["patch"]
    cells["block"] = np.arange(n)
    smooth = np.ones((n, 2), bool)
    joints = (tables.elements, tables.grid, bases, cells, tolerance, smooth)
    closes = ball_block_nb.smooth_joints(*joints)
    domain = tables.trims.domain.reshape(-1, 2, 2)
    blocks["period"] = (closes * np.diff(domain, axis=2)[:, :, 0])[cells["patch"]]
    blocks["cap"] = -1
    ball_block_nb.base_blocks(cells, smooth, bases, blocks)
    frame.caps.take(cells, blocks, _target_radius(frame))
    child = np.full(n, -1, np.int32)
    all_cells = _Cells(cells, blocks, child, np.zeros((n, 2, 4)), np.zeros(n), np.zeros(n, int))
    while True:
        # Cut the cells whose derivatives change too much for any bound.
        cells = all_cells.cells
        is_rough = ~(cells["turn"] <= MAX_TURN) & (_length(cells) > MAX_ROUGH_LENGTH * size)
        can_cut = _is_leaf(all_cells) & ~_has_cap(all_cells) & (all_cells.depth < MAX_DEPTH)
        cut_cells = np.flatnonzero(can_cut & is_rough)
        if len(cut_cells) == 0:
            break
        all_cells = _cut(frame, all_cells, cut_cells, own_blocks=True)
    rows = np.arange(len(all_cells.cells), dtype=np.intp)
    max_cells = len(rows) + BUDGET
    for _ in range(ROUNDS):
        _bound(frame, all_cells, rows)
        # Cut cells with a large unproved share, the largest first, until the budget is spent.
        cells = all_cells.cells
        length, is_leaf = _length(cells), _is_leaf(all_cells)
        loss = all_cells.unproved * length**2
        is_sound = (cells["turn"] <= MAX_TURN) | _has_cap(all_cells)
        can_cut = is_leaf & is_sound & (length > MIN_LENGTH * size) & (all_cells.depth < MAX_DEPTH)
        poor_cells = np.flatnonzero(can_cut & (all_cells.unproved > MAX_UNPROVED))
        if loss[poor_cells].sum() <= MAX_UNPROVED_IN_ALL * (length[is_leaf] ** 2).sum():
            break
        n_cuts = min(max_cells - len(cells), BUDGET // ROUNDS) // 2
        cut_cells = np.sort(poor_cells[np.argsort(-loss[poor_cells], kind="stable")[:n_cuts]])
        if len(cut_cells) == 0:
            break
        start = len(cells)
        all_cells = _cut(frame, all_cells, cut_cells, own_blocks=False)
        rows = np.arange(start, len(all_cells.cells), dtype=np.intp)
    else:
        _bound(frame, all_cells, rows)
    return Balls(elements, all_cells.child, all_cells.value)


def _grid(tables: Tables, centre: FloatArray, size: float) -> tuple[Records, Rows, Records]:
    """Return the cells of the grids of all elements; a span has as many as its neediest element.

    Returns the `GRID` row of each element; (patches, 3) the first cell and the numbers of cells in
    u and v; and the cells, patch by patch, in which only their places are set. `CELL_TURN` and
    `MAX_CELL_LENGTH` decide how many an element needs.
    """
    elements, grid = tables.elements, tables.grid
    n = len(elements.table)
    # The quarters of every element, one after the other.
    quarters = np.zeros(4 * n, CELL)
    quarters["element"] = np.repeat(np.arange(n), 4)
    halves = [(-0.5, 0.0), (0.0, 0.5)]
    quarters["box"] = np.tile([(*a, *b) for a in halves for b in halves], (n, 1))
    _measure_cells(tables, centre, quarters)
    # Cells that an element needs in s and in t, (n, 2); fewer if they exceed the budget. The
    # longest quarter counts: towards a pole lengths vanish, and second derivatives with them.
    lengths = np.linalg.norm(quarters["first"], axis=2).reshape(-1, 4, 2).max(axis=1)
    second = quarters["second"][:, [0, 2]].reshape(-1, 4, 2).max(axis=1)
    turn = second / np.maximum(lengths, 1e-300)
    length_ratio = 2.0 * lengths / (MAX_CELL_LENGTH * size)
    for max_turn in CELL_TURN:
        n_cells = np.ceil(np.maximum(turn / max_turn, length_ratio))
        n_cells = np.clip(n_cells, 1, MAX_CELLS).astype(np.int32)
        if n_cells.prod(axis=1).sum() <= GRID_BUDGET:
            break
    rows = np.zeros(n, GRID)
    bases = np.zeros((len(grid.patches), 3), np.intp)
    parts: list[Records] = []
    n_total = 0
    for k, patch in enumerate(grid.patches):
        nu, nv = int(np.ptp(patch["u"])) - 1, int(np.ptp(patch["v"])) - 1
        span = slice(int(patch["first"]), int(patch["first"]) + nu * nv)
        span_cells = n_cells[span].reshape(nu, nv, 2)
        n_u, n_v = span_cells[:, :, 0].max(axis=1), span_cells[:, :, 1].max(axis=0)
        u, v = int(n_u.sum()), int(n_v.sum())
        bases[k] = n_total, u, v
        corner = (np.cumsum(n_u) - n_u)[:, None] * v + (np.cumsum(n_v) - n_v)[None, :]
        rows["first"][span] = n_total + corner.ravel()
        rows["stride"][span] = v
        rows["cells"][span, 0] = np.repeat(n_u, nv)
        rows["cells"][span, 1] = np.tile(n_v, nu)
        # The cells of the patch, in the order of the grid.
        counts = n_u, n_v
        spans = [np.repeat(np.arange(len(c)), c) for c in counts]
        places = [np.arange(c.sum()) - np.repeat(np.cumsum(c) - c, c) for c in counts]
        i, j = np.meshgrid(*spans, indexing="ij")
        a, b = np.meshgrid(*places, indexing="ij")
        cells = np.zeros(i.size, CELL)
        cells["element"] = span.start + (i * nv + j).ravel()
        low = np.stack([a / n_u[i], b / n_v[j]], axis=-1).reshape(-1, 2)
        high = np.stack([(a + 1) / n_u[i], (b + 1) / n_v[j]], axis=-1).reshape(-1, 2)
        _place_cells(cells, np.stack([low, high], axis=-1) - 0.5, elements.table)
        parts.append(cells)
        n_total += u * v
    return rows, bases, np.concatenate(parts)


def _place_cells(cells: Records, box: FloatArray, table: Records) -> None:
    """Set box, uv, width and patch of cells; `box` (n, 2, 2) is low and high in s and in t."""
    cells["box"] = box.reshape(-1, 4)
    rows = table[cells["element"]]
    element_box = rows["box"].reshape(-1, 2, 2)
    width = element_box[:, :, 1] - element_box[:, :, 0]
    cells["uv"] = (element_box[:, :, :1] + (box + 0.5) * width[:, :, None]).reshape(-1, 4)
    cells["wide"] = width * (box[:, :, 1] - box[:, :, 0])
    cells["patch"] = rows["patch"]


def _measure(frame: _Frame, cells: Records) -> None:
    """Set the bounds of cells, their caps, and their state by the trims, in place."""
    tables = frame.tables
    _measure_cells(tables, frame.centre, cells)
    frame.caps.mark(cells)
    cells["state"] = tables.elements.table["trim"][cells["element"]]
    for k in np.flatnonzero(cells["state"] == CUT):
        box = cells["uv"][k].tolist()
        cells["state"][k] = trim_nb.box_state(tables.trims, int(cells["patch"][k]), *box)


def _measure_cells(tables: Tables, centre: FloatArray, cells: Records) -> None:
    """Set the bounds of cells, in place (`ball_cell_nb.measure`)."""
    run_ranges(ball_cell_nb.measure_cells, len(cells), MIN_CELLS, tables.elements, centre, cells)


def _target_radius(frame: _Frame) -> float:
    """Return the radius of the balls that a smooth block should allow, length."""
    return BLOCK_GOALS * GOAL * frame.size


def _is_leaf(all_cells: _Cells) -> NDArray[np.bool_]:
    """Return a mask (cells,) of those that are not cut and not trimmed away."""
    return (all_cells.child < 0) & (all_cells.cells["state"] != OUT)


def _length(cells: Records) -> FloatArray:
    """Return the length (n,) of the longer diagonal of each cell."""
    corner = cells["corner"]
    return np.maximum(
        np.linalg.norm(corner[:, 3] - corner[:, 0], axis=1),
        np.linalg.norm(corner[:, 2] - corner[:, 1], axis=1),
    )


def _has_cap(all_cells: _Cells) -> NDArray[np.bool_]:
    """Return a mask (cells,) of those whose smooth block is a cap."""
    caps: NDArray[np.bool_] = all_cells.blocks["cap"][all_cells.cells["block"]] >= 0
    return caps


def _cut(frame: _Frame, old: _Cells, rows: Rows, own_blocks: bool) -> _Cells:
    """Return all cells with `rows` halved: the old ones, then both halves of each row.

    A cell is cut across its longer direction; with `own_blocks` where its derivatives then change
    least. Halves inherit the smooth block, unless surroundings of their own are better, and by
    interpolation the radii; with `own_blocks` inherited blocks count as proving nothing.
    """
    n = len(old.cells)
    parents = np.repeat(old.cells[rows], 2)
    # Halved across s (0) or t (1), rough cells so that their derivatives change least.
    cells = old.cells[rows]
    lengths = np.linalg.norm(cells["first"], axis=2)
    axis = (lengths[:, 1] > lengths[:, 0]).astype(int)
    if own_blocks:
        second = cells["second"]
        with np.errstate(divide="ignore", invalid="ignore"):
            a = second[:, :2] / lengths[:, :1]
            b = second[:, 1:] / lengths[:, 1:]
        turn_s = np.hypot(0.5 * a[:, 0] + a[:, 1], 0.5 * b[:, 0] + b[:, 1])
        turn_t = np.hypot(a[:, 0] + 0.5 * a[:, 1], b[:, 0] + 0.5 * b[:, 1])
        axis = (~(turn_s <= turn_t)).astype(int)
    halves = np.zeros(len(parents), CELL)
    halves["element"], halves["block"] = parents["element"], parents["block"]
    box = parents["box"].reshape(-1, 2, 2).copy()
    half_rows = np.arange(len(box))
    axes = np.repeat(axis, 2)
    box[half_rows, axes, 1 - half_rows % 2] = box[half_rows, axes].mean(axis=1)
    _place_cells(halves, box, frame.tables.elements.table)
    _measure(frame, halves)
    inherited = old.blocks[halves["block"]]
    if own_blocks:
        inherited["radii"], inherited["cap"] = 0.0, -1
    halves["block"] = len(old.blocks) + half_rows
    blocks = np.concatenate([old.blocks, _own_blocks(frame, halves, inherited)])
    child = np.concatenate([old.child, np.full(len(halves), -1, np.int32)])
    child[rows] = 2 * (n + 2 * np.arange(len(rows))) + axis
    # Corner values of the halves, those halved across t with their two directions swapped.
    is_in_t = (axis == 1)[:, None, None, None]
    values = old.value[rows].reshape(-1, 2, 2, 2)
    values = np.where(is_in_t, values.swapaxes(2, 3), values)
    middle = values.mean(axis=2)
    first_half = np.stack([values[:, :, 0], middle], axis=2)
    second_half = np.stack([middle, values[:, :, 1]], axis=2)
    half_values = np.stack([first_half, second_half], axis=1).reshape(-1, 2, 2, 2)
    half_values = np.where(is_in_t.repeat(2, axis=0), half_values.swapaxes(2, 3), half_values)
    value = np.concatenate([old.value, half_values.reshape(-1, 2, 4)])
    unproved = np.concatenate([old.unproved, np.zeros(len(halves))])
    depth = np.concatenate([old.depth, np.repeat(old.depth[rows] + 1, 2)])
    return _Cells(np.concatenate([old.cells, halves]), blocks, child, value, unproved, depth)


def _own_blocks(frame: _Frame, parts: Records, blocks: Records) -> Records:
    """Return smooth blocks of cells: the given ones, or surroundings in their element, or caps.

    Surroundings are tried from the widest on (`single_cell_blocks`), but not for cells with a block
    that proves anything whose own surroundings would cross a side of the element. Then caps replace
    blocks of any cells near poles. Changes `blocks`.
    """
    box = parts["box"].reshape(-1, 2, 2)
    half = box[:, :, 1] - box[:, :, 0]
    lengths = np.maximum(np.linalg.norm(parts["first"], axis=2), 1e-300)
    aspect = np.minimum(lengths.max(axis=1, keepdims=True) / lengths, 8.0)
    around = np.stack([parts] * len(SURROUNDINGS))
    # Only an inherited block extends across a side of the element.
    is_beyond = np.abs(box).max(axis=2) + half * aspect > 0.5
    at_side = (blocks["radii"].min(axis=1) > 0.0) & is_beyond.any(axis=1)
    for row, ratio in zip(around, SURROUNDINGS, strict=True):
        margin = ratio * half * aspect
        around_box = np.stack([box[:, :, 0] - margin, box[:, :, 1] + margin], axis=2)
        _place_cells(row, np.clip(around_box, -0.5, 0.5), frame.tables.elements.table)
    rows = np.flatnonzero(~at_side)
    new_blocks = blocks[rows]
    limit = _target_radius(frame)
    own_around = np.ascontiguousarray(around[:, rows])
    elements = frame.tables.elements
    ball_block_nb.single_cell_blocks(elements, frame.centre, own_around, limit, new_blocks)
    blocks[rows] = new_blocks
    frame.caps.take(parts, blocks, limit)
    return blocks


def _bound(frame: _Frame, all_cells: _Cells, rows: Rows) -> None:
    """Write radii and unproved share of those cells of `rows` that are not cut or trimmed away.

    They go to `value` and `unproved` of `all_cells`. All leaves of the body bound them.
    """
    cells = all_cells.cells
    leaves = np.flatnonzero(_is_leaf(all_cells)).astype(np.int32)
    corner, bulge = cells["corner"][leaves], cells["bulge"][leaves, None]
    margin = bulge + ball_plane_nb.ROUNDING * frame.size
    low, high = corner.min(axis=1) - margin, corner.max(axis=1) + margin
    tree, order = tree_over(low, high)
    rows = np.intersect1d(rows, leaves)
    body = CellTree(cells, tree, leaves[order])
    surface = CentredSurface(frame.tables.elements, frame.tables.trims, frame.centre)
    limits = BallLimits(frame.size, CAP * frame.size, GOAL * frame.size)
    result = CellBounds(rows, all_cells.value, all_cells.unproved)
    arguments = body, surface, all_cells.blocks, limits, result
    run_ranges(ball_bound_nb.bound_cells, len(rows), MIN_CELLS, *arguments)
