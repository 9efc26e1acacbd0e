"""Masters that change their shape, touched by points without a thickness.

A shape that only moves is a rigid body: whatever its control points do, contact must find what it
finds on that body under a pose. A closed one has an inside. A thin shell keeps energy.
"""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.stress.deforming import breathing, closest, twisting
from tests.unit.geometry.test_net import brick
from tests.unit.search.holed import holed_plate

import contiga as cg
from contiga.matter.iga import assemble_shell

BODIES: dict[str, Callable[[], cg.Body]] = {
    "ball": lambda: cg.Body([cg.shapes.sphere(radius=1.0)]),
    "torus": lambda: cg.Body([cg.shapes.torus(major=3.0, minor=1.0)]),
    "box": brick,
    "plane": lambda: cg.Body([cg.shapes.plane(width=2.0, length=2.0)]),
    "bumps": lambda: cg.Body([cg.shapes.bumpy_plate(waves=2)]),
    "holed": holed_plate,
}


def scaled(body: cg.Body, by: float) -> cg.Body:
    return cg.Body([patch.scaled(by) for patch in body.patches], trims=body.trims)


def moved_both_ways(
    body: cg.Body, search: str, *, turn: float, steps: int, n: int = 400
) -> tuple[int, int]:
    """Points in contact in all steps, and how many of them differ between a body that goes by its
    pose and one whose control points go."""
    rest, size, rng = body.net.points, body.size, np.random.default_rng(5)
    low, high = body.bounds()
    points = rng.uniform(low - 0.1 * size, high + 0.1 * size, (n, 3))
    velocity = 0.01 * size * rng.standard_normal((n, 3))
    stiff, soft = (
        cg.Contact(body, cg.Slave(points, area=np.ones(n)), law=cg.PenaltyLaw(1.0), search=search)
        for _ in range(2)
    )
    state, shaped = stiff.start(points), soft.start(points, control_points=rest)
    pose, seen, differ = np.eye(4), 0, 0
    for _ in range(steps):
        velocity += 0.003 * size * rng.standard_normal((n, 3))
        points = points + velocity
        R = Rotation.from_rotvec(turn * rng.standard_normal(3)).as_matrix() @ pose[:3, :3]
        pose[:3, :3], pose[:3, 3] = R, pose[:3, 3] + 0.01 * size * rng.standard_normal(3)
        state = stiff.step(state, points, pose, dt=1.0)
        shaped = soft.step(shaped, points, dt=1.0, control_points=rest @ R.T + pose[:3, 3])
        off = np.abs(state.penetration - shaped.penetration) > 1e-7 * size
        off |= np.abs(state.force - shaped.force).max(axis=1) > 1e-7 * size
        seen += int((state.in_contact | shaped.in_contact).sum())
        differ += int((off | (state.in_contact != shaped.in_contact)).sum())
    return seen, differ


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("search", ["intersection", "penetration"])
@pytest.mark.parametrize("turn", [0.0, 5e-4])
def test_a_shape_that_moves_stiffly_is_a_rigid_body(name: str, search: str, turn: float) -> None:
    seen, differ = moved_both_ways(BODIES[name](), search, turn=turn, steps=8)
    assert seen > 30
    assert differ == 0


def test_a_wall_that_holds_a_point_past_the_middle_turns_with_the_shape() -> None:
    """The opposite wall is nearer, and would push it on: what tells so has to turn, too."""
    body = brick()  # 1 by 2 by 3
    point, rest = np.array([[-0.1, 1.0, 1.5]]), body.net.points
    contact = cg.Contact(body, cg.Slave(point, area=[1.0]), law=cg.PenaltyLaw(1.0))
    state = contact.start(point, control_points=rest)
    for _ in range(8):
        point = point + np.array([0.1, 0.0, 0.0])
        state = contact.step(state, point, dt=1.0, control_points=rest)
    for angle in np.linspace(0.0, np.pi, 40):
        turn = Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix().T
        state = contact.step(state, point @ turn, dt=1.0, control_points=rest @ turn)
        np.testing.assert_allclose(state.penetration, [0.7], rtol=0, atol=1e-12)


@pytest.mark.parametrize("by", [1e-6, 1e6])
def test_so_it_is_at_any_size(by: float) -> None:
    for name in ("ball", "bumps"):
        seen, differ = moved_both_ways(
            scaled(BODIES[name](), by), "intersection", turn=0.0, steps=6, n=200
        )
        assert seen > 20
        assert differ == 0


