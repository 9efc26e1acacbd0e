"""Forces of shells, block by block, called from Python."""

from __future__ import annotations

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.matter.kernels.elements_stress_nb import membrane_stress
from contiga.matter.kernels.lanes_nb import (
    ENERGY,
    GRADIENT,
    LANES,
    SECOND,
    STRAIN,
    blank,
    gather,
    sum_in_block,
    total,
)
from contiga.matter.kernels.membrane_nb import green_strain
from contiga.matter.kernels.shell_nb import (
    ALL_LOST,
    ALL_STORED,
    INSIDE,
    KAPPA,
    MOMENT,
    NET,
    ROW,
    SHELL_SIZE,
    WIDTH,
    add_layer,
    begin_thickness,
    clear,
    curvature,
    end_thickness,
    flat_lanes,
    moments,
    shell_derivatives,
    shell_forces,
    shell_stress,
    strain_at_height,
)


@inner(linked=False)
def shell_strain(bank, net, tables, b, g):
    """Write F, f_ij, a₃, 1/J, b, κ and E of Gauss point g of block b into the bank."""
    count = tables.nodes.shape[1]
    shell_derivatives(net, tables.basis[b], g * count * WIDTH * LANES, count, bank)
    curvature(bank, tables.rest[b], g * ROW)
    green_strain(bank)


@inner(linked=False)
def shell_response(bank, tables, memory, b, g):
    """Write n, m and energies of Gauss point g of block b, and the memory of its layers.

    With layers E in the bank becomes that of the last one.
    """
    layers = len(tables.layers)
    size = memory.old.shape[1] // (tables.points * max(layers, 1))
    first = g * max(layers, 1) * size
    old, new = memory.old[b], memory.new[b]
    if layers == 0:
        before, after = old[first : first + size], new[first : first + size]
        membrane_stress(bank, tables.material, tables.numbers, tables.curves, before, after)
        moments(bank, tables.bending)
        return
    begin_thickness(bank)
    for k in range(layers):
        height, share = tables.layers[k, 0], tables.layers[k, 1]
        start = first + k * size
        before, after = old[start : start + size], new[start : start + size]
        strain_at_height(bank, height)
        membrane_stress(bank, tables.material, tables.numbers, tables.curves, before, after)
        add_layer(bank, height, share)
    end_thickness(bank)


@kernel()
def shells(motion, tables, memory, out, start, stop):
    """Write forces, energies and new memory of blocks start … stop into `out` and `memory.new`.

    `out.inverted` is the largest number of lanes without a normal at a Gauss point, zero for
    membranes, which need none.
    """
    bank, net, force = scratch(SHELL_SIZE), scratch(NET), scratch(NET)
    count = tables.nodes.shape[1]
    bends = len(tables.layers) > 0 or max(tables.bending[0], tables.bending[1]) > 0.0
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], count, net)
        clear(force, 3 * count)
        blank(bank)
        clear(bank[ALL_STORED * LANES :], 2)
        flat = 0
        for g in range(tables.points):
            shell_strain(bank, net, tables, b, g)
            if bends:
                flat = max(flat, flat_lanes(bank))
            shell_response(bank, tables, memory, b, g)
            shell_stress(bank, tables.weights[b], g * LANES)
            shell_forces(bank, tables.basis[b], g * count * WIDTH * LANES, count, force)
        out.inverted[b] = flat
        out.energy[b, 0] = total(bank, ALL_STORED)
        out.energy[b, 1] = 0.0
        out.energy[b, 2] = 0.0
        out.energy[b, 3] = total(bank, ALL_LOST)
        sum_in_block(force, tables.sums, b, out.partial)


@inner()
def _copy_rows(bank, row, rows, to, out):
    """Copy rows of the bank to rows of `out`."""
    for at in range(rows * LANES):
        out[to * LANES + at] = bank[row * LANES + at]


@kernel()
def shell_inside(motion, tables, memory, out, start, stop):
    """Write F, E, κ, n, m, W at Gauss points of blocks start … stop into `out`.

    Each point has `INSIDE` rows of lanes. The new memory is written, too.
    """
    bank, net = scratch(SHELL_SIZE), scratch(NET)
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], tables.nodes.shape[1], net)
        blank(bank)
        for g in range(tables.points):
            rows = out[b, g * INSIDE * LANES : (g + 1) * INSIDE * LANES]
            shell_strain(bank, net, tables, b, g)
            for i in range(3):
                _copy_rows(bank, GRADIENT + 3 * i, 2, 2 * i, rows)
            _copy_rows(bank, STRAIN, 3, 6, rows)
            _copy_rows(bank, KAPPA, 3, 9, rows)
            shell_response(bank, tables, memory, b, g)
            _copy_rows(bank, SECOND, 3, 12, rows)
            _copy_rows(bank, MOMENT, 3, 15, rows)
            _copy_rows(bank, ENERGY, 1, 18, rows)
