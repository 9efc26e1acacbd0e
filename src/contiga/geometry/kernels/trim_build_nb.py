"""Kernels that build the trim tables: splitting into monotone pieces and filling the cell grid."""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.codes import CUT
from contiga.arrays.kernels.sort_nb import sort
from contiga.geometry.kernels.trim_nb import MARGIN, u_range_in_row
from contiga.jit import inner, kernel

ROOT_WIDTH = 1e-14
ROUNDING = 1e-15
"""A derivative below this share of its terms' size is rounding, not a turning point."""

MAX_BREAKS = 16
"""Breaks per coefficient of a segment: `roots_inside` finds at most four per coefficient of a
turning polynomial, of which there are two, with twice as many coefficients."""


@inner()
def _binomial(n, k):
    """Return the binomial coefficient n over k."""
    value = 1.0
    for i in range(k):
        value = value * (n - i) / (i + 1)
    return value


@inner()
def turning_polynomial(coefs, degree, axis):
    """Return Bernstein coefficients of x'w − xw', whose roots are the turning points of x/w.

    Coefficients that are pure rounding are set to zero. Degree is 2p − 1.
    """
    p = degree
    out = np.zeros(2 * p)
    size = 0.0
    for i in range(p):
        dx = p * (coefs[i + 1, axis] - coefs[i, axis])
        dw = p * (coefs[i + 1, 2] - coefs[i, 2])
        for j in range(p + 1):
            scale = _binomial(p - 1, i) * _binomial(p, j) / _binomial(2 * p - 1, i + j)
            out[i + j] += scale * (dx * coefs[j, 2] - coefs[j, axis] * dw)
            size = max(size, p * abs(coefs[i, axis] * coefs[j, 2]))
    size = max(size, p * abs(coefs[p, axis] * coefs[p, 2]))
    for k in range(2 * p):
        if abs(out[k]) <= 64.0 * ROUNDING * size:
            out[k] = 0.0
    return out


@inner()
def _sign_changes(c):
    """Return the number of sign changes in a sequence, zeros skipped."""
    changes = 0
    last = 0.0
    for x in c:
        if x != 0.0:
            if last * x < 0.0:
                changes += 1
            last = 1.0 if x > 0.0 else -1.0
    return changes


@inner()
def _append_root(roots, count, root):
    """Append `root` unless the list has it to 4 `ROOT_WIDTH`, or is full; return the new count."""
    for i in range(count):
        if abs(roots[i] - root) < 4.0 * ROOT_WIDTH:
            return count
    if count < roots.shape[0]:
        roots[count] = root
        count += 1
    return count


@kernel()
def roots_inside(c):
    """Return ascending roots in (0, 1) of a Bernstein polynomial with coefficients c (n,).

    The interval is halved by de Casteljau until each part has no sign change among its coefficients
    (then no root: variation diminishing) or is `ROOT_WIDTH` wide. A middle that is a root itself is
    appended on the way, since neither half shows it. Multiple roots are found once;
    by rounding, one without a change of sign may be missed.
    """
    n = c.shape[0]
    roots = np.empty(4 * n)
    count = 0
    stack = np.empty((64 + 2 * n, n))
    lows = np.empty(64 + 2 * n)
    widths = np.empty(64 + 2 * n)
    for i in range(n):  # as in `rows_nb`
        stack[0, i] = c[i]
    lows[0], widths[0] = 0.0, 1.0
    top = 1
    while top > 0:
        top -= 1
        part = stack[top].copy()
        low, width = lows[top], widths[top]
        if _sign_changes(part) == 0:
            continue
        if width < ROOT_WIDTH or top + 2 >= stack.shape[0]:
            count = _append_root(roots, count, low + 0.5 * width)
            continue
        left = np.empty(n)
        for r in range(n):
            left[r] = part[0]
            for i in range(n - 1 - r):
                part[i] = 0.5 * (part[i] + part[i + 1])
        for i in range(n):
            stack[top, i] = part[i]
            stack[top + 1, i] = left[i]
        if part[0] == 0.0:
            count = _append_root(roots, count, low + 0.5 * width)
        lows[top], widths[top] = low + 0.5 * width, 0.5 * width
        lows[top + 1], widths[top + 1] = low, 0.5 * width
        top += 2
    roots = roots[:count]
    sort(roots)
    return roots


