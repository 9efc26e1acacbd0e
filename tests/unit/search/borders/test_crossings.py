"""Faces that go through themselves or each other, and those that do not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline
from tests.unit.search.borders.test_meetings import APART, MEET, MOVED

import contiga as cg
from contiga.errors import FileError, GeometryError
from contiga.search.borders.crossings import crossing_of, leaf_boxes, near_leaves
from contiga.search.tables import tables_of


def bent_pipe(bend: float, radius: float = 1.0) -> cg.NurbsSurface:
    """A bicubic pipe that is bent by half a turn about the z axis."""
    s, round_ = np.linspace(-1.0, 1.0, 24), np.linspace(0.0, 2.0 * np.pi, 17)
    angle = np.clip(2.0 * s, -1.0, 1.0) * np.pi / 2.0
    out = np.stack([np.sin(angle), -np.cos(angle), 0.0 * angle], axis=1)
    centre = bend * out
    centre[:, 1] += 4.0 * np.maximum(np.abs(s) - 0.5, 0.0)
    ring = np.cos(round_)[:, None] * out[:, None] + np.sin(round_)[:, None] * np.array([0, 0, 1.0])
    along = make_interp_spline(s, centre[:, None] + radius * ring, 3)
    about = make_interp_spline(round_, np.moveaxis(along.c, 1, 0), 3)
    return cg.NurbsSurface((3, 3), (along.t, about.t), np.moveaxis(about.c, 0, 1))


def eight() -> cg.NurbsSurface:
    """A cylinder over a figure of eight, which crosses itself on the z axis."""
    t = np.linspace(0.7, 2.0 * np.pi + 0.7, 25)
    curve = make_interp_spline(t, np.stack([np.sin(t), 0.5 * np.sin(2 * t), 0 * t], axis=1), 3)
    return cg.shapes.extruded(cg.NurbsCurve(3, curve.t, curve.c), (0.0, 0.0, 2.0))


@pytest.mark.parametrize(("bend", "factor"), [(0.2, 1.0), (0.5, 1e-6), (0.9, 1e6)])
def test_a_pipe_bent_too_tightly_goes_through_itself_on_the_inside(
    bend: float, factor: float
) -> None:
    body = cg.Body([bent_pipe(bend)]).scaled(factor).transformed(MOVED)
    crossing = body.openings.crossing
    assert crossing is not None
    assert crossing.patches == (0, 0)
    # By symmetry it crosses in the plane x = 0 of the pipe.
    assert abs((np.linalg.inv(MOVED) @ [*crossing.point, 1.0])[0]) < 1e-6 * body.size
    assert body.flaws[0].startswith("patch 0 goes through itself at (")
    assert not body.closed


@pytest.mark.parametrize("bend", [1.05, 1.5, 3.0])
def test_one_that_is_bent_less_does_not(bend: float) -> None:
    assert cg.Body([bent_pipe(bend)]).openings.crossing is None


def test_an_eight_crosses_itself_on_its_axis() -> None:
    crossing = cg.Body([eight()]).openings.crossing
    assert crossing is not None
    assert np.abs(crossing.point[:2]).max() < 1e-3  # the spline through points of the eight


SHAPES = ["plane", "disc", "cylinder", "cone", "sphere", "ellipsoid", "torus", "saddle"]


@pytest.mark.parametrize("name", [*SHAPES, "bumpy_plate"])
def test_shapes_do_not(name: str) -> None:
    assert cg.Body([getattr(cg.shapes, name)()]).openings.crossing is None


@pytest.mark.parametrize("name", APART)
def test_pieces_that_are_apart_do_not_cross(name: str) -> None:
    body = cg.Body(APART[name])
    assert crossing_of(body, np.zeros(len(body.patches), int), 0.0) is None


CROSS = [name for name, (_, how) in MEET.items() if how == "overlap" and name != "a ball in a ball"]


@pytest.mark.parametrize("name", CROSS)
def test_pieces_that_cross_do_so_on_both_faces(name: str) -> None:
    body = cg.Body(MEET[name][0]).transformed(MOVED)
    crossing = crossing_of(body, np.zeros(len(body.patches), int), 0.0)
    assert crossing is not None
    for patch in crossing.patches:
        gap = cg.Body([body.patches[patch]]).project([crossing.point]).gap[0]
        assert abs(gap) < 1e-9 * body.size


def test_adjacent_faces_of_one_piece_that_cross_away_from_their_edge_are_told() -> None:
    """A pillow whose upper face dips through the lower one in the middle."""
    x = np.array([0.0, 1.0, 3.0, 5.0, 6.0]) / 6.0
    knots = np.array([0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0])

    def sheet(rim: float, middle: float) -> cg.NurbsSurface:
        height = np.zeros((5, 5))
        height[1:4, 1:4] = rim
        height[2, 2] = middle
        net = np.dstack([*np.meshgrid(x, x, indexing="ij"), height])
        return cg.NurbsSurface((3, 3), (knots, knots), net)

    top, floor = sheet(0.4, -3.0), sheet(0.0, 0.0).flipped()
    body = cg.Body([top, floor])
    assert body.openings.free_edges == 0
    crossing = body.openings.crossing
    assert crossing is not None
    assert set(crossing.patches) == {0, 1}
    assert abs(crossing.point[2]) < 1e-9
    assert not body.closed
    with pytest.raises(GeometryError, match="go through each other at"):
        body.mass_properties(1.0)
    sound = cg.Body([sheet(0.4, 0.4), floor])
    assert (sound.closed, sound.flaws) == (True, [])


def test_a_file_with_such_a_face_is_refused_with_the_place(tmp_path: Path) -> None:
    from tests.unit.io.cad.test_unite_body import _gismo

    path = _gismo(tmp_path / "pipe.xml", [cg.shapes.plane(), bent_pipe(0.5)])
    with pytest.raises(FileError, match=r"patch 1: a face goes through itself.*'patch 1 goes th"):
        cg.read_cad(path)
    assert len(cg.read_cad(path, faces=1).patches) == 1


def wall(low: tuple[float, ...], high: tuple[float, ...], turn: float = 0.0) -> cg.NurbsSurface:
    """A rectangle in the plane y = 0, (x, z) from `low` to `high`, turned about z at the origin."""
    (a, c), (b, d) = low, high
    at = cg.motion.pose.rotation([0.0, 0.0, 1.0], turn, [0.0, 0.0, 0.0])
    flat = cg.shapes.bilinear((a, 0, c), (b, 0, c), (a, 0, d), (b, 0, d))
    return flat.transformed(at)


UPRIGHT = wall((-1.0, -1.0), (1.0, 1.0))
APART_OR_TOUCHING = {
    "edges that cross in a point": wall((-1.0, 1.0), (1.0, 2.0), np.pi / 2),
    "an edge that ends in the face": wall((0.0, -0.5), (1.0, 0.5), np.pi / 2),
    "an edge that crosses the face's edge": wall((0.0, 0.0), (1.0, 2.0), np.pi / 2),
    "a corner in the face": wall((0.0, 0.0), (1.0, 1.0), np.pi / 2),
    "edges along each other": wall((-1.0, 1.0), (1.0, 2.0), 0.3),
    "a face in the same plane": wall((-0.5, -0.5), (0.5, 0.5)),
    "a face that overlaps in the same plane": wall((0.5, 0.5), (2.0, 2.0)),
    "a hair apart": wall((-1.0, 1.0 + 1e-7), (1.0, 2.0), np.pi / 2),
}


@pytest.mark.parametrize("factor", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("name", APART_OR_TOUCHING)
def test_faces_that_touch_in_a_point_or_along_an_edge_do_not_pierce(
    name: str, factor: float
) -> None:
    body = cg.Body([UPRIGHT, APART_OR_TOUCHING[name]]).scaled(factor).transformed(MOVED)
    assert crossing_of(body, np.zeros(2, int), 0.0) is None


@pytest.mark.parametrize("sine", [0.02, 0.5, 1.0])
@pytest.mark.parametrize("length", [1e-3, 0.1, 1.0])
def test_faces_pierce_over_a_length_at_a_point_of_both(length: float, sine: float) -> None:
    turn = float(np.arcsin(sine))
    body = cg.Body([UPRIGHT, wall((-1.0, 1.0 - length), (1.0, 2.0), turn)]).transformed(MOVED)
    crossing = crossing_of(body, np.zeros(2, int), 0.0)
    assert crossing is not None
    x, y, z = (np.linalg.inv(MOVED) @ [*crossing.point, 1.0])[:3]
    assert abs(x) < 1e-9
    assert abs(y) < 1e-9
    assert 1.0 - length - 1e-9 <= z <= 1.0 + 1e-9


def test_a_face_does_not_pierce_itself_where_its_seam_meets_a_crease() -> None:
    corners = [[0, 0, -1], [2, 0, -1], [2, 0, 1], [0, 0, 1]]
    can = cg.shapes.revolved(cg.NurbsCurve(1, [0.0, 0, 1, 2, 3, 3], corners))
    body = cg.Body([can]).transformed(MOVED)
    assert (body.closed, body.flaws) == (True, [])
    assert abs(body.volume() - 8.0 * np.pi) < 1e-9


def test_two_halves_of_a_ball_do_not_cross_at_its_poles() -> None:
    ball = cg.shapes.sphere()
    (a, b), v = ball.domain
    halves = [ball.restricted(part, v) for part in ((a, 0.5 * (a + b)), (0.5 * (a + b), b))]
    body = cg.Body(halves).transformed(MOVED)
    assert (body.closed, body.flaws) == (True, [])


def test_leaves_that_adjoin_are_a_pair_each_once() -> None:
    tables = tables_of(cg.Body([bent_pipe(1.5)]))
    pairs = np.sort(near_leaves(tables), axis=1)
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    box = leaf_boxes(tables)
    rows = np.flatnonzero(tables.leaves["element"] >= 0)
    found = set(map(tuple, pairs.tolist()))
    for k in rows[::7]:
        meets = (box[rows, 0] <= box[k, 1]).all(axis=1) & (box[k, 0] <= box[rows, 1]).all(axis=1)
        for j in rows[meets]:
            assert j == k or tuple(sorted((int(j), int(k)))) in found
