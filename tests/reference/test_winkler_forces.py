"""Forces of an elastic foundation on slaves against closed forms, by weights at rest.

The truth is F = ∫ k λ n / t over the slave, with the penetration λ and normal n of the body's
signed distance: integrals in one variable, or two nested ones, to 1e-11.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad

import contiga as cg

K, T = 3.0, 0.5
SHIFTS = ((0.12, 0.43), (0.37, 0.81), (0.62, 0.18), (0.87, 0.56))  # of a cell
REFINED = (24, 40, 64, 104, 168)


Height = Callable[[np.ndarray, np.ndarray], np.ndarray]


class Scene(NamedTuple):
    """A body and a slave over a rectangle, and the force along z on it."""

    body: cg.Body
    half: tuple[float, float]
    """Half the sides of the rectangle."""
    height: Height
    exact: float


def _flat(height: float) -> Height:
    return lambda x, _: np.full(len(x), height)


def _integral(function: Callable[[float], float], low: float, high: float) -> float:
    return float(quad(function, low, high, epsabs=0.0, epsrel=1e-12, limit=200)[0])


def _cap(radius: float, height: float) -> float:
    """Force of a ball about the origin on the plane z = height."""

    def ring(r: float) -> float:
        far = np.hypot(r, height)
        return K / T * (radius - far) * height / far * 2.0 * np.pi * r

    return _integral(ring, 0.0, np.sqrt(radius**2 - height**2))


def _sphere() -> Scene:
    body = cg.Body([cg.shapes.sphere(radius=1.0)])
    return Scene(body, (0.66, 0.66), _flat(0.8), _cap(1.0, 0.8))


def _two_balls() -> Scene:
    body = cg.Body([cg.shapes.sphere(radius=0.5, centre=[x, 0, 0]) for x in (-0.6, 0.6)])
    return Scene(body, (1.2, 0.6), _flat(0.4), 2.0 * _cap(0.5, 0.4))


def _torus() -> Scene:
    major, minor, height = 1.0, 0.4, 0.3

    def ring(r: float) -> float:
        far = np.hypot(r - major, height)
        return K / T * (minor - far) * height / far * 2.0 * np.pi * r

    half = np.sqrt(minor**2 - height**2)
    force = _integral(ring, major - half, major) + _integral(ring, major, major + half)
    return Scene(
        cg.Body([cg.shapes.torus(major=major, minor=minor)]), (1.4, 1.4), _flat(height), force
    )


def _cylinder() -> Scene:
    height, half = 0.8, 0.5

    def strip(y: float) -> float:
        far = np.hypot(y, height)
        return K / T * (1.0 - far) * height / far * 2.0 * half

    body = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0, axis="x")])
    return Scene(body, (half, 0.8), _flat(height), _integral(strip, -0.6, 0.6))


def _saddle_depth(x: float, y: float, height: float) -> tuple[float, float]:
    """Distance of (x, y, height) below z = (x² − y²)/4, and the normal's z there, by Newton."""
    u, v = x, y
    for _ in range(30):
        w = (u * u - v * v) / 4.0
        e = np.array([u - x + (w - height) * u / 2.0, v - y - (w - height) * v / 2.0])
        jacobian = np.array(
            [
                [1.0 + u * u / 4.0 + (w - height) / 2.0, -u * v / 4.0],
                [-u * v / 4.0, 1.0 + v * v / 4.0 - (w - height) / 2.0],
            ]
        )
        du, dv = np.linalg.solve(jacobian, e)
        u, v = u - du, v - dv
        if abs(du) + abs(dv) < 1e-15:
            break
    w = (u * u - v * v) / 4.0
    up = 1.0 / np.sqrt(1.0 + (u * u + v * v) / 4.0)
    return float(np.sqrt((u - x) ** 2 + (v - y) ** 2 + (w - height) ** 2)), float(up)


