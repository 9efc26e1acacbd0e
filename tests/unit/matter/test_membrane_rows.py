"""Row sums of membranes against the eigenvalues of their stiffness, in all kinds of states."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from tests.unit.matter import rig

from contiga.materials import Elastic, Fabric, NeoHooke
from contiga.matter import Assembled
from contiga.matter.coefficients import Material

pytestmark = pytest.mark.interpreted

LOOP = {
    "warp": [[0, 0], [0.1, 0.4], [0.4, 3.0]],
    "warp_unloading": [[0, 0], [0.2, 0.1], [0.4, 2.0]],
    "hysteresis_slope": 15.0,
}
MATERIALS: dict[str, Material] = {
    "elastic": Elastic(young=3.0, poisson=0.3),
    "tension field": Elastic(young=3.0, poisson=0.3, compression=False),
    "tension field that thickens": Elastic(young=3.0, poisson=-0.5, compression=False),
    "rubber": NeoHooke(young=3.0, poisson=0.45),
    "fabric": Fabric(
        **LOOP, weft=2.0, shear=[[0, 0], [0.1, 0.05], [0.5, 0.4]], direction=[1, 0, 0]
    ),
    "stuffed fabric": Fabric(warp=3.0, shear=0.3, direction=[1, 1, 0], compression=0.5),
}
STATES = {
    "at rest": [[1.0, 0.0], [0.0, 1.0]],
    "stretched": [[1.4, 0.0], [0.0, 1.2]],
    "along a line": [[1.3, 0.0], [0.0, 0.7]],
    "folded along a line": [[1.05, 0.0], [0.0, 0.2]],
    "pressed": [[0.8, 0.0], [0.0, 0.9]],
    "sheared": [[1.1, 0.5], [0.0, 1.0]],
    "sheared and pressed": [[0.9, -0.4], [0.1, 0.8]],
}
NODES = rig.moved(rig.grid((3, 3, 0)), 0.05) * [1.0, 1.0, 0.0]


EXACT = "elastic", "rubber"
"""What has its own tangent; others have one that bounds theirs."""


def taken_to(nodes: np.ndarray, state: str, apart: float) -> np.ndarray:
    """Nodes in a state, pushed about and turned in space."""
    flat = np.zeros_like(nodes)
    flat[:, :2] = nodes[:, :2] @ np.transpose(STATES[state])
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    return np.asarray(rig.moved(flat, apart, seed=2) @ turn.T)


def made(nodes: np.ndarray, elements: np.ndarray, name: str) -> Assembled:
    """A membrane of a material."""
    return rig.one_part("tri3", nodes, elements, MATERIALS[name], thickness=0.3)


def fastest(matter: Assembled, q: np.ndarray) -> float:
    """The largest eigenvalue of the stiffness over the masses: ω²."""
    stiffness = rig.tangent(matter, q)
    masses = np.diag(np.repeat(matter.mass, 3))
    return float(eigh(0.5 * (stiffness + stiffness.T), masses)[0][-1])


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", MATERIALS)
def test_they_are_above_the_largest_eigenvalue(name: str, state: str) -> None:
    matter = made(NODES, rig.sheet(3, 3), name)
    for apart in (0.0, 0.03):
        q = taken_to(NODES, state, apart)
        told = matter.stiffness(matter.start()._replace(points=q))
        assert np.max(told / matter.mass) >= fastest(matter, q)


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", MATERIALS)
def test_of_one_element_too_and_those_with_their_own_tangent_are_exact(
    name: str, state: str
) -> None:
    matter = made(NODES[[0, 1, 5]], np.array([[0, 1, 2]]), name)
    q = taken_to(matter.nodes, state, 0.01)
    told = matter.stiffness(matter.start()._replace(points=q))
    assert np.max(told / matter.mass) >= fastest(matter, q)
    if name in EXACT:
        exact = np.abs(rig.tangent(matter, q)).sum(axis=1).reshape(-1, 3).max(axis=1)
        np.testing.assert_allclose(told, exact, rtol=1e-6)
