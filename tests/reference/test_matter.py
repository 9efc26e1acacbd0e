"""Matter against closed forms and published benchmarks, on meshes that are refined."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import eigh, solve
from tests.unit.matter import rig

from contiga.errors import ElementError
from contiga.materials import Elastic, Fabric, Foam, NeoHooke
from contiga.matter import Assembled


def cook(nodes: np.ndarray) -> np.ndarray:
    """Nodes of a unit square as Cook's panel: 48 wide, 44 high at the left, 16 at the right."""
    x, y = nodes[:, 0], nodes[:, 1]
    low, high = 44.0 * x, 44.0 + 16.0 * x
    return np.stack([48.0 * x, low + (high - low) * y, nodes[:, 2]], axis=1)


def tangent_of(matter: Assembled, q: np.ndarray, free: np.ndarray, h: float = 1e-6) -> np.ndarray:
    """Stiffness of some degrees of freedom, by differences of forces."""
    columns = []
    for k in free:
        way = np.zeros(q.size)
        way[k] = h
        way = way.reshape(q.shape)
        columns.append(
            (rig.still(matter, q - way)[0] - rig.still(matter, q + way)[0]).ravel()[free]
        )
    return np.stack(columns, axis=1) / (2.0 * h)


def settled(matter: Assembled, free: np.ndarray, load: np.ndarray, parts: int) -> np.ndarray:
    """Nodes at rest under a load that is put on in parts, by Newton's method."""
    q = matter.nodes.copy()
    for part in range(1, parts + 1):
        for _ in range(20):
            miss = (rig.still(matter, q)[0] + load * part / parts).ravel()[free]
            if np.abs(miss).max() < 1e-7 * np.abs(load).max():
                break
            step = np.zeros(q.size)
            step[free] = solve(tangent_of(matter, q, free), miss)
            q = _moved(matter, q, step.reshape(q.shape))
        else:
            raise AssertionError("does not come to rest")
    return q


def _moved(matter: Assembled, q: np.ndarray, step: np.ndarray) -> np.ndarray:
    """q and a step, or so much of it that no element turns inside out."""
    share = 1.0
    while True:
        try:
            rig.still(matter, q + share * step)
        except ElementError:
            share *= 0.5
        else:
            return q + share * step


def panel(n: int, tip: float, material: Elastic | NeoHooke, kind: str, parts: int) -> np.ndarray:
    """How far the middle and the top of the right side of Cook's panel go up under a load there."""
    if kind == "tri3":
        nodes, elements, more = cook(rig.grid((n, n, 0))), rig.sheet(n, n), {"thickness": 1.0}
    else:
        nodes, more = cook(rig.grid((n, n, 1))), {}
        elements = rig.tets((n, n, 1)) if kind == "tet4" else rig.hexes((n, n, 1))
        if kind == "tet4" and np.linalg.det(nodes[elements[0, 1:]] - nodes[elements[0, 0]]) < 0.0:
            elements = elements[:, [0, 2, 1, 3]]
    matter = rig.one_part(kind, nodes, elements, material, **more)
    right = np.isclose(nodes[:, 0], 48.0)
    share = np.where(np.isin(nodes[:, 1], [44.0, 60.0]), 0.5, 1.0) * right
    load = np.zeros_like(nodes)
    load[:, 1] = tip * share / share.sum()
    moves = np.ones_like(nodes, bool)
    moves[:, 2] = False
    moves[nodes[:, 0] == 0.0] = False
    q = settled(matter, np.flatnonzero(moves), load, parts)
    up = (q - nodes)[:, 1]
    middle = right & np.isclose(nodes[:, 1], 52.0)
    return np.array([up[middle].mean(), up[right & np.isclose(nodes[:, 1], 60.0)].mean()])


def test_cooks_panel_in_plane_stress() -> None:
    """E = 1, ν = 1/3, F = 1 (here small, as the truth is linear): 23.965 at (48, 52)."""
    small = 1e-4
    found = [
        panel(n, small, Elastic(young=1.0, poisson=1.0 / 3.0), "tri3", 1)[0] / small
        for n in (4, 8, 16)
    ]
    errors = np.abs(np.array(found) / 23.965 - 1.0)
    assert errors[2] < 0.11
    assert errors[0] > 1.8 * errors[1] > 4.5 * errors[2]


RUBBER = {"young": 240.565, "poisson": 0.4999}


def test_cooks_panel_that_keeps_its_volume() -> None:
    """E = 240.565, ν = 0.4999, F = 100 in plane strain: 7.671 in the middle of its end, 8.039 on
    top, in linear theory, so under a hundredth of the load here."""
    scale = 1.0 / 30.0
    truth = np.array([7.671, 8.039])
    found = [panel(n, 100.0 * scale, NeoHooke(**RUBBER), "hex8", 1) / scale for n in (2, 6)]
    errors = [np.abs(up / truth - 1.0) for up in found]
    assert (errors[1] < 0.05).all()
    assert (errors[1] < 0.6 * errors[0]).all()


def test_tetrahedra_lock_less_where_they_average_their_volume() -> None:
    """The same panel: element by element it moves by a quarter of what it should."""
    averaged, locked = (
        panel(6, 100.0 / 30.0, NeoHooke(**RUBBER, volume=volume), "tet4", 1)[0] * 30.0
        for volume in ("nodes", "element")
    )
    assert locked < 2.2
    assert 1.6 * locked < averaged < 7.671


