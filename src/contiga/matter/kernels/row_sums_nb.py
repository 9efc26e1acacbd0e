"""Row sums of the stiffness of elements, block by block, which bound the critical step.

K_ab = V ∂P/∂F : G_a ⊗ G_b. The tangents of solids are differences of the stress, each in the
direction of unloading, in which materials with hysteresis are stiffer; their relative error is
10⁻⁶. Tangents of membranes are in closed form, which takes a thirteenth of the time.
"""

from __future__ import annotations

import math

from contiga.jit import inlined, inner, kernel
from contiga.jit.scratch import scratch, zero_scratch
from contiga.matter.kernels.bar_nb import bar_rows as rows_of_bars
from contiga.matter.kernels.elements_stress_nb import membrane_stress, solid_stress
from contiga.matter.kernels.lanes_nb import (
    CORNER_ROWS,
    GRADIENT,
    LANES,
    SIZE,
    STRESS,
    gather,
    sum_in_block,
)
from contiga.matter.kernels.membrane_nb import green_strain, triangle_gradient
from contiga.matter.kernels.membrane_rows_nb import PAIRS, pair_stiffness, triangle_sums
from contiga.matter.kernels.membrane_tangent_nb import membrane_tangent
from contiga.matter.kernels.solid_hex_nb import ROW_SUMS, hex_gradient
from contiga.matter.kernels.solid_nb import determinant, tet_gradient

F, P, X = GRADIENT * LANES, STRESS * LANES, CORNER_ROWS * LANES
ROW = 3 * LANES
NINE = 9 * LANES
TANGENT = 3 * NINE
NUDGE = 1e-6
"""Change of a component of F for finite differences."""
MAX_CORNERS = 8
GRADIENTS_SIZE = MAX_CORNERS * ROW


@inner(linked=False)
def all_gradients(others, corners, width, full):
    """Fill `full` (corners, 3, LANES) from the gradients of all corners but the first, `others`.

    The sum over the corners is zero. `width` components are filled, the others are not.
    """
    for lane in range(3 * LANES):
        full[lane] = 0.0
    for a in range(1, corners):
        for j in range(width):
            for lane in range(LANES):
                g = others[((a - 1) * width + j) * LANES + lane]
                full[a * ROW + j * LANES + lane] = g
                full[j * LANES + lane] -= g


@inner(linked=False)
def _nudge(bank, at, stress, change):
    """Change a row of F by `NUDGE` towards unloading, against its stress, and write the change."""
    for lane in range(LANES):
        change[lane] = -NUDGE if stress[at + lane] > 0.0 else NUDGE
        bank[F + at + lane] += change[lane]


@inner(linked=False)
def _differences(bank, at, stress, change, tangent):
    """Write ∂P/∂F (9, LANES) for the changed row of F into `tangent`, and restore the row."""
    for lane in range(LANES):
        bank[F + at + lane] -= change[lane]
    for row in range(9):
        for lane in range(LANES):
            p = row * LANES + lane
            tangent[p] = (bank[P + p] - stress[p]) / change[lane]


@inlined()
def _contract(tangent, g, lane, full, corner):
    """Return ∂P/∂F : G of a corner for one component of P in a lane, whose row begins at g."""
    n = corner * ROW + lane
    return (
        tangent[g] * full[n]
        + tangent[g + LANES] * full[n + LANES]
        + tangent[g + 2 * LANES] * full[n + 2 * LANES]
    )


@inlined()
def _add_row(tangent, full, corners, corner, row, measures):
    """Add |K| of one direction of all `corners`, a literal number, to a row of one corner."""
    for lane in range(LANES):
        x = _contract(tangent, lane, lane, full, corner)
        y = _contract(tangent, NINE + lane, lane, full, corner)
        z = _contract(tangent, 2 * NINE + lane, lane, full, corner)
        measure, total = measures[lane], row[lane]
        for b in range(corners):
            g = b * ROW + lane
            k = x * full[g] + y * full[g + LANES] + z * full[g + 2 * LANES]
            total += measure * abs(k)
        row[lane] = total


@inner(linked=False)
def _add_row_of_4(tangent, full, corner, row, measures):
    _add_row(tangent, full, 4, corner, row, measures)


@inner(linked=False)
def _add_row_of_8(tangent, full, corner, row, measures):
    _add_row(tangent, full, 8, corner, row, measures)


