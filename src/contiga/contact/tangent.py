"""Derivatives of the forces of a step: what Newton's method in an implicit code asks for.

A step is a function of where the slave's points and the master are at its end; the state before it
stays as it is, with all that laws and friction remember. Of a point with the normal n and the force
F(λ, λ̇) the derivative is n dFᵀ + F H, with H = dn/dp of the foot (`contiga.search.slopes`), and so
K = −k (n nᵀ + g H) of a spring. Rates are changes over the step: dλ̇ = dλ/Δt. What is common to
several points, as one force that they share, couples them: Σ_j L_i R_jᵀ beside the blocks.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga.arrays.layout import as_numbers
from contiga.arrays.threads import run_ranges
from contiga.contact.kernels import tangent_nb
from contiga.contact.respond import ContactRows
from contiga.contact.state import State
from contiga.errors import InputError
from contiga.laws.friction import Friction
from contiga.laws.law import Law
from contiga.masters.protocol import Surface
from contiga.records import (
    DepthSlopes,
    FloatArray,
    FootSlopes,
    IntArray,
    LawInput,
    LawOutput,
    LawTangent,
    Projection,
)
from contiga.slaves.sampling import Sampling

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# Points below which a second thread does not pay.
POINTS = 2048


class StepInputs(NamedTuple):
    """What laws were handed in the step that has made a state."""

    points: ContactRows
    """That carry forces."""
    law: LawInput


class NormalTangent(NamedTuple):
    """The forces of k points and their slopes, as the kernel reads them."""

    force: FloatArray
    """(k,)."""
    own: FloatArray
    """(k,) ∂F/∂λ."""
    rate: FloatArray
    """(k,) ∂F/∂λ̇."""
    dt: float
    """Length of the step; infinite where it has none, and no rates."""
    grown: FloatArray
    """(k, 3) the gradient of each force over its own point, filled in."""


class PointTangent(NamedTuple):
    """Derivatives of the forces on k points over their places: blocks, and what couples them.

    dF_i = blocks_i dx_i + left_i Σ_j right_jᵀ dx_j.
    """

    rows: IntArray
    """(k,) the points, ascending."""
    blocks: FloatArray
    """(k, 3, 3)."""
    left: FloatArray
    """(k, 3, r), with the next."""
    right: FloatArray


def point_tangent(
    surface: Surface,
    law: Law,
    friction: Friction | None,
    state: State,
    half: FloatArray | None,
    inputs: StepInputs,
) -> PointTangent:
    """Derivatives of the forces on the points that carry, body axes.

    `half` (m,) is half the thickness of shells at all points.

    Raises
    ------
    InputError
        Law or friction has no derivatives, or not one row a point.
    """
    points = inputs.points
    if friction is not None:
        raise InputError(
            "the friction has no slopes",
            where="friction",
            found=type(friction).__name__,
            allowed="a friction with slopes(FrictionInput) -> FrictionSlopes",
        )
    slopes = _foot_slopes(surface, state, points, half)
    output, tangent = _law_tangent(law, inputs.law)
    k, dt = len(points.rows), inputs.law.dt
    rate = np.zeros(k) if tangent.rate is None else tangent.rate
    normal = NormalTangent(
        output.force, tangent.force.own, rate, dt if dt > 0.0 else np.inf, np.empty((k, 3))
    )
    blocks = np.empty((k, 3, 3))
    run_ranges(tangent_nb.normal_blocks, k, POINTS, points, slopes, normal, blocks)
    left = right = np.zeros((k, 3, 0))
    if tangent.force.left is not None and tangent.force.right is not None:
        left = points.normal[:, :, None] * tangent.force.left[:, None, :]
        right = slopes.depth[:, :, None] * tangent.force.right[:, None, :]
    return PointTangent(points.rows, blocks, left, right)


def in_world(tangent: PointTangent, pose: FloatArray) -> PointTangent:
    """The same in world axes."""
    blocks = np.empty(tangent.blocks.shape)
    run_ranges(tangent_nb.to_world, len(blocks), POINTS, tangent.blocks, pose, blocks)
    turn = pose[:3, :3]
    left, right = (
        np.einsum("ab,kbr->kar", turn, side, optimize=False)
        for side in (tangent.left, tangent.right)
    )
    return PointTangent(tangent.rows, blocks, left, right)


def matrix_of(tangent: PointTangent, sampling: Sampling) -> csr_array:
    """(3 n, 3 n) of the n nodes of a slave, three rows each.

    Between nodes x_q = Σ_a N_qa x_a and F_a = Σ_q N_qa F_q: so it is Nᵀ K N of that of the points.
    """
    from scipy.sparse import csr_array, eye_array, kron

    rows, n = tangent.rows, sampling.n_nodes
    if sampling.first:
        k = len(rows)
        shapes = csr_array(kron(sampling.shape_functions(rows), eye_array(3)))
        points = _matrix(tangent._replace(rows=np.arange(k, dtype=np.int32)), k)
        return csr_array(shapes.T @ points @ shapes)
    return _matrix(tangent, n)


def _matrix(tangent: PointTangent, n: int) -> csr_array:
    """(3 n, 3 n) of n points, three rows each."""
    from scipy.sparse import csr_array

    rows = tangent.rows
    k = len(rows)
    data, indices = np.empty(9 * k), np.empty(9 * k, np.int32)
    run_ranges(tangent_nb.block_rows, k, POINTS, rows, tangent.blocks, data, indices)
    count = np.zeros(3 * n + 1, np.int32)
    for a in range(3):
        count[3 * rows + a + 1] = 3
    matrix = csr_array((data, indices, np.cumsum(count, dtype=np.int32)), shape=(3 * n, 3 * n))
    if tangent.left.shape[2] == 0:
        return matrix
    left, right = (_columns(rows, side, n) for side in (tangent.left, tangent.right))
    return csr_array(matrix + left @ right.T)


def _columns(rows: IntArray, values: FloatArray, n: int) -> csr_array:
    """(3 n, r) sparse, of `values` (k, 3, r) at points `rows`."""
    from scipy.sparse import csr_array

    r = values.shape[2]
    places = (3 * rows[:, None] + np.arange(3)).ravel()
    flat = values.reshape(-1, r)
    at, column = np.nonzero(flat)
    return csr_array((flat[at, column], (places[at], column)), shape=(3 * n, r))


def _foot_slopes(
    surface: Surface, state: State, points: ContactRows, half: FloatArray | None
) -> FootSlopes:
    """Derivatives of depth and normal of the points; of shells at feet on the body itself."""
    rows = points.rows
    k = len(rows)
    p_B, foot, normal = state.points_B[rows], points.foot, points.normal
    beside = np.einsum("ki,ki->k", p_B - foot, normal, optimize=False)
    gap = np.where(points.depth > 0.0, -points.depth, beside)
    out_of_reach = gap > 0.0
    if half is not None:
        off = half[rows]
        foot, gap = foot - off[:, None] * normal, gap + off
    feet = Projection(
        state.patch[rows],
        state.uv[rows],
        np.ascontiguousarray(foot),
        np.ascontiguousarray(normal),
        gap,
        state.feature[rows],
        np.zeros(k, np.int8),
        np.zeros(k, np.int8),
    )
    slopes = FootSlopes(np.zeros((k, 3)), np.zeros((k, 3, 3)))
    if k:
        surface.slopes(p_B, feet, slopes)
    slopes.depth[out_of_reach] = 0.0
    return slopes


def _law_tangent(law: Law, inp: LawInput) -> tuple[LawOutput, LawTangent]:
    """What the law answers where its derivatives are asked for, and these, checked.

    Raises
    ------
    InputError
        It answers none, or not one row a point.
    """
    n = len(inp.penetration)
    if n == 0:
        none = np.zeros(0)
        return LawOutput(none, none, none, np.zeros((0, 0))), LawTangent(DepthSlopes(none))
    output = law.respond(inp._replace(wants_tangent=True))
    tangent = output.tangent
    if tangent is None:
        raise InputError(
            "the law has no tangent",
            where="law",
            found=type(law).__name__,
            allowed="a law whose LawOutput has one where LawInput.wants_tangent is true",
            remedy="Answer LawOutput(…, tangent=slopes), (n,) of each force over its penetration, "
            "or a LawTangent where forces depend on rates or on other points",
        )
    if not isinstance(tangent, LawTangent):
        tangent = LawTangent(DepthSlopes(tangent))
    return output, LawTangent(
        _checked_slopes(tangent.force, n, "force"),
        None if tangent.rate is None else _checked(tangent.rate, (n,), "rate"),
        None if tangent.stiffness is None else _checked_slopes(tangent.stiffness, n, "stiffness"),
    )


def _checked_slopes(slopes: DepthSlopes, n: int, name: str) -> DepthSlopes:
    own = _checked(slopes.own, (n,), f"{name}.own")
    if slopes.left is None or slopes.right is None:
        return DepthSlopes(own)
    r = np.shape(slopes.left)[-1] if np.ndim(slopes.left) == 2 else 1
    sides = (("left", slopes.left), ("right", slopes.right))
    left, right = (_checked(side, (n, r), f"{name}.{at}") for at, side in sides)
    return DepthSlopes(own, left, right)


def _checked(values: object, shape: tuple[int, ...], name: str) -> FloatArray:
    where = f"law: tangent.{name}"
    numbers = as_numbers(values, where, "the law must answer numbers")
    if numbers.shape != shape:
        raise InputError(
            "the law must answer one row a point in contact",
            where=where,
            found=numbers.shape,
            allowed=str(shape),
        )
    return numbers
