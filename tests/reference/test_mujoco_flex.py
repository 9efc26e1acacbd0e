"""A soft body at rest on a plane and on a ball: MuJoCo's flex beside `Settle`, on the same mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

import contiga as cg
from contiga.slaves.skin import CellBlock, skin

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.skipif(
    not hasattr(mujoco.mjtIntegrator, "mjINT_DISCRETE"),
    reason="flexes of older versions are not integrated implicitly",
)

YOUNG, POISSON, MASS, GRAVITY = 5e3, 0.3, 0.1, 9.81
LIGHT = 0.1 * GRAVITY
"""By which strains are so small that all laws of material are linear."""
NODES, LAYERS, SPACING = 5, 3, 0.015
TOP = 0.5 * SPACING * (LAYERS - 1)
SKIN = 1e-3
"""Radius by which MuJoCo's vertices and facets are thick."""
BALL, DEPTH = 0.05, 5e-3


@dataclass(frozen=True)
class Flex:
    """Its tetrahedra, where their vertices are at first, and where they come to rest."""

    rest: np.ndarray
    elements: np.ndarray
    settled: np.ndarray


def flex(
    ground: str, height: float, gravity: float, pinned: str = "", poisson: float = POISSON
) -> Flex:
    """A block that comes down on geometry by MuJoCo, half a second; contacts hardly give."""
    contact = 'condim="1" solref="0.002 1"'
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
    <option timestep="0.0005" gravity="0 0 {-gravity}" integrator="discrete" solver="CG"
      tolerance="1e-10"/>
    <worldbody><geom {ground} {contact}/><body name="block" pos="0 0 {height}">
    <flexcomp name="soft" type="grid" dim="3" count="{NODES} {NODES} {LAYERS}" mass="{MASS}"
      spacing="{SPACING} {SPACING} {SPACING}" radius="{SKIN}">
    <contact {contact} selfcollide="none" solimp=".99 .999 .0001"/>
    <elasticity young="{YOUNG}" poisson="{poisson}" damping="0.05"/>{pinned}
    </flexcomp></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    rest = data.flexvert_xpos.copy()
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert np.abs(data.qvel).max() < 1e-4
    return Flex(rest, model.flex_elem.reshape(-1, 4).copy(), data.flexvert_xpos.copy())


def ours(
    soft: Flex,
    body: cg.Body,
    gravity: float,
    *,
    mirrored: bool = False,
    poisson: float = POISSON,
) -> np.ndarray:
    """Its mesh and masses, at rest by contiga; or the mesh with its cells cut the other way."""
    elements = soft.elements
    if mirrored:
        place = {tuple(p): k for k, p in enumerate(np.rint(1e6 * soft.rest).astype(int).tolist())}
        other = np.rint(1e6 * soft.rest * [-1, 1, 1]).astype(int).tolist()
        elements = np.array([place[tuple(p)] for p in other])[elements]
    corners = soft.rest[elements]
    turned = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0.0
    elements = np.where(turned[:, None], elements[:, [0, 2, 1, 3]], elements)
    facets = skin(soft.rest, [CellBlock("tetra", elements.astype(np.int64))])
    rubber = cg.materials.Elastic(young=YOUNG, poisson=poisson)
    part = cg.matter.Part(kind="tet4", elements=elements, material=rubber, density=1.0)
    matter = cg.matter.assemble(soft.rest, [part], facets=facets)
    matter.mass = np.full(len(soft.rest), MASS / len(soft.rest))  # each the same, as MuJoCo has it
    slave = cg.Slave(soft.rest, facets, elements={"tetra": elements})
    law = cg.PenaltyLaw(1e7, per_area=True)
    top = np.isclose(soft.rest[:, 2], TOP) if gravity == 0.0 else None
    contact = cg.Contact(body, slave, law=law, quadrature=12, search="penetration")
    simulation = cg.Simulation(
        bodies={"ground": body},
        slaves={"soft": (slave, cg.motion.Deforming(material=matter, fixed=top))},
        contacts=[contact],
        gravity=[0.0, 0.0, -gravity],
        end=1.0,
        step="auto",
        settling=cg.Settle(tolerance=1e-4),
    )
    return simulation.settle().slaves["soft"].points


