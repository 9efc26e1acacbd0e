"""A shell of splines as the master of free masses: a closed system keeps what such a one keeps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from scipy.sparse import block_array, eye_array
from scipy.sparse.linalg import spsolve

import contiga as cg
from contiga.laws.friction import Friction
from contiga.matter.iga import Symmetry, assemble_shell


class Drift(NamedTuple):
    """Largest departures in a run, of what is kept."""

    energy: float
    """As a share of the energy at the start."""
    momentum: float
    moment: float
    touched: int
    """Most points in contact."""


def falling_masses(dt: float, friction: Friction | None) -> Drift:
    """81 masses fall on a free plate of splines, sideways as well; velocity Verlet."""
    parts = [k / 4 for k in range(1, 4)]
    plate = cg.shapes.plane(width=100.0, length=100.0).k_refined((1, 1), parts, parts)
    steel = cg.materials.Elastic(young=2000.0, poisson=0.3)
    shell = assemble_shell([plate], material=steel, density=1e-3, thickness=1.0)
    master, M = cg.Body([plate]), shell.mass[:, None]
    np.testing.assert_array_equal(master.net.points, shell.net.points)
    grid = np.stack(np.meshgrid(*[np.linspace(-14.0, 14.0, 9)] * 2), axis=-1).reshape(-1, 2)
    x, m = np.column_stack([grid, np.full(81, 1.2)]), np.full((81, 1), 30.0 / 81)
    contact = cg.Contact(
        master,
        cg.Slave(x, area=np.full(81, 10.0)),
        law=cg.PenaltyLaw(20.0),
        shell_thickness=1.0,
        friction=friction,
    )
    v, q = np.tile([0.5, 0.0, -2.0], (81, 1)), shell.net.points.copy()
    w = np.zeros_like(q)
    inner, state = shell.forces(shell.start(), q, w, dt), contact.start(x, control_points=q)
    energies, kept, touched = [], [], 0
    for k in range(round(1.5 / dt) + 1):
        if k:
            v += 0.5 * dt * state.force / m
            w += 0.5 * dt * (inner.force + state.control_force) / M
            x, q = x + dt * v, q + dt * w
            state = contact.step(state, x, dt=dt, control_points=q)
            inner = shell.forces(inner.state, q, w, dt)
            v += 0.5 * dt * state.force / m
            w += 0.5 * dt * (inner.force + state.control_force) / M
        kinetic = 0.5 * (m * v**2).sum() + 0.5 * (M * w**2).sum()
        lost = state.energy.stored + state.energy.friction
        energies.append(kinetic + inner.energy.strain + lost)
        moment = np.cross(x, m * v).sum(axis=0) + np.cross(q, M * w).sum(axis=0)
        kept.append(np.concatenate([(m * v).sum(axis=0) + (M * w).sum(axis=0), moment]))
        touched = max(touched, state.n_contact)
    drift = np.abs(np.array(kept) - kept[0]).max(axis=0)
    energy = np.abs(np.array(energies) - energies[0]).max() / energies[0]
    return Drift(energy, drift[:3].max(), drift[3:].max(), touched)


@pytest.mark.parametrize(
    "friction", [None, cg.Coulomb(0.3, stiffness=5.0)], ids=["smooth", "rough"]
)
def test_energy_is_kept_with_order_two_and_momentum_and_moment_to_rounding(
    friction: Friction | None,
) -> None:
    coarse, fine = (falling_masses(dt, friction) for dt in (0.004, 0.002))
    assert coarse.touched == fine.touched == 81
    assert coarse.energy < 5e-4
    assert 3.0 < coarse.energy / fine.energy < 6.0
    assert max(coarse.momentum, fine.momentum) < 1e-12  # of 60 g mm/ms
    assert max(coarse.moment, fine.moment) < 1e-10  # of 6,000 g mm²/ms


@pytest.mark.parametrize(
    "friction", [None, cg.Coulomb(0.3), cg.Coulomb(5.0)], ids=["smooth", "slips", "sticks"]
)
def test_newtons_method_solves_for_points_and_control_points_together(
    friction: cg.Coulomb | None,
) -> None:
    """Points on springs press a clamped shell, the master, and go over it; both are unknown."""
    parts = [k / 4 for k in range(1, 4)]
    plate = cg.shapes.plane(width=20.0, length=20.0).k_refined((1, 1), parts, parts)
    steel = cg.materials.Elastic(young=2000.0, poisson=0.3)
    clamps = [Symmetry(edge) for edge in ("u0", "u1", "v0", "v1")]
    shell = assemble_shell([plate], material=steel, density=1e-3, thickness=1.0, symmetry=clamps)
    free = np.ones(shell.net.points.shape, bool)
    for edge in ("u0", "u1", "v0", "v1"):
        free[shell.net.edge(edge)] = False
    grid = np.stack(np.meshgrid(*[np.linspace(-4.0, 4.0, 5)] * 2), axis=-1).reshape(-1, 2)
    anchors, spring = np.column_stack([grid, np.full(25, 0.5)]), 3.0
    slave, law = cg.Slave(anchors, area=np.ones(25)), cg.PenaltyLaw(50.0)
    how = {"law": law, "shell_thickness": 1.0, "depth": 0.5, "friction": friction}
    contact = cg.Contact(cg.Body([plate]), slave, **how)
    x, now, runs = np.add(anchors, [0.0, 0.0, 0.05]), shell.start(), []
    state = contact.start(x, control_points=now.points)
    n, alive = x.size, np.concatenate([np.ones(x.size, bool), free.ravel()])
    for place in ([0.0, 0.0, -0.2], [0.1, 0.05, -0.4], [0.5, 0.2, -0.6], [1.0, 0.5, -0.8]):
        residuals: list[float] = []
        while len(residuals) < 20:
            after = contact.step(state, x, dt=0, control_points=now.points)
            inside = shell.forces(now, now.points, 0.0 * now.points, 0.0)
            on_points = after.force - spring * (x - anchors - place)
            both = np.concatenate([on_points, inside.force + after.control_force]).ravel()
            residuals.append(np.abs(both[alive]).max())
            if residuals[-1] < 1e-9:
                break
            slopes = contact.linearise(after)
            K = block_array(
                [
                    [spring * eye_array(n) - slopes.force_by_points, -slopes.force_by_control],
                    [-slopes.control_by_points, shell.tangent(now) - slopes.control_by_control],
                ]
            ).tocsr()
            way = np.zeros(len(both))
            way[alive] = spsolve(K[alive][:, alive].tocsc(), both[alive])
            x = x + way[:n].reshape(x.shape)
            now = now._replace(points=now.points + way[n:].reshape(now.points.shape))
        state = after
        runs.append(residuals)
    assert max(len(one) - 1 for one in runs) <= 6, runs
    assert all(one[-2] < one[-3] ** 2 for one in runs), runs
    assert state.n_contact > 10
    assert now.points[:, 2].min() < -0.05
    np.testing.assert_allclose(
        state.control_force.sum(axis=0), -state.force.sum(axis=0), atol=1e-12
    )
    if friction is not None:
        pull = np.linalg.norm(state.friction, axis=1) / state.normal_force
        slips = friction.static < 1.0
        assert np.allclose(pull, 0.3) if slips else (np.abs(pull - 1.8) < 0.3).all()
