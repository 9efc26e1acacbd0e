"""Connected regions, FacetArea and CloudArea in their corners."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.area.kernels import touch_nb
from contiga.area.regions import neighbours_of, regions, topology_of
from contiga.arrays.layout import locked
from contiga.errors import InputError

PLATE = cg.Body([cg.shapes.plane(width=20.0, length=20.0)])


def touch(body, points, facets=None, area=None, kind="slave"):
    slave = cg.Slave(points, facets)
    contact = cg.Contact(
        body,
        slave,
        law=cg.PenaltyLaw(1.0),
        area=area,
        search="penetration",
        contact_type=kind,
    )
    return contact.start(points)


def lattice(n, m, z=-0.1):
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(m + 1.0), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], 1)
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def tubes(gap, depth):
    """Two lying half tubes side by side, `gap` apart, pressed `depth` into z = 0."""
    angle = np.linspace(-np.pi, 0.0, 61)
    y = np.arange(11) * 0.05
    tube = np.array([[np.cos(a), s, np.sin(a) + 1.0 - depth] for a in angle for s in y])
    return np.concatenate([tube, tube + np.array([2.0 + gap, 0.0, 0.0])])


def test_side_by_side_cylinders_are_two_regions_until_their_gap_closes():
    area = cg.HullArea("auto")
    counts = [touch(PLATE, tubes(0.03, d), area=area).n_clusters for d in (0.1, 0.5, 0.7, 1.0)]
    assert counts == [2, 2, 2, 1]


def test_regions_do_not_change_with_order_or_rigid_motion():
    points = tubes(0.03, 0.5)
    rows = np.flatnonzero(points[:, 2] < 0).astype(np.int32)
    own = regions(neighbours_of(points), rows, points)
    order = np.random.default_rng(2).permutation(len(points))
    place = np.argsort(order)
    c, sine = np.cos(0.7), np.sin(0.7)
    turned = points @ np.array([[c, sine, 0], [-sine, c, 0], [0, 0, 1]]) + [5.0, -3.0, 1.0]
    other = regions(neighbours_of(turned[order]), place[rows].astype(np.int32), turned[order])
    pairs = {(int(a), int(b)) for a, b in zip(own, other, strict=True)}
    assert len(pairs) == len(set(own.tolist())) == len(set(other.tolist())) == 2


def test_a_seam_does_not_part_a_region():
    tube = cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)])
    y = np.linspace(-0.3, 0.3, 13)
    points = np.array([[0.9, a, b] for a in y for b in y])
    state = touch(tube, points, area=cg.HullArea("auto", mapping="exact"))
    assert state.n_clusters == 1
    assert state.total_area == pytest.approx(2 * np.arctan(0.3 / 0.9) * 0.6, rel=1e-6)


def test_plate_in_full_contact_has_its_area_on_either_side():
    points, facets = lattice(4, 3)
    for kind in ("slave", "master"):
        state = touch(PLATE, points, facets, kind=kind)
        assert state.total_area == pytest.approx(12.0, rel=1e-12)
        assert state.n_clusters == 1


def test_first_touch_of_one_node_has_next_to_no_area():
    points, facets = lattice(4, 4, 0.1)
    points[12, 2] = -1e-6
    state = touch(PLATE, points, facets)
    assert state.n_contact == 1
    assert 0.0 < state.total_area < 1e-8


@pytest.mark.interpreted
def test_cut_of_one_facet_is_exact():
    points = np.array([[0.0, 0, -1.0], [1.0, 0, 1.0], [0, 1.0, 3.0]])
    state = touch(PLATE, points, [[0, 1, 2]], cg.FacetArea("slave"))
    whole = 0.5 * np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0]))
    assert state.total_area == pytest.approx(whole / 2 / 4, rel=1e-12)
    state = touch(PLATE, points, [[0, 1, 2]], cg.FacetArea("master"))
    assert state.total_area == pytest.approx(0.5 / 2 / 4, rel=1e-12)


def test_no_contact_is_no_area():
    points, facets = lattice(3, 3, 0.5)
    for area in (cg.FacetArea(), cg.CloudArea(), cg.HullArea(), cg.HullArea(3, mapping="exact")):
        state = touch(PLATE, points, facets, area)
        assert state.total_area == state.n_clusters == state.mean_pressure == 0
        assert state.max_pressure == 0.0
        assert np.isnan(state.centre_of_pressure).all()


@pytest.mark.parametrize("on", ["slave", "master"])
def test_facets_without_area_count_for_nothing(on):
    points, facets = lattice(2, 2)
    more = np.concatenate([facets, [[0, 0, 1], [3, 3, 3], [0, 3, 6]]])
    assert touch(PLATE, points, more, cg.FacetArea(on)).total_area == pytest.approx(4.0)
    points[0, 2] = 0.1  # now some of them are cut
    pair = (facets, more[:-1])  # the last is upright now, and has an area
    plain, with_more = (touch(PLATE, points, f, cg.FacetArea(on)) for f in pair)
    assert with_more.total_area == pytest.approx(plain.total_area, rel=1e-12)


def test_cloud_of_a_sheet_is_measured_like_its_mesh():
    points, facets = lattice(6, 6)
    points[:, 2] = 0.3 * points[:, 0] - 0.7
    mesh = touch(PLATE, points, facets)
    cloud = touch(PLATE, points, None, cg.CloudArea())
    assert cloud.total_area == pytest.approx(mesh.total_area, rel=1e-12)


def test_profiles_have_length_times_depth():
    body = cg.Body.from_profile(cg.shapes.circle(radius=1.0), depth=2.0)
    x = np.linspace(-1.0, 1.0, 201)
    points = np.column_stack([x, np.full(201, -0.8), np.zeros(201)])
    inside = np.abs(x) <= 0.6
    cloud = touch(body, points, None, cg.CloudArea())
    assert cloud.total_area == pytest.approx(2.0 * 0.01 * inside.sum(), rel=0.01)
    hull = touch(body, points, None, cg.HullArea("auto", mapping="exact"))
    assert hull.total_area == pytest.approx(2.0 * 2.0 * np.arccos(0.8), rel=0.01)


def test_pressure_is_force_over_area():
    points, facets = lattice(4, 4)
    slave = cg.Slave(points, facets)
    law = cg.StressLaw(10.0, thickness=1.0)
    state = cg.Contact(PLATE, slave, law=law, search="penetration").start(points)
    assert state.pressure == pytest.approx(np.ones(25))
    assert state.mean_pressure == pytest.approx(1.0)
    assert state.centre_of_pressure == pytest.approx([2.0, 2.0, 0.0])


def test_one_bad_point_leaves_the_other_facets():
    points, facets = lattice(4, 4)
    contact = cg.Contact(PLATE, cg.Slave(points, facets), law=cg.PenaltyLaw(1.0))
    state = contact.start(points + np.array([0, 0, 0.2]))
    bad = points.copy()
    bad[0] = np.nan
    state = contact.step(state, bad, dt=1.0)
    assert state.n_contact == 24
    assert state.total_area == pytest.approx(16.0 - 1.0)


@pytest.mark.parametrize(
    "make",
    [
        lambda: cg.FacetArea("both"),
        lambda: cg.CloudArea(bridge=0.5),
        lambda: touch(PLATE, np.zeros((3, 3)), None, cg.FacetArea()),
        lambda: touch(PLATE, np.zeros((1, 3)), None, cg.CloudArea()),
        lambda: topology_of(np.array([[0, 1, 7]], np.int32), 3),
        lambda: touch(PLATE, tubes(0.0, 0.1)[:, [0, 2, 1]] * [1, 1, 0], None, cg.CloudArea()),
    ],
)
def test_input_that_has_no_area_is_refused(make):
    with pytest.raises(InputError):
        make()


def test_facets_that_may_be_written_to_and_facets_that_may_not_are_one_version():
    facets = np.array([[0, 1, 2], [1, 3, 2]], np.int32)
    same = topology_of(locked(facets), 4)
    before = len(getattr(touch_nb.incidence, "overloads", ()))
    actual = topology_of(facets, 4)
    assert len(getattr(touch_nb.incidence, "overloads", ())) == before
    for own, other in zip(actual, same, strict=True):
        np.testing.assert_array_equal(own, other)
    assert not actual.facets.flags.writeable
