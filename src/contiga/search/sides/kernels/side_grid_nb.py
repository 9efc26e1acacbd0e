"""Find which cells of a grid contain surface, and which of the others are connected.

The grid has two levels: cells, and in those that may contain surface 4 × 4 × 4 small ones, kept as
the bits of a word (bit 16 i + 4 j + k), so that a flood fill in them is a few shifts.
"""

from __future__ import annotations

import math

import numpy as np

from contiga.arrays.kernels.union_nb import root, unite
from contiga.jit import inner, kernel
from contiga.search.sides.kernels.side_pieces_nb import HIGH, LOW, NORMAL, SLAB_HIGH, SLAB_LOW

SPLIT = 4
"""Number of small cells along a cell."""
ONE = np.uint64(1)
NO_BITS = np.uint64(0)
I_LAST = np.uint64(0xFFFF000000000000)
J_LAST = np.uint64(0xF000F000F000F000)
K_LAST = np.uint64(0x8888888888888888)
I_FIRST = np.uint64(0x000000000000FFFF)
J_FIRST = np.uint64(0x000F000F000F000F)
K_FIRST = np.uint64(0x1111111111111111)
PLACE_TOL = 1e-9
"""Rounding of a place in the grid, in small cells, with a wide margin."""


@inner()
def _cell_range(piece, c, small, count):
    """Return the first and last small cell that the piece's box meets along axis c."""
    first = max(math.floor(piece[LOW + c] / small - PLACE_TOL), 0)
    last = min(math.floor(piece[HIGH + c] / small + PLACE_TOL), count - 1)
    return first, last


@kernel()
def paint(pieces, small, shape, words, surface_bits, piece_of_word):
    """Mark in `words` (flat) the cells that pieces meet, or their small cells in `surface_bits`.

    If `surface_bits` has rows, `words` holds the row of each cell: then set the bits of the small
    cells in `surface_bits`, and the last piece of each cell in `piece_of_word`.
    """
    for p in range(pieces.shape[0]):
        # Columns of small cells run along the axis nearest to the piece's normal; the slab bounds
        # the cells of each column that the piece meets.
        piece = pieces[p]
        axis = 0
        for c in range(1, 3):
            if abs(piece[NORMAL + c]) > abs(piece[NORMAL + axis]):
                axis = c
        a = (axis + 1) % 3
        b = (axis + 2) % 3
        strides = (shape[1] * shape[2], shape[2], 1)
        bits = (16, 4, 1)
        n_a, n_b, n_c = piece[NORMAL + a], piece[NORMAL + b], piece[NORMAL + axis]
        radius = 0.5 * small * (abs(n_a) + abs(n_b) + abs(n_c))
        a0, a1 = _cell_range(piece, a, small, SPLIT * shape[a])
        b0, b1 = _cell_range(piece, b, small, SPLIT * shape[b])
        c0, c1 = _cell_range(piece, axis, small, SPLIT * shape[axis])
        for i in range(a0, a1 + 1):
            for j in range(b0, b1 + 1):
                first, last = c0, c1
                if n_c != 0.0:
                    offset = n_a * (i + 0.5) * small + n_b * (j + 0.5) * small
                    bound_0 = (piece[SLAB_LOW] - radius - offset) / (n_c * small) - 0.5
                    bound_1 = (piece[SLAB_HIGH] + radius - offset) / (n_c * small) - 0.5
                    first = max(first, math.ceil(min(bound_0, bound_1) - PLACE_TOL))
                    last = min(last, math.floor(max(bound_0, bound_1) + PLACE_TOL))
                base = (i >> 2) * strides[a] + (j >> 2) * strides[b]
                if surface_bits.shape[0] == 0:
                    for k in range(first >> 2, (last >> 2) + 1 if last >= first else 0):
                        words[base + k * strides[axis]] = 1
                    continue
                bit = (i & 3) * bits[a] + (j & 3) * bits[b]
                for k in range(first, last + 1):
                    word = words[base + (k >> 2) * strides[axis]]
                    surface_bits[word] |= ONE << np.uint64(bit + (k & 3) * bits[axis])
                    piece_of_word[word] = p


