"""Points x = N q of splines, and forces that go back."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.matter import rig
from tests.unit.matter.iga.shells import crooked, made, plate, tube

from contiga.errors import InputError

pytestmark = pytest.mark.interpreted


@pytest.mark.parametrize(("contact", "each"), [("gauss", None), ("gauss", 2), ("grid", 3)])
def test_forces_on_points_do_the_same_work_on_control_points(
    contact: str, each: int | None
) -> None:
    shell = made([crooked(2, (2, 1))], contact=contact, points=each)
    q = rig.moved(shell.nodes, 0.1)
    x = shell.points(q)
    assert x.shape == (2 * (each or 3) ** 2, 3)
    random = np.random.default_rng(0)
    force, way = random.normal(size=x.shape), random.normal(size=q.shape)
    spread = shell.spread(force)
    assert np.sum(force * shell.points(way)) == pytest.approx(np.sum(spread * way), rel=1e-13)
    np.testing.assert_allclose(spread.sum(axis=0), force.sum(axis=0), atol=1e-13)
    moment = np.cross(x, force).sum(axis=0)
    np.testing.assert_allclose(np.cross(q, spread).sum(axis=0), moment, atol=1e-13)
    some = np.array([1, 4, 5])
    np.testing.assert_array_equal(shell.contact.rows.at(some).times(q), x[some])
    whole = shell.contact.rows.matrix(len(q))
    np.testing.assert_allclose(whole @ q, x, atol=1e-15)


def test_weights_are_areas_at_rest() -> None:
    arch = tube(2.0, 3.0, (2.5, 0.6), 2, (3, 2))
    area = 2.0 * 1.9 * 3.0
    for contact, slack in (("gauss", 1e-6), ("grid", 1e-3)):
        shell = made([arch], contact=contact, points=8)
        assert shell.contact.weight.sum() == pytest.approx(area, rel=slack)
    assert made([arch]).mass.sum() == pytest.approx(2.0 * 0.1 * area, rel=1e-6)


def test_points_lie_on_the_surface_between_their_facets() -> None:
    arch = tube(2.0, 3.0, (2.5, 0.6), 2, (3, 2))
    shell = made([arch, arch.translated([0.0, 3.0, 0.0])], contact="gauss")
    for points in (shell.contact, shell.drawn(4)):
        x = points.points(shell.nodes)
        np.testing.assert_allclose(np.hypot(x[:, 0], x[:, 2]), 2.0, rtol=1e-12)
        corners = x[points.facets]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        along = points.normals(shell.nodes)[points.facets[:, 0]]
        assert (np.sum(normals * along, axis=1) > 0.0).all()
    assert shell.contact.facets.max() == len(shell.contact.weight) - 1
    drawn = shell.drawn(4)
    assert not drawn.measure.any()
    np.testing.assert_allclose(drawn.points(shell.nodes)[:, 1].max(), 6.0, rtol=1e-12)


def test_a_pressure_pushes_along_the_normal_by_the_area() -> None:
    size = np.array([2.0, 3.0])
    shell = made([plate(2, (2, 2), (2.0, 3.0))])
    force = shell.pressure(shell.nodes * [1.5, 1.0, 1.0])
    np.testing.assert_allclose(force.sum(axis=0), [0.0, 0.0, 1.5 * size.prod()], atol=1e-12)


@pytest.mark.parametrize(
    ("contact", "each", "told"),
    [("middle", 2, "contact: is not known"), ("gauss", 0, "points: must be a whole number")],
)
def test_other_points_are_refused(contact: str, each: int, told: str) -> None:
    with pytest.raises(InputError, match=told):
        made([plate(2, (1, 1), (1.0, 1.0))], contact=contact, points=each)
