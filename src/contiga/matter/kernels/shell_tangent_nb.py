"""Stiffness of shells in blocks of lanes: K_IJ = ∂²W/∂x_I∂x_J of pairs of control points I ≤ J.

With the names of `shell_nb`, w_I = G₁ f₂ − G₂ f₁, s_I = w_I × a₃, d_I = w_I × c, h_I = m:H_I,
μ = m:b, g = G_I1 G_J2 − G_I2 G_J1, and the derivatives R_I (6, 3) of E₁₁, E₂₂, 2 E₁₂, κ₁₁, κ₂₂ and
2 κ₁₂ it is

    K_IJ = R_Iᵀ D R_J + (G_I·n·G_J) 1 + [(h_I w_J − h_J w_I)/J + g c]×
           + (h_I a₃ s_Jᵀ + h_J s_I a₃ᵀ + d_I s_Jᵀ + s_I d_Jᵀ)/J
           + μ ((w_I·w_J) 1 − w_J w_Iᵀ − s_I s_Jᵀ)/J²,

where κ_ij changes with x_I by −H_ij a₃ + (f_ij × w_I + b_ij s_I)/J.
"""

from __future__ import annotations

import numpy as np

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.matter.kernels.lanes_nb import (
    GRADIENT,
    LANES,
    SECOND,
    TANGENT,
    blank,
    gather,
    sum_in_block,
)
from contiga.matter.kernels.membrane_tangent_nb import membrane_tangent
from contiga.matter.kernels.shell_elements_nb import shell_response, shell_strain
from contiga.matter.kernels.shell_nb import (
    BENT,
    COUPLE,
    CURVED,
    MOMENT,
    NET,
    NORMAL,
    ROW,
    SHELL_ROWS,
    STRETCHED,
    WIDTH,
    clear,
    shell_stress,
    strain_at_height,
)

MODULI = SHELL_ROWS
"""Six rows each of ∂n/∂E, ∂n/∂κ = ∂m/∂E and ∂m/∂κ: 1111, 2222, 1122, 1212, 1112, 2212."""
BANK = (SHELL_ROWS + 18) * LANES
PER_POINT = 30
"""Rows of a control point: R (18), w, s, d, h, G₁, G₂."""
VECTOR_W, VECTOR_S, VECTOR_D, LEVER, SLOPE = 18, 21, 24, 27, 28
PAIR = 9 * LANES

F, S, C = GRADIENT * LANES, SECOND * LANES, COUPLE * LANES
X, B, M, N = CURVED * LANES, BENT * LANES, MOMENT * LANES, NORMAL * LANES
R, D = STRETCHED * LANES, MODULI * LANES


@inner(linked=False)
def add_moduli(bank, height, share):
    """Add the moduli of a layer at `height`, with its `share` of the thickness, to the bank."""
    lever, square = share * height, share * height * height
    for at in range(6 * LANES):
        modulus = bank[TANGENT * LANES + at]
        bank[D + at] += share * modulus
        bank[D + 6 * LANES + at] += lever * modulus
        bank[D + 12 * LANES + at] += square * modulus


@inner()
def shell_moduli(bank, tables):
    """Write the moduli of a Gauss point whose strains are in the bank, which layers overwrite."""
    clear(bank[D:], 18)
    layers = len(tables.layers)
    if layers == 0:
        membrane_tangent(bank, tables.tangent, tables.numbers)
        add_moduli(bank, 0.0, 1.0)
        for row in range(4):
            for lane in range(LANES):
                bank[D + (12 + row) * LANES + lane] = tables.bending[row]
    for k in range(layers):
        height, share = tables.layers[k, 0], tables.layers[k, 1]
        strain_at_height(bank, height)
        membrane_tangent(bank, tables.tangent, tables.numbers)
        add_moduli(bank, height, share)


@inner(linked=False)
def weigh(bank, weights, first):
    """Multiply n and moduli in the bank by the weights from `first` on."""
    for row in range(18):
        for lane in range(LANES):
            bank[D + row * LANES + lane] *= weights[first + lane]
    for row in range(3):
        for lane in range(LANES):
            bank[S + row * LANES + lane] *= weights[first + lane]


