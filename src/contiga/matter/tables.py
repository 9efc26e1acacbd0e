"""Tables of elements for kernels: records of arrays, made once."""

from __future__ import annotations

from typing import NamedTuple

from contiga.curves.curve_records import Curves
from contiga.pointer_records import pass_by_pointer
from contiga.records import FloatArray, IntArray


@pass_by_pointer
class BlockSums(NamedTuple):
    """Lanes that a block adds up at each of its nodes."""

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
    """Number of the material in the kernels `elements_stress_nb`."""
    numbers: FloatArray
    """(c,) coefficients of the material."""
    curves: Curves
    """Curves of the material."""
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
    """(4,) D₁₁₁₁, D₂₂₂₂, D₁₁₂₂, D₁₂₁₂ of moments m = D κ; not used where there are layers."""
    layers: FloatArray
    """(l, 2) height and share of the thickness of each layer; (0, 2) where n and m are asked for
    at the middle surface alone."""
    sums: BlockSums


@pass_by_pointer
class SlopeTables(NamedTuple):
    """Points of edges where a shell keeps its slope to a neighbour, or to a plane of symmetry."""

    nodes: IntArray
    """(n, k) control points of both sides, two rows from the edge on; those of one fill rows up."""
    basis: FloatArray
    """(n, 5, k) derivatives: S_u and S_v of the first side, of the second, and along the edge."""
    plane: FloatArray
    """(n, 3) normal of the plane of symmetry; zero where two elements meet."""
    rest: FloatArray
    """(n, 2) cosine and sine of the angle between both normals at rest; of a plane a₃·n and 0."""
    stiffness: FloatArray
    """(n,) moment by radian, times the length of edge at rest that the point stands for."""
    nudge: FloatArray
    """(n,) length by which control points are moved for differences."""


@pass_by_pointer
class SlopeOutput(NamedTuple):
    """Output of the points that keep slopes."""

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
    """Time since the memory `old` was written."""
    pressures: FloatArray
    """(m,) λ (J − 1) averaged at nodes; (0,) where nothing is averaged."""


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
    """(b, 4) strain, hourglass, viscosity, hysteresis of blocks; (b, 4 + LANES) where what each
    element stores is asked for, too."""
    inverted: IntArray
    """(b,) number of elements of a block that have turned inside out."""