def _saddle() -> Scene:
    """A saddle on a bowl: the region of contact is the ellipse x²/4 + y²/2 < 0.06."""

    def bowl(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 0.5 * x**2 + 0.25 * y**2 - 0.06

    a, b = np.sqrt(0.06 * 4.0), np.sqrt(0.06 * 2.0)

    def ray(angle: float) -> float:
        def at(r: float) -> float:
            x, y = a * r * np.cos(angle), b * r * np.sin(angle)
            depth, up = _saddle_depth(x, y, float(bowl(np.array(x), np.array(y))))
            return K / T * depth * up * np.sqrt(1.0 + x**2 + 0.25 * y**2) * a * b * r

        return _integral(at, 0.0, 1.0)

    # The trapezoidal rule of a smooth periodic function converges faster than any power.
    force = 2.0 * np.pi * np.mean([ray(angle) for angle in 2.0 * np.pi * np.arange(32) / 32])
    body = cg.Body([cg.shapes.saddle(width=2.4, length=2.4, height=0.36)])
    return Scene(body, (0.6, 0.45), bowl, float(force))


def _saddle_on_a_flat_slave() -> Scene:
    """A saddle pressed through a flat sheet, out over two of its borders."""
    height, half = 0.08, 0.8

    def strip(y: float) -> float:
        def at(x: float) -> float:
            depth, up = _saddle_depth(x, y, height)
            return K / T * depth * up

        return 2.0 * _integral(at, np.sqrt(4.0 * height + y * y), half)

    # y = s sin(θ): the strip's length ends with a root there.
    end = np.sqrt(half**2 - 4.0 * height)

    def turned(angle: float) -> float:
        return strip(end * np.sin(angle)) * end * np.cos(angle)

    body = cg.Body([cg.shapes.saddle(width=2.4, length=2.4, height=0.36)])
    force = 2.0 * _integral(turned, 0.0, 0.5 * np.pi)
    return Scene(body, (half, half), _flat(height), force)


SCENES = {
    "sphere": _sphere,
    "two balls": _two_balls,
    "torus": _torus,
    "cylinder": _cylinder,
    "saddle": _saddle,
}
# Points within a facet lie on its plane, and not on the bowl that its corners were taken from.
FLAT = SCENES | {"saddle": _saddle_on_a_flat_slave}


def _sheet(scene: Scene, shift: tuple[float, float], cells: int) -> cg.Slave:
    """A sheet of the scene's sides, its inner lines of nodes moved by a part of a cell."""
    lines = []
    for half, s in zip(scene.half, shift, strict=True):
        inner = half * (np.linspace(-1.0, 1.0, cells)[1:-1] + 2.0 * (s - 0.5) / cells)
        lines.append(np.concatenate([[-half], inner, [half]]))
    xy = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
    row = np.arange(len(xy)).reshape(cells, cells)
    a, b, c, d = (part.ravel() for part in (row[:-1, :-1], row[1:, :-1], row[1:, 1:], row[:-1, 1:]))
    facets = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return cg.Slave(np.column_stack([xy, scene.height(*xy.T)]), facets)


def _error(scene: Scene, cells: int, quadrature: str | int) -> float:
    """Relative error of the force along z, root mean square over the shifts."""
    law = cg.StressLaw(K, thickness=T)
    values = []
    for shift in SHIFTS:
        slave = _sheet(scene, shift, cells)
        contact = cg.Contact(
            scene.body, slave, law=law, search="penetration", quadrature=quadrature
        )
        values.append(contact.start(slave.points).total_force[2])
    return float(np.sqrt(np.mean((np.array(values) / scene.exact - 1.0) ** 2)))


@pytest.mark.parametrize("name", list(SCENES))
def test_with_65_nodes_a_side_the_force_is_right_to_a_two_thousandth(name: str) -> None:
    assert _error(SCENES[name](), 65, "nodes") <= 5e-4


@pytest.mark.parametrize("name", list(FLAT))
def test_with_six_points_a_facet_it_is_right_to_a_ten_thousandth(name: str) -> None:
    assert _error(FLAT[name](), 65, 6) <= 1e-4


@pytest.mark.parametrize("name", list(SCENES))
def test_the_error_of_the_force_falls_with_the_square_of_the_mesh(name: str) -> None:
    scene = SCENES[name]()
    errors = [_error(scene, cells, "nodes") for cells in REFINED]
    order = -np.polyfit(np.log(REFINED), np.log(errors), 1)[0]
    assert order >= 1.95, errors