@inner(linked=False)
def point_rows(bank, basis, first, out):
    """Write the `PER_POINT` rows of a control point whose basis begins at `first`."""
    for lane in range(LANES):
        g = first + lane
        g_1, g_2 = basis[g], basis[g + LANES]
        out[SLOPE * LANES + lane] = g_1
        out[(SLOPE + 1) * LANES + lane] = g_2
        f = F + lane
        ax, bx = bank[f], bank[f + LANES]
        ay, by = bank[f + ROW], bank[f + ROW + LANES]
        az, bz = bank[f + 2 * ROW], bank[f + 2 * ROW + LANES]
        nx, ny, nz = bank[N + lane], bank[N + LANES + lane], bank[N + 2 * LANES + lane]
        cx, cy, cz = bank[C + lane], bank[C + LANES + lane], bank[C + 2 * LANES + lane]
        inverse = bank[R + lane]
        out[lane] = ax * g_1
        out[LANES + lane] = ay * g_1
        out[2 * LANES + lane] = az * g_1
        out[3 * LANES + lane] = bx * g_2
        out[4 * LANES + lane] = by * g_2
        out[5 * LANES + lane] = bz * g_2
        out[6 * LANES + lane] = ax * g_2 + bx * g_1
        out[7 * LANES + lane] = ay * g_2 + by * g_1
        out[8 * LANES + lane] = az * g_2 + bz * g_1
        wx, wy, wz = g_1 * bx - g_2 * ax, g_1 * by - g_2 * ay, g_1 * bz - g_2 * az
        sx, sy, sz = wy * nz - wz * ny, wz * nx - wx * nz, wx * ny - wy * nx
        h = 0.0
        for k in range(3):
            at, double = X + k * ROW + lane, 2.0 if k == 2 else 1.0
            slope, bent = basis[g + (2 + k) * LANES], inverse * bank[B + k * LANES + lane]
            h += bank[M + k * LANES + lane] * slope
            x, y, z = bank[at] * inverse, bank[at + LANES] * inverse, bank[at + 2 * LANES] * inverse
            to = (9 + 3 * k) * LANES + lane
            out[to] = double * (y * wz - z * wy + bent * sx - slope * nx)
            out[to + LANES] = double * (z * wx - x * wz + bent * sy - slope * ny)
            out[to + 2 * LANES] = double * (x * wy - y * wx + bent * sz - slope * nz)
        out[VECTOR_W * LANES + lane] = wx
        out[(VECTOR_W + 1) * LANES + lane] = wy
        out[(VECTOR_W + 2) * LANES + lane] = wz
        out[VECTOR_S * LANES + lane] = sx
        out[(VECTOR_S + 1) * LANES + lane] = sy
        out[(VECTOR_S + 2) * LANES + lane] = sz
        out[VECTOR_D * LANES + lane] = wy * cz - wz * cy
        out[(VECTOR_D + 1) * LANES + lane] = wz * cx - wx * cz
        out[(VECTOR_D + 2) * LANES + lane] = wx * cy - wy * cx
        out[LEVER * LANES + lane] = h


@inner(linked=False)
def _times(bank, first, rows, at, out, to):
    """Add to `out` the symmetric 3 × 3 moduli, six rows from `first`, times three rows of R."""
    for lane in range(LANES):
        d = D + first * LANES + lane
        c_1, c_2, c_both = bank[d], bank[d + LANES], bank[d + 2 * LANES]
        shear, with_1, with_2 = bank[d + 3 * LANES], bank[d + 4 * LANES], bank[d + 5 * LANES]
        for i in range(3):
            r = at + i * LANES + lane
            e_1, e_2, e_12 = rows[r], rows[r + ROW], rows[r + 2 * ROW]
            o = to + i * LANES + lane
            out[o] += c_1 * e_1 + c_both * e_2 + with_1 * e_12
            out[o + ROW] += c_both * e_1 + c_2 * e_2 + with_2 * e_12
            out[o + 2 * ROW] += with_1 * e_1 + with_2 * e_2 + shear * e_12


@inner()
def moduli_times(bank, rows, out):
    """Write D R of a control point, 18 rows."""
    clear(out, 18)
    _times(bank, 0, rows, 0, out, 0)
    _times(bank, 6, rows, 3 * ROW, out, 0)
    _times(bank, 6, rows, 0, out, 3 * ROW)
    _times(bank, 12, rows, 3 * ROW, out, 3 * ROW)


@inner(linked=False)
def add_material(rows_i, weighted_j, out):
    """Add R_Iᵀ D R_J to K_IJ, from the rows of I and D R_J."""
    for lane in range(LANES):
        for i in range(3):
            for j in range(3):
                a, b = i * LANES + lane, j * LANES + lane
                total = rows_i[a] * weighted_j[b]
                for row in range(1, 6):
                    total += rows_i[a + row * ROW] * weighted_j[b + row * ROW]
                out[(3 * i + j) * LANES + lane] += total