@kernel()
def label_regions(clear):
    """Return the number of each cell's connected region of clear cells, 0 for other cells.

    Regions are numbered from 1, in the order of their first cells. Cells are connected by faces.
    """
    shape = clear.shape
    parent = np.arange(shape[0] * shape[1] * shape[2]).astype(np.int32)
    label = np.zeros(shape, np.int32)
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                if not clear[i, j, k]:
                    continue
                cell = (i * shape[1] + j) * shape[2] + k
                if i > 0 and clear[i - 1, j, k]:
                    unite(parent, cell, cell - shape[1] * shape[2])
                if j > 0 and clear[i, j - 1, k]:
                    unite(parent, cell, cell - shape[2])
                if k > 0 and clear[i, j, k - 1]:
                    unite(parent, cell, cell - 1)
    count = 0
    number = np.zeros(len(parent), np.int32)
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                if not clear[i, j, k]:
                    continue
                first = root(parent, (i * shape[1] + j) * shape[2] + k)
                if number[first] == 0:
                    count += 1
                    number[first] = count
                label[i, j, k] = number[first]
    return label


@kernel()
def depths(clear):
    """Return the number of steps from each cell to the next cell that is not clear.

    Diagonal steps count as one; 0 in cells that are not clear, and more than any path is long if
    all are clear. The method is a forward and a backward pass (Rosenfeld & Pfaltz 1968, doi
    10.1016/0031-3203(68)90013-7).
    """
    n_i, n_j, n_k = clear.shape
    depth = np.zeros(clear.shape, np.int32)
    for back in range(2):
        step = 1 if back else -1
        # Nested loops: divisions that find (i, j, k) from one index would take most of the time.
        for i in range(n_i - 1, -1, -1) if back else range(n_i):
            for j in range(n_j - 1, -1, -1) if back else range(n_j):
                for k in range(n_k - 1, -1, -1) if back else range(n_k):
                    if clear[i, j, k]:
                        max_depth = depth[i, j, k] if back else n_i + n_j + n_k
                        depth[i, j, k] = _depth_beside(depth, i, j, k, step, max_depth)
    return depth


@inner()
def _depth_beside(depth, i, j, k, step, max_depth):
    """Return 1 + the least depth of the 13 cells around that were visited before, ≤ `max_depth`."""
    n_i, n_j, n_k = depth.shape
    for di in range(2):
        for dj in range(-1, 2):
            for dk in range(-1, 2):
                if di == 0 and (dj < 0 or (dj == 0 and dk < 1)):
                    continue
                a, b, c = i + step * di, j + step * dj, k + step * dk
                if 0 <= a < n_i and 0 <= b < n_j and 0 <= c < n_k:
                    max_depth = min(max_depth, depth[a, b, c] + 1)
    return max_depth


@inner()
def _flood(seed, clear):
    """Return the bits of `clear` that are connected to the bit `seed` (a word with this bit)."""
    x = seed
    while True:
        y = x | ((x & ~K_LAST) << ONE) | ((x & ~K_FIRST) >> ONE)
        y |= ((x & ~J_LAST) << np.uint64(4)) | ((x & ~J_FIRST) >> np.uint64(4))
        y |= (x << np.uint64(16)) | (x >> np.uint64(16))
        y &= clear
        if y == x:
            return x
        x = y


@kernel()
def parts_of(surface_bits):
    """Return the connected sets of small cells without surface in each word: first and mask.

    `mask` (m,) holds the bits of each set, `first` (n + 1,) the row at which the sets of each word
    begin. Cells are connected by faces.
    """
    first = np.zeros(surface_bits.shape[0] + 1, np.int64)
    mask = np.empty(4 * surface_bits.shape[0] + 64, np.uint64)
    count = 0
    for w in range(surface_bits.shape[0]):
        clear = ~surface_bits[w]
        if count + 64 > mask.shape[0]:
            more = np.empty(2 * mask.shape[0], np.uint64)
            for p in range(count):
                more[p] = mask[p]
            mask = more
        while clear != NO_BITS:
            part = _flood(clear & (~clear + ONE), clear)
            clear &= ~part
            mask[count] = part
            count += 1
        first[w + 1] = count
    return first, mask[:count].copy()