@inner()
def monotone_breaks(coefs, degree):
    """Return ascending parameters, 0 to 1, between which a segment is monotone in u and in v.

    Parameters within 1e-12 are one.
    """
    if degree == 1:
        return np.array([0.0, 1.0])
    ru = roots_inside(turning_polynomial(coefs, degree, 0))
    rv = roots_inside(turning_polynomial(coefs, degree, 1))
    breaks = np.empty(2 + ru.size + rv.size)
    breaks[0] = 0.0
    for k in range(ru.size):
        breaks[1 + k] = ru[k]
    for k in range(rv.size):
        breaks[1 + ru.size + k] = rv[k]
    breaks[-1] = 1.0
    sort(breaks)
    n = 1
    for i in range(1, breaks.size):
        if breaks[i] - breaks[n - 1] > 1e-12:
            breaks[n] = breaks[i]
            n += 1
        elif i == breaks.size - 1:
            breaks[n - 1] = 1.0
    return breaks[:n]


@inner()
def split_first(coefs, degree, t):
    """Return both parts of a segment cut at t (de Casteljau), with the same bits at their joint."""
    right = coefs.copy()
    left = coefs.copy()
    s = 1.0 - t
    for r in range(degree + 1):
        for k in range(3):
            left[r, k] = right[0, k]
        for i in range(degree - r):
            for k in range(3):
                right[i, k] = s * right[i, k] + t * right[i + 1, k]
    return left, right


@kernel()
def monotone_pieces(segments, degrees):
    """Return the monotone pieces of segments (s, p + 1, 3), in order.

    They are coefficients (n, p + 1, 3), the segment (n,) of each piece and its parameter interval
    (n, 2) there.
    """
    breaks = np.empty((segments.shape[0], MAX_BREAKS * segments.shape[1]))
    count = np.empty(segments.shape[0], np.int64)
    total = 0
    for s in range(segments.shape[0]):
        segment_breaks = monotone_breaks(segments[s], degrees[s])
        count[s] = segment_breaks.size - 1
        total += count[s]
        for k in range(segment_breaks.size):
            breaks[s, k] = segment_breaks[k]
    coefs = np.empty((total, segments.shape[1], 3))
    source = np.empty(total, np.int32)
    interval = np.empty((total, 2))
    n = 0
    for s in range(segments.shape[0]):
        remainder = segments[s].copy()
        for k in range(count[s]):
            piece = remainder
            if k < count[s] - 1:
                t = (breaks[s, k + 1] - breaks[s, k]) / (1.0 - breaks[s, k])
                piece, remainder = split_first(remainder, degrees[s], t)
            for i in range(segments.shape[1]):
                for c in range(3):
                    coefs[n, i, c] = piece[i, c]
            source[n] = s
            interval[n, 0], interval[n, 1] = breaks[s, k], breaks[s, k + 1]
            n += 1
    return coefs, source, interval


@inner()
def _columns(tables, patch, low, high):
    """Return the first and last column of cells that an interval of u touches, with `MARGIN`."""
    u0, u1 = tables.domain[patch, 0], tables.domain[patch, 1]
    nu = tables.grid_shape[patch, 0]
    du = (u1 - u0) / nu
    margin = MARGIN * max(u1 - u0, abs(u0), abs(u1))
    first = min(max(math.floor((low - margin - u0) / du), 0), nu - 1)
    last = min(max(math.floor((high + margin - u0) / du), 0), nu - 1)
    return first, last


@inner()
def _row_pieces(tables, patch, v_low, v_high):
    """Return the pieces that touch a row of cells, and the first and last column of each there."""
    start, stop = tables.patch_start[patch], tables.patch_start[patch + 1]
    v0, v1 = tables.domain[patch, 2], tables.domain[patch, 3]
    margin = MARGIN * max(v1 - v0, abs(v0), abs(v1))
    pieces = np.empty(stop - start, np.int32)
    first = np.empty(stop - start, np.int64)
    last = np.empty(stop - start, np.int64)
    n = 0
    for p in range(start, stop):
        ends = tables.piece_ends[p]
        if max(ends[1], ends[3]) < v_low - margin or min(ends[1], ends[3]) > v_high + margin:
            continue
        low, high = u_range_in_row(tables, p, v_low - margin, v_high + margin)
        pieces[n] = p
        first[n], last[n] = _columns(tables, patch, low, high)
        n += 1
    return pieces[:n], first[:n], last[:n]


