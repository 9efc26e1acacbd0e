"""p-curves drawn from edges: over seams, round and round, over poles, along slits."""

from __future__ import annotations

import warnings
from itertools import pairwise
from types import SimpleNamespace as Bag
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.errors import ContigaWarning
from contiga.io.cad import rhino
from contiga.io.cad.assemble import Assembly
from contiga.io.cad.chart import Chart
from contiga.io.cad.projected_faces import ProjectedFace, Trim, add_projected
from contiga.io.cad.render_check import RenderMesh, find_mismatches
from contiga.io.cad.warp import project_edge

LOW, MIDDLE, HIGH = 1.0, 2.0, 3.0
Loops = list[list[tuple[int, bool]]]


def arc(start: float, end: float, z: float, radius: float = 1.0) -> cg.NurbsCurve:
    """Part of a circle about z between angles in degrees."""
    t = np.radians(np.linspace(start, end, 1 + max(1, int(np.ceil(abs(end - start) / 90.0)))))
    middle, half = 0.5 * (t[1:] + t[:-1]), 0.5 * (t[1] - t[0])
    angles = np.empty(2 * len(t) - 1)
    angles[::2], angles[1::2] = t, middle
    weights = np.where(np.arange(len(angles)) % 2, np.cos(half), 1.0)
    points = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1) / weights[:, None]
    points = np.column_stack([points, np.full(len(angles), z)])
    knots = np.repeat(np.arange(len(t)), [3, *[2] * (len(t) - 2), 3])
    return cg.NurbsCurve(2, knots, points, weights)


def line(start: Any, end: Any) -> cg.NurbsCurve:
    return cg.NurbsCurve(1, [0, 0, 1, 1], [start, end])


def at(angle: float, z: float) -> list[float]:
    return [np.cos(np.radians(angle)), np.sin(np.radians(angle)), z]


def upright(angle: float, low: float = LOW, high: float = HIGH) -> cg.NurbsCurve:
    return line(at(angle, low), at(angle, high))


def window(start: float, end: float) -> tuple[list[cg.NurbsCurve], Loops]:
    edges = [arc(start, end, LOW), upright(end), arc(start, end, HIGH), upright(start)]
    return edges, [[(0, False), (1, False), (2, True), (3, True)]]


def cut(surface: cg.NurbsSurface, edges: list[cg.NurbsCurve], loops: Loops) -> cg.Body:
    """The face between some edges as a body."""
    assembly = Assembly("made up")
    trims = [[Trim(*trim) for trim in loop] for loop in loops]
    assert add_projected(assembly, ProjectedFace(surface, trims, False, "face 1"), edges, 1e-3)
    edge_of = {k: rhino.Edge(edge, 1e-3) for k, edge in enumerate(edges)}
    return assembly.body("made up", edge_of.get, None)


def notched() -> tuple[list[cg.NurbsCurve], Loops]:
    """A band with a notch over the seam, 90° wide."""
    edges = [
        *(arc(0, 360, LOW), upright(0, LOW, MIDDLE), arc(0, 45, MIDDLE), upright(45, MIDDLE)),
        *(arc(45, 315, HIGH), upright(315, MIDDLE), arc(315, 360, MIDDLE)),
    ]
    there = [(0, False), (1, False), (6, True), (5, False), (4, True), (3, True), (2, True)]
    return edges, [[*there, (1, True)]]


