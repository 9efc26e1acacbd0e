"""Parts stand at the gap asked for: closed forms, scipy, and both sides of every start."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize
from tests.sample import full

import contiga as cg
from contiga.placement import approach

RADIUS = 20.0
BALL = cg.Body(cg.shapes.sphere(radius=RADIUS), name="ball")
SIZE = BALL.size
UP, DOWN = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])
STARTS = {"free": 60.0, "near": 21.0, "overlapping": 5.0, "inside": -3.0}


def middle(body: cg.Body) -> np.ndarray:
    """Of a body that is alike on both sides."""
    return body.bounds().mean(axis=0)


def cube(size: float = 2.0, turn: float = 0.0, name: str = "cube") -> cg.TriMesh:
    """About the origin, an edge upward where it is turned by an eighth about x."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    return cg.TriMesh(0.5 * size * corners, triangles, name=name).rotated("x", turn)


@pytest.mark.parametrize("gap", [0.0, 2.0])
@pytest.mark.parametrize("start", STARTS)
def test_a_point_stands_off_a_ball_from_every_start(start: str, gap: float) -> None:
    node = cg.Slave([[6.0, 3.0, STARTS[start]]])
    placed = cg.place(node, on=BALL, direction=7.0 * DOWN, gap=gap)
    height = np.sqrt((RADIUS + gap) ** 2 - 45.0)
    np.testing.assert_allclose(placed.points, [[6.0, 3.0, height]], rtol=0, atol=1e-9 * SIZE)


@pytest.mark.parametrize("start", STARTS.values())
def test_a_ball_stands_off_points_from_every_start(start: float) -> None:
    points = cg.Slave([[6.0, 3.0, 0.0], [0.0, 0.0, -90.0]])
    body = BALL.translated([0.0, 0.0, start])
    z = middle(cg.place(body, on=points, direction="z" if start < 0 else DOWN, gap=1.0))[2]
    height = np.sqrt((RADIUS + 1.0) ** 2 - 45.0)
    assert abs(abs(z) - height) < 1e-9 * SIZE


@pytest.mark.parametrize("gap", [0.0, 1.5])
@pytest.mark.parametrize("start", [60.0, 12.0])
def test_two_balls_off_centre(start: float, gap: float) -> None:
    other = cg.Body(cg.shapes.sphere(radius=5.0, centre=[8.0, -6.0, start]))
    placed = cg.place(other, on=BALL, direction=DOWN, gap=gap)
    height = np.sqrt((RADIUS + 5.0 + gap) ** 2 - 100.0)
    np.testing.assert_allclose(middle(placed), [8.0, -6.0, height], rtol=0, atol=1e-9 * 10)


def test_a_ball_in_a_ring_stops_at_the_ring() -> None:
    ring = cg.Body(cg.shapes.torus(major=30.0, minor=8.0))
    ball = cg.Body(cg.shapes.sphere(radius=12.0, centre=[30.0, 4.0, 60.0]))
    x, y, z = middle(cg.place(ball, on=ring, direction=DOWN, gap=1.0))
    assert abs(np.hypot(np.hypot(x, y) - 30.0, z) - 21.0) < 1e-9 * ball.size


def test_two_ellipsoids_beside_scipy() -> None:
    a, b = np.array([3.0, 2.0, 1.0]), np.array([1.0, 2.5, 1.5])
    one, other = (cg.Body(cg.shapes.ellipsoid(axes=axes)) for axes in (a, b))
    placed = cg.place(other.translated([1.0, 2.0, 9.0]), on=one, direction=[0.1, -0.2, -1], gap=0.3)
    centre = middle(placed)

    def apart(x: np.ndarray) -> float:
        return float(np.linalg.norm(x[:3] - x[3:]))

    on_both = [
        {"type": "eq", "fun": lambda x: np.square(x[:3] / a).sum() - 1.0},
        {"type": "eq", "fun": lambda x: np.square((x[3:] - centre) / b).sum() - 1.0},
    ]
    start = np.concatenate([[0.0, 0.0, a[2]], centre - [0.0, 0.0, b[2]]])
    actual = minimize(apart, start, constraints=on_both, method="SLSQP", options={"ftol": 1e-15})
    assert actual.fun == pytest.approx(0.3, abs=1e-7)