@kernel()
def join(labels, words, places, first, mask):
    """Return the root of every connected region: labelled cells (label − 1), then the parts.

    `labels` (cells,) are the regions, from 1, of cells without surface, 0 in cells that may contain
    surface; `words` (cells,) are the words of these, −1 elsewhere; `places` (words, 3) are the
    cells of the words, none at the border of the grid; `first` and `mask` are those of `parts_of`.
    """
    shape = labels.shape
    count = 0
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                count = max(count, labels[i, j, k])
    parent = np.arange(count + mask.shape[0]).astype(np.int32)
    for w in range(places.shape[0]):
        for side in range(6):
            axis, is_forward = side // 2, side % 2 == 1
            step = 1 if is_forward else -1
            i = places[w, 0] + (step if axis == 0 else 0)
            j = places[w, 1] + (step if axis == 1 else 0)
            k = places[w, 2] + (step if axis == 2 else 0)
            face = (I_LAST, J_LAST, K_LAST)[axis]
            if not is_forward:
                face = (I_FIRST, J_FIRST, K_FIRST)[axis]
            other = words[i, j, k]
            if other >= 0 and not is_forward:
                continue  # two words are compared once, from the first of them
            shift = np.uint64((48, 12, 3)[axis])
            for p in range(first[w], first[w + 1]):
                facing = mask[p] & face
                if facing == NO_BITS:
                    continue
                if other < 0:
                    unite(parent, count + p, labels[i, j, k] - 1)
                    continue
                opposite = facing >> shift
                for q in range(first[other], first[other + 1]):
                    if mask[q] & opposite != NO_BITS:
                        unite(parent, count + p, count + q)
    for k in range(parent.shape[0]):
        parent[k] = root(parent, k)
    return parent


@kernel()
def sizes_and_samples(parent, labels, depth, places, first, mask):
    """Return the number of small cells (n,) connected to every root, and three sample points each.

    The points (n, 3, 3) have coordinates in units of cells. They are the middles of three cells
    next to cells that may contain surface, spread over the region, or of small cells if the region
    has no such cell. Rows that are no root are undefined. `parent` (n,) is that of `join`, `depth`
    (cells,) that of `depths`.
    """
    n = parent.shape[0]
    size = np.zeros(n, np.int64)
    n_border = np.zeros(n, np.int64)
    samples = np.empty((n, 3, 3))
    n_i, n_j, n_k = labels.shape
    count = n - mask.shape[0]
    for is_second in (False, True):
        n_seen = np.zeros(n, np.int64)
        for i in range(n_i):
            for j in range(n_j):
                for k in range(n_k):
                    if labels[i, j, k] == 0:
                        continue
                    r = parent[labels[i, j, k] - 1]
                    is_at_border = depth[i, j, k] == 1
                    if not is_second:
                        size[r] += SPLIT**3
                        n_border[r] += 1 if is_at_border else 0
                        continue
                    if not is_at_border:
                        continue
                    for q in range(3):
                        if n_seen[r] == (2 * q + 1) * n_border[r] // 6:
                            samples[r, q, 0] = i + 0.5
                            samples[r, q, 1] = j + 0.5
                            samples[r, q, 2] = k + 0.5
                    n_seen[r] += 1
    for w in range(places.shape[0]):
        for p in range(first[w], first[w + 1]):
            r = parent[count + p]
            if n_border[r] == 0:
                bit = 0
                while (mask[p] >> np.uint64(bit)) & ONE == NO_BITS:
                    bit += 1
                middle = (
                    places[w, 0] + ((bit >> 4) + 0.5) / SPLIT,
                    places[w, 1] + (((bit >> 2) & 3) + 0.5) / SPLIT,
                    places[w, 2] + ((bit & 3) + 0.5) / SPLIT,
                )
                for q in range(0 if size[r] == 0 else 2, 3):
                    for c in range(3):
                        samples[r, q, c] = middle[c]
            bits = mask[p]
            while bits != NO_BITS:  # each bit is a small cell
                bits &= bits - ONE
                size[r] += 1
    return size, samples


@kernel()
def side_tables(parent, sign, labels, depth, words, first, mask):
    """Return the tables for queries of sides: `cell` and `masks` of a `SideGrid`.

    They are (cells,) side times depth, or FIRST_WORD + word in cells that may contain surface, and
    (words, 2) masks of the small cells inside, and of those outside. `sign` (roots,) is 1 outside,
    −1 inside, 0 unknown.
    """
    shape = labels.shape
    cell = np.empty(shape, np.int32)
    masks = np.zeros((first.shape[0] - 1, 2), np.uint64)
    count = parent.shape[0] - mask.shape[0]
    for i in range(shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                if labels[i, j, k] > 0:
                    cell[i, j, k] = sign[parent[labels[i, j, k] - 1]] * depth[i, j, k]
                else:
                    cell[i, j, k] = FIRST_WORD + words[i, j, k]
    for w in range(masks.shape[0]):
        for p in range(first[w], first[w + 1]):
            side = sign[parent[count + p]]
            if side < 0:
                masks[w, 0] |= mask[p]
            elif side > 0:
                masks[w, 1] |= mask[p]
    return cell, masks


FIRST_WORD = 1 << 20
"""Smallest entry of a cell that refers to a word."""