def by_hand(soft: Flex, poisson: float, gravity: float) -> np.ndarray:
    """Displacements of its tetrahedra by their weight, linear, its lowest layer held upright."""
    n, u = len(soft.rest), np.zeros(3 * len(soft.rest))
    shear = YOUNG / (2.0 * (1.0 + poisson))
    bulk = 2.0 * shear * poisson / (1.0 - 2.0 * poisson)
    stiffness = np.zeros((n, 3, n, 3))
    for corners in soft.elements:
        edges = (soft.rest[corners[1:]] - soft.rest[corners[0]]).T
        slopes = np.linalg.inv(edges)
        g = np.vstack([-slopes.sum(axis=0), slopes])
        alike = np.einsum("ak,bk,ij->aibj", g, g, np.eye(3)) + np.einsum("aj,bi->aibj", g, g)
        part = shear * alike + bulk * np.einsum("ai,bj->aibj", g, g)
        at = np.ix_(corners, range(3), corners, range(3))
        stiffness[at] += abs(np.linalg.det(edges)) / 6.0 * part
    free = np.ones((n, 3), bool)
    free[np.isclose(soft.rest[:, 2], soft.rest[:, 2].min()), 2] = False
    rows = np.flatnonzero(free)
    weight = np.tile([0.0, 0.0, -gravity * MASS / n], n)[rows]
    matrix = stiffness.reshape(3 * n, 3 * n)[np.ix_(rows, rows)]
    # Free to slide as a whole and to turn: the shortest solution of those.
    u[rows] = np.linalg.lstsq(matrix, weight, rcond=1e-10)[0]
    return u.reshape(-1, 3)


def moved(soft: Flex, points: np.ndarray) -> np.ndarray:
    """Displacements, without those as a whole along a plane without friction, or into it."""
    low = np.isclose(soft.rest[:, 2], soft.rest[:, 2].min())
    way = points - soft.rest
    return way - np.append(way[:, :2].mean(axis=0), way[low, 2].mean())


def test_a_block_rests_on_a_plane_as_mujocos_does() -> None:
    soft = flex('type="plane" size="1 1 .1"', TOP + SKIN, GRAVITY)
    plane = cg.Body([cg.shapes.plane(width=1.0, length=1.0, centre=(0.0, 0.0, SKIN))])
    theirs = moved(soft, soft.settled)
    mine, cut = (
        moved(soft, ours(soft, plane, GRAVITY, mirrored=mirrored)) for mirrored in (False, True)
    )
    high = np.isclose(soft.rest[:, 2], soft.rest[:, 2].max())
    assert theirs[high, 2].mean() == pytest.approx(-9e-4, rel=0.05)
    assert mine[high, 2].mean() == pytest.approx(theirs[high, 2].mean(), rel=0.1)
    # What the mesh is worth: the same block, its cells cut along other diagonals.
    assert np.abs(mine - theirs).max() < 0.5 * np.abs(mine - cut).max()


@pytest.mark.parametrize(("poisson", "apart"), [(0.0, 0.01), (POISSON, 0.1)])
def test_a_light_block_rests_as_linear_elements_do(poisson: float, apart: float) -> None:
    """MuJoCo's does, too, without Poisson's effect; with it its block sinks 6 % less."""
    soft = flex('type="plane" size="1 1 .1"', TOP + SKIN, LIGHT, poisson=poisson)
    plane = cg.Body([cg.shapes.plane(width=1.0, length=1.0, centre=(0.0, 0.0, SKIN))])
    high = np.isclose(soft.rest[:, 2], soft.rest[:, 2].max())
    linear = by_hand(soft, poisson, LIGHT)[high, 2].mean()
    mine = moved(soft, ours(soft, plane, LIGHT, poisson=poisson))[high, 2].mean()
    assert mine == pytest.approx(linear, rel=1e-3)
    assert moved(soft, soft.settled)[high, 2].mean() == pytest.approx(linear, rel=apart)


def test_a_block_is_pressed_on_a_ball_as_mujocos_is() -> None:
    centre = -TOP - BALL - SKIN + DEPTH
    last = f"{NODES - 1} {NODES - 1} {LAYERS - 1}"
    soft = flex(
        f'type="sphere" size="{BALL}" pos="0 0 {centre}"', 0.0, 0.0,
        f'<pin gridrange="0 0 {LAYERS - 1} {last}"/>',
    )  # fmt: skip
    ball = cg.Body([cg.shapes.sphere(radius=BALL + SKIN, centre=(0.0, 0.0, centre))])
    theirs = soft.settled - soft.rest
    mine, cut = (ours(soft, ball, 0.0, mirrored=mirrored) - soft.rest for mirrored in (False, True))
    assert theirs[:, 2].max() > 0.9 * DEPTH
    assert mine[:, 2].max() == pytest.approx(theirs[:, 2].max(), rel=0.1)
    assert np.abs(mine - theirs).max() < np.abs(mine - cut).max() < 0.2 * np.abs(theirs).max()
