"""Cells of the elements of a body, and the touching balls proved at their corners.

The grid of an element has cells small enough for its derivatives to be nearly constant; cells near
poles are halved until they are, and then the largest ones in which little was proved.
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
    CELL,
    HOME,
    BallLimits,
    CellBounds,
    CellTree,
    CentredSurface,
)
from contiga.search.balls.kernels import ball_block_nb, ball_bound_nb, ball_cell_nb, ball_plane_nb
from contiga.search.hierarchy.build import tree_over
from contiga.search.hierarchy.table_types import Tables

# Largest radius looked for, and the one up to which cells are cut for it, as shares of the size.
CAP = 0.25
GOAL = 0.01
# Derivatives of a cell of the grid differ by about this share from those of its middle: the
# first that needs no more cells than that.
CELL_TURN = (0.2, 0.28, 0.4)
GRID_BUDGET = 8000
# Cells whose derivatives differ by more than this are cut before anything is asked of them,
LARGEST_TURN = 0.6
# unless they are shorter than this share of the body's size.
ROUGH = 5e-3
# Length of a cell of the grid as a share of the body's size, and cells an element, at most.
CELL_LENGTH = 1.0 / 12.0
MAX_CELLS = 16
# Cuts of a cell at most, and how long it must be to be cut, as a share of the size.
DEEPEST = 12
SHORTEST = 1e-3
# Rounds of cutting the largest cells where too little was proved, and how many they may add.
ROUNDS = 12
BUDGET = 30000
# Share of a cell in which too little was proved for it to be cut, and of the body for any to be.
WANTING, WANTING_IN_ALL = 0.25, 0.01
# How far the surroundings of a cell tried as its smooth block go, in its lengths.
SURROUNDINGS = (2.0, 1.0, 0.0)
# Balls that a block is to allow, in units of the goal.
BLOCK_GOALS = 3.0
# Cells that a thread takes at once.
CELLS = 16
# Sides that lie closer than this share of the body's size are one.
CLOSE = 1e-12

GRID = np.dtype(
    [
        ("first", "i4"),  # its first cell
        ("stride", "i4"),  # from cell (i, j) to (i + 1, j)
        ("cells", "i4", 2),
    ],
    align=True,
)


@pass_by_pointer
class Balls(NamedTuple):
    """Radii of touching balls over a body: a grid of cells an element, some halved again."""

    elements: Records
    """(elements,) `GRID`."""
    child: IntArray
    """(cells,) twice the first of a cell's halves, plus 1 where it is halved across t; or −1."""
    value: FloatArray
    """(cells, 2, 4) inner and outer radius at the corners, interpolated bilinearly."""


Places = NDArray[np.intp]


class _Cells(NamedTuple):
    """Cells under construction: the grid's first, then the halves of those that were cut."""

    cells: Records
    homes: Records
    child: IntArray
    value: FloatArray
    want: FloatArray
    depth: IntArray


class _Place(NamedTuple):
    """The body that the cells lie on, and the frame and sizes they are measured in."""

    tables: Tables
    centre: FloatArray
    """All lengths of cells are about this point."""
    size: float
    tolerance: float
    """Sides that lie closer than this are one."""
    caps: Caps