def test_crossed_edges_of_two_meshes_meet_between_their_corners() -> None:
    below, above = cube(turn=np.pi / 4), cube(turn=np.pi / 4).rotated("z", np.pi / 2)
    placed = cg.place(above.translated([0.3, 0.2, 9.0]), on=below, direction=DOWN, gap=0.25)
    expected = 2.0 * np.sqrt(2.0) + 0.25
    assert placed.bounds().mean(axis=0)[2] == pytest.approx(expected, abs=1e-9)


def test_an_oblique_way_ends_where_the_nearest_node_is_told_by_a_plane() -> None:
    plate = cg.Body(cg.shapes.plane(width=100.0, length=100.0))
    nodes = cg.Slave([[0.0, 0.0, 30.0], [5.0, 0.0, 28.0]], active=[True, False])
    placed = cg.place(nodes, on=plate, direction=[1.0, 0.0, -1.0], gap=4.0)
    np.testing.assert_allclose(placed.points[0], [26.0, 0.0, 4.0], rtol=0, atol=1e-7)
    assert placed.active.tolist() == [True, False]


def test_what_lies_behind_a_sheet_comes_back_to_its_free_side() -> None:
    plate = cg.Body(cg.shapes.plane(width=10.0, length=10.0))
    placed = cg.place(cg.Slave([[0.0, 1.0, -3.0]]), on=plate, direction=DOWN, gap=0.5)
    np.testing.assert_allclose(placed.points, [[0.0, 1.0, 0.5]], rtol=0, atol=1e-9)


BESIDE = [[30.0, 0.0, -1.0], [30.0, 0.0, 5.0]]
"""Past the border of the plate, before and behind its plane."""


@pytest.mark.parametrize("start", [0.5, 0.01, -0.5, -3.0])
def test_points_past_a_border_count_by_their_distance(start: float) -> None:
    plate = cg.Body(cg.shapes.plane(width=10.0, length=10.0))
    points = cg.Slave([[0.0, 0.0, start], *BESIDE])
    placed = cg.place(points, on=plate, direction=DOWN, gap=0.1)
    assert placed.points[0, 2] == pytest.approx(0.1, abs=1e-9)


def test_a_plate_comes_down_on_points_some_of_them_beside_it() -> None:
    plate = cg.Body(cg.shapes.plane(width=10.0, length=10.0)).flipped().translated([0, 0, 9.0])
    points = cg.Slave([[0.0, 0.0, 0.0], *BESIDE])
    assert middle(cg.place(plate, on=points, direction=DOWN, gap=0.1))[2] == pytest.approx(0.1)


def test_a_point_that_comes_round_the_border_is_not_left_behind() -> None:
    # The first point ends 0.6 before the plate when the other, first past its border, is behind it.
    plate = cg.Body(cg.shapes.plane(width=10.0, length=10.0))
    points = cg.Slave([[0.0, 0.0, 0.7], [-5.3, 0.0, -6.0]])
    with pytest.raises(cg.errors.InputError, match="points come round the border of an open body"):
        cg.place(points, on=plate, direction=[1.0, 0.0, -0.2], gap=0.6)


def test_a_gap_that_is_not_settled_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(approach, "_MAX_ROUNDS", 1)
    other = cg.Body(cg.shapes.sphere(radius=5.0, centre=[8.0, -6.0, 60.0]))
    with pytest.raises(cg.errors.InputError, match=r"the gap is not settled: each of 1 rounds"):
        cg.place(other, on=BALL, direction=DOWN, gap=1.5)


