"""Blocks of cells over which a patch is smooth: how near its own points come to touching balls.

Between two points of a block whose derivatives along the straight way in parameters stay within
an angle φ of one direction, the chord is at least cos φ times the way's length L, and the normal
turns by at most κL: |(X − Q)·n| ≤ κL²/2. Hence no ball that touches within the block and is
smaller than cos²φ/κ holds another point of it. Where no bend goes to one side, nothing does.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.elements.kernels.element_nb import BINOMIAL
from contiga.jit import inner, kernel
from contiga.jit.scratch import stack_int64
from contiga.search.balls.kernels.ball_cell_nb import WORST, bends, deviation, measure

KINK = 1e-8
"""Derivatives that jump by less than this share of themselves are continuous: a surface that
turns by an angle ε reaches ε²ρ/2 into a ball of radius ρ, which is less than rounding."""
TURN = 0.9
"""Blocks in which the derivatives change by more than this share prove nothing of use,"""
GROWN = 0.6
"""and beyond the cells next to it no block is grown farther than this."""
WIDE = 2.0
"""How far blocks are grown beyond their cell, in lengths of the cell."""
MAX_BLOCK_CELLS = 160
"""Cells in a block at most."""
BINOMIAL_TWICE = np.array([[float(math.comb(2 * n, k)) for k in range(32)] for n in range(16)])


@inner()
def _end_rows(elements, e, side, shift, first, row):
    """Homogeneous coefficients along a side, and their derivative across it, about `shift`."""
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
def jump(elements, e, f, way, tolerance):
    """Bound of the jump of the derivative across the joint where f continues e in direction `way`.

    From the Bernstein coefficients of ((A' of f) − (A' of e))·w − (w' of f − w' of e)·A over w².
    Infinite where the two sides are farther apart than `tolerance`.
    """
    p, q = elements.table[e]["degree"]
    r, s = elements.table[f]["degree"]
    n = 1 + max(p, q, r, s)
    first = np.zeros((n, 4))
    row = np.zeros((n, 4))
    other_first = np.zeros((n, 4))
    other_row = np.zeros((n, 4))
    shift = np.zeros(3)
    degree = _end_rows(elements, e, 2 * way + 1, shift, first, row)
    for c in range(3):
        shift[c] = elements.table[f]["origin"][c] - elements.table[e]["origin"][c]
    if _end_rows(elements, f, 2 * way, shift, other_first, other_row) != degree:
        return math.inf
    least = row[0, 3]
    for k in range(1, degree + 1):
        least = min(least, row[k, 3])
    for k in range(degree + 1):
        for c in range(3):
            if not abs(row[k, c] - other_row[k, c]) <= tolerance * least:
                return math.inf
        if not abs(row[k, 3] - other_row[k, 3]) <= 1e-12 * least:
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
    return math.sqrt(largest) / least**2


@inner()
def _turn_seen(middle, cell):
    """Largest share by which derivatives in `cell` differ from those of the middle of `middle`."""
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
def near(cells, rows, k, home):
    """Radii of inner and outer ball that the block `rows` of cells bounds, into home["near"]."""
    middle = cells[k]
    nx, ny, nz = middle["normal"]
    turn = 0.0
    bent = 0.0
    for r in rows:
        bent = max(bent, max(-cells[r]["bend"][0], cells[r]["bend"][1]))
        turn = max(turn, _turn_seen(middle, cells[r]))
    if not turn < TURN:
        return False
    both = (1.0 - turn * turn) / bent if bent > 0.0 else math.inf
    home["near"][0] = both
    home["near"][1] = both
    inner = 0.0
    outer = 0.0
    for r in rows:
        cell = cells[r]
        x, y, z = cell["normal"]
        apart = math.sqrt((x - nx) ** 2 + (y - ny) ** 2 + (z - nz) ** 2)
        slack = apart + 2.0 * math.sin(0.5 * math.asin(middle["tilt"]))
        low, high = bends(cell, slack)
        inner = max(inner, -low / (1.0 - cell["shear"]) ** 2)
        outer = max(outer, high / (1.0 - cell["shear"]) ** 2)
    shape = ((1.0 - turn) / (1.0 + turn)) ** 2
    home["near"][0] = max(both, shape / inner if inner > 0.0 else math.inf)
    home["near"][1] = max(both, shape / outer if outer > 0.0 else math.inf)
    return True


@inner()
def _fits(cells, smooth, base, ij, line):
    """Return whether a line of cells beside a block is there, is sound, and joins it smoothly.

    `line` is the side of the block, the cells along it and the offset of the new line.
    """
    side, low, high, offset = line
    k = base[0] + ij[0] * base[2] + ij[1]
    inward = -1 if side % 2 == 1 else 1
    for x in range(low, high + 1):
        if side < 2:
            new = _at(smooth, base, ij[0] + offset, ij[1] + x)
            old = _at(smooth, base, ij[0] + offset + inward, ij[1] + x)
        else:
            new = _at(smooth, base, ij[0] + x, ij[1] + offset)
            old = _at(smooth, base, ij[0] + x, ij[1] + offset + inward)
        if new < 0 or new == k or not cells[new]["turn"] < WORST:
            return False
        if not smooth[old if side % 2 == 1 else new, side // 2]:
            return False
        if x < high and not smooth[new, 1 - side // 2]:
            return False
        if not _turn_seen(cells[k], cells[new]) < (TURN if abs(offset) == 1 else GROWN):
            return False
    return True


@inner()
def _at(smooth, base, i, j):
    """Number of the cell (i, j) of a patch, counted on round a seam; −1 outside."""
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
def base_homes(cells, smooth, bases, homes):
    """Around every sound cell of the patches' grids, a block about as wide all round."""
    rows = stack_int64(MAX_BLOCK_CELLS)
    for patch in range(bases.shape[0]):
        base = (bases[patch, 0], bases[patch, 1], bases[patch, 2])
        for i in range(base[1]):
            for j in range(base[2]):
                k = base[0] + i * base[2] + j
                if cells[k]["turn"] < WORST:
                    _home(cells, smooth, base, (i, j), rows, homes[k])