def build_balls(tables: Tables) -> Balls:
    root = tables.tree[0]
    centre, size = 0.5 * (root["low"] + root["high"]), float(tables.scale[0])
    reach = np.finfo(float).eps * float(np.abs(centre).max())
    tolerance = CLOSE * size + 8.0 * reach
    elements, bases, cells = _grid(tables, centre, size)
    place = _Place(tables, centre, size, tolerance, find_caps(tables, cells, tolerance))
    _measure(place, cells)
    # The cells of the grids with the smooth blocks around them.
    n, homes = len(cells), np.zeros(len(cells), HOME)
    homes["patch"] = cells["patch"]
    cells["home"] = np.arange(n)
    smooth = np.ones((n, 2), bool)
    joints = (tables.elements, tables.grid, bases, cells, tolerance, smooth)
    closes = ball_block_nb.joints(*joints)
    domain = tables.trims.domain.reshape(-1, 2, 2)
    homes["period"] = (closes * np.diff(domain, axis=2)[:, :, 0])[cells["patch"]]
    homes["cap"] = -1
    ball_block_nb.base_homes(cells, smooth, bases, homes)
    place.caps.take(cells, homes, _limit(place))
    child = np.full(n, -1, np.int32)
    all_cells = _Cells(cells, homes, child, np.zeros((n, 2, 4)), np.zeros(n), np.zeros(n, int))
    while True:
        # Cells whose derivatives differ too much to say anything, and that can be cut.
        cells = all_cells.cells
        rough = ~(cells["turn"] <= LARGEST_TURN) & (_length(cells) > ROUGH * size)
        able = _is_leaf(all_cells) & ~_has_cap(all_cells) & (all_cells.depth < DEEPEST)
        parts = np.flatnonzero(able & rough)
        if len(parts) == 0:
            break
        all_cells = _cut(place, all_cells, parts, own_homes=True)
    rows = np.arange(len(all_cells.cells), dtype=np.intp)
    most = len(rows) + BUDGET
    for _ in range(ROUNDS):
        _bound(place, all_cells, rows)
        # Cells in which much is wanting, the largest first until the budget is spent.
        cells = all_cells.cells
        length, leaf = _length(cells), _is_leaf(all_cells)
        loss = all_cells.want * length**2
        sound = (cells["turn"] <= LARGEST_TURN) | _has_cap(all_cells)
        able = leaf & sound & (length > SHORTEST * size) & (all_cells.depth < DEEPEST)
        poor = np.flatnonzero(able & (all_cells.want > WANTING))
        if loss[poor].sum() <= WANTING_IN_ALL * (length[leaf] ** 2).sum():
            break
        free = min(most - len(cells), BUDGET // ROUNDS) // 2
        parts = np.sort(poor[np.argsort(-loss[poor], kind="stable")[:free]])
        if len(parts) == 0:
            break
        start = len(cells)
        all_cells = _cut(place, all_cells, parts, own_homes=False)
        rows = np.arange(start, len(all_cells.cells), dtype=np.intp)
    else:
        _bound(place, all_cells, rows)
    return Balls(elements, all_cells.child, all_cells.value)


def _grid(tables: Tables, centre: FloatArray, size: float) -> tuple[Records, Places, Records]:
    """Cells of every element: as many a span as the most that any element of the span needs."""
    elements, grid = tables.elements, tables.grid
    n = len(elements.table)
    # The quarters of every element, one after the other.
    quarters = np.zeros(4 * n, CELL)
    quarters["element"] = np.repeat(np.arange(n), 4)
    halves = [(-0.5, 0.0), (0.0, 0.5)]
    quarters["box"] = np.tile([(*a, *b) for a in halves for b in halves], (n, 1))
    _measure_cells(tables, centre, quarters)
    # Cells that an element wants in s and in t, (n, 2): fewer where that would be too many.
    # The longest quarter counts: towards a pole lengths vanish, and bends with them.
    lengths = np.linalg.norm(quarters["first"], axis=2).reshape(-1, 4, 2).max(axis=1)
    second = quarters["second"][:, [0, 2]].reshape(-1, 4, 2).max(axis=1)
    turn = second / np.maximum(lengths, 1e-300)
    long = 2.0 * lengths / (CELL_LENGTH * size)
    for share in CELL_TURN:
        wants = np.clip(np.ceil(np.maximum(turn / share, long)), 1, MAX_CELLS).astype(np.int32)
        if wants.prod(axis=1).sum() <= GRID_BUDGET:
            break
    rows = np.zeros(n, GRID)
    bases = np.zeros((len(grid.patches), 3), np.intp)
    parts: list[Records] = []
    used = 0
    for k, patch in enumerate(grid.patches):
        nu, nv = int(np.ptp(patch["u"])) - 1, int(np.ptp(patch["v"])) - 1
        span = slice(int(patch["first"]), int(patch["first"]) + nu * nv)
        need = wants[span].reshape(nu, nv, 2)
        along, across = need[:, :, 0].max(axis=1), need[:, :, 1].max(axis=0)
        u, v = int(along.sum()), int(across.sum())
        bases[k] = used, u, v
        corner = (np.cumsum(along) - along)[:, None] * v + (np.cumsum(across) - across)[None, :]
        rows["first"][span] = used + corner.ravel()
        rows["stride"][span] = v
        rows["cells"][span, 0] = np.repeat(along, nv)
        rows["cells"][span, 1] = np.tile(across, nu)
        # Its cells, in the order of the grid.
        counts = along, across
        spans = [np.repeat(np.arange(len(c)), c) for c in counts]
        places = [np.arange(c.sum()) - np.repeat(np.cumsum(c) - c, c) for c in counts]
        i, j = np.meshgrid(*spans, indexing="ij")
        a, b = np.meshgrid(*places, indexing="ij")
        cells = np.zeros(i.size, CELL)
        cells["element"] = span.start + (i * nv + j).ravel()
        low = np.stack([a / along[i], b / across[j]], axis=-1).reshape(-1, 2)
        high = np.stack([(a + 1) / along[i], (b + 1) / across[j]], axis=-1).reshape(-1, 2)
        _place_cells(cells, np.stack([low, high], axis=-1) - 0.5, elements.table)
        parts.append(cells)
        used += u * v
    return rows, bases, np.concatenate(parts)


def _place_cells(cells: Records, box: FloatArray, table: Records) -> None:
    """Set where cells lie: `box` (n, 2, 2) from low to high in s and t."""
    cells["box"] = box.reshape(-1, 4)
    rows = table[cells["element"]]
    whole = rows["box"].reshape(-1, 2, 2)
    wide = whole[:, :, 1] - whole[:, :, 0]
    cells["uv"] = (whole[:, :, :1] + (box + 0.5) * wide[:, :, None]).reshape(-1, 4)
    cells["wide"] = wide * (box[:, :, 1] - box[:, :, 0])
    cells["patch"] = rows["patch"]


def _measure(place: _Place, cells: Records) -> None:
    """Bounds of cells, and where they lie in caps and in the trims."""
    tables = place.tables
    _measure_cells(tables, place.centre, cells)
    place.caps.mark(cells)
    cells["state"] = tables.elements.table["trim"][cells["element"]]
    for k in np.flatnonzero(cells["state"] == CUT):
        box = cells["uv"][k].tolist()
        cells["state"][k] = trim_nb.box_state(tables.trims, int(cells["patch"][k]), *box)


def _measure_cells(tables: Tables, centre: FloatArray, cells: Records) -> None:
    run_ranges(ball_cell_nb.measure_cells, len(cells), CELLS, tables.elements, centre, cells)


def _limit(place: _Place) -> float:
    """Balls that a smooth block is to allow."""
    return BLOCK_GOALS * GOAL * place.size


def _is_leaf(all_cells: _Cells) -> NDArray[np.bool_]:
    return (all_cells.child < 0) & (all_cells.cells["state"] != OUT)


def _length(cells: Records) -> FloatArray:
    corner = cells["corner"]
    return np.maximum(
        np.linalg.norm(corner[:, 3] - corner[:, 0], axis=1),
        np.linalg.norm(corner[:, 2] - corner[:, 1], axis=1),
    )


def _has_cap(all_cells: _Cells) -> NDArray[np.bool_]:
    """Cells whose smooth block is a cap."""
    caps: NDArray[np.bool_] = all_cells.homes["cap"][all_cells.cells["home"]] >= 0
    return caps


def _cut(place: _Place, old: _Cells, rows: Places, own_homes: bool) -> _Cells:
    """Cells with `rows` halved; the parts take the homes of the whole or get their own."""
    n = len(old.cells)
    whole = np.repeat(old.cells[rows], 2)
    # Halved across s (0) or t (1), rough ones so that they turn least.
    cells = old.cells[rows]
    lengths = np.linalg.norm(cells["first"], axis=2)
    way = (lengths[:, 1] > lengths[:, 0]).astype(int)
    if own_homes:
        second = cells["second"]
        with np.errstate(divide="ignore", invalid="ignore"):
            a = second[:, :2] / lengths[:, :1]
            b = second[:, 1:] / lengths[:, 1:]
        in_s = np.hypot(0.5 * a[:, 0] + a[:, 1], 0.5 * b[:, 0] + b[:, 1])
        in_t = np.hypot(a[:, 0] + 0.5 * a[:, 1], b[:, 0] + 0.5 * b[:, 1])
        way = (~(in_s <= in_t)).astype(int)
    parts = np.zeros(len(whole), CELL)
    parts["element"], parts["home"] = whole["element"], whole["home"]
    box = whole["box"].reshape(-1, 2, 2).copy()
    each = np.arange(len(box))
    ways = np.repeat(way, 2)
    box[each, ways, 1 - each % 2] = box[each, ways].mean(axis=1)
    _place_cells(parts, box, place.tables.elements.table)
    _measure(place, parts)
    inherited = old.homes[parts["home"]]
    if own_homes:
        inherited["near"], inherited["cap"] = 0.0, -1
    parts["home"] = len(old.homes) + each
    homes = np.concatenate([old.homes, _own_homes(place, parts, inherited)])
    child = np.concatenate([old.child, np.full(len(parts), -1, np.int32)])
    child[rows] = 2 * (n + 2 * np.arange(len(rows))) + way
    # Corner values of the halves, those halved across t with their two directions swapped.
    across = (way == 1)[:, None, None, None]
    known = old.value[rows].reshape(-1, 2, 2, 2)
    known = np.where(across, known.swapaxes(2, 3), known)
    middle = known.mean(axis=2)
    first = np.stack([known[:, :, 0], middle], axis=2)
    second_half = np.stack([middle, known[:, :, 1]], axis=2)
    halves = np.stack([first, second_half], axis=1).reshape(-1, 2, 2, 2)
    halves = np.where(across.repeat(2, axis=0), halves.swapaxes(2, 3), halves)
    value = np.concatenate([old.value, halves.reshape(-1, 2, 4)])
    want = np.concatenate([old.want, np.zeros(len(parts))])
    depth = np.concatenate([old.depth, np.repeat(old.depth[rows] + 1, 2)])
    return _Cells(np.concatenate([old.cells, parts]), homes, child, value, want, depth)


def _own_homes(place: _Place, parts: Records, homes: Records) -> Records:
    """Smooth blocks around cells: the given ones, or surroundings in their element if better."""
    box = parts["box"].reshape(-1, 2, 2)
    half = box[:, :, 1] - box[:, :, 0]
    lengths = np.maximum(np.linalg.norm(parts["first"], axis=2), 1e-300)
    even = np.minimum(lengths.max(axis=1, keepdims=True) / lengths, 8.0)
    around = np.stack([parts] * len(SURROUNDINGS))
    # Across a side of the element goes only what was inherited.
    beyond = np.abs(box).max(axis=2) + half * even > 0.5
    at_side = (homes["near"].min(axis=1) > 0.0) & beyond.any(axis=1)
    for row, share in zip(around, SURROUNDINGS, strict=True):
        far = share * half * even
        wider = np.stack([box[:, :, 0] - far, box[:, :, 1] + far], axis=2)
        _place_cells(row, np.clip(wider, -0.5, 0.5), place.tables.elements.table)
    rows = np.flatnonzero(~at_side)
    better = homes[rows]
    limit = _limit(place)
    own_around = np.ascontiguousarray(around[:, rows])
    ball_block_nb.homes_within(place.tables.elements, place.centre, own_around, limit, better)
    homes[rows] = better
    place.caps.take(parts, homes, limit)
    return homes


def _bound(place: _Place, all_cells: _Cells, rows: Places) -> None:
    """Radii of the cells `rows` that are not cut or trimmed away."""
    cells = all_cells.cells
    leaves = np.flatnonzero(_is_leaf(all_cells)).astype(np.int32)
    corner, bulge = cells["corner"][leaves], cells["bulge"][leaves, None]
    margin = bulge + ball_plane_nb.ROUNDING * place.size
    low, high = corner.min(axis=1) - margin, corner.max(axis=1) + margin
    tree, order = tree_over(low, high)
    rows = np.intersect1d(rows, leaves)
    body = CellTree(cells, tree, leaves[order])
    surface = CentredSurface(place.tables.elements, place.tables.trims, place.centre)
    limits = BallLimits(place.size, CAP * place.size, GOAL * place.size)
    result = CellBounds(rows, all_cells.value, all_cells.want)
    given = body, surface, all_cells.homes, limits, result
    run_ranges(ball_bound_nb.bound_cells, len(rows), CELLS, *given)
