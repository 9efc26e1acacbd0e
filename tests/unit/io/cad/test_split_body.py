"""A body cut by a plane: what both parts have together is the whole, and each of it is exact."""

from __future__ import annotations

import math

import numpy as np
import pytest

import contiga as cg
from contiga.errors import GeometryError, InputError, MeshError

SHAPES = {
    "sphere": cg.shapes.sphere(radius=1.0),
    "torus": cg.shapes.torus(major=2.0, minor=0.5),
    "cylinder": cg.shapes.cylinder(radius=1.0, height=4.0),
    "bumps": cg.shapes.bumpy_plate(waves=3),
}
PLANE = np.array([0.05, 0.02, 0.02]), np.array([0.3, 0.9, 0.1])


def test_parts_of_a_ball_are_closed_caps() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=2.0)], name="ball", unit="mm")
    ball = ball.with_reference_point([1.0, 2.0, 3.0])
    above, below = ball.split(([0.0, 0.0, 1.0], [0.0, 0.0, 5.0]))
    cap = math.pi / 3.0 * 1.0**2 * (3.0 * 2.0 - 1.0)
    assert above.closed
    assert below.closed
    assert above.volume() == pytest.approx(cap, rel=1e-9)
    assert below.volume() == pytest.approx(ball.volume() - cap, rel=1e-9)
    assert above.bounds()[0, 2] == pytest.approx(1.0, abs=1e-9)
    for part in (above, below):
        assert (part.name, part.unit) == ("ball", "mm")
        assert part.reference_point.tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("name", list(SHAPES))
def test_both_parts_are_the_whole_and_lie_on_their_sides(name: str) -> None:
    body, (point, normal) = cg.Body([SHAPES[name]]), PLANE
    above, below = body.split(PLANE)
    assert body.closed == above.closed == below.closed
    for part, sign in ((above, 1.0), (below, -1.0)):
        reach = sign * (part.tessellate(0.01).vertices - point) @ normal
        assert reach.min() > -0.02
        assert reach.max() > 0.1
    if body.closed:
        assert above.volume() + below.volume() == pytest.approx(body.volume(), rel=1e-9)
    else:
        assert above.area() + below.area() == pytest.approx(body.area(), rel=1e-9)


def test_a_cavity_is_cut_with_what_is_around_it() -> None:
    outer, inner = (cg.shapes.sphere(radius=radius) for radius in (2.0, 1.0))
    hollow = cg.Body([outer, inner.flipped()])
    halves = hollow.split(([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]))
    for half in halves:
        assert half.closed
        assert half.volume() == pytest.approx(2.0 / 3.0 * math.pi * 7.0, rel=1e-9)


@pytest.mark.parametrize("away", [1.5, 1.0, -3.0])
def test_a_plane_that_misses_is_told(away: float) -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
    with pytest.raises(GeometryError, match=r"ball\.split\(plane\): the plane does not cut"):
        ball.split(([0.0, 0.0, away], [0.0, 0.0, 1.0]))


@pytest.mark.parametrize(
    "plane", [3, ([0.0, 0.0], [1.0, 0.0]), ([0, 0, 0], [0, 0, 0]), ([0, 0, math.nan], [0, 0, 1])]
)
def test_what_is_no_plane_is_told(plane: object) -> None:
    with pytest.raises(InputError, match="must be a point and a normal"):
        cg.Body([SHAPES["sphere"]]).split(plane)


def test_a_mesh_is_refused() -> None:
    mesh = cg.Body([SHAPES["sphere"]]).tessellate(0.1)
    with pytest.raises(MeshError, match="a mesh is not split by a plane"):
        mesh.split(PLANE)
