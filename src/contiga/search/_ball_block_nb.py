"""Blocks of cells over which a patch is smooth: how near its own points come to touching balls.

Between two points of a block whose derivatives along the straight way in parameters stay within
an angle φ of one direction, the chord is at least cos φ times the way's length L, and the normal
turns by at most κL: |(X − Q)·n| ≤ κL²/2. Hence no ball that touches within the block and is
smaller than cos²φ/κ holds another point of it. Where no bend goes to one side, nothing does.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from contiga.search._ball_cell_nb import WORST, bends, deviation, measure
from contiga.search._element_nb import BINOMIAL

KINK = 1e-9
"""Derivatives that jump by less than this share of themselves are continuous: a surface that
turns by an angle ε reaches ε²ρ/2 into a ball of radius ρ, which is less than rounding."""
TURN = 0.8
"""Blocks in which the derivatives change by more than this share prove nothing of use."""
BINOMIAL_TWICE = np.array([[float(math.comb(2 * n, k)) for k in range(32)] for n in range(16)])


@njit(cache=True)
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


@njit(cache=True)
def jump(elements, e, f, way, tolerance):
    """Bound of the jump of the derivative across the joint where f continues e in direction `way`.

    From the Bernstein coefficients of ((A' of f) − (A' of e))·w − (w' of f − w' of e)·A over w².
    Infinite where the two sides are farther apart than `tolerance`.
    """
    n = 1 + max(elements.table[e]["degree"].max(), elements.table[f]["degree"].max())
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
    least = row[: degree + 1, 3].min()
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


@njit(cache=True)
def near(cells, rows, k, home):
    """Radii of inner and outer ball that the block `rows` of cells bounds, into home["near"]."""
    own = cells[k]
    nx, ny, nz = own["normal"]
    turn = 0.0
    bent = 0.0
    for r in rows:
        cell = cells[r]
        bent = max(bent, max(-cell["bend"][0], cell["bend"][1]))
        u = own["wide"][0] / cell["wide"][0]
        v = own["wide"][1] / cell["wide"][1]
        da = 0.5 * (cell["second"][0] + cell["second"][1]) * u
        db = 0.5 * (cell["second"][1] + cell["second"][2]) * v
        da += math.sqrt(
            (cell["first"][0, 0] * u - own["first"][0, 0]) ** 2
            + (cell["first"][0, 1] * u - own["first"][0, 1]) ** 2
            + (cell["first"][0, 2] * u - own["first"][0, 2]) ** 2
        )
        db += math.sqrt(
            (cell["first"][1, 0] * v - own["first"][1, 0]) ** 2
            + (cell["first"][1, 1] * v - own["first"][1, 1]) ** 2
            + (cell["first"][1, 2] * v - own["first"][1, 2]) ** 2
        )
        turn = max(turn, deviation(own, da, db))
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
        slack = apart + 2.0 * math.sin(0.5 * math.asin(own["tilt"]))
        low, high = bends(cell, slack)
        inner = max(inner, -low / (1.0 - cell["turn"]) ** 2)
        outer = max(outer, high / (1.0 - cell["turn"]) ** 2)
    shape = ((1.0 - turn) / (1.0 + turn)) ** 2
    home["near"][0] = max(both, shape / inner if inner > 0.0 else math.inf)
    home["near"][1] = max(both, shape / outer if outer > 0.0 else math.inf)
    return True


@njit(cache=True)
def _fits(cells, smooth, base, ij, offsets):
    """Whether the cells from ij + offsets low to high exist, are sound, and join smoothly."""
    first, nu, nv = base
    i, j = ij
    i0, i1, j0, j1 = offsets
    for a in range(i0, i1 + 1):
        for b in range(j0, j1 + 1):
            x = i + a
            y = j + b
            k = _at(smooth, base, x, y)
            if k < 0 or not cells[k]["turn"] < WORST:
                return False
            if a < i1 and not smooth[k, 0]:
                return False
            if b < j1 and not smooth[k, 1]:
                return False
    return True


@njit(cache=True)
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


@njit(cache=True)
def base_homes(cells, smooth, bases, homes):
    """Around every sound cell of the patches' grids, the largest block of up to 3 × 3 that holds."""
    rows = np.empty(9, np.int64)
    for patch in range(bases.shape[0]):
        base = (bases[patch, 0], bases[patch, 1], bases[patch, 2])
        for i in range(base[1]):
            for j in range(base[2]):
                k = base[0] + i * base[2] + j
                if cells[k]["turn"] < WORST:
                    _home(cells, smooth, base, (i, j), rows, homes[k])


@njit(cache=True)
def _home(cells, smooth, base, ij, rows, home):
    i, j = ij
    k = base[0] + i * base[2] + j
    reach = np.zeros(4, np.int64)
    for side in range(4):
        reach[side] = -1 if side % 2 == 0 else 1
        if not _fits(cells, smooth, base, ij, (reach[0], reach[1], reach[2], reach[3])):
            reach[side] = 0
    if not _fill(cells, smooth, base, ij, reach, rows, home):
        reach[:] = 0
        if not _fill(cells, smooth, base, ij, reach, rows, home):
            return
    u0, u1, v0, v1 = cells[k]["uv"]
    for a in range(reach[0], 0):
        u0 -= cells[_at(smooth, base, i + a, j)]["wide"][0]
    for a in range(1, reach[1] + 1):
        u1 += cells[_at(smooth, base, i + a, j)]["wide"][0]
    for b in range(reach[2], 0):
        v0 -= cells[_at(smooth, base, i, j + b)]["wide"][1]
    for b in range(1, reach[3] + 1):
        v1 += cells[_at(smooth, base, i, j + b)]["wide"][1]
    home["uv"][0] = u0
    home["uv"][1] = u1
    home["uv"][2] = v0
    home["uv"][3] = v1


@njit(cache=True)
def _fill(cells, smooth, base, ij, reach, rows, home):
    n = 0
    for a in range(reach[0], reach[1] + 1):
        for b in range(reach[2], reach[3] + 1):
            rows[n] = _at(smooth, base, ij[0] + a, ij[1] + b)
            n += 1
    return near(cells, rows[:n], base[0] + ij[0] * base[2] + ij[1], home)


@njit(cache=True)
def homes_within(elements, centre, pairs, homes):
    """The same for cells that had to be cut: `pairs` are the cells and their surroundings."""
    own, around = pairs
    row = np.zeros(1, np.int64)
    for k in range(own.shape[0]):
        measure(elements, around[k]["element"], centre, around[k])
        row[0] = k
        if around[k]["turn"] < WORST and near(around, row, k, homes[k]):
            homes[k]["uv"][:] = around[k]["uv"]
        elif own[k]["turn"] < WORST and near(own, row, k, homes[k]):
            homes[k]["uv"][:] = own[k]["uv"]


@njit(cache=True)
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
                    leap = jump(elements, e, f, way, tolerance) * cells[k]["wide"][way]
                    smooth[k, way] = leap <= KINK * _across(cells[k], way)
                    if last and smooth[k, way]:
                        closes[patch, way] = 1.0
    return closes


@njit(cache=True)
def _across(cell, way):
    """Length of a cell across its lines in direction 1 − way."""
    r11, r12, r22 = cell["metric"]
    return r11 * r22 / math.hypot(r12, r22) if way == 0 else r22
