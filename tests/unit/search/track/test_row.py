"""A point tracked by itself has the foot that it has in the lanes, or is handed back untouched."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.search.holed import holed_plate
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.records import Projection, SurfacePlaces, empty_projection, rows_of
from contiga.search.track.kernels import row_nb
from contiga.search.track.project import track
from contiga.search.track.track_records import FlaggedFeet, PointMotion, RowStarts
from contiga.statuses import Status


def quartic():
    """A patch of degree four in one direction, which the lanes do not take."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 5), np.linspace(0.0, 1.0, 2), indexing="ij")
    knots = ([0.0] * 5 + [1.0] * 5, [0.0, 0.0, 1.0, 1.0])
    return cg.Body([cg.NurbsSurface((4, 1), knots, np.stack([x, y, 0.1 * x**4], axis=-1))])


BODIES = {
    "rational": lambda: cg.Body([cg.shapes.torus()]),
    "polynomial": lambda: cg.Body([cg.shapes.bumpy_plate()]),
    "with poles": lambda: cg.Body([cg.shapes.sphere()]),
    "trimmed": holed_plate,
    "quartic": quartic,
}


def copy_of(feet: Projection) -> Projection:
    return rows_of(feet, np.arange(len(feet.gap)))


def one_by_one(body: cg.Body, before, points, feet: Projection) -> tuple[Projection, np.ndarray]:
    """Feet, and which rows were done."""
    out, back = copy_of(feet), np.full(len(points), 7, np.uint8)
    for k in range(len(points)):
        row_nb.track_row(
            tracking_tables_of(body), PointMotion(before, points), FlaggedFeet(out, back), k
        )
    assert set(back) <= {0, row_nb.FLAGGED}
    return out, back == 0


def by_the_lanes(body: cg.Body, before, points, feet: Projection) -> Projection:
    out = empty_projection(len(points))
    track(tracking_tables_of(body), points, SurfacePlaces(feet.patch, feet.uv), out, before)
    return out


def scene(kind: str, way: float, n: int = 2000):
    """A body, points about it, their feet, and the points after a step."""
    body = BODIES[kind]()
    rng = np.random.default_rng(6)
    patch = body.patches[0]
    low, high = np.transpose(patch.domain)
    uv = low + (high - low) * rng.random((n, 2))
    p = patch.evaluate(uv) + rng.uniform(-0.02, 0.02, (n, 1)) * patch.normal(uv)
    return body, p, p + way * rng.normal(size=p.shape), body.project(p)


@pytest.mark.parametrize("way", [0.001, 0.02])
@pytest.mark.parametrize("kind", BODIES)
def test_rows_done_have_the_bits_of_the_lanes_and_the_others_are_as_they_were(kind, way):
    body, before, points, feet = scene(kind, way)
    out, done = one_by_one(body, before, points, feet)
    lanes = by_the_lanes(body, before, points, feet)
    for own, other, first in zip(out, lanes, feet, strict=True):
        np.testing.assert_array_equal(own[done], other[done])
        np.testing.assert_array_equal(own[~done], first[~done])
    assert lanes.certified[done].all()
    if way < 0.01:
        least = {"quartic": 0.0, "trimmed": 0.6}.get(kind, 0.95)
        assert least <= done.mean() <= (1.0 if least else 0.0)


def test_feet_that_go_on_into_the_next_element_are_found():
    body, before, points, feet = scene("rational", 0.01)
    out, done = one_by_one(body, before, points, feet)
    grid = tracking_tables_of(body).grid
    u, v = (grid.breaks[slice(*grid.patches[0][name])] for name in ("u", "v"))
    there, here = (
        np.searchsorted(u, f.uv[:, 0]) * len(v) + np.searchsorted(v, f.uv[:, 1])
        for f in (out, feet)
    )
    assert (done & (there != here)).sum() > 10


@pytest.mark.interpreted
def test_rows_without_a_foot_or_a_place_are_handed_back():
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    before = np.array([[0.1, 0.2, 0.3], [0.4, 0.1, 0.2], [0.0, 0.5, 0.1], [0.9, 0.0, 0.1]])
    points, feet = before + np.array([0.0, 0.0, 0.01]), body.project(before)
    feet.patch[1] = -1
    points[2, 0] = np.nan
    points[3] = [1.5, 0.0, 0.1]  # beyond the border
    out, done = one_by_one(body, before, points, feet)
    assert done.tolist() == [True, False, False, False]
    np.testing.assert_allclose(out.gap[0], 0.31, rtol=0, atol=1e-15)
    assert out.status[0] == Status.OK
    assert out.certified[0] == 1


@pytest.mark.interpreted
def test_rows_are_gathered_and_scattered():
    body = cg.Body([cg.shapes.plane(width=2.0, length=2.0)])
    points = np.linspace(-0.5, 0.5, 15).reshape(5, 3)
    feet = body.project(points)
    rows = np.array([3, 1], np.int32)
    start = RowStarts(feet.patch, feet.uv, points, points + 1.0)
    to = RowStarts(np.empty(2, np.int32), *(np.empty((2, n)) for n in (2, 3, 3)))
    for i in range(2):
        row_nb.gather_row(start, rows, to, i)
    for own, all_rows in zip(to, start, strict=True):
        np.testing.assert_array_equal(own, all_rows[rows])
    out = rows_of(feet, np.array([0, 0, 0, 0, 0]))
    for i in range(2):
        row_nb.scatter_row(rows_of(feet, rows), rows, out, i)
    for own, all_rows in zip(out, feet, strict=True):
        np.testing.assert_array_equal(own, all_rows[[0, 1, 0, 3, 0]])
