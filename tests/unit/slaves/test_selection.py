"""Part of a slave by nodes, box or side: what stays, what is active, what area it has."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.errors import MeshError
from contiga.rigid import pose

GRID = 11


def sheet() -> cg.Slave:
    """A square of side 10 of unit squares, z = 0, and a point of no facet."""
    x, y = np.meshgrid(np.arange(GRID), np.arange(GRID), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.zeros(GRID * GRID)], axis=1)
    index = np.arange(GRID * GRID).reshape(GRID, GRID)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1)
    return cg.Slave(np.vstack([points, [[50.0, 50.0, 50.0]]]), quads.reshape(-1, 4), name="sheet")


def ball() -> cg.Slave:
    mesh = cg.shapes.sphere(radius=2.0).tessellate(0.0002)
    return cg.Slave(mesh.vertices, mesh.triangles, name="ball")


def test_a_box_keeps_the_facets_with_all_corners_in_it() -> None:
    part = sheet().selected(box=[[2.0, 3.0, -1.0], [5.5, 5.0, 1.0]])
    assert len(part) == GRID * GRID + 1  # all points stay
    assert part.bounds().tolist() == [[2, 3, 0], [5, 5, 0]]
    assert part.active.sum() == 4 * 3
    assert part.area is not None
    assert part.area.sum() == pytest.approx(6.0)  # of 3 by 2 squares
    assert (part.area[~part.active] == 0.0).all()


def test_a_side_is_a_cap_of_the_ball_with_its_area() -> None:
    whole = ball()
    for angle in (45.0, 60.0, 90.0):
        cap = whole.selected(side=([0.0, 0.0, 5.0], angle))
        area = 2.0 * np.pi * 4.0 * (1.0 - np.cos(np.radians(angle)))
        assert cap.area is not None
        assert cap.area.sum() == pytest.approx(area, rel=0.05)
        lowest = 2.0 * np.cos(np.radians(angle))
        assert cap.bounds()[0, 2] == pytest.approx(lowest, abs=0.15)
    assert whole.selected(side=([0, 0, 1], 180.0)).facets.shape == whole.facets.shape


def test_criteria_are_fulfilled_together_and_one_after_the_other_alike() -> None:
    box, side = [[0.0, -3.0, -3.0], [3.0, 3.0, 3.0]], ([0.0, 0.0, 1.0], 60.0)
    both = ball().selected(box=box, side=side)
    after = ball().selected(box=box).selected(side=side)
    assert np.array_equal(both.active, after.active)
    assert np.array_equal(both.facets, after.facets)
    assert np.array_equal(both.area, after.area)


def test_given_areas_thickness_and_mass_are_kept() -> None:
    whole = sheet()
    count = len(whole)
    given = cg.Slave(
        whole.points, whole.facets, area=np.full(count, 7.0), thickness=np.full(count, 2.0),
        mass=np.arange(count), unit="mm",
    )  # fmt: skip
    part = given.selected(nodes=np.arange(GRID * 2))
    assert part.area.tolist() == given.area.tolist()
    assert part.thickness.tolist() == given.thickness.tolist()
    assert part.mass.tolist() == given.mass.tolist()
    assert part.unit == "mm"
    assert part.active.sum() == GRID * 2


def test_points_of_a_cloud_are_chosen_one_by_one() -> None:
    cloud = cg.Slave(sheet().points)
    part = cloud.selected(box=[[0, 0, 0], [1, 1, 0]])
    assert part.facets is None
    assert part.active.sum() == 4
    mask = np.zeros(len(cloud), dtype=bool)
    mask[[3, 7]] = True
    assert cloud.selected(nodes=mask).active.tolist() == mask.tolist()


def test_points_that_are_not_active_are_never_chosen() -> None:
    part = sheet().selected(box=[[0, 0, 0], [60, 60, 60]])
    assert not part.active[-1]


def test_only_what_is_chosen_touches() -> None:
    """A ball pressed into the sheet: two halves of it carry the force of the whole."""
    body = cg.Body([cg.shapes.sphere(radius=3.0)])
    place = np.eye(4)
    place[:3, 3] = -5.0, -5.0, 2.5
    whole = sheet().transformed(place)

    def force(slave: cg.Slave) -> float:
        contact = cg.Contact(
            body, slave, law=cg.PenaltyLaw(10.0, per_area=True), search="penetration"
        )
        state = contact.start(slave.points)
        return float(state.total_force[2])

    left = whole.selected(box=[[-9, -9, -9], [0, 9, 9]])
    right = whole.selected(box=[[0, -9, -9], [9, 9, 9]])
    assert force(left) > 0.0
    assert force(left) + force(right) == pytest.approx(force(whole))


@pytest.mark.parametrize("scale", [1.0, 1e-3, 25.4])
def test_areas_of_a_part_are_those_of_its_facets_wherever_it_was_put(scale: float) -> None:
    place = pose.compose(pose.translation([0.1, 0.2, -10.1]), pose.rotation([1, 2, 3], 0.7))
    here = sheet().selected(box=[[0, 0, 0], [4.1, 9, 9]])
    moved = sheet().transformed(place).scaled(scale).selected(nodes=here.active)
    assert moved.area.sum() == pytest.approx(here.area.sum() * scale**2, rel=1e-12)
    assert here.area.sum() < 0.9 * sheet().area.sum()


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"box": [[20, 0, 0], [30, 9, 9]]}, r"sheet, box: no point lies in the box; found .*"
         r"allowed: a box about some of \[0\.0, 0\.0, 0\.0\] to \[10\.0, 10\.0, 0\.0\]"),
        ({"box": [[0.1, 0.1, 0], [1.1, 1.1, 0]]}, "no whole facet of it is chosen"),
        ({"box": [[1, 0, 0], [0, 1, 1]]}, "a box needs its lowest and its highest corner"),
        ({"box": [0, 1]}, "a box needs its lowest"),
        ({"box": "all"}, "a box needs its lowest"),
        ({"side": ([0, 0, 0], 10.0)}, "a direction is three numbers"),
        ({"side": ([0, 1], 10.0)}, "a direction is three numbers"),
        ({"side": ([0, 0, 1], 0.0)}, "an angle .* allowed: above 0, up to 180"),
        ({"side": ([0, 0, -1], 90.0)}, "no facet faces that way to 90 degrees"),
        ({"nodes": [200]}, "the numbers of points"),
        ({"nodes": [0.5]}, "the numbers of points"),
        ({"nodes": [True]}, r"allowed: \(122,\) of bool"),
    ],
)  # fmt: skip
def test_what_chooses_nothing_is_refused(given: dict[str, object], message: str) -> None:
    with pytest.raises(MeshError, match=message):
        sheet().selected(**given)


def test_a_cloud_has_no_sides() -> None:
    with pytest.raises(MeshError, match="a cloud has no sides"):
        cg.Slave(sheet().points, name="dust").selected(side=([0, 0, 1], 30.0))
