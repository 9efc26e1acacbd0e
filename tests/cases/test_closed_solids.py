"""Closed solids in contact: what tunnels is let go, what slides round stays on."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from tests.sample import FULL, full

import contiga as cg
from contiga.errors import ContigaWarning
from contiga.geometry.edges import UNTRIMMED, BodyEdge, EdgeUse
from contiga.statuses import Status

POINTS = 500
STEPS = 300


def _body(name: str, solids: ModuleType, folder: Path) -> cg.Body:
    return cg.read_cad(solids.write(solids.SOLIDS[name](), folder / f"{name}.step"))


@pytest.mark.parametrize("name", ["slot", *full("crossing_bores", "link_rod")])
def test_points_that_went_right_through_are_released(
    name: str, solids: ModuleType, tmp_path: Path
) -> None:
    """A closed body keeps nothing that has come out on its far side."""
    body = _body(name, solids, tmp_path)
    low, high = body.bounds()
    rng = np.random.default_rng(1)
    points = rng.uniform(low, high, (POINTS, 3))
    points[:, 2] = low[2] - 0.05 * body.size
    contact = cg.Contact(body, cg.Slave(points, area=np.ones(POINTS)), law=cg.PenaltyLaw(1.0))
    state = contact.start(points)
    touched = np.zeros(POINTS, dtype=bool)
    up = np.array([0.0, 0.0, high[2] - low[2] + 0.1 * body.size])
    for share in np.linspace(0.0, 1.0, 41)[1:]:
        state = contact.step(state, points + share * up)
        touched |= state.in_contact
    assert touched.sum() > POINTS / 3
    assert state.n_contact == 0


@pytest.mark.parametrize(
    "name",
    [
        *("cup", "shell", "cone", "torus", "sphere"),
        *full("link_rod", "crossing_bores", "rounded_box", "slot", "lens"),
    ],
)
def test_feet_slide_round_a_solid_without_a_gap(
    name: str, solids: ModuleType, tmp_path: Path
) -> None:
    """Each step a point goes on from its foot along the surface: the foot follows it.

    Over edges, corners, seams and poles, convex and concave ones, no foot is lost, and none
    jumps farther than a few steps.
    """
    body = _body(name, solids, tmp_path)
    _slide(body, 2e-3 * body.size)


def test_feet_slide_over_a_slit(solids: ModuleType, tmp_path: Path) -> None:
    path = solids.write(solids.gaping_box(0.05), tmp_path / "gaping.step")
    with pytest.warns(ContigaWarning, match="slit"):
        body = cg.read_cad(path)
    _slide(body, 2e-3 * body.size, slit=2.0 * body.openings.slit)


def _slide(body: cg.Body, step: float, slit: float = 0.0) -> None:
    rng = np.random.default_rng(0)
    feet = body.project(rng.uniform(*body.bounds(), (48, 3)))
    axis = rng.normal(size=(48, 3))
    seen = set()
    for _ in range(STEPS):
        way = np.cross(axis, feet.normal)
        way /= np.linalg.norm(way, axis=1)[:, None]
        points = feet.point + step * way
        last, feet = feet, body.project(points, start=feet, mode="track")
        # On the inner side of a fold a foot ends, and the next one is near.
        assert np.isin(feet.status, (Status.OK, Status.BRANCH_EVENT)).all()
        assert (np.linalg.norm(feet.point - last.point, axis=1) <= 3.0 * step + slit).all()
        assert (np.linalg.norm(feet.point - points, axis=1) <= 1.5 * step + slit).all()
        seen |= set(feet.patch.tolist())
    assert len(seen) >= 0.5 * len(body.patches)


def test_sides_about_a_sharp_rim_where_its_disc_touches_the_square_it_lies_in(
    solids: ModuleType, tmp_path: Path
) -> None:
    """A disc is as wide as its plane: beside four places of the rim the sides of that are near."""
    cone = _body("cone", solids, tmp_path)  # radius 4, height 9
    rng = np.random.default_rng(5)
    n = 20_000
    angle = 0.5 * np.pi * rng.integers(4, size=n) + 10.0 ** rng.uniform(-9, -1, n) * rng.choice(
        [-1, 1], n
    )
    about = 2.0 * np.pi * rng.random(n)
    off = 10.0 ** rng.uniform(-7, 0, n)
    r, z = 4.0 + off * np.cos(about), off * np.sin(about)
    outside = np.maximum(-z, (r - 4.0 + z * 4.0 / 9.0) / np.hypot(1.0, 4.0 / 9.0))
    points = np.column_stack([r * np.cos(angle), r * np.sin(angle), z])
    told = np.abs(outside) > 1e-9
    np.testing.assert_array_equal(cone.contains(points)[told], (outside < 0.0)[told])


@pytest.mark.parametrize("angle", [1e-6, 1e-4, *full(1e-7, 1e-5, 1e-3)])
@pytest.mark.parametrize("convex", [True, False])
@pytest.mark.parametrize("named", [True, False])
def test_a_nearly_tangent_joint_does_not_flicker(angle: float, convex: bool, named: bool) -> None:
    """Along and across a joint of two planes: one change of face, a normal between the two's."""
    body = _hinge(angle if convex else -angle, named)
    n = 1600 if FULL else 200
    for height in (-1e-3, 0.0, 1e-3):
        across = np.linspace(-0.5, 0.5, n + 1)
        oblique = np.column_stack([across, 0.3 * across, np.full(n + 1, height)])
        along = np.column_stack([np.zeros(n + 1), across, np.full(n + 1, height)])
        for path in (oblique, along, oblique[::-1]):
            feet = body.project(path[:1])
            patches = [int(feet.patch[0])]
            for point in path[1:]:
                last, feet = feet, body.project(point[None], start=feet, mode="track")
                assert feet.status[0] == Status.OK
                jump = np.linalg.norm(feet.point - last.point)
                assert jump <= 1.1 / n + 4.0 * angle * abs(height) + 1e-9
                turn = np.linalg.norm(feet.normal - last.normal)
                assert turn <= 1.1 * angle + 1e-9
                patches.append(int(feet.patch[0]))
            changes = int((np.diff(patches) != 0).sum())
            assert changes <= 1


def _hinge(angle: float, named: bool) -> cg.Body:
    """Two plane patches that meet along the y axis at a turn of `angle`."""
    drop = -np.tan(angle)
    knots = ([0, 0, 1, 1], [0, 0, 1, 1])
    left = cg.NurbsSurface((1, 1), knots, [[[-1, -1, 0], [-1, 1, 0]], [[0, -1, 0], [0, 1, 0]]])
    right = cg.NurbsSurface((1, 1), knots, [[[0, -1, 0], [0, 1, 0]], [[1, -1, drop], [1, 1, drop]]])
    if not named:
        return cg.Body([left, right])
    uses = (EdgeUse(0, UNTRIMMED, 1, False), EdgeUse(1, UNTRIMMED, 0, False))
    return cg.Body([left, right], edges=[BodyEdge(left.isocurve(u=1.0), 0.0, uses)])
