"""Blocks of cells over which a patch is smooth: their own bound of touching balls.

Between two points of a block whose derivatives along the straight line in parameters stay within
an angle φ of one direction, the chord is at least cos φ times the curve's length L, and the normal
turns by at most κL: |(X − Q)·n| ≤ κL²/2. Hence no ball that touches within the block and is
smaller than cos²φ/κ contains another point of it. If all curvatures are towards one side, the ball
on the other side has no bound.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import BINOMIAL
from contiga.jit import inner, kernel
from contiga.jit.scratch import stack_int64
from contiga.search.balls.kernels.ball_cell_nb import (
    MAX_CHANGE,
    deviation,
    measure,
    normal_curvatures,
)

KINK_TOL = 1e-8
"""Relative jump of derivatives below which they are continuous: a surface that turns by an angle ε
reaches ε²ρ/2 into a ball of radius ρ, which is less than rounding."""
MAX_TURN = 0.9
MAX_OUTER_TURN = 0.6
"""Largest relative change of derivatives in a block, and in its cells that are not next to the
middle."""
BLOCK_REACH = 2.0
"""Distance to which blocks grow around their cell, in lengths of the cell."""
MAX_BLOCK_CELLS = 160
"""Largest number of cells of a block."""
BINOMIAL_TWICE = np.array([[float(math.comb(2 * n, k)) for k in range(32)] for n in range(16)])
"""Binomial coefficients of twice the degree."""


@inner()
def _end_rows(elements, e, side, shift, first, row):
    """Write the homogeneous coefficients along a side to `row`, their derivative across to `first`.

    The derivative is by the patch's parameter; `shift` is added to the points. Returns the degree
    along the side.
    """
    table = elements.table[e]
    p = table["degree"][0]
    q = table["degree"][1]
    along = q if side < 2 else p
    across = p if side < 2 else q
    width = table["box"][1] - table["box"][0] if side < 2 else table["box"][3] - table["box"][2]
    for k in range(along + 1):
        if side < 2:
            i = p if side == 1 else 0
            j = p - 1 if side == 1 else 1
            a = table["bernstein"] + 4 * (i * (q + 1) + k)
            b = table["bernstein"] + 4 * (j * (q + 1) + k)
        else:
            i = q if side == 3 else 0
            j = q - 1 if side == 3 else 1
            a = table["bernstein"] + 4 * (k * (q + 1) + i)
            b = table["bernstein"] + 4 * (k * (q + 1) + j)
        sign = 1.0 if side % 2 == 1 else -1.0
        for c in range(4):
            x = elements.coefs[a + c]
            y = elements.coefs[b + c]
            if c < 3:
                x += elements.coefs[a + 3] * shift[c]
                y += elements.coefs[b + 3] * shift[c]
            row[k, c] = x
            first[k, c] = sign * across * (x - y) / width
    return along


@inner()
def derivative_jump(elements, e, f, axis, tolerance):
    """Return a bound of the jump of the derivative where element f continues e along an axis.

    The bound is the largest Bernstein coefficient of ((A' of f) − (A' of e))·w − (w' of f − w' of
    e)·A over w². It is infinite if the two sides are farther apart than `tolerance`, or differ in
    degree or weights.
    """
    p, q = elements.table[e]["degree"]
    r, s = elements.table[f]["degree"]
    n = 1 + max(p, q, r, s)
    first = np.zeros((n, 4))
    row = np.zeros((n, 4))
    other_first = np.zeros((n, 4))
    other_row = np.zeros((n, 4))
    shift = np.zeros(3)
    degree = _end_rows(elements, e, 2 * axis + 1, shift, first, row)
    for c in range(3):
        shift[c] = elements.table[f]["origin"][c] - elements.table[e]["origin"][c]
    if _end_rows(elements, f, 2 * axis, shift, other_first, other_row) != degree:
        return math.inf
    min_weight = row[0, 3]
    for k in range(1, degree + 1):
        min_weight = min(min_weight, row[k, 3])
    for k in range(degree + 1):
        for c in range(3):
            if not abs(row[k, c] - other_row[k, c]) <= tolerance * min_weight:
                return math.inf
        if not abs(row[k, 3] - other_row[k, 3]) <= 1e-12 * min_weight:
            return math.inf
    largest = 0.0
    for k in range(2 * degree + 1):
        square = 0.0
        for c in range(3):
            total = 0.0
            for i in range(max(0, k - degree), min(k, degree) + 1):
                j = k - i
                share = BINOMIAL[degree, i] * BINOMIAL[degree, j] / BINOMIAL_TWICE[degree, k]
                total += share * (other_first[i, c] - first[i, c]) * row[j, 3]
                total -= share * (other_first[i, 3] - first[i, 3]) * row[j, c]
            square += total * total
        largest = max(largest, square)
    return math.sqrt(largest) / min_weight**2


@inner()
def _turn_from(middle, cell):
    """Return the largest relative change of derivatives in `cell` from the middle of `middle`."""
    u = middle["wide"][0] / cell["wide"][0]
    v = middle["wide"][1] / cell["wide"][1]
    da = 0.0
    db = 0.0
    for c in range(3):
        da += (cell["first"][0, c] * u - middle["first"][0, c]) ** 2
        db += (cell["first"][1, c] * v - middle["first"][1, c]) ** 2
    da = math.sqrt(da) + cell["change"][0] * u
    db = math.sqrt(db) + cell["change"][1] * v
    return deviation(middle, da, db)


@inner()
def block_radii(cells, rows, k, block):
    """Write the radii of inner and outer ball by the block `rows` of cells to block["radii"].

    Each is the better of two bounds: by the largest curvature to either side, and by the largest to
    its own side. Returns False, with nothing written, if derivatives change by `MAX_TURN` or more
    from the middle of cell k.
    """
    middle = cells[k]
    nx, ny, nz = middle["normal"]
    turn = 0.0
    curvature = 0.0
    for r in rows:
        curvature = max(curvature, max(-cells[r]["bend"][0], cells[r]["bend"][1]))
        turn = max(turn, _turn_from(middle, cells[r]))
    if not turn < MAX_TURN:
        return False
    radius = (1.0 - turn * turn) / curvature if curvature > 0.0 else math.inf
    block["radii"][0] = radius
    block["radii"][1] = radius
    inner = 0.0
    outer = 0.0
    for r in rows:
        cell = cells[r]
        x, y, z = cell["normal"]
        distance = math.sqrt((x - nx) ** 2 + (y - ny) ** 2 + (z - nz) ** 2)
        slack = distance + 2.0 * math.sin(0.5 * math.asin(middle["tilt"]))
        low, high = normal_curvatures(cell, slack)
        inner = max(inner, -low / (1.0 - cell["shear"]) ** 2)
        outer = max(outer, high / (1.0 - cell["shear"]) ** 2)
    shape = ((1.0 - turn) / (1.0 + turn)) ** 2
    block["radii"][0] = max(radius, shape / inner if inner > 0.0 else math.inf)
    block["radii"][1] = max(radius, shape / outer if outer > 0.0 else math.inf)
    return True


@inner()
def _can_grow(cells, smooth, base, ij, line):
    """Return whether a line of cells next to a block exists, is sound, and joins it smoothly.

    Its cells must also join each other smoothly. Sound means that derivatives are bounded and
    within `MAX_TURN` of the middle's (`MAX_OUTER_TURN` beyond the first line). `line` is the side
    of the block, the range of cells along it, and the offset of the new line.
    """
    side, low, high, offset = line
    k = base[0] + ij[0] * base[2] + ij[1]
    inward = -1 if side % 2 == 1 else 1
    for x in range(low, high + 1):
        if side < 2:
            new = _cell_at(smooth, base, ij[0] + offset, ij[1] + x)
            old = _cell_at(smooth, base, ij[0] + offset + inward, ij[1] + x)
        else:
            new = _cell_at(smooth, base, ij[0] + x, ij[1] + offset)
            old = _cell_at(smooth, base, ij[0] + x, ij[1] + offset + inward)
        if new < 0 or new == k or not cells[new]["turn"] < MAX_CHANGE:
            return False
        if not smooth[old if side % 2 == 1 else new, side // 2]:
            return False
        if x < high and not smooth[new, 1 - side // 2]:
            return False
        max_turn = MAX_TURN if abs(offset) == 1 else MAX_OUTER_TURN
        if not _turn_from(cells[k], cells[new]) < max_turn:
            return False
    return True


@inner()
def _cell_at(smooth, base, i, j):
    """Return the cell (i, j) of a patch; −1 outside.

    Indices continue over a smooth seam if the patch has at least four cells in that direction.
    """
    first, nu, nv = base
    if i < 0 or i >= nu:
        edge = first + (nu - 1) * nv + min(max(j, 0), nv - 1)
        if nu < 4 or not smooth[edge, 0]:
            return -1
        i = i % nu
    if j < 0 or j >= nv:
        edge = first + i * nv + nv - 1
        if nv < 4 or not smooth[edge, 1]:
            return -1
        j = j % nv
    return first + i * nv + j


@kernel()
def base_blocks(cells, smooth, bases, blocks):
    """Write the smooth block of every cell of the patches' grids whose derivatives are bounded.

    Sets `uv` and `radii` of its row of `blocks`. Blocks extend about equally to all sides; see
    `_grow_block`.
    """
    rows = stack_int64(MAX_BLOCK_CELLS)
    for patch in range(bases.shape[0]):
        base = (bases[patch, 0], bases[patch, 1], bases[patch, 2])
        for i in range(base[1]):
            for j in range(base[2]):
                k = base[0] + i * base[2] + j
                if cells[k]["turn"] < MAX_CHANGE:
                    _grow_block(cells, smooth, base, (i, j), rows, blocks[k])


@inner()
def _grow_block(cells, smooth, base, ij, rows, block):
    """Grow a block around one cell line by line; write its radii and extent to `block`.

    The side with the smallest margin grows next, until it meets a kink, an unbounded cell,
    `MAX_BLOCK_CELLS`, or all margins are `BLOCK_REACH` cells. If the block proves nothing, it is
    the cell alone; if that proves nothing, `block` stays as it is.
    """
    i, j = ij
    k = base[0] + i * base[2] + j
    reach = np.zeros(4, np.int64)  # offsets of the first and last line in i and j
    margin = np.zeros(4)
    uv = cells[k]["uv"].copy()
    r11, r12, r22 = cells[k]["metric"]
    across = r11 * r22 / math.hypot(r12, r22), r22  # of one cell
    goal = BLOCK_REACH * max(r11, math.hypot(r12, r22))
    while True:
        side = 0
        for c in range(1, 4):
            if margin[c] < margin[side]:
                side = c
        if margin[side] >= goal:
            break
        other = 2 - 2 * (side // 2)
        step = 1 if side % 2 == 1 else -1
        line = (side, reach[other], reach[other + 1], reach[side] + step)
        count = (reach[1] - reach[0] + 1) * (reach[3] - reach[2] + 1)
        length = reach[other + 1] - reach[other] + 1
        if count + length > MAX_BLOCK_CELLS or not _can_grow(cells, smooth, base, ij, line):
            margin[side] = math.inf
            continue
        reach[side] += step
        if side < 2:
            new = _cell_at(smooth, base, i + reach[side], j)
        else:
            new = _cell_at(smooth, base, i, j + reach[side])
        width = cells[new]["wide"][side // 2]
        uv[side] += step * width
        margin[side] += across[side // 2] * width / cells[k]["wide"][side // 2]
    n = 0
    for a in range(reach[0], reach[1] + 1):
        for b in range(reach[2], reach[3] + 1):
            rows[n] = _cell_at(smooth, base, i + a, j + b)
            n += 1
    if not block_radii(cells, rows[:n], k, block):
        rows[0] = k
        for c in range(4):
            uv[c] = cells[k]["uv"][c]
        if not block_radii(cells, rows[:1], k, block):
            return
    for c in range(4):
        block["uv"][c] = uv[c]


@kernel()
def single_cell_blocks(elements, centre, around, target, blocks):
    """Write smooth blocks of one cell, from surroundings `around` (m, n), the widest first.

    The first block is taken that allows balls as large as `target`: the points outside a smaller
    block are nearer. Otherwise the block is taken that allows the largest balls, which may be the
    one that is already in `blocks`. Measures `around` in place.
    """
    row = np.zeros(1, np.int64)
    trial = blocks[:1].copy()
    for k in range(around.shape[1]):
        for i in range(around.shape[0]):
            radius = min(blocks[k]["radii"][0], blocks[k]["radii"][1])
            if radius >= target:
                break
            measure(elements, around[i, k]["element"], centre, around[i, k])
            row[0] = k
            if not around[i, k]["turn"] < MAX_CHANGE:
                continue
            if not block_radii(around[i], row, k, trial[0]):
                continue
            if min(trial[0]["radii"][0], trial[0]["radii"][1]) > radius:
                for c in range(2):
                    blocks[k]["radii"][c] = trial[0]["radii"][c]
                for c in range(4):
                    blocks[k]["uv"][c] = around[i, k]["uv"][c]
                blocks[k]["cap"] = -1


@kernel()
def smooth_joints(elements, grid, bases, cells, tolerance, smooth):
    """Write to smooth[cell, axis] whether a cell of the patches' grids joins the next one smoothly.

    All have to be True before; only cells at sides of elements change. Smooth means that
    derivatives jump by `KINK_TOL` of their size at most, in bounded cells. Returns (patches, 2): 1
    if at least one cell at the end of a patch joins its start smoothly in that direction, else 0.
    """
    closes = np.zeros((bases.shape[0], 2))
    for patch in range(bases.shape[0]):
        first, nu, nv = bases[patch]
        for i in range(nu):
            for j in range(nv):
                for axis in range(2):
                    k = first + i * nv + j
                    is_last = i == nu - 1 if axis == 0 else j == nv - 1
                    if axis == 0:
                        other = first + (i + 1) % nu * nv + j
                    else:
                        other = first + i * nv + (j + 1) % nv
                    e = cells[k]["element"]
                    f = cells[other]["element"]
                    if is_last and elements.table[e]["neighbour"][2 * axis + 1] != f:
                        smooth[k, axis] = False
                        continue
                    if cells[k]["box"][2 * axis + 1] < 0.5:
                        continue
                    smooth[k, axis] = False
                    if cells[k]["turn"] < MAX_CHANGE:
                        jump = derivative_jump(elements, e, f, axis, tolerance)
                        jump *= cells[k]["wide"][axis]
                        r11, r12, r22 = cells[k]["metric"]
                        across = r11 * r22 / math.hypot(r12, r22) if axis == 0 else r22
                        smooth[k, axis] = jump <= KINK_TOL * across
                    if is_last and smooth[k, axis]:
                        closes[patch, axis] = 1.0
    return closes
