"""Forces of elements, block by block, called from Python: one kernel for each kind of element."""

from __future__ import annotations

from contiga.jit import inner, kernel
from contiga.jit.scratch import scratch
from contiga.matter.kernels.bar_nb import bar_forces
from contiga.matter.kernels.elements_stress_nb import membrane_stress, solid_stress
from contiga.matter.kernels.lanes_nb import (
    ENERGY,
    HOURGLASS,
    LANES,
    N_ENERGIES,
    SIZE,
    blank,
    copy_to_rate,
    gather,
    inverted,
    sum_in_block,
    total,
)
from contiga.matter.kernels.membrane_nb import (
    first_stress,
    green_strain,
    triangle_forces,
    triangle_gradient,
)
from contiga.matter.kernels.solid_hex_nb import hex_forces, hex_gradient, hourglass
from contiga.matter.kernels.solid_nb import (
    determinant,
    mean_pressure,
    quarter_volumes,
    tet_forces,
    tet_gradient,
)
from contiga.matter.kernels.solid_viscosity_nb import bulk_viscosity


@inner()
def _write_energies(bank, measures, energy):
    """Write the energies (4,) of a block into `energy`, and those of its lanes if there is room.

    Energies by volume in the bank are multiplied by `measures`, and summed. In (4 + LANES,) the
    stored energy of each lane follows, hourglass springs included.
    """
    for kind in range(N_ENERGIES):
        row = (ENERGY + kind) * LANES
        for lane in range(LANES):
            bank[row + lane] *= measures[lane]
    if len(energy) > N_ENERGIES:
        for lane in range(LANES):
            energy[N_ENERGIES + lane] = bank[ENERGY * LANES + lane] + bank[HOURGLASS * LANES + lane]
    for kind in range(N_ENERGIES):
        energy[kind] = total(bank, ENERGY + kind)


@inner()
def _solid_response(bank, tables, memory, b, step):
    """Write J, stress and energies of a solid's gradient, and the new memory of block b."""
    determinant(bank)
    old, new = memory.old[b], memory.new[b]
    solid_stress(bank, tables, step, old, new)
    if len(tables.viscosity) > 0:
        bulk_viscosity(bank, tables.viscosity, tables.sizes[b], step, old, new)


@kernel()
def tet_volumes(motion, tables, out, start, stop):
    """Write the present volumes at nodes of blocks start … stop, as x of the rows of `out.partial`.

    Each corner of a tetrahedron has a quarter of its volume.
    """
    bank = scratch(SIZE)
    for b in range(start, stop):
        gather(motion.points, tables.nodes[b], 4, bank)
        tet_gradient(bank, tables.gradients[b])
        determinant(bank)
        quarter_volumes(bank, tables.measures[b])
        sum_in_block(bank, tables.sums, b, out.partial)


@kernel()
def tetrahedra(motion, tables, memory, out, start, stop):
    """Write forces, energies and numbers of inverted elements of blocks start … stop into `out`.

    They are `out.partial`, `out.energy` and `out.inverted`. The new memory is written, too; without
    bulk viscosity velocities are not read.
    """
    bank = scratch(SIZE)
    for b in range(start, stop):
        gradients, volumes = tables.gradients[b], tables.measures[b]
        blank(bank)
        if len(tables.viscosity) > 0:
            gather(motion.velocities, tables.nodes[b], 4, bank)
            tet_gradient(bank, gradients)
            copy_to_rate(bank)
        gather(motion.points, tables.nodes[b], 4, bank)
        tet_gradient(bank, gradients)
        if tables.averaged:
            mean_pressure(bank, motion.pressures, tables.nodes[b])
        _solid_response(bank, tables, memory, b, motion.step)
        out.inverted[b] = inverted(bank)
        _write_energies(bank, volumes, out.energy[b])
        tet_forces(bank, gradients, volumes)
        sum_in_block(bank, tables.sums, b, out.partial)


@kernel()
def hexahedra(motion, tables, memory, out, start, stop):
    """Write forces, energies and numbers of inverted elements as `tetrahedra` does."""
    bank = scratch(SIZE)
    for b in range(start, stop):
        gradients, volumes = tables.gradients[b], tables.measures[b]
        blank(bank)
        if len(tables.viscosity) > 0:
            gather(motion.velocities, tables.nodes[b], 8, bank)
            hex_gradient(bank, gradients)
            copy_to_rate(bank)
        gather(motion.points, tables.nodes[b], 8, bank)
        hex_gradient(bank, gradients)
        _solid_response(bank, tables, memory, b, motion.step)
        out.inverted[b] = inverted(bank)
        hourglass(bank, tables.hourglass[b])
        _write_energies(bank, volumes, out.energy[b])
        hex_forces(bank, gradients, volumes)
        sum_in_block(bank, tables.sums, b, out.partial)


@kernel()
def triangles(motion, tables, memory, out, start, stop):
    """Write forces, energies and new memory of blocks start … stop; 0 in `out.inverted`."""
    bank = scratch(SIZE)
    for b in range(start, stop):
        gradients, areas = tables.gradients[b], tables.measures[b]
        blank(bank)
        gather(motion.points, tables.nodes[b], 3, bank)
        triangle_gradient(bank, gradients)
        green_strain(bank)
        old, new = memory.old[b], memory.new[b]
        membrane_stress(bank, tables.material, tables.numbers, tables.curves, old, new)
        first_stress(bank)
        _write_energies(bank, areas, out.energy[b])
        triangle_forces(bank, gradients, areas)
        out.inverted[b] = 0
        sum_in_block(bank, tables.sums, b, out.partial)


@kernel()
def bars(motion, tables, memory, out, start, stop):
    """Write forces, energies and new memory of blocks start … stop; 0 in `out.inverted`."""
    bank = scratch(SIZE)
    for b in range(start, stop):
        blank(bank)
        gather(motion.points, tables.nodes[b], 2, bank)
        old, new = memory.old[b], memory.new[b]
        bar_forces(bank, tables.numbers, tables.curves, tables.gradients[b], old, new)
        _write_energies(bank, tables.measures[b], out.energy[b])
        out.inverted[b] = 0
        sum_in_block(bank, tables.sums, b, out.partial)
