"""Internal forces of 10⁵ elements, by element and thread, and beside scikit-fem's assembly.

`python -m benchmarks matter`. Both assemble the same residual of neo-Hooke's tetrahedra, and agree.
"""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np

import contiga as cg
from benchmarks.rivals import missing
from benchmarks.timing import in_turns, on_threads
from contiga.matter import Assembled, Part, assemble

SIDE = 26  # 6 · 26³ = 105,456 tetrahedra
ROUNDS = 15
RUBBER = cg.materials.NeoHooke(young=3.0, poisson=0.4)
SOFT = cg.materials.NeoHooke(young=3.0, poisson=0.499, volume="nodes")
STEEL = cg.materials.Elastic(young=3.0, poisson=0.3)
PAD = cg.materials.Foam(loading=[[0, 0], [0.05, 0.1], [0.6, 0.2], [0.9, 3.0]], hysteresis=0.1)
CLOTH = cg.materials.Fabric(warp=3.0, shear=0.3, direction=[1.0, 0.0, 0.0])


def run(side: int = SIDE) -> list[str]:
    """The lines of the table."""
    q, elements = cube(side)
    square, triangles = sheet(8 * side)
    cells = corners(2 * side)
    matters = {
        "tet4 neo-Hooke": solid("tet4", q, elements, RUBBER),
        "tet4 neo-Hooke, averaged": solid("tet4", q, elements, SOFT),
        "tet4 elastic": solid("tet4", q, elements, STEEL),
        "hex8 neo-Hooke": solid("hex8", nodes_of(2 * side), cells, RUBBER),
        "hex8 foam": solid("hex8", nodes_of(2 * side), cells, PAD),
        "tri3 elastic": membrane(square, triangles, STEEL),
        "tri3 fabric": membrane(square, triangles, CLOTH),
    }
    works = {name: asked(matter) for name, matter in matters.items()}
    times = []
    for threads in (1, 2):
        with on_threads(threads):
            times.append(in_turns(works, ROUNDS))
    with on_threads(1):  # what else the machine does is not counted
        alone = in_turns(works, ROUNDS, process_time)
    lines = []
    for name, matter in matters.items():
        one, two = (found[name] for found in times)
        n = sum(len(group.elements) for group in matter.groups)
        lines.append(
            f"{name:26s} {n:8d} elements {1e9 * alone[name] / n:7.1f} ns each on one thread, "
            f"{one / two:5.2f} times as fast on two"
        )
    return [*lines, *beside_scikit_fem(matters["tet4 neo-Hooke"])]


def nodes_of(side: int) -> np.ndarray:
    """Nodes of a grid in the unit cube."""
    x = np.linspace(0.0, 1.0, side + 1)
    return np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)


def corners(side: int) -> np.ndarray:
    """Hexahedra of that grid."""
    i = np.arange((side + 1) ** 3).reshape((side + 1,) * 3)
    low, high = slice(None, -1), slice(1, None)
    ring = ((low, low), (high, low), (high, high), (low, high))
    return np.stack([i[a, b, c].ravel() for c in (low, high) for a, b in ring], axis=1)


def cube(side: int) -> tuple[np.ndarray, np.ndarray]:
    """The grid's nodes, and six tetrahedra in each of its cells."""
    cuts = (0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)
    return nodes_of(side), corners(side)[:, np.array(cuts)].reshape(-1, 4)


def sheet(side: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and triangles of a square."""
    x = np.linspace(0.0, 1.0, side + 1)
    u, v = np.meshgrid(x, x, indexing="ij")
    i = np.arange(u.size).reshape(u.shape)
    a, b, c, d = (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:])
    halves = [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    nodes = np.stack([u.ravel(), v.ravel(), np.zeros(u.size)], axis=1)
    return nodes, np.stack(halves, axis=1).reshape(-1, 3)


def solid(kind: str, nodes: np.ndarray, elements: np.ndarray, material: Any) -> Assembled:
    """Matter of one part."""
    return assemble(nodes, [Part(kind=kind, elements=elements, material=material, density=1.0)])


def membrane(nodes: np.ndarray, elements: np.ndarray, material: Any) -> Assembled:
    """The same of a membrane."""
    part = Part(kind="tri3", elements=elements, material=material, density=1.0, thickness=0.1)
    return assemble(nodes, [part])


def bent(nodes: np.ndarray) -> np.ndarray:
    """Nodes somewhat elsewhere."""
    return np.asarray(nodes + 0.02 * np.sin(5.0 * nodes[:, [1, 2, 0]]))


def asked(matter: Assembled) -> Callable[[int], Any]:
    """A work that asks for the forces."""
    q = bent(matter.nodes)
    state, v = matter.start(), np.zeros_like(q)
    return lambda _: matter.forces(state, q, v, 0.0)


def beside_scikit_fem(matter: Assembled) -> list[str]:
    """The same forces by scikit-fem, and how much longer they take."""
    absent = missing("skfem")
    if absent is not None:
        return [f"beside scikit-fem: not measured: {absent}"]
    rival = scikit_fem(matter)
    forces = matter.forces(matter.start(), bent(matter.nodes), np.zeros_like(matter.nodes), 0.0)
    difference = np.abs(rival(0) - forces.force).max() / np.abs(forces.force).max()
    with on_threads(1):
        times = in_turns({"ours": asked(matter), "theirs": rival}, 5, process_time)
    return [
        f"scikit-fem's assembly takes {times['theirs'] / times['ours']:.0f} times as long as one "
        f"thread; forces differ by {difference:.0e} of the largest"
    ]


def scikit_fem(matter: Assembled) -> Callable[[int], np.ndarray]:
    """Its assembly of the residual of neo-Hooke's tetrahedra, as forces (n, 3)."""
    import skfem
    from skfem.helpers import ddot, det, grad, inv, transpose

    mesh = skfem.MeshTet(matter.nodes.T.copy(), matter.groups[0].elements.T.copy())
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTetP1()), intorder=1)
    mu, lam = matter.groups[0].tables.numbers
    moved = np.zeros(basis.N)
    moved[basis.nodal_dofs] = (bent(matter.nodes) - matter.nodes).T

    @skfem.LinearForm  # type: ignore[untyped-decorator]
    def residual(v: Any, w: Any) -> Any:
        f = grad(w["u"]) + np.eye(3)[:, :, None, None]
        j, inverse = det(f), transpose(inv(f))
        return ddot(mu * (f - inverse) + lam * (j - 1.0) * j * inverse, grad(v))

    def assembled(_: int) -> np.ndarray:
        found = residual.assemble(basis, u=basis.interpolate(moved))
        return np.asarray(-found[basis.nodal_dofs].T)

    return assembled