@inner()
def add_rows(bank, tangent, full, corners, measures):
    """Add |K| of one direction of all columns to the rows of all corners.

    There are four or eight corners; any other number gives NaN.
    """
    for a in range(corners):
        for i in range(3):
            at = X + a * ROW + i * LANES
            if corners == 4:
                _add_row_of_4(tangent[i * ROW :], full, a, bank[at : at + LANES], measures)
            elif corners == 8:
                _add_row_of_8(tangent[i * ROW :], full, a, bank[at : at + LANES], measures)
            else:
                for lane in range(LANES):
                    bank[at + lane] = math.nan


@inner()
def _start(bank, stress, corners):
    """Copy P to `stress`, and set the row sums to zero, in place of the corners in the bank."""
    for at in range(NINE):
        stress[at] = bank[P + at]
    for at in range(X, X + corners * ROW):
        bank[at] = 0.0


@kernel()
def tet_rows(motion, tables, memory, out, start, stop):
    """Write row sums of |K| of blocks start … stop, at their nodes, into `out.partial`.

    The new memory is overwritten with that of nudged states.
    """
    bank, full = zero_scratch(SIZE), scratch(GRADIENTS_SIZE)
    stress, change, tangent = scratch(NINE), scratch(LANES), scratch(TANGENT)
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], 4, bank)
        tet_gradient(bank, tables.gradients[b])
        all_gradients(tables.gradients[b], 4, 3, full)
        determinant(bank)
        solid_stress(bank, tables, motion.step, memory.old[b], memory.new[b])
        _start(bank, stress, 4)
        for k in range(3):
            for l in range(3):
                at = k * ROW + l * LANES
                _nudge(bank, at, stress, change)
                determinant(bank)
                solid_stress(bank, tables, motion.step, memory.old[b], memory.new[b])
                _differences(bank, at, stress, change, tangent[l * NINE : (l + 1) * NINE])
            add_rows(bank, tangent, full, 4, tables.measures[b])
        sum_in_block(bank, tables.sums, b, out.partial)


@kernel()
def hex_rows(motion, tables, memory, out, start, stop):
    """Write row sums of |K|, with hourglass springs, of blocks start … stop into `out.partial`.

    They are sums at nodes of blocks. The new memory is overwritten with that of nudged states.
    """
    bank = zero_scratch(SIZE)
    stress, change, tangent = scratch(NINE), scratch(LANES), scratch(TANGENT)
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], 8, bank)
        hex_gradient(bank, tables.gradients[b])
        determinant(bank)
        solid_stress(bank, tables, motion.step, memory.old[b], memory.new[b])
        _start(bank, stress, 8)
        for k in range(3):
            for l in range(3):
                at = k * ROW + l * LANES
                _nudge(bank, at, stress, change)
                determinant(bank)
                solid_stress(bank, tables, motion.step, memory.old[b], memory.new[b])
                _differences(bank, at, stress, change, tangent[l * NINE : (l + 1) * NINE])
            add_rows(bank, tangent, tables.gradients[b], 8, tables.measures[b])
        # Row sums of the hourglass springs, the same in each direction.
        for a in range(8):
            for i in range(3):
                for lane in range(LANES):
                    springs = tables.hourglass[b, (ROW_SUMS + a) * LANES + lane]
                    bank[X + a * ROW + i * LANES + lane] += springs
        sum_in_block(bank, tables.sums, b, out.partial)


@kernel()
def triangle_rows(motion, tables, memory, out, start, stop):
    """Write row sums of |K| of blocks start … stop, at their nodes, into `out.partial`.

    The new memory is written, too.
    """
    bank, pairs = scratch(SIZE), scratch(PAIRS)
    for b in range(start, stop):
        gradients = tables.gradients[b]
        gather(motion.points, tables.nodes[b], 3, bank)
        triangle_gradient(bank, gradients)
        green_strain(bank)
        old, new = memory.old[b], memory.new[b]
        membrane_stress(bank, tables.material, tables.numbers, tables.curves, old, new)
        membrane_tangent(bank, tables.tangent, tables.numbers)
        for pair in range(3):
            pair_stiffness(bank, gradients, pair, pairs[pair * NINE : (pair + 1) * NINE])
        triangle_sums(bank, pairs, tables.measures[b])
        sum_in_block(bank, tables.sums, b, out.partial)


@kernel()
def bar_rows(motion, tables, memory, out, start, stop):
    """Write upper bounds of row sums of |K| of blocks start … stop into `out.partial`."""
    bank = scratch(SIZE)
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], 2, bank)
        rows_of_bars(bank, tables.numbers, tables.gradients[b], tables.measures[b])
        sum_in_block(bank, tables.sums, b, out.partial)