LID = cg.Body(cg.shapes.plane(width=60.0, length=60.0, centre=[0, 0, 200]), name="lid")
BONNET = cg.Body(cg.shapes.saddle(width=100.0, length=100.0, height=10.0, centre=[0, 0, 200]))
PIPE = cg.Body(cg.shapes.cylinder(radius=30.0, height=60.0, centre=[0, 0, 200], axis="x"))


@pytest.mark.parametrize(
    ("part", "turned"),
    [
        *((LID, False), (PIPE, True)),
        *full((LID, True), (BONNET, False), (BONNET, True), (PIPE, False)),
    ],
    ids=["lid", "pipe, turned", "lid, turned", "bonnet", "bonnet, turned", "pipe"],
)
def test_an_open_part_stands_above_a_closed_one_on_either_side(part: cg.Body, turned: bool) -> None:
    """It was refused whatever was done: all that was behind an open face counted as inside it."""
    ball = cg.Body(cg.shapes.sphere(radius=50.0), name="ball")
    thing = part.flipped() if turned else part
    placed = cg.place(thing, on=ball, direction=DOWN, gap=30.0)
    nearest = np.abs(placed.project(np.zeros((1, 3))).gap[0])
    assert nearest == pytest.approx(80.0, abs=1e-7)
    # And the other way round: the ball comes up to it.
    moved = cg.place(ball, on=thing, direction=UP, gap=30.0)
    assert np.abs(thing.project([middle(moved)]).gap[0]) == pytest.approx(80.0, abs=1e-7)


def test_open_parts_that_are_in_the_way_are_named() -> None:
    node = cg.Slave([[0.0, 0.0, 100.0]], name="node")
    with pytest.raises(cg.errors.InputError, match=r"swap the free side of lid .*: lid is open"):
        cg.place(node, on=LID, direction=UP, gap=1.0)
    with pytest.raises(cg.errors.InputError) as caught:
        cg.place(cg.Slave([[0.0, 0.0, 40.0]]), on=BALL, direction=UP, gap=1.0)
    assert "open" not in str(caught.value)


def test_a_part_that_stands_right_stays() -> None:
    node = cg.Slave([[0.0, 0.0, RADIUS + 1.0]])
    assert np.array_equal(cg.place(node, on=BALL, direction=DOWN, gap=1.0).points, node.points)


def test_size_does_not_matter() -> None:
    for scale in (1e-3, 1e3):
        ball = BALL.scaled(scale)
        node = cg.Slave([[6.0 * scale, 0.0, 50.0 * scale]])
        z = cg.place(node, on=ball, direction=DOWN, gap=2.0 * scale).points[0, 2]
        assert abs(z / scale - np.sqrt(22.0**2 - 36.0)) < 1e-9 * SIZE


def test_a_way_past_the_other_is_refused() -> None:
    for way in (UP, np.array([1.0, 0.0, 0.0])):
        with pytest.raises(cg.errors.InputError, match="never has a gap of 1 from ball"):
            cg.place(cg.Slave([[0.0, 0.0, 40.0]]), on=BALL, direction=way, gap=1.0)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"gap": -1.0}, "gap: must be a finite number, not below zero"),
        ({"gap": "1"}, "gap: must be a number"),
        ({"direction": [0, 0, 0]}, "zero vector"),
        ({"on": 3}, "on: must be a body or a slave"),
        ({"on": cg.Slave([[0, 0, 0]])}, "two slaves have no gap"),
    ],
)
def test_wrong_input_is_refused(change: dict, said: str) -> None:
    good = {"on": BALL, "direction": DOWN, "gap": 1.0}
    with pytest.raises(cg.errors.InputError, match=said):
        cg.place(cg.Slave([[0.0, 0.0, 40.0]]), **(good | change))


def test_a_slave_without_active_points_is_refused() -> None:
    node = cg.Slave([[0.0, 0.0, 40.0]], active=[False])
    with pytest.raises(cg.errors.InputError, match="no point of it is active"):
        cg.place(node, on=BALL, direction=DOWN)