BAND = [arc(0, 360, LOW), upright(0), arc(0, 360, HIGH)]
ROUND = [(0, False), (1, False), (2, True), (1, True)]
HOLE = [arc(100, 160, 1.5), upright(160, 1.5, 2.5), arc(100, 160, 2.5), upright(100, 1.5, 2.5)]
ON_A_TUBE = {
    "away from the seam": (*window(40, 130), 90.0),
    "over the seam": (*window(-45, 45), 90.0),
    "over the seam, a turn on": (*window(300, 390), 90.0),
    "from the seam on": (*window(0, 90), 90.0),
    "up to the seam": (*window(270, 360), 90.0),
    "all but a slot": (*window(20, 340), 320.0),
    "a band": (BAND, [ROUND], 360.0),
    "a band with a window": (
        [*BAND, *HOLE], [ROUND, [(6, False), (5, False), (4, True), (3, True)]], 330.0,
    ),
    "a band without a seam edge": (
        [BAND[0], BAND[2]], [[(0, False)], [(1, True)]], 360.0,
    ),
    "a notch at the seam": (*notched(), 315.0),
}  # fmt: skip


@pytest.mark.parametrize("name", ON_A_TUBE)
@pytest.mark.parametrize("turn", [0.0, 77.0])
def test_faces_on_a_tube_have_their_area(name: str, turn: float) -> None:
    """Wherever the seam is."""
    edges, loops, degrees = ON_A_TUBE[name]
    tube = cg.shapes.cylinder(radius=1.0, height=10.0)
    turned = tube.rotated([0, 0, 1], np.radians(turn))
    assert cut(turned, edges, loops).area() == pytest.approx(np.radians(degrees) * 2.0, rel=1e-9)


def test_a_band_is_joined_to_itself_along_its_seam() -> None:
    body = cut(cg.shapes.cylinder(radius=1.0, height=10.0), BAND, [ROUND])
    assert sorted(len(edge.uses) for edge in body.edges) == [1, 1, 2]
    assert max(edge.gap for edge in body.edges) < 1e-12


@pytest.mark.parametrize("angle", [0.0, 130.0])
def test_faces_over_poles_are_closed_there(angle: float) -> None:
    """Half a ball above a circle, its loop over the pole; and all of it, from pole to pole."""
    ball = cg.shapes.sphere(radius=1.0)
    rise = arc(0, 90, 0.0).rotated([1, 0, 0], np.pi / 2).rotated([0, 0, 1], np.radians(angle))
    ring = arc(angle, angle + 360, 0.0)
    dome = cut(ball, [ring, rise], [[(0, False), (1, False), (-1, False), (1, True)]])
    assert dome.area() == pytest.approx(2 * np.pi, rel=1e-9)
    whole = arc(-90, 90, 0.0).rotated([1, 0, 0], np.pi / 2).rotated([0, 0, 1], np.radians(angle))
    both = cut(ball, [whole], [[(0, False), (-1, False), (0, True), (-1, False)]])
    assert both.area() == pytest.approx(4 * np.pi, rel=1e-9)


