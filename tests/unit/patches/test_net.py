"""Patches that are joined, places on them, and what is refused of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from tests.unit.matter.iga.shells import crooked, plate, tube

from contiga import NurbsSurface, shapes
from contiga.errors import InputError
from contiga.matter.iga import Joint, join
from contiga.patches.basis import VALUE, basis_at


def squares(count: int, degree: int = 2) -> list[NurbsSurface]:
    """Unit squares side by side along x."""
    one = plate(degree, (2, 2), (1.0, 1.0))
    return [one.translated([float(k), 0.0, 0.0]) for k in range(count)]


def test_patches_share_the_control_points_of_their_edges() -> None:
    net = join(squares(3))
    assert [part.shape for part in net.control] == [(4, 4)] * 3
    assert len(net.points) == 3 * 16 - 2 * 4
    assert net.joints == (
        Joint((0, 1), ("u1", "u0"), False),
        Joint((1, 2), ("u1", "u0"), False),
    )
    np.testing.assert_array_equal(net.control[0][-1], net.control[1][0])
    for patch, control in zip(squares(3), net.control, strict=True):
        np.testing.assert_allclose(net.points[control], patch.control_points, atol=1e-12)


@pytest.mark.parametrize("turn", ["flipped", "transposed"])
def test_whichever_way_their_edges_run(turn: str) -> None:
    first, second = squares(2)
    net = join([first, getattr(second, turn)()])
    assert len(net.points) == 28
    assert len(net.joints) == 1
    back = join([first, second.transposed().flipped()])
    assert len(back.points) == 28
    joint = join([first.transposed(), second.flipped().transposed().flipped()]).joints[0]
    assert joint.turned


def test_four_patches_around_a_corner_share_it() -> None:
    first, second = squares(2)
    net = join([first, second, first.translated([0, 1, 0]), second.translated([0, 1, 0])])
    assert len(net.points) == 49
    assert len(net.joints) == 4


def test_a_patch_is_cut_where_its_slope_may_jump_and_meets_itself_where_it_is_closed() -> None:
    """Four quarters, whose knots stand twice at degree 2; all their lines are joints."""
    ring = shapes.cylinder(radius=1.0, height=2.0).k_refined((0, 1), [], [0.25])
    n, m = ring.control_points.shape[:2]
    net = join([ring])
    assert (n, m) == (9, 4)
    assert len(net.points) == 8 * 4
    assert [piece.ends for piece in net.pieces] == [
        ("u0", "v0", "v1"),
        ("v0", "v1"),
        ("v0", "v1"),
        ("u1", "v0", "v1"),
    ]
    assert sorted(joint.pieces for joint in net.joints) == [(0, 1), (0, 3), (1, 2), (2, 3)]
    assert {joint.edges for joint in net.joints} == {("u1", "u0"), ("u0", "u1")}
    for piece in net.pieces:
        np.testing.assert_allclose(net.points[piece.control], piece.control_points, atol=1e-12)
        (a, b), (c, d) = ((knots[0], knots[-1]) for knots in piece.knots)
        uv = np.random.default_rng(0).uniform([a, c], [b, d], (9, 2))
        at = basis_at(piece, uv)
        found = at.of(VALUE, piece.control_points.reshape(-1, 3))
        np.testing.assert_allclose(found, ring.evaluate(uv), atol=1e-13)


def test_a_smooth_patch_that_is_closed_is_one_piece_that_meets_itself() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 9)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    points = np.zeros((9, 3, 3))
    points[:, :, :2], points[:, :, 2] = ring[:, None], [0.0, 1.0, 2.0]
    knots = np.concatenate([np.zeros(2), np.linspace(0.0, 1.0, 8), np.ones(2)])
    net = join([NurbsSurface((2, 2), (knots, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]), points)])
    assert len(net.points) == 8 * 3
    assert net.joints == (Joint((0, 0), ("u0", "u1"), False),)


def test_slits_within_the_tolerance_are_closed() -> None:
    first, second = squares(2)
    apart = second.translated([1e-3, 0.0, 0.0])
    assert len(join([first, apart], tolerance=2e-3).points) == 28
    with pytest.raises(InputError, match=r"surfaces 1 do not meet.*0\.001 from surfaces\[0\]"):
        join([first, apart])


def test_edges_that_are_one_curve_must_have_one_net() -> None:
    first, second = squares(2)
    with pytest.raises(InputError, match=r"surfaces\[0\] u1 and surfaces\[1\] u0: they meet, but "):
        join([first, second.insert_knots(v=[second.domain[1][0] + 0.3])])
    with pytest.raises(InputError, match="their degree there differ"):
        join([first, second.elevate(0, 1)])
    ring = tube(1.0, 2.0, (0.0, 1.0), 2, (1, 1))
    weights = np.array(ring.weights)
    weights[1] *= 1.5
    points = np.array(ring.control_points)
    other = tube(1.0, 2.0, (0.0, 1.0), 2, (1, 1)).translated([0.0, 2.0, 0.0])
    wrong = NurbsSurface(ring.degrees, ring.knots, points, weights)
    with pytest.raises(InputError, match="do not meet"):
        join([wrong, other])


def test_edges_that_meet_along_a_part_are_told() -> None:
    """A patch beside two that have half of its edge each."""
    big = tube(1.0, 2.0, (2.5, 0.6), 2, (2, 2))
    below, above = big.translated([0.0, -2.0, 0.0]), big.translated([0.0, 2.0, 0.0])
    assert len(join([below, big, above]).joints) == 2
    one, other = above.split(u=above.domain[0][0] + 0.25)
    with pytest.raises(InputError, match=r"surfaces\[0\] v1 and surfaces\[1\] v0: they meet along"):
        join([big, one, other])
    halves = big.split(u=big.domain[0][0] + 0.25)
    assert len(join([*halves, one, other]).joints) == 4


class Plain(NamedTuple):
    """A patch of plain arrays."""

    degrees: tuple[int, int]
    knots: tuple[np.ndarray, np.ndarray]
    control_points: np.ndarray
    weights: np.ndarray | None


def test_what_cannot_be_a_shell_is_told() -> None:
    with pytest.raises(InputError, match="a shell needs a surface"):
        join([])
    with pytest.raises(InputError, match=r"surfaces\[0\]: is of a degree .* found \(6, 2\)"):
        join([plate(2, (1, 1), (1.0, 1.0)).elevate(4, 0)])
    flat = crooked(2, (1, 1))
    weights = np.array(flat.weights)
    weights[1, 1] = 0.0
    parts = flat.degrees, flat.knots, np.array(flat.control_points)
    with pytest.raises(InputError, match=r"surfaces\[0\]: weights must be positive; found 0\.0"):
        join([Plain(*parts, weights)])
    parts[2][0, 0, 0] = np.nan
    with pytest.raises(InputError, match="control points must be finite"):
        join([Plain(*parts, None)])


def test_poles_and_degenerate_edges_are_told() -> None:
    with pytest.raises(InputError, match=r"edge v0 is a pole"):
        join([shapes.sphere(radius=1.0)])
    points = np.array(plate(2, (2, 2), (1.0, 1.0)).control_points)
    points[1] = points[0]
    flat = plate(2, (2, 2), (1.0, 1.0))
    with pytest.raises(InputError, match="edge u0 is degenerate"):
        join([NurbsSurface(flat.degrees, flat.knots, points)])


def test_edges_are_named_by_their_parameters() -> None:
    surface = plate(2, (3, 2), (3.0, 1.0))
    net = join([surface])
    (a, b), (c, d) = surface.domain
    for name, end in (("u0", (a, c)), ("u1", (b, c)), ("v0", (a, c)), ("v1", (a, d))):
        rows = net.edge(name)
        axis = int(np.argmin(np.ptp(net.points[rows], axis=0)[:2]))
        assert np.ptp(net.points[rows, axis]) < 1e-12
        assert net.points[rows[0], axis] == pytest.approx(surface.evaluate(end)[0, axis])
        assert len(net.edge(name, rows=2)) == 2 * len(rows)
    for wrong in ("w0", "u2", ""):
        with pytest.raises(InputError, match=r"there is no such edge.*u0, u1, v0, v1"):
            net.edge(wrong)
    with pytest.raises(InputError, match="there is no such patch; found 1; allowed: 0 to 0"):
        net.edge("u0", 1)
    with pytest.raises(InputError, match="has 5 rows of control points from its edge u0 on"):
        net.edge("u0", rows=6)


def test_places_are_those_of_the_surface_and_not_of_the_net() -> None:
    """Of an arc the middle control point is above the surface: no box that holds the whole net."""
    arch = (
        tube(1.0, 2.0, (np.pi, 0.0), 2, (1, 1)) if False else tube(1.0, 2.0, (2.5, 0.6), 2, (1, 1))
    )
    net = join([arch])
    assert net.points[:, 2].max() > 1.5
    np.testing.assert_allclose(np.hypot(net.sites[:, 0], net.sites[:, 2]), 1.0, rtol=1e-12)
    top = net.box([-1, -1, 0.9], [1, 3, 1.1])
    assert len(top) == 3
    with pytest.raises(InputError, match="no control point has its place on the surface there"):
        net.box([-1, -1, 1.2], [1, 3, 2.0])
