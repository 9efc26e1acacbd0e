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
    inner: NDArray[np.bool_]
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
    nodes, wide = rest.copy(), np.ptp(rest, axis=0) > 0.0
    inner = ((nodes > 0.01) & (nodes < 0.99) | ~wide).all(axis=1)
    shift = np.random.default_rng(0).uniform(-0.05, 0.05, nodes.shape)
    nodes[inner] += np.where(wide, shift, 0.0)[inner]
    part = cg.matter.Part(
        kind=kind, elements=elements, material=material, density=1.0, thickness=thickness
    )
    return Patch(f"{kind}, {name}", cg.matter.assemble(nodes, [part]), nodes, inner)


def _forces(patch: Patch, q: FloatArray) -> FloatArray:
    """Return the internal forces (n, 3) on nodes at `q` (n, 3), without velocities."""
    return np.asarray(patch.matter.forces(patch.matter.start(), q, np.zeros_like(q), 0.0).force)


def turned(angle: float) -> FloatArray:
    """Return the rotation matrix (3, 3) by `angle`, rad, about the axis (1, 2, −½)."""
    axis = np.array([1.0, 2.0, -0.5]) / np.sqrt(5.25)
    across = np.cross(np.eye(3), axis)
    return np.asarray(
        np.cos(angle) * np.eye(3)
        + (1.0 - np.cos(angle)) * np.outer(axis, axis)
        - np.sin(angle) * across
    )


def _even(patch: Patch) -> tuple[float, float]:
    """Return the largest force on an inner node and on any node, under the uniform strain."""
    force = np.abs(_forces(patch, patch.nodes @ STRAIN.T))
    return float(force[patch.inner].max()), float(force.max())


class Missed(NamedTuple):
    """Errors (k,) of forces over angles, over the largest force of the uniform strain."""

    rigid: FloatArray
    """Largest force on a patch that is turned and moved without strain."""
    carried: FloatArray
    """Largest difference of forces on a strained patch, turned and moved, from turned forces."""


def _turned(patch: Patch, angles: FloatArray, size: float) -> Missed:
    """Turn a patch by angles (k,), move it, and return the errors of its forces over `size`."""
    strained = patch.nodes @ STRAIN.T
    still = _forces(patch, strained)
    missed = np.empty((2, len(angles)))
    for k, angle in enumerate(angles):
        turn = turned(float(angle))
        away = 3.0 * np.sin(angle) * np.array([1.0, -2.0, 0.5])
        missed[0, k] = np.abs(_forces(patch, patch.nodes @ turn.T + away)).max()
        missed[1, k] = np.abs(_forces(patch, strained @ turn.T + away) - still @ turn.T).max()
    return Missed(*missed / size)


@CASES.add(
    "matter-patch",
    "Even strains, rigid motions and turned scenes",
    "Σ f = 0 inside,  f(R X + c) = 0,  f(R x + c) = R f(x)",
    "Three elements each way with nodes anywhere inside, of each kind and material: forces by "
    "the largest of an even strain of a fifth, at twelve turns and places.",
)
def _patch() -> Answer:
    angles = np.linspace(0.0, 2.0 * np.pi, 13)
    uneven, found = 0.0, {}
    for patch in patches():
        inside, size = _even(patch)
        uneven = max(uneven, inside / size)
        found[patch.name] = _turned(patch, angles, size)
    checks = (
        zero("patch test: force on an inner node under an even strain", uneven, EXACT),
        zero("rigid motions: force on any node",
             max(one.rigid.max() for one in found.values()), EXACT),
        zero("turned as a whole: force off the one turned along",
             max(one.carried.max() for one in found.values()), EXACT),
    )  # fmt: skip
    worst = {
        kind: np.max([one.carried for name, one in found.items() if name.startswith(kind)], axis=0)
        for kind in ("hex8", "tet4", "tri3")
    }
    draw = errors_over(
        ("angle", "force off the one turned along"),
        [(kind, angles, errors) for kind, errors in worst.items()],
    )
    return Answer(checks, draw)