@pytest.mark.parametrize("move", [breathing, twisting])
@pytest.mark.parametrize("steps", [50, 200, pytest.param(1600, marks=pytest.mark.full)])
def test_points_of_a_closed_shape_are_in_contact_where_they_have_come_in(
    move: Callable[[np.ndarray, float], np.ndarray], steps: int
) -> None:
    """Free points at first outside; at the end all that are inside are in contact, as deep as the
    surface is far, and none that are not. So it is in few steps and in many."""
    body = cg.Body([cg.shapes.torus(major=1.5, minor=0.5)])
    patch, rest, rng = body.patches[0], body.net.points, np.random.default_rng(7)
    points = rng.uniform(-2.3, 2.3, (400, 3)) * [1.0, 1.0, 0.4]
    points = points[~body.contains(points)][:60]
    ends = points + rng.uniform(-0.3, 0.3, points.shape)
    contact = cg.Contact(body, cg.Slave(points, area=np.ones(60)), law=cg.PenaltyLaw(1.0))
    state = contact.start(points, control_points=move(rest, 0.0))
    for k in range(1, steps + 1):
        share = k / steps
        net, x = move(rest, 0.8 * share), points + share * (ends - points)
        state = contact.step(state, x, dt=1.0, control_points=net)
    shape = cg.NurbsSurface(patch.degrees, patch.knots, net[body.net.control[0]], patch.weights)
    inside = cg.Body([shape]).contains(x)
    np.testing.assert_array_equal(state.in_contact, inside)
    assert 3 < inside.sum() < 55
    true = closest([shape], x[inside]).distance
    nearest = np.abs(state.penetration[inside] - true) < 1e-7
    # Of the others a wall opposite to the one they came in by has come nearer since.
    assert nearest.mean() > 0.9
    assert (state.penetration[inside][~nearest] > true[~nearest]).all()


def fallen_masses(dt: float) -> tuple[float, float, int]:
    """81 masses fall on a thin plate of splines; largest departures of energy, as a share of that
    at the start, and of momentum; most points in contact."""
    parts = [k / 4 for k in range(1, 4)]
    plate = cg.shapes.plane(width=100.0, length=100.0).k_refined((1, 1), parts, parts)
    steel = cg.materials.Elastic(young=2000.0, poisson=0.3)
    shell = assemble_shell([plate], material=steel, density=1e-3, thickness=1.0)
    grid = np.stack(np.meshgrid(*[np.linspace(-14.0, 14.0, 9)] * 2), axis=-1).reshape(-1, 2)
    x, m = np.column_stack([grid, np.full(81, 0.7)]), np.full((81, 1), 30.0 / 81)
    slave = cg.Slave(x, area=np.full(81, 10.0))
    contact = cg.Contact(cg.Body([plate]), slave, law=cg.PenaltyLaw(20.0))
    v, q = np.tile([0.5, 0.0, -2.0], (81, 1)), shell.net.points.copy()
    w, M = np.zeros_like(q), shell.mass[:, None]
    inner, state = shell.forces(shell.start(), q, w, dt), contact.start(x, control_points=q)
    energies, momenta, touched = [], [], 0
    for _ in range(round(1.5 / dt)):
        v += 0.5 * dt * state.force / m
        w += 0.5 * dt * (inner.force + state.control_force) / M
        x, q = x + dt * v, q + dt * w
        state = contact.step(state, x, dt=dt, control_points=q)
        inner = shell.forces(inner.state, q, w, dt)
        v += 0.5 * dt * state.force / m
        w += 0.5 * dt * (inner.force + state.control_force) / M
        kinetic = 0.5 * (m * v**2).sum() + 0.5 * (M * w**2).sum()
        energies.append(kinetic + inner.energy.strain + state.energy.stored)
        momenta.append((m * v).sum(axis=0) + (M * w).sum(axis=0))
        touched = max(touched, state.n_contact)
    begun = 0.5 * 30.0 * 4.25
    energy = np.abs(np.array(energies) - begun).max() / begun
    return energy, np.abs(np.array(momenta) - momenta[0]).max(), touched


def test_a_thin_shell_keeps_energy_with_order_two_and_momentum_to_rounding() -> None:
    (coarse, one, touched), (fine, other, again) = (fallen_masses(dt) for dt in (0.004, 0.002))
    assert touched == again == 81
    assert coarse < 2e-3
    assert 3.0 < coarse / fine < 6.0
    assert max(one, other) < 1e-12  # of 60 g mm/ms


def test_a_new_shape_each_step_does_not_fill_memory() -> None:
    """A shape that is kept takes twice the bound."""
    body = cg.Body([cg.shapes.sphere(radius=1.0)])
    points = np.random.default_rng(0).normal(size=(50, 3))
    points *= 1.1 / np.linalg.norm(points, axis=1)[:, None]
    contact = cg.Contact(body, cg.Slave(points, area=np.ones(50)), law=cg.PenaltyLaw(1.0))
    state = contact.start(points, control_points=body.net.points)
    sizes, touched = [], 0
    tracemalloc.start()
    try:
        for k in range(1, 91):
            net = body.net.points * (1.0 + 0.2 * np.sin(0.1 * k))
            state = contact.step(state, points, dt=0.1, control_points=net)
            touched = max(touched, state.n_contact)
            if k % 30 == 0:
                gc.collect()
                sizes.append(tracemalloc.get_traced_memory()[0])
    finally:
        tracemalloc.stop()
    assert touched == 50
    assert max(sizes[1:]) - sizes[0] < 1_000_000
