"""Elements under even strains and rigid motions, and scenes turned: exact but for rounding."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

import contiga as cg
from contiga_validation.closed_forms.case import Answer, Cases, zero
from contiga_validation.closed_forms.foam import bricks
from contiga_validation.closed_forms.matter import GROUP
from contiga_validation.closed_forms.pictures import errors_over
from contiga_validation.engine.arrays import FloatArray, IntArray

CASES = Cases(GROUP)

EXACT = 1e-12
"""Error allowed of a force, over the largest force of the same strain at any node."""
STRAIN = np.array([[1.2, 0.1, 0.05], [-0.03, 0.95, 0.02], [0.1, 0.0, 1.1]])
"""Uniform deformation gradient."""
_TETRA = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
"""Six tetrahedra about a diagonal of a hexahedron."""
_TRIANGLES = ((0, 1, 2), (0, 2, 3))
"""Two triangles of its lower face."""
ELASTIC, RUBBER = (
    cg.materials.Elastic(young=3.0, poisson=0.3),
    cg.materials.NeoHooke(young=3.0, poisson=0.4),
)
SOLIDS = {
    "elastic": ELASTIC,
    "neo-Hooke": RUBBER,
    "foam": cg.materials.Foam(loading=np.array([[0.0, 0.0], [0.5, 0.4], [0.9, 4.0]]), tension=2.0),
}
MEMBRANES = {
    "elastic": ELASTIC,
    "neo-Hooke": RUBBER,
    "fabric": cg.materials.Fabric(
        warp=np.array(3.0),
        weft=np.array(2.0),
        shear=np.array(0.4),
        direction=np.array([1.0, 0.2, 0.0]),
    ),
}


class Patch(NamedTuple):
    """Distorted elements of one kind and material, assembled."""

    name: str
    matter: cg.matter.Assembled
    nodes: FloatArray
    is_inner: NDArray[np.bool_]
    """Mask (n,) of the nodes that are on no border."""


def patches() -> Iterator[Patch]:
    """Yield a patch of 3 × 3 (× 3) cells of each kind of element and material."""
    line = np.linspace(0.0, 1.0, 4)
    points, hexes = bricks((line, line, line))
    tets = np.concatenate([hexes[:, list(corners)] for corners in _TETRA])
    layer, below = bricks((line, line, np.array([0.0, 1.0])))
    flat, sheet = np.unique(
        np.stack([below[:, list(corners)] for corners in _TRIANGLES]), return_inverse=True
    )
    triangles = sheet.reshape(-1, 3).astype(np.int32)
    for name, material in SOLIDS.items():
        yield _distorted("hex8", name, points, hexes, material)
        yield _distorted("tet4", name, points, tets, material)
    for name, material in MEMBRANES.items():
        yield _distorted("tri3", name, layer[flat], triangles, material, 0.2)


def _distorted(
    kind: str,
    name: str,
    rest: FloatArray,
    elements: IntArray,
    material: Any,
    thickness: float | None = None,
) -> Patch:
    """Return a patch whose inner nodes are moved by up to 0.05, the same at each call.

    A flat patch stays flat. Membranes have a `thickness`.
    """
    nodes, is_extended = rest.copy(), np.ptp(rest, axis=0) > 0.0
    is_inner = ((nodes > 0.01) & (nodes < 0.99) | ~is_extended).all(axis=1)
    shift = np.random.default_rng(0).uniform(-0.05, 0.05, nodes.shape)
    nodes[is_inner] += np.where(is_extended, shift, 0.0)[is_inner]
    part = cg.matter.Part(
        kind=kind, elements=elements, material=material, density=1.0, thickness=thickness
    )
    return Patch(f"{kind}, {name}", cg.matter.assemble(nodes, [part]), nodes, is_inner)


def _forces(patch: Patch, q: FloatArray) -> FloatArray:
    """Return the internal forces (n, 3) on nodes at `q` (n, 3), without velocities."""
    return np.asarray(patch.matter.forces(patch.matter.start(), q, np.zeros_like(q), 0.0).force)


def rotation(angle: float) -> FloatArray:
    """Return the rotation matrix (3, 3) by `angle`, rad, about the axis (1, 2, −½)."""
    axis = np.array([1.0, 2.0, -0.5]) / np.sqrt(5.25)
    across = np.cross(np.eye(3), axis)
    return np.asarray(
        np.cos(angle) * np.eye(3)
        + (1.0 - np.cos(angle)) * np.outer(axis, axis)
        - np.sin(angle) * across
    )


def _uniform_strain_forces(patch: Patch) -> tuple[float, float]:
    """Return the largest force on an inner node and on any node, under the uniform strain."""
    force = np.abs(_forces(patch, patch.nodes @ STRAIN.T))
    return float(force[patch.is_inner].max()), float(force.max())


class ForceErrors(NamedTuple):
    """Errors (k,) of forces over angles, over the largest force of the uniform strain."""

    rigid: FloatArray
    """Largest force on a patch that is turned and moved without strain."""
    turned_error: FloatArray
    """Largest difference of forces on a strained patch, turned and moved, from turned forces."""


def _force_errors(patch: Patch, angles: FloatArray, size: float) -> ForceErrors:
    """Turn a patch by angles (k,), move it, and return the errors of its forces over `size`."""
    strained = patch.nodes @ STRAIN.T
    start_force = _forces(patch, strained)
    force_errors = np.empty((2, len(angles)))
    for k, angle in enumerate(angles):
        turn = rotation(float(angle))
        offset = 3.0 * np.sin(angle) * np.array([1.0, -2.0, 0.5])
        force_errors[0, k] = np.abs(_forces(patch, patch.nodes @ turn.T + offset)).max()
        force_errors[1, k] = np.abs(
            _forces(patch, strained @ turn.T + offset) - start_force @ turn.T
        ).max()
    return ForceErrors(*force_errors / size)


@CASES.add(
    "matter-patch",
    "Even strains, rigid motions and turned scenes",
    "Σ f = 0 inside,  f(R X + c) = 0,  f(R x + c) = R f(x)",
    "Three elements each way with nodes anywhere inside, of each kind and material: forces by "
    "the largest of an even strain of a fifth, at twelve turns and places.",
)
def _patch() -> Answer:
    angles = np.linspace(0.0, 2.0 * np.pi, 13)
    patch_error, errors_by_patch = 0.0, {}
    for patch in patches():
        inside, size = _uniform_strain_forces(patch)
        patch_error = max(patch_error, inside / size)
        errors_by_patch[patch.name] = _force_errors(patch, angles, size)
    checks = (
        zero("patch test: force on an inner node under an even strain", patch_error, EXACT),
        zero("rigid motions: force on any node",
             max(one.rigid.max() for one in errors_by_patch.values()), EXACT),
        zero("turned as a whole: force off the one turned along",
             max(one.turned_error.max() for one in errors_by_patch.values()), EXACT),
    )  # fmt: skip
    worst = {
        kind: np.max(
            [one.turned_error for name, one in errors_by_patch.items() if name.startswith(kind)],
            axis=0,
        )
        for kind in ("hex8", "tet4", "tri3")
    }
    draw = errors_over(
        ("angle", "force off the one turned along"),
        [(kind, angles, errors) for kind, errors in worst.items()],
    )
    return Answer(checks, draw)