@inner(linked=False)
def add_geometric(bank, rows_i, rows_j, out):
    """Add the geometric part of K_IJ, all but R_Iᵀ D R_J, from the stresses and rows of I and J."""
    for lane in range(LANES):
        inverse = bank[R + lane]
        w, s, d = VECTOR_W * LANES + lane, VECTOR_S * LANES + lane, VECTOR_D * LANES + lane
        u, v = SLOPE * LANES + lane, (SLOPE + 1) * LANES + lane
        mu = bank[M + lane] * bank[B + lane] + bank[M + LANES + lane] * bank[B + LANES + lane]
        mu += bank[M + 2 * LANES + lane] * bank[B + 2 * LANES + lane]
        mu *= inverse * inverse
        h_i, h_j = inverse * rows_i[LEVER * LANES + lane], inverse * rows_j[LEVER * LANES + lane]
        g = rows_i[u] * rows_j[v] - rows_i[v] * rows_j[u]
        even = (
            bank[S + lane] * rows_i[u] * rows_j[u] + bank[S + LANES + lane] * rows_i[v] * rows_j[v]
        )
        even += bank[S + 2 * LANES + lane] * (rows_i[u] * rows_j[v] + rows_i[v] * rows_j[u])
        for i in range(3):
            even += mu * rows_i[w + i * LANES] * rows_j[w + i * LANES]
        for i in range(3):
            a = i * LANES
            normal = bank[N + a + lane]
            for j in range(3):
                b = j * LANES
                k = h_i * normal * rows_j[s + b] + h_j * rows_i[s + a] * bank[N + b + lane]
                k += inverse * (rows_i[d + a] * rows_j[s + b] + rows_i[s + a] * rows_j[d + b])
                k -= mu * (rows_j[w + a] * rows_i[w + b] + rows_i[s + a] * rows_j[s + b])
                out[(3 * i + j) * LANES + lane] += k
            out[4 * a + lane] += even
        x = h_i * rows_j[w] - h_j * rows_i[w] + g * bank[C + lane]
        y = h_i * rows_j[w + LANES] - h_j * rows_i[w + LANES] + g * bank[C + LANES + lane]
        z = (
            h_i * rows_j[w + 2 * LANES]
            - h_j * rows_i[w + 2 * LANES]
            + g * bank[C + 2 * LANES + lane]
        )
        out[LANES + lane] -= z
        out[2 * LANES + lane] += y
        out[3 * LANES + lane] += z
        out[5 * LANES + lane] -= x
        out[6 * LANES + lane] -= y
        out[7 * LANES + lane] += x


@inner()
def _block_stiffness(bank, net, rows, tables, memory, b, out):
    """Write K of all pairs of block b, nine rows each: (0, 0), (0, 1) … (1, 1), (1, 2) …

    The new memory is overwritten; `rows` is memory for rows of control points and one D R.
    """
    count = tables.nodes.shape[1]
    width, weighted = PER_POINT * LANES, rows[count * PER_POINT * LANES :]
    clear(out, 9 * (count * (count + 1) // 2))
    for g in range(tables.points):
        shell_strain(bank, net, tables, b, g)
        shell_response(bank, tables, memory, b, g)
        shell_stress(bank, tables.weights[b], g * LANES)
        shell_moduli(bank, tables)
        weigh(bank, tables.weights[b], g * LANES)
        for k in range(count):
            first = (g * count + k) * WIDTH * LANES
            point_rows(bank, tables.basis[b], first, rows[k * width : (k + 1) * width])
        for j in range(count):
            rows_j = rows[j * width : (j + 1) * width]
            moduli_times(bank, rows_j, weighted)
            for i in range(j + 1):
                pair = i * count - i * (i - 1) // 2 + j - i
                to = out[pair * PAIR : (pair + 1) * PAIR]
                rows_i = rows[i * width : (i + 1) * width]
                add_material(rows_i, weighted, to)
                add_geometric(bank, rows_i, rows_j, to)


@inner(linked=False)
def add_sums(pair, i, j, sums):
    """Add |K_IJ| to the sums of the rows of I, and the sums of its columns to those of J."""
    for lane in range(LANES):
        for a in range(3):
            for b in range(3):
                size = abs(pair[(3 * a + b) * LANES + lane])
                sums[(3 * i + a) * LANES + lane] += size
                if i != j:
                    sums[(3 * j + b) * LANES + lane] += size


@kernel()
def shell_stiffness(motion, tables, memory, out, start, stop):
    """Write K of all pairs of blocks start … stop into `out` (b, pairs · 9 · LANES).

    Pairs are in the order of `_block_stiffness`. The new memory is overwritten.
    """
    count = tables.nodes.shape[1]
    bank, net = scratch(BANK), scratch(NET)
    rows = np.empty((count * PER_POINT + 18) * LANES)
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], count, net)
        blank(bank)
        _block_stiffness(bank, net, rows, tables, memory, b, out[b])


@kernel()
def shell_row_sums(motion, tables, memory, out, start, stop):
    """Write row sums of |K| of blocks start … stop, at nodes of blocks, into `out.partial`.

    The new memory is overwritten.
    """
    count = tables.nodes.shape[1]
    bank, net, sums = scratch(BANK), scratch(NET), scratch(NET)
    rows = np.empty((count * PER_POINT + 18) * LANES)
    stiff = np.empty(count * (count + 1) // 2 * PAIR)
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], count, net)
        blank(bank)
        _block_stiffness(bank, net, rows, tables, memory, b, stiff)
        clear(sums, 3 * count)
        for i in range(count):
            for j in range(i, count):
                pair = (i * count - i * (i - 1) // 2 + j - i) * PAIR
                add_sums(stiff[pair : pair + PAIR], i, j, sums)
        sum_in_block(sums, tables.sums, b, out.partial)
