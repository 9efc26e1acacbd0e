"""Outlines close around regions, go around holes, and enclose the area."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg

PLATE = cg.Body([cg.shapes.plane(width=20.0, length=20.0)])


def sheet(n, half, shift=(0.0123, 0.0077)):
    x = np.linspace(-half, half, n + 1)
    xy = np.stack(np.meshgrid(x + shift[0], x + shift[1], indexing="ij"), -1).reshape(-1, 2)
    i = np.arange(len(xy)).reshape(n + 1, n + 1)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return xy, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def outlines(body, points, facets, area, kind="slave"):
    contact = cg.Contact(
        body,
        cg.Slave(points, facets),
        law=cg.PenaltyLaw(1.0),
        area=area,
        search="penetration",
        contact_type=kind,
    )
    state = contact.start(points)
    return state, contact.outlines(state)


def loops_of(found):
    return [found.points[a:b] for a, b in zip(found.first, found.first[1:], strict=False)]


def enclosed(loop):
    x, y = loop[:, :2].T
    return 0.5 * abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def test_outline_of_a_disc_is_its_circle_and_encloses_the_area():
    xy, facets = sheet(40, 1.0)
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=[0, 0, 0.8])])
    state, found = outlines(ball, np.column_stack([xy, 0 * xy[:, 0]]), facets, cg.FacetArea())
    (loop,) = loops_of(found)
    assert found.clusters.tolist() == [0]
    assert np.linalg.norm(loop[:, :2], axis=1) == pytest.approx(0.6, abs=2e-3)
    assert enclosed(loop) == pytest.approx(state.total_area, rel=1e-12)
    # Neighbours along the line are no farther apart than a facet is wide.
    step = np.linalg.norm(loop - np.roll(loop, 1, axis=0), axis=1)
    assert step.max() < 1.5 * 0.05


def test_outline_on_the_master_lies_on_it():
    xy, facets = sheet(40, 1.0)
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=[0, 0, 0.8])])
    points = np.column_stack([xy, 0 * xy[:, 0]])
    _, found = outlines(ball, points, facets, None, "master")
    assert np.linalg.norm(found.points - [0, 0, 0.8], axis=1) == pytest.approx(1.0, abs=1e-12)


def test_a_ring_has_an_outer_and_an_inner_outline_of_one_region():
    xy, facets = sheet(60, 1.6)
    ring = cg.Body([cg.shapes.torus(major=1.0, minor=0.4)])
    points = np.column_stack([xy, np.full(len(xy), 0.3)])
    state, found = outlines(ring, points, facets, cg.FacetArea("slave"))
    areas = sorted(enclosed(loop) for loop in loops_of(found))
    assert found.clusters.tolist() == [0, 0]
    assert areas[1] - areas[0] == pytest.approx(state.total_area, rel=1e-12)


def test_two_regions_have_an_outline_each():
    xy, facets = sheet(60, 1.3)
    two = cg.Body([cg.shapes.sphere(radius=0.5, centre=[x, 0, 0]) for x in (-0.6, 0.6)])
    points = np.column_stack([xy, np.full(len(xy), 0.35)])
    for area in (cg.FacetArea(), cg.CloudArea(), cg.HullArea("auto", mapping="exact")):
        state, found = outlines(two, points, facets, area)
        assert sorted(set(found.clusters.tolist())) == [0, 1]
        for loop, cluster in zip(loops_of(found), found.clusters, strict=True):
            side = np.sign(points[state.clusters == cluster, 0].mean())
            assert (side * loop[:, 0] > 0.0).all()


def test_a_sheet_wholly_in_contact_ends_at_its_rim():
    xy, facets = sheet(3, 1.0, (0.0, 0.0))
    points = np.column_stack([xy, np.full(len(xy), -0.1)])
    _, found = outlines(PLATE, points, facets, cg.FacetArea())
    (loop,) = loops_of(found)
    assert len(loop) == 12
    assert enclosed(loop) == pytest.approx(4.0)


def test_hull_goes_over_a_seam_on_the_surface():
    tube = cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)])
    y = np.linspace(-0.3, 0.3, 13)
    points = np.array([[0.9, a, b] for a in y for b in y])
    _, found = outlines(tube, points, None, cg.HullArea("auto", mapping="exact"))
    (loop,) = loops_of(found)
    assert np.linalg.norm(loop[:, :2], axis=1) == pytest.approx(1.0, abs=1e-12)
    assert np.abs(np.arctan2(loop[:, 1], loop[:, 0])).max() == pytest.approx(np.arctan(1 / 3))


def test_no_contact_has_no_outline_and_constant_areas_tell_none():
    xy, facets = sheet(3, 1.0)
    points = np.column_stack([xy, np.full(len(xy), 0.1)])
    for area in (cg.FacetArea(), cg.CloudArea(), cg.HullArea()):
        _, found = outlines(PLATE, points, facets, area)
        assert len(found.points) == len(found.clusters) == 0
        assert found.first.tolist() == [0]
    assert outlines(PLATE, points, facets, cg.NodalArea(1.0))[1] is None


def test_outline_moves_with_its_master():
    xy, facets = sheet(20, 1.0)
    points = np.column_stack([xy, 0 * xy[:, 0]])
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    contact = cg.Contact(
        ball, cg.Slave(points, facets), law=cg.PenaltyLaw(1.0), search="penetration"
    )
    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [0, 0, -1], [1, 0, 0]]
    pose[:3, 3] = [0.0, 0.0, 0.8]
    actual = contact.outlines(contact.start(points, pose), pose)
    assert np.abs(actual.points[:, 2]).max() < 1e-12
    assert np.linalg.norm(actual.points[:, :2], axis=1) == pytest.approx(0.6, abs=1e-2)
