"""Elements at rest: gradients of their shape functions, volumes, and shares of their mass."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from contiga.errors import InputError
from contiga.records import FloatArray

FLAT = 1e-12
"""Volume or area, over that of a cube or square of the longest edge, that counts as zero."""


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
"""Faces of a hexahedron, counter-clockwise seen from outside."""


class Shapes(NamedTuple):
    """n elements of one kind at rest."""

    gradients: FloatArray
    """(n, g) of the corners' shape functions; for linear simplices without the first corner."""
    measures: FloatArray
    """(n,) volume, area or length, negative if an element is inside out."""
    shares: FloatArray
    """(n, k) parts of the measure that belong to each corner."""
    sizes: FloatArray
    """(n,) longest edge."""


def tetrahedra(corners: FloatArray) -> Shapes:
    """Return the shapes of linear tetrahedra (n, 4, 3); without volume gradients are not finite.

    Measures and shares of tetrahedra that are inside out are negative.
    """
    edges = corners[:, 1:] - corners[:, :1]
    cofactors = np.stack(
        [np.cross(edges[:, (k + 1) % 3], edges[:, (k + 2) % 3]) for k in range(3)], 1
    )
    determinants = np.sum(edges[:, 0] * cofactors[:, 0], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        gradients = cofactors / determinants[:, None, None]
    shares = np.repeat(determinants[:, None] / 24.0, 4, axis=1)
    return Shapes(gradients.reshape(-1, 9), determinants / 6.0, shares, longest_edge(corners))


def hexahedra(corners: FloatArray) -> Shapes:
    """Return the shapes of trilinear hexahedra (n, 8, 3), with mean gradients ∫ ∇N dV / V.

    Gauss's rule of 2 × 2 × 2 points is exact for them. A hexahedron whose determinant is not
    positive at one of these points counts as inside out: its measure is the least determinant.
    """
    n = len(corners)
    gradients, shares = np.zeros((n, 8, 3)), np.zeros((n, 8))
    least = np.full(n, np.inf)
    for point in CUBE / np.sqrt(3.0):
        # Trilinear shape functions (8,) of the cube −1 … 1, and their derivatives (8, 3).
        x, y, z = (0.5 * (1.0 + CUBE * point)).T
        values, slopes = x * y * z, 0.5 * CUBE * np.stack([y * z, z * x, x * y], axis=1)
        a, b, c = (np.einsum("eai,a->ei", corners, slopes[:, k]) for k in range(3))
        cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
        determinants = np.sum(a * cofactors[:, 0], axis=1)
        gradients += np.einsum("ak,eki->eai", slopes, cofactors)
        shares += determinants[:, None] * values
        least = np.minimum(least, determinants)
    volumes = shares.sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        gradients /= volumes[:, None, None]
    volumes = np.where(least > 0.0, volumes, least)
    return Shapes(gradients.reshape(n, 24), volumes, shares, longest_edge(corners))


def measures(kind: str, corners: FloatArray) -> FloatArray:
    """Return volumes, areas or lengths (n,) of elements (n, k, 3), in closed form and ≥ 0.

    `kind` is bar2, tri3, tet4 or hex8, with corners in VTK's order; the faces of a hexahedron are
    bilinear. Elements that are inside out count as positive; of a hexahedron that is inside out in
    part, that part is subtracted.

    Raises
    ------
    InputError
        An unknown kind.
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
    # The volume is the sum of ∫ x·n dA / 3 over the faces, for a bilinear face the mean of its two
    # divisions into triangles.
    corner = [np.zeros_like(edges[0]), *edges]
    total = np.zeros(len(corners))
    for face in CUBE_FACES:
        a, b, c, d = (corner[k] for k in face)
        total += _dot(a + b, _cross(c, d)) + _dot(a, _cross(b, c + d))
    return np.abs(total) / 12.0


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return cross products (3, n) of vectors (3, n), in a third of the time of `np.cross`."""
    return np.stack(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


class HourglassModes(NamedTuple):
    """The modes ξη, ηζ, ζξ and ξηζ of n hexahedra at rest."""

    at_rest: FloatArray
    """(n, 4, 3) h_α·X."""
    vectors: FloatArray
    """(n, 4, 8) γ_α = h_α − Σ_j (h_α·X_j) B_j."""
    lengths: FloatArray
    """(n, 4) longest of the element's sides along those of ξ, η, ζ that are in the mode."""


def hourglass_modes(corners: FloatArray, gradients: FloatArray) -> HourglassModes:
    """Return the hourglass modes of hexahedra (n, 8, 3) with mean gradients (n, 24) at rest."""
    n = len(corners)
    x, y, z = CUBE.T
    modes = np.stack([x * y, y * z, z * x, x * y * z])
    at_rest = np.einsum("ma,eai->emi", modes, corners)
    vectors = modes - np.einsum("emi,eai->ema", at_rest, gradients.reshape(n, 8, 3))
    sides = np.einsum("aj,eai->eji", CUBE, corners) / 4.0
    a, b, c = np.sqrt(np.sum(sides * sides, axis=2)).T
    pairs = [np.maximum(a, b), np.maximum(b, c), np.maximum(c, a)]
    return HourglassModes(at_rest, vectors, np.stack([*pairs, np.maximum(pairs[0], c)], axis=1))


def hourglass_springs(corners: FloatArray, shapes: Shapes, modulus: float) -> FloatArray:
    """Return hourglass springs (n, 24) of hexahedra with `corners` (n, 8, 3), rows of a table.

    They are h_α·X (12), the stiffnesses c (4) and row sums of these springs at the corners (8); see
    `solid_hex_nb`. A brick of side a that is bent along it by its mode ξη stores E V (2 q)²/(6 a²),
    its springs c V (8 q)²/2: they are as stiff as the material with c = E/(48 a²). For objectivity
    c is the same in all directions, with the longer of both sides, so that none is too stiff.
    """
    modes = hourglass_modes(corners, shapes.gradients)
    stiffness = modulus / (48.0 * modes.lengths**2)
    weighted = stiffness[:, :, None] * modes.vectors
    row_sums = np.abs(np.einsum("ema,emb->eab", weighted, modes.vectors)).sum(axis=2)
    row_sums *= shapes.measures[:, None]
    return np.concatenate([modes.at_rest.reshape(-1, 12), stiffness, row_sums], axis=1)


def triangles(corners: FloatArray, direction: FloatArray | None = None) -> Shapes:
    """Return the shapes of linear triangles with corners (n, 3, 3), in their planes.

    The first axis in a plane is the first edge, or the projection of `direction` (n, 3). Gradients
    are not finite without an area, or if the direction is across the plane.
    """
    edges = corners[:, 1:] - corners[:, :1]
    normal = np.cross(edges[:, 0], edges[:, 1])
    double_area = np.sqrt(np.sum(normal * normal, axis=1))
    first = edges[:, 0] if direction is None else direction
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = normal / double_area[:, None]
        first = first - np.sum(first * normal, axis=1, keepdims=True) * normal
        first = first / np.sqrt(np.sum(first * first, axis=1, keepdims=True))
        axes = np.stack([first, np.cross(normal, first)], axis=1)
        in_plane = np.sum(edges[:, :, None, :] * axes[:, None, :, :], axis=-1)
        (a, b), (c, d) = in_plane[:, 0].T, in_plane[:, 1].T
        gradients = np.stack([d, -c, -b, a], axis=1) / double_area[:, None]
    shares = np.repeat(double_area[:, None] / 6.0, 3, axis=1)
    return Shapes(gradients, 0.5 * double_area, shares, longest_edge(corners))


def bars(corners: FloatArray) -> Shapes:
    """Return the shapes of bars with ends (n, 2, 3); their gradients are 1/length."""
    length = longest_edge(corners)
    with np.errstate(divide="ignore"):
        inverse = 1.0 / length[:, None]
    return Shapes(inverse, length, np.repeat(0.5 * length[:, None], 2, axis=1), length)


def longest_edge(corners: FloatArray) -> FloatArray:
    """Return the longest distance (n,) between two corners of elements (n, k, 3)."""
    vectors = corners[:, :, None] - corners[:, None]
    return np.asarray(np.sqrt(np.max(np.sum(vectors * vectors, axis=-1), axis=(1, 2))))