def test_the_first_frequency_of_a_cantilever() -> None:
    """1.8751²/2π √(E I/(ρ A L⁴)) of a slender beam of hexahedra, as they are refined."""
    length, height, young, density = 10.0, 0.5, 3.0, 2.0  # the rig's density
    exact = 1.8751040687**2 * math.sqrt(young * height**2 / 12.0 / density / length**4)
    found = []
    for n in (10, 30):
        counts = (n, n // 10, 1)
        nodes = rig.grid(counts, (length, height, height))
        hexes = rig.hexes(counts)
        matter = rig.one_part("hex8", nodes, hexes, Elastic(young=young))
        moves = np.ones_like(nodes, bool)
        moves[:, 2] = False
        moves[nodes[:, 0] == 0.0] = False
        free = np.flatnonzero(moves)
        stiff = tangent_of(matter, nodes, free)
        mass = np.repeat(matter.mass, 3)[free]
        square = eigh(0.5 * (stiff + stiff.T), np.diag(mass), subset_by_index=[0, 0])[0][0]
        found.append(math.sqrt(square) / exact)
    assert abs(found[1] - 1.0) < 0.01
    assert abs(found[1] - 1.0) < 0.5 * abs(found[0] - 1.0)


def test_the_first_frequency_of_a_drum() -> None:
    """2.404826 √(N/(ρ t))/a of a round membrane that is stretched evenly."""
    young, nu, strain, thickness, density = 5.0, 0.3, 1e-3, 0.1, 2.0  # the rig's density
    tension = young * thickness * strain / (1.0 - nu)
    exact = 2.404825558 * math.sqrt(tension / (density * thickness))
    found = []
    for n in (6, 12):
        nodes, facets = disc(n)
        matter = rig.one_part(
            "tri3", nodes, facets, Elastic(young=young, poisson=nu), thickness=thickness
        )
        q = nodes * math.sqrt(1.0 + 2.0 * strain)
        inner = np.flatnonzero(np.hypot(nodes[:, 0], nodes[:, 1]) < 1.0 - 1e-9)
        free = 3 * inner + 2
        stiff = tangent_of(matter, q, free)
        square = eigh(0.5 * (stiff + stiff.T), np.diag(matter.mass[inner]), subset_by_index=[0, 0])
        found.append(math.sqrt(square[0][0]) / exact)
    assert abs(found[1] - 1.0) < 0.005
    assert abs(found[1] - 1.0) < 0.35 * abs(found[0] - 1.0)


def swung(matter: Assembled, q: np.ndarray, steps: int, end: float) -> float:
    """The largest error of the energy of what swings from q, over what there was at the start."""
    dt, v, mass = end / steps, np.zeros_like(q), matter.mass[:, None]
    answer = matter.forces(matter.start(), q, v, 0.0)
    first = answer.energy.strain + answer.energy.hourglass
    worst, lost = 0.0, 0.0
    for _ in range(steps):
        v = v + 0.5 * dt * answer.force / mass
        q = q + dt * v
        answer = matter.forces(answer.state, q, v, dt)
        v = v + 0.5 * dt * answer.force / mass
        energy = answer.energy
        lost += energy.viscosity + energy.hysteresis
        total = energy.strain + energy.hourglass + lost + 0.5 * np.sum(mass * v * v)
        worst = max(worst, abs(total / first - 1.0))
    return worst


FOAM = Foam(loading=[[0, 0], [0.9, 2.0]], hysteresis=0.3, shape=2.0)
WOVEN = Fabric(warp=2.0, weft=3.0, shear=0.5, direction=[1.0, 0.3, 0.0], compression=1.0)


@pytest.mark.parametrize(
    ("kind", "material"),
    [
        ("tet4", NeoHooke(young=3.0, poisson=0.45, volume="nodes")),
        ("hex8", NeoHooke(young=3.0, poisson=0.3)),
        ("hex8", FOAM),
        ("tri3", WOVEN),
    ],
)
def test_the_balance_of_energy_closes_with_the_square_of_the_step(
    kind: str, material: NeoHooke | Foam | Fabric
) -> None:
    if kind == "tri3":
        nodes, elements, more = rig.grid((2, 2, 0)), rig.sheet(2, 2), {"thickness": 0.1}
    else:
        nodes, more = rig.grid((2, 2, 1)), {}
        elements = rig.tets((2, 2, 1)) if kind == "tet4" else rig.hexes((2, 2, 1))
    matter = rig.one_part(kind, nodes, elements, material, **more)
    q = rig.moved(nodes * [0.9, 1.05, 1.02], 0.01)
    step = 2.0 * math.sqrt(np.min(matter.mass / matter.stiffness(matter.start())))
    end = 60.0 * step
    errors = [swung(matter, q, n, end) for n in (240, 480)]
    assert errors[1] < 4e-3
    assert errors[0] > 3.0 * errors[1]


def disc(n: int) -> tuple[np.ndarray, np.ndarray]:
    """A round mesh of radius one in n rings: 6 k nodes on ring k."""
    nodes, facets, start = [np.zeros((1, 3))], [], [0]
    for k in range(1, n + 1):
        angle = 2.0 * np.pi * np.arange(6 * k) / (6 * k)
        ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1) * k / n
        start.append(start[-1] + len(nodes[-1]))
        nodes.append(ring)
        for side in range(6):
            for i in range(k):
                a, b = side * k + i, (side * k + i + 1) % (6 * k)
                c = side * (k - 1) + i
                inner = [start[k - 1] + c % max(6 * (k - 1), 1)]
                facets.append([start[k] + a, start[k] + b, inner[0]])
                if i + 1 < k:
                    other = start[k - 1] + (c + 1) % (6 * (k - 1))
                    facets.append([start[k] + b, other, inner[0]])
    return np.concatenate(nodes), np.array(facets)
