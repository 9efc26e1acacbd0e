"""What kernels are told of elements: records of arrays, made once."""

from __future__ import annotations

from typing import NamedTuple

from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray


@pass_by_pointer
class BlockSums(NamedTuple):
    """Which lanes a block adds up at which of its nodes."""

    blocks: IntArray
    """(b + 1,) where the rows of a block begin; a row is a node of a block."""
    starts: IntArray
    """(r + 1,) where the places of a row begin."""
    places: IntArray
    """(p,) of the x of a corner's force in a block's bank."""


@pass_by_pointer
class ElementTables(NamedTuple):
    """Elements of one kind and material, in b blocks of `LANES`."""

    nodes: IntArray
    """(b, k, LANES) corners."""
    gradients: FloatArray
    """(b, g · LANES) gradients of the corners' shape functions at rest."""
    measures: FloatArray
    """(b, LANES) volume of solids at rest, area of membranes, length of bars; 0 fills blocks."""
    material: int
    """Which; numbers are in the kernels `elements_stress_nb`."""
    numbers: FloatArray
    """(c,) coefficients of the material."""
    tangent: FloatArray
    """(4,) of membranes: see `Coefficients`; (0,) of others."""
    hourglass: FloatArray
    """(b, 24 · LANES) of hexahedra, rows by `solid_hex_nb`; (0, 0) of others."""
    viscosity: FloatArray
    """(3,) coefficients of the bulk viscosity; (0,) of what has none."""
    sizes: FloatArray
    """(b, LANES) lengths for the bulk viscosity."""
    averaged: int
    """1 if the change of volume is averaged at the nodes of tetrahedra."""
    sums: BlockSums


@pass_by_pointer
class Motion(NamedTuple):
    """What elements are asked at."""

    points: FloatArray
    """(m, 3)."""
    velocities: FloatArray
    """(m, 3)."""
    step: float
    """Time since the memory `old` was written."""
    pressures: FloatArray
    """(m,) λ (J − 1) averaged at nodes; (0,) where nothing is averaged."""


@pass_by_pointer
class Memory(NamedTuple):
    """What the materials of elements remember, columns one after the other in each block."""

    old: FloatArray
    """(b, c · LANES) at the start of the step."""
    new: FloatArray
    """(b, c · LANES) at its end."""


@pass_by_pointer
class ElementOutput(NamedTuple):
    """What elements write."""

    partial: FloatArray
    """(r, 3) forces on nodes of blocks."""
    energy: FloatArray
    """(b, 4) strain, hourglass, viscosity, hysteresis of blocks; (b, 4 + LANES) where what each
    element stores is asked for, too."""
    inverted: IntArray
    """(b,) how many elements of a block have turned inside out."""