@inner()
def _cell_toggles(tables, pieces, first, column, rows):
    """Return ascending v in a row at which `_parity_right` of `column` changes."""
    heights = np.empty(2 * pieces.size)
    n = 0
    for k in range(pieces.size):
        if first[k] <= column:
            continue
        ends = tables.piece_ends[pieces[k]]
        if ends[1] == ends[3]:
            continue
        for v in (ends[1], ends[3]):
            if rows[0] < v <= rows[1]:
                heights[n] = v
                n += 1
    ordered = heights[:n]
    sort(ordered)
    # A value that occurs an even number of times changes nothing.
    n_odd = 0
    for k in range(n):
        if n_odd > 0 and ordered[n_odd - 1] == ordered[k]:
            n_odd -= 1
        else:
            ordered[n_odd] = ordered[k]
            n_odd += 1
    return ordered[:n_odd]


@inner()
def _parity_right(tables, pieces, first, column, v):
    """Return the parity, 0 or 1, of the number of pieces right of a column that the line v meets.

    Pieces that touch the column do not count, others by the half-open rule in v.
    """
    parity = 0
    for k in range(pieces.size):
        if first[k] > column:
            ends = tables.piece_ends[pieces[k]]
            if min(ends[1], ends[3]) <= v < max(ends[1], ends[3]):
                parity ^= 1
    return parity


@kernel()
def fill_cells(tables):
    """Compute cell states, parities, piece lists and toggles of all grids of `tables`.

    Returns ``cell_start, cell_pieces, toggle_start, toggles``; states and parities are written to
    the arrays of `tables`.
    """
    cells = tables.cell_state.shape[0]
    cell_start = np.zeros(cells + 1, np.int64)
    toggle_start = np.zeros(cells + 1, np.int64)
    listed = np.empty(64, np.int32)
    flips = np.empty(64)
    n_listed = 0
    n_flips = 0
    for patch in range(tables.trimmed.shape[0]):
        nu, nv = tables.grid_shape[patch, 0], tables.grid_shape[patch, 1]
        v0, v1 = tables.domain[patch, 2], tables.domain[patch, 3]
        for j in range(nv):
            v_low = v0 + j * ((v1 - v0) / nv)
            # The last line is the domain's end, which rounding might fall short of.
            v_high = v0 + (j + 1) * ((v1 - v0) / nv) if j < nv - 1 else v1
            pieces, first, last = _row_pieces(tables, patch, v_low, v_high)
            for i in range(nu):
                cell = tables.grid_start[patch] + j * nu + i
                before = n_listed
                for k in range(pieces.size):
                    if first[k] <= i <= last[k]:
                        if n_listed == listed.size:
                            longer = np.empty(2 * n_listed, np.int32)
                            for m in range(n_listed):
                                longer[m] = listed[m]
                            listed = longer
                        listed[n_listed] = pieces[k]
                        n_listed += 1
                if n_listed == before:
                    mid = 0.5 * (v_low + v_high)
                    tables.cell_state[cell] = _parity_right(tables, pieces, first, i, mid)
                else:
                    tables.cell_state[cell] = CUT
                    tables.cell_parity[cell] = _parity_right(tables, pieces, first, i, v_low)
                    for v in _cell_toggles(tables, pieces, first, i, (v_low, v_high)):
                        if n_flips == flips.size:
                            more_flips = np.empty(2 * n_flips)
                            for m in range(n_flips):
                                more_flips[m] = flips[m]
                            flips = more_flips
                        flips[n_flips] = v
                        n_flips += 1
                cell_start[cell + 1] = n_listed
                toggle_start[cell + 1] = n_flips
    return cell_start, listed[:n_listed].copy(), toggle_start, flips[:n_flips].copy()