@inner()
def _home(cells, smooth, base, ij, rows, home):
    i, j = ij
    k = base[0] + i * base[2] + j
    reach = np.zeros(4, np.int64)  # offsets of the first and the last line each way
    margin = np.zeros(4)
    uv = cells[k]["uv"].copy()
    r11, r12, r22 = cells[k]["metric"]
    across = r11 * r22 / math.hypot(r12, r22), r22  # of one cell
    goal = WIDE * max(r11, math.hypot(r12, r22))
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
        if count + length > MAX_BLOCK_CELLS or not _fits(cells, smooth, base, ij, line):
            margin[side] = math.inf
            continue
        reach[side] += step
        if side < 2:
            new = _at(smooth, base, i + reach[side], j)
        else:
            new = _at(smooth, base, i, j + reach[side])
        wide = cells[new]["wide"][side // 2]
        uv[side] += step * wide
        margin[side] += across[side // 2] * wide / cells[k]["wide"][side // 2]
    n = 0
    for a in range(reach[0], reach[1] + 1):
        for b in range(reach[2], reach[3] + 1):
            rows[n] = _at(smooth, base, i + a, j + b)
            n += 1
    if not near(cells, rows[:n], k, home):
        rows[0] = k
        for c in range(4):
            uv[c] = cells[k]["uv"][c]
        if not near(cells, rows[:1], k, home):
            return
    for c in range(4):
        home["uv"][c] = uv[c]


@kernel()
def homes_within(elements, centre, around, enough, homes):
    """Smooth blocks that are one cell, out of surroundings `around` (m, n), the widest first.

    A block is kept where it allows balls as large as `enough`: what a smaller one leaves out lies
    nearer. Else that is taken which allows the largest.
    """
    row = np.zeros(1, np.int64)
    trial = homes[:1].copy()
    for k in range(around.shape[1]):
        for i in range(around.shape[0]):
            least = min(homes[k]["near"][0], homes[k]["near"][1])
            if least >= enough:
                break
            measure(elements, around[i, k]["element"], centre, around[i, k])
            row[0] = k
            if not around[i, k]["turn"] < WORST or not near(around[i], row, k, trial[0]):
                continue
            if min(trial[0]["near"][0], trial[0]["near"][1]) > least:
                for c in range(2):
                    homes[k]["near"][c] = trial[0]["near"][c]
                for c in range(4):
                    homes[k]["uv"][c] = around[i, k]["uv"][c]
                homes[k]["cap"] = -1


@kernel()
def joints(elements, grid, bases, cells, tolerance, smooth):
    """Mark which cells of the patches' grids join the next one in u and in v smoothly.

    Returns (patches, 2): 1 where a patch closes in that direction.
    """
    closes = np.zeros((bases.shape[0], 2))
    for patch in range(bases.shape[0]):
        first, nu, nv = bases[patch]
        for i in range(nu):
            for j in range(nv):
                for way in range(2):
                    k = first + i * nv + j
                    last = i == nu - 1 if way == 0 else j == nv - 1
                    if way == 0:
                        other = first + (i + 1) % nu * nv + j
                    else:
                        other = first + i * nv + (j + 1) % nv
                    e = cells[k]["element"]
                    f = cells[other]["element"]
                    if last and elements.table[e]["neighbour"][2 * way + 1] != f:
                        smooth[k, way] = False
                        continue
                    if cells[k]["box"][2 * way + 1] < 0.5:
                        continue
                    smooth[k, way] = False
                    if cells[k]["turn"] < WORST:
                        leap = jump(elements, e, f, way, tolerance) * cells[k]["wide"][way]
                        r11, r12, r22 = cells[k]["metric"]
                        across = r11 * r22 / math.hypot(r12, r22) if way == 0 else r22
                        smooth[k, way] = leap <= KINK * across
                    if last and smooth[k, way]:
                        closes[patch, way] = 1.0
    return closes