def test_a_slit_edge_is_used_twice() -> None:
    """A flat face whose loop runs in along an edge and out again is closed there."""
    corners = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]
    sheet = cg.NurbsSurface(
        (1, 1), ([0, 0, 1, 1], [0, 0, 1, 1]),
        np.array([[[-1, -1, 0], [-1, 3, 0]], [[3, -1, 0], [3, 3, 0]]], float),
    )  # fmt: skip
    edges = [line(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    edges.append(line([2, 2, 0], [1, 1, 0]))
    loop = [(0, False), (1, False), (4, False), (4, True), (2, False), (3, False)]
    body = cut(sheet, edges, [loop])
    assert body.area() == pytest.approx(4.0, rel=1e-12)
    (slit,) = (edge for edge in body.edges if len(edge.uses) == 2)
    assert slit.uses[0].reversed != slit.uses[1].reversed
    assert body.openings.free_edges == 4


def test_knots_an_ulp_apart_are_one() -> None:
    net = np.array(
        [[[0, 0, 0], [0, 1, 0]], [[0.5, 0, 0], [0.5, 1, 0]], [[1, 0, 0.25], [1, 1, 0.25]]]
    )
    sheet = cg.NurbsSurface((2, 1), ([0, 0, 0, 1, 1, 1], [0, 0, 1, 1]), net)  # z = x²/4
    uv = np.array([[0.1, 0.2], [0.4, 0.5], [0.9, 0.6]])
    at_knots, between = uv, 0.5 * (uv[1:] + uv[:-1])
    height = (
        [[u * u / 4] for u in at_knots[:, 0]],
        [[a * b / 4] for a, b in pairwise(uv[:, 0])],
    )
    points = np.empty((5, 3))
    points[::2], points[1::2] = np.hstack([at_knots, height[0]]), np.hstack([between, height[1]])
    edge = cg.NurbsCurve(2, [0, 0, 0, 0.3, 0.3, 1, 1, 1], points)
    near = np.nextafter(np.nextafter(0.3, 1), 1)
    made = project_edge(cg.NurbsCurve(1, [0, 0, near, 1, 1], uv), edge, sheet, 1e-3)
    assert made is not None
    t = np.linspace(0, 1, 201)
    assert np.abs(sheet.evaluate(made.evaluate(t)[:, :2]) - edge.evaluate(t)).max() < 1e-14


def test_an_edge_off_the_surface_is_told_with_the_face() -> None:
    edges, loops = window(40, 130)
    edges[1] = line([0.5, 0.5, LOW], [0.5, 0.5, HIGH])
    with pytest.warns(ContigaWarning, match=r"face 1: edge 1 does not lie on the surface"):
        cut(cg.shapes.cylinder(radius=1.0, height=10.0), edges, loops)


def test_the_surface_is_unrolled_as_far_as_it_takes() -> None:
    chart = Chart(cg.shapes.cylinder(radius=1.0, height=10.0))
    assert chart.periods.tolist() == [1.0, 0.0]
    patch = chart.unroll(np.array([[0.7, 0.0], [2.9, 1.0]]))
    assert patch.domain[0][0] <= 0.7
    assert patch.domain[0][1] >= 2.9
    uv = np.column_stack([np.linspace(0.7, 2.9, 50), np.full(50, 0.3)])
    assert np.abs(patch.evaluate(uv) - chart.points(uv)).max() < 1e-14


@pytest.mark.parametrize(("degrees", "told"), [(90.0, ""), (45.0, "area"), (130.0, "area")])
def test_a_face_that_is_not_what_its_render_mesh_shows_is_told(degrees: float, told: str) -> None:
    body = cut(cg.shapes.cylinder(radius=1.0, height=10.0), *window(0, 90))
    angles, heights = np.meshgrid(np.linspace(0, degrees, 10), [LOW, HIGH], indexing="ij")
    vertices = np.array([at(a, z) for a, z in zip(angles.ravel(), heights.ravel(), strict=True)])
    k = 2 * np.arange(9)[:, None]
    triangles = np.concatenate([k + np.array(corners) for corners in ((0, 2, 1), (1, 2, 3))])
    actual = list(find_mismatches(body, [RenderMesh(vertices, triangles)]))
    assert [k for k, _ in actual] == [0] * bool(told)
    assert all(told in text for _, text in actual)
    if degrees > 90.0:
        assert "up to 0.684 off it" in actual[0][1]  # the chord of 40°


def test_what_cannot_be_read_is_told_with_file_and_face(tmp_path: Any) -> None:
    """Weights that are not positive, say."""
    bad = Bag(Degree=1, Knots=[0.0, 1.0], IsRational=True, ToNurbsCurve=lambda: bad)
    bad.Points = [Bag(X=0.0, Y=0.0, Z=0.0, W=1.0), Bag(X=1.0, Y=0.0, Z=0.0, W=-1.0)]
    brep = Bag(Edges=[bad], Faces=[])
    item = Bag(label=Bag(faces=[]), geometry=brep, matrix=np.eye(4))
    with pytest.raises(cg.errors.FileError, match=r"part\.3dm, edge 0: .*Mend or delete it"):
        rhino._brep(item, [], 1e-3, "part.3dm")


def test_nothing_is_told_of_what_is_sound() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        cut(cg.shapes.cylinder(radius=1.0, height=10.0), *window(300, 390))
