"""Tables of elements for kernels: records of arrays, made once."""

from __future__ import annotations

from typing import NamedTuple

from contiga.curves.curve_records import Curves
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray


@pass_by_pointer
class BlockSums(NamedTuple):
    """Lanes that are summed at each node of a block."""

    blocks: IntArray
    """(b + 1,) first row of each block; a row is a node of a block."""
    starts: IntArray
    """(r + 1,) first place of each row."""
    places: IntArray
    """(p,) place of the x of a corner's force in a block's bank."""


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
    """Number of the material in the kernels `elements_stress_nb`."""
    numbers: FloatArray
    """(c,) coefficients of the material."""
    curves: Curves
    """Curves of the material."""
    tangent: FloatArray
    """(4,) for membranes: see `Coefficients`; else (0,)."""
    hourglass: FloatArray
    """(b, 24 · LANES) for hexahedra, rows by `solid_hex_nb`; else (0, 0)."""
    viscosity: FloatArray
    """(3,) coefficients of the bulk viscosity; (0,) without it."""
    sizes: FloatArray
    """(b, LANES) lengths for the bulk viscosity."""
    averaged: int
    """1 if the change of volume is averaged at the nodes of tetrahedra."""
    sums: BlockSums


@pass_by_pointer
class ShellTables(NamedTuple):
    """Elements of a shell of one pair of degrees and one material, in b blocks of `LANES`."""

    nodes: IntArray
    """(b, k, LANES) control points."""
    points: int
    """Gauss points of an element."""
    basis: FloatArray
    """(b, points · k · 5 · LANES) derivatives G₁, G₂, H₁₁, H₂₂, H₁₂ by control point, along axes of
    the rest surface that are orthonormal at each Gauss point."""
    rest: FloatArray
    """(b, points · 3 · LANES) curvatures B₁₁, B₂₂, B₁₂ at rest."""
    weights: FloatArray
    """(b, points · LANES) area at rest; 0 fills blocks."""
    material: int
    """Number of the material in the kernels `elements_stress_nb`."""
    numbers: FloatArray
    """(c,) coefficients of the material."""
    curves: Curves
    """Curves of the material."""
    tangent: FloatArray
    """(4,) or (0,): see `Coefficients`."""
    bending: FloatArray
    """(4,) D₁₁₁₁, D₂₂₂₂, D₁₁₂₂, D₁₂₁₂ of moments m = D κ; not used with layers."""
    layers: FloatArray
    """(l, 2) height and share of the thickness of each layer; (0, 2) if n and m follow from the
    middle surface alone."""
    sums: BlockSums


@pass_by_pointer
class SlopeTables(NamedTuple):
    """Points of edges where springs hold the slope to a neighbour, or to a plane of symmetry."""

    nodes: IntArray
    """(n, k) control points of both sides, two rows from the edge on; one side is padded."""
    basis: FloatArray
    """(n, 5, k) derivatives: S_u and S_v of the first side, of the second, and along the edge."""
    plane: FloatArray
    """(n, 3) normal of the plane of symmetry; zero at the joint of two elements."""
    rest: FloatArray
    """(n, 2) cosine and sine of the angle between both normals at rest; for a plane a₃·n and 0."""
    stiffness: FloatArray
    """(n,) moment by radian, times the length of edge at rest of the point."""
    nudge: FloatArray
    """(n,) displacement of control points for finite differences, length."""


@pass_by_pointer
class SlopeOutput(NamedTuple):
    """Output of springs between slopes."""

    partial: FloatArray
    """(n · k, 3) forces on control points."""
    energy: FloatArray
    """(n,)."""


@pass_by_pointer
class Motion(NamedTuple):
    """Positions and velocities of the degrees of freedom at the end of a step."""

    points: FloatArray
    """(m, 3)."""
    velocities: FloatArray
    """(m, 3)."""
    step: float
    """Time since the state of the memory `old`."""
    pressures: FloatArray
    """(m,) λ (J − 1) averaged at nodes; (0,) without averages."""


@pass_by_pointer
class Memory(NamedTuple):
    """Memory of the materials of elements, columns one after the other in each block."""

    old: FloatArray
    """(b, c · LANES) at the start of the step."""
    new: FloatArray
    """(b, c · LANES) at its end."""


@pass_by_pointer
class ElementOutput(NamedTuple):
    """Output of elements."""

    partial: FloatArray
    """(r, 3) forces on nodes of blocks."""
    energy: FloatArray
    """(b, 4) strain, hourglass, viscosity, hysteresis of blocks; (b, 4 + LANES) with the stored
    energy of each element."""
    inverted: IntArray
    """(b,) number of elements of each block that are inside out."""
