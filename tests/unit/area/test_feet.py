"""CloudArea by the feet: regions of clouds that are no sheet at rest."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError

BY_FEET = cg.CloudArea(by="feet")


def touch(body, points, area=BY_FEET, kind="slave"):
    contact = cg.Contact(
        body,
        cg.Slave(points),
        law=cg.PenaltyLaw(1.0),
        area=area,
        search="penetration",
        contact_type=kind,
    )
    state = contact.start(points)
    return state, contact.outlines(state)


def ball_cloud(n, radius, centre):
    """n points spread evenly over a whole sphere (golden spiral)."""
    k = np.arange(n) + 0.5
    z = 1.0 - 2.0 * k / n
    angle = np.pi * (1.0 + 5.0**0.5) * k
    r = np.sqrt(1.0 - z * z)
    return radius * np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1) + centre


def order(errors, sizes):
    return -np.polyfit(np.log(np.sqrt(sizes)), np.log(errors), 1)[0]


@pytest.mark.parametrize("kind", ["slave", "master"])
def test_closed_cloud_in_a_plane_has_its_cap_and_disc_to_second_order(kind):
    plate = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    exact = {"slave": 2 * np.pi * 0.2, "master": np.pi * (1.0 - 0.64)}[kind]
    sizes = (1000, 2000, 4000, 8000, 16000)
    errors = []
    for n in sizes:
        cloud = ball_cloud(n, 1.0, [0.0123, 0.0077, 0.8])
        state, _ = touch(plate, cloud, kind=kind)
        assert state.n_clusters == 1
        errors.append(abs(state.total_area / exact - 1.0))
    assert order(errors, sizes) >= 1.7  # one place of the cloud only: noise of the cut is in it
    assert errors[-1] < 1e-3


def test_same_cloud_is_refused_by_its_rest():
    plate = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    with pytest.raises(InputError, match="not a graph over its best-fit plane"):
        touch(plate, ball_cloud(1000, 1.0, [0, 0, 0.8]), cg.CloudArea())


def test_sheet_has_the_same_area_by_rest_and_by_feet():
    ball = cg.Body([cg.shapes.sphere(radius=1.0, centre=[0, 0, 0.8])])
    x, y = np.meshgrid(np.linspace(-1, 1, 61) + 0.003, np.linspace(-1, 1, 61) - 0.007)
    points = np.stack([x.ravel(), y.ravel(), 0.01 * x.ravel()], axis=1)
    rest, feet = (touch(ball, points, cg.CloudArea(by=by))[0] for by in ("rest", "feet"))
    assert feet.n_contact == rest.n_contact
    assert feet.total_area == pytest.approx(rest.total_area, rel=2e-3)
    assert feet.total_area == pytest.approx(np.pi * 0.36, rel=3e-3)


def test_region_round_a_pole_and_over_seams_is_whole():
    # A ball of points inside a hollow ball, touching at the master's pole, where its seam ends.
    hollow = cg.Body([cg.shapes.sphere(radius=1.0)]).flipped()
    r, c = 0.8, 0.22
    own = 2 * np.pi * r * ((r * r - 1.0 - c * c) / (2 * c) + c + r)
    state, found = touch(hollow, ball_cloud(12000, r, [0.0, 0.0, -c]))
    assert state.n_clusters == 1
    assert state.total_area == pytest.approx(own, rel=3e-3)
    assert len(found.clusters) == 1


def test_region_that_wraps_around_is_laid_out_in_its_parameters():
    # 300° of a cylinder, its seam inside: no plane shows it from one side.
    tube = cg.Body([cg.shapes.cylinder(radius=1.0, height=4.0)])
    angle = np.linspace(-np.radians(150), np.radians(150), 301)
    z = np.linspace(1.0, 2.0, 51)
    a, h = (v.ravel() for v in np.meshgrid(angle, z))
    points = np.stack([0.95 * np.cos(a), 0.95 * np.sin(a), h - 2.0 + 0.1], axis=1)
    state, _ = touch(tube, points, kind="master")
    assert state.n_contact == len(points)
    assert state.total_area == pytest.approx(np.radians(300), rel=1e-4)


def test_two_regions_of_one_closed_cloud():
    low = cg.shapes.plane(width=4.0, length=4.0, centre=[0, 0, -0.8])
    high = cg.shapes.plane(width=4.0, length=4.0, centre=[0, 0, 0.8]).flipped()
    state, found = touch(cg.Body([low, high]), ball_cloud(8000, 1.0, [0, 0, 0]))
    assert state.n_clusters == 2
    assert state.total_area == pytest.approx(2 * 2 * np.pi * 0.2, rel=3e-3)
    assert sorted(found.clusters.tolist()) == [0, 1]


def test_order_of_the_points_does_not_matter():
    plate = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    cloud = ball_cloud(2000, 1.0, [0.01, 0.02, 0.8])
    order = np.random.default_rng(3).permutation(len(cloud))
    state, mixed = touch(plate, cloud)[0], touch(plate, cloud[order])[0]
    assert mixed.area == pytest.approx(state.area[order], rel=1e-9, abs=1e-12)


def test_no_contact_has_no_area():
    plate = cg.Body([cg.shapes.plane(width=4.0, length=4.0)])
    state, found = touch(plate, ball_cloud(500, 1.0, [0, 0, 1.5]))
    assert state.total_area == len(found.clusters) == 0


def test_unknown_positions_are_refused():
    with pytest.raises(InputError, match="unknown positions"):
        cg.CloudArea(by="now")
