"""Implicit codes that solve with the tangent of a contact: iterations, closed forms, gradients."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from examples import iron_membrane, press_shell

import contiga as cg

EXAMPLES = Path(__file__).parents[2] / "examples"
NAMES = ("iron_membrane", "press_shell", "hertz_scikit_fem", "rubber_felupe", "throw_jax")
MOST = 6
"""Iterations of a load step."""


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_short(name: str) -> None:
    assert len((EXAMPLES / f"{name}.py").read_text(encoding="utf-8").splitlines()) <= 80


def is_quadratic(residuals: list[float], size: float) -> bool:
    """Whether the last step within its range squares the residual, or does better, over `size`."""
    before, after = residuals[-3:-1]
    return after / size < 100.0 * (before / size) ** 2


def radius_of(state: cg.State, at: np.ndarray) -> float:
    """Of a contact, by the second moment of Hertz's pressure: ∫ p r² dA = 2/5 F a²."""
    return float(np.sqrt(2.5 * state.force[:, 2] @ (at**2).sum(axis=1) / state.force[:, 2].sum()))


def taut(along: float, above: float) -> np.ndarray:
    """Force (x, z) on a roller whose axis is there, of a membrane that is one straight strip.

    It is plane strain: three straight parts, of which that in the middle lies on the roller, which
    the spring of the law makes thinner by the penetration T/(R k).
    """
    module = iron_membrane
    side = 0.5 * module.STRETCH * module.WIDTH + np.array([along, -along])
    radius = outer = module.RADIUS + 0.5 * module.THICK
    for _ in range(20):
        far = np.hypot(side, above)
        angle = np.arcsin(radius / far) - np.arctan2(above, side)
        straight = np.sqrt(far**2 - radius**2)
        stretch = (straight.sum() + radius * angle.sum()) / module.WIDTH
        modulus = module.YOUNG / (1.0 - module.POISSON**2)
        pull = module.THICK * modulus * 0.5 * (stretch**2 - 1.0) * stretch
        radius = outer - pull * stretch / (radius * module.STIFFNESS)
    return module.LENGTH * pull * np.array([np.cos(angle) @ [-1.0, 1.0], np.sin(angle).sum()])


@pytest.mark.parametrize(("size", "down", "along"), [(6.0, 3, 0), (6.0, 10, 20)])
def test_ironing_takes_few_iterations_and_ends_quadratically(
    size: float, down: int, along: int
) -> None:
    steps = iron_membrane.iron(size, down, along)
    assert len(steps) == down + along
    assert max(len(step.residuals) - 1 for step in steps) <= MOST
    assert all(is_quadratic(step.residuals, 1.0) for step in steps)


def test_the_roller_feels_a_taut_strip() -> None:
    steps = iron_membrane.iron(down=10, along=4)
    top = iron_membrane.RADIUS + 0.5 * iron_membrane.THICK
    wanted = [taut(max(0, k - 10), top - min(k, 10)) for k in range(1, 15)]
    found = np.array([step.wrench[[0, 2]] for step in steps])
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=0.01 * np.max(wanted))


def test_a_pressed_shell_ends_quadratically_and_takes_the_work_of_the_roller() -> None:
    """∫ F dδ by the trapezium rule, whose error falls with the square of the load step."""
    missed = []
    for step in (0.5, 0.25):
        _, steps = press_shell.press((8, 4), down=2.0, step=step)
        assert len(steps) == 2.0 / step
        assert max(len(one.residuals) - 1 for one in steps) <= 8
        assert all(is_quadratic(one.residuals, 10.0) for one in steps)
        force = np.array([0.0, *(one.force for one in steps)])
        missed.append(steps[-1].energy - step * (force[1:] + force[:-1]).sum() / 2.0)
    assert abs(missed[1]) < 3e-3 * steps[-1].energy
    assert missed[0] / missed[1] == pytest.approx(4.0, rel=0.2)


def test_a_sphere_on_a_block_of_scikit_fem_is_hertz_within_the_order_of_the_mesh() -> None:
    pytest.importorskip("skfem")
    from examples import hertz_scikit_fem as hertz

    error = []
    for n in (32, 64):
        state, residuals = hertz.press(n)
        assert len(residuals) - 1 <= MOST
        radius = radius_of(state, state.points_B[:, :1])
        error.append(abs([-state.total_force[2] / hertz.FORCE, radius / hertz.RADIUS] - np.ones(2)))
    assert (error[0] < 0.015).all()
    assert error[1][0] < error[0][0] / 2.0
    assert (error[1] < 0.006).all()


def test_a_punch_on_rubber_of_felupe_is_hertz_while_it_is_small() -> None:
    pytest.importorskip("felupe")
    from examples import rubber_felupe as rubber

    depths = [0.25, 0.5, 0.75, 1.0]
    young = 9.0 * rubber.BULK * rubber.SHEAR / (3.0 * rubber.BULK + rubber.SHEAR)
    modulus = young / (1.0 - (0.5 * young / rubber.SHEAR - 1.0) ** 2)
    for depth, (state, residuals) in zip(depths, rubber.press(10, depths), strict=True):
        assert len(residuals) <= MOST
        wanted = np.sqrt(rubber.BALL * depth)
        assert radius_of(state, state.points_B[:, :2]) == pytest.approx(wanted, rel=0.1)
        force = 4.0 / 3.0 * modulus * wanted * depth
        assert -4.0 * state.total_force[2] == pytest.approx(force, rel=0.05)


def test_jax_differentiates_a_throw_through_its_bounce() -> None:
    """In a process of its own: JAX has threads, and other tests fork theirs."""
    if find_spec("jax") is None:
        pytest.skip("jax is not installed")
    thrown = f"from {__name__} import throw; throw()"
    subprocess.run([sys.executable, "-c", thrown], cwd=EXAMPLES.parent, check=True)


def throw() -> None:
    """Check the gradients of a throw, and that it is aimed by them."""
    from examples import throw_jax as throw
    from jax import jacfwd, jacrev

    start = throw.VELOCITY
    backward, forward = jacrev(throw.miss)(start), jacfwd(throw.miss)(start)
    np.testing.assert_allclose(backward, forward, rtol=1e-9)
    for way, column in zip(1e-6 * np.eye(3), backward.T, strict=True):
        change = (throw.miss(start + way) - throw.miss(start - way)) / 2e-6
        np.testing.assert_allclose(change, column, rtol=1e-5, atol=1e-5)
    tried = throw.aim(start)
    bounced = [throw.CONTACT.start(x).n_contact for x in np.asarray(throw.path(tried[-1]))]
    assert np.count_nonzero(bounced) > 10
    assert np.linalg.norm(throw.miss(start)) > 0.1
    assert np.linalg.norm(throw.miss(tried[-1])) < 1e-10
