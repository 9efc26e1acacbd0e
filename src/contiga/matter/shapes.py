"""Elements at rest: gradients of their shape functions, volumes, and shares of their mass."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.records import FloatArray

FLAT = 1e-12
"""Of the volume or area that the longest edge would make: what is less is none."""


CUBE = np.array(
    [
        [-1.0, -1.0, -1.0], [1.0, -1.0, -1.0], [1.0, 1.0, -1.0], [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0],
    ]
)  # fmt: skip
"""Corners of a hexahedron in VTK's order."""
CUBE_FACES = (
    *((0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4)),
    *((3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)),
)
"""Its faces, seen from outside."""


class Shapes(NamedTuple):
    """n elements of one kind at rest."""

    gradients: FloatArray
    """(n, g) of the corners' shape functions; of linear simplices of all corners but the first."""
    measures: FloatArray
    """(n,) volume, area or length, below zero where an element is inside out."""
    shares: FloatArray
    """(n, k) of the measure that belongs to each corner."""
    sizes: FloatArray
    """(n,) longest edge."""


def tetrahedra(corners: FloatArray) -> Shapes:
    """Linear tetrahedra from their corners (n, 4, 3)."""
    edges = corners[:, 1:] - corners[:, :1]
    cofactors = np.stack(
        [np.cross(edges[:, (k + 1) % 3], edges[:, (k + 2) % 3]) for k in range(3)], 1
    )
    whole = np.sum(edges[:, 0] * cofactors[:, 0], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        gradients = cofactors / whole[:, None, None]
    shares = np.repeat(whole[:, None] / 24.0, 4, axis=1)
    return Shapes(gradients.reshape(-1, 9), whole / 6.0, shares, longest_edge(corners))


def hexahedra(corners: FloatArray) -> Shapes:
    """Trilinear hexahedra from their corners (n, 8, 3), with mean gradients ∫ ∇N dV / V.

    Gauss's rule of 2 × 2 × 2 points is exact for them. One whose map has no positive determinant
    at one of these points is inside out.
    """
    n = len(corners)
    gradients, shares = np.zeros((n, 8, 3)), np.zeros((n, 8))
    least = np.full(n, np.inf)
    for point in CUBE / np.sqrt(3.0):
        values, slopes = _trilinear(point)
        a, b, c = (np.einsum("eai,a->ei", corners, slopes[:, k]) for k in range(3))
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        whole = np.sum(a * cofactors[:, 0], axis=1)
        gradients += np.einsum("ak,eki->eai", slopes, cofactors)
        shares += whole[:, None] * values
        least = np.minimum(least, whole)
    volumes = shares.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        gradients /= volumes[:, None, None]
    volumes = np.where(least > 0.0, volumes, least)
    return Shapes(gradients.reshape(n, 24), volumes, shares, longest_edge(corners))


def measures(kind: str, corners: FloatArray) -> FloatArray:
    """Return volumes, areas or lengths (n,) of elements (n, k, 3).

    They are exact but for the sign and rounding.

    Raises
    ------
    InputError
        A kind that is not known here.
    """
    edges = np.ascontiguousarray(np.moveaxis(corners[:, 1:] - corners[:, :1], 0, 2))
    if kind == "bar2":
        return np.sqrt(_dot(edges[0], edges[0]))
    if kind == "tri3":
        normal = _cross(edges[0], edges[1])
        return 0.5 * np.sqrt(_dot(normal, normal))
    if kind == "tet4":
        return np.abs(_dot(edges[0], _cross(edges[1], edges[2]))) / 6.0
    if kind != "hex8":
        raise InputError(
            "no volume is known of elements of this kind",
            where="kind",
            found=kind,
            allowed="bar2, tri3, tet4, hex8",
        )
    # The sum over the faces of ∫ x·n dA / 3; of a bilinear face that is the mean of what its two
    # pairs of triangles have.
    corner = [np.zeros_like(edges[0]), *edges]
    whole = np.zeros(len(corners))
    for face in CUBE_FACES:
        a, b, c, d = (corner[k] for k in face)
        whole += _dot(a + b, _cross(c, d)) + _dot(a, _cross(b, c + d))
    return np.abs(whole) / 12.0


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return cross products (3, n) of vectors (3, n), in a third of the time of NumPy's."""
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _trilinear(point: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return shape functions (8,) of the cube −1 … 1 at a point, and their derivatives (8, 3)."""
    factors = 0.5 * (1.0 + CUBE * point)
    x, y, z = factors.T
    slopes = 0.5 * CUBE * np.stack([y * z, z * x, x * y], axis=1)
    return x * y * z, slopes


class HourglassModes(NamedTuple):
    """The modes ξη, ηζ, ζξ and ξηζ of n hexahedra at rest."""

    seen: FloatArray
    """(n, 4, 3) h_α·X."""
    vectors: FloatArray
    """(n, 4, 8) γ_α = h_α − Σ_j (h_α·X_j) B_j."""
    lengths: FloatArray
    """(n, 4) the longest of the element's sides along ξ, η, ζ that are in a mode."""


def hourglass_modes(corners: FloatArray, gradients: FloatArray) -> HourglassModes:
    """The hourglass modes of hexahedra (n, 8, 3) with mean gradients (n, 24)."""
    n = len(corners)
    x, y, z = CUBE.T
    modes = np.stack([x * y, y * z, z * x, x * y * z])
    seen = np.einsum("ma,eai->emi", modes, corners)
    vectors = modes - np.einsum("emi,eai->ema", seen, gradients.reshape(n, 8, 3))
    sides = np.einsum("aj,eai->eji", CUBE, corners) / 4.0
    a, b, c = np.sqrt(np.sum(sides * sides, axis=2)).T
    pairs = [np.maximum(a, b), np.maximum(b, c), np.maximum(c, a)]
    return HourglassModes(seen, vectors, np.stack([*pairs, np.maximum(pairs[0], c)], axis=1))


def triangles(corners: FloatArray, along: FloatArray | None = None) -> Shapes:
    """Linear triangles from their corners (n, 3, 3), in their own plane.

    Its first axis is the first edge, or `along` (n, 3) as it lies in the plane.
    """
    edges = corners[:, 1:] - corners[:, :1]
    normal = np.cross(edges[:, 0], edges[:, 1])
    double = np.sqrt(np.sum(normal * normal, axis=1))
    first = edges[:, 0] if along is None else along
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = normal / double[:, None]
        first = first - np.sum(first * normal, axis=1, keepdims=True) * normal
        first = first / np.sqrt(np.sum(first * first, axis=1, keepdims=True))
        axes = np.stack([first, np.cross(normal, first)], axis=1)
        flat = np.sum(edges[:, :, None, :] * axes[:, None, :, :], axis=-1)
        (a, b), (c, d) = flat[:, 0].T, flat[:, 1].T
        gradients = np.stack([d, -c, -b, a], axis=1) / double[:, None]
    shares = np.repeat(double[:, None] / 6.0, 3, axis=1)
    return Shapes(gradients, 0.5 * double, shares, longest_edge(corners))


def bars(corners: FloatArray) -> Shapes:
    """Bars from their ends (n, 2, 3); what stands for gradients is 1/length."""
    length = longest_edge(corners)
    with np.errstate(divide="ignore"):
        inverse = 1.0 / length[:, None]
    return Shapes(inverse, length, np.repeat(0.5 * length[:, None], 2, axis=1), length)


def longest_edge(corners: FloatArray) -> FloatArray:
    """Return the longest distance (n,) between two corners of elements (n, k, 3)."""
    ways = corners[:, :, None] - corners[:, None]
    return np.asarray(np.sqrt(np.max(np.sum(ways * ways, axis=-1), axis=(1, 2))))
