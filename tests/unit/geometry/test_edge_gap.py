"""How far the faces' images of an edge are from it."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.geometry.edge_gaps import image_length, image_of
from contiga.geometry.edges import UNTRIMMED, BodyEdge, EdgeUse


def plane(size=2.0):
    net = np.array([[[0, 0, 0], [0, size, 0]], [[size, 0, 0], [size, size, 0]]], dtype=float)
    return cg.NurbsSurface((1, 1), ([0, 0, size, size], [0, 0, size, size]), net)


def polyline(points):
    points = np.asarray(points, dtype=float)
    t = np.linspace(0.0, 1.0, len(points))
    return cg.NurbsCurve(1, np.concatenate([[0.0], t, [1.0]]), points)


def gap_to(curve, pcurve):
    edge = BodyEdge(curve, 0.0, (EdgeUse(0, 0, 0, False),))
    return image_of(edge, 0, [plane()], [((pcurve,),)])


def test_an_image_on_its_edge_has_no_gap():
    square = [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5], [0.5, 0.5]]
    actual = gap_to(polyline([[*p, 0.0] for p in square]), polyline(square))
    assert actual.gap == pytest.approx(0.0, abs=1e-15)


def test_the_gap_and_its_place():
    line = polyline([[0.5, 0.5, 0.01], [1.5, 0.5, 0.03]])
    actual = gap_to(line, polyline([[0.5, 0.5], [1.5, 0.5]]))
    assert actual.gap == pytest.approx(0.03, rel=1e-3)
    assert actual.point == pytest.approx((1.5, 0.5, 0.0))


def test_the_worst_is_found_between_samples():
    """A bulge of the p-curve, highest where no sample falls."""
    bulge = cg.NurbsCurve(
        3, [0, 0, 0, 0, 1, 1, 1, 1], [[0.5, 0.5], [0.6, 0.5], [0.7, 0.5009], [1.5, 0.5]]
    )
    fine = bulge.evaluate(np.linspace(0, 1, 20001))
    actual = gap_to(polyline([[0.5, 0.5, 0.0], [1.5, 0.5, 0.0]]), bulge)
    assert actual.gap == pytest.approx(float(fine[:, 1].max() - 0.5), rel=1e-6)


def test_parameters_need_not_agree():
    curve = cg.NurbsCurve(
        2, [0, 0, 0, 1, 1, 1], [[0.5, 0.5, 0], [0.6, 0.5, 0], [1.5, 0.5, 0]], [1.0, 5.0, 1.0]
    )
    assert gap_to(curve, polyline([[1.5, 0.5], [0.5, 0.5]])).gap < 1e-12


@pytest.mark.parametrize("teeth", [40, 1500])
def test_a_curve_that_comes_back_close_to_itself(teeth):
    """The nearest sample may lie on another tooth: the foot is looked for again, more densely."""
    x = np.linspace(0.5, 1.5, 2 * teeth + 1)
    zigzag = np.column_stack([x, np.where(np.arange(2 * teeth + 1) % 2, 1.5, 0.5)])
    actual = gap_to(polyline(np.column_stack([zigzag, 0 * x])), polyline(zigzag))
    assert actual.gap < 1e-12


def test_natural_sides_and_parts_of_them():
    patch = plane()
    side = EdgeUse(0, UNTRIMMED, 3, False)
    line = polyline([[0.5, 2.0, 0.0], [1.0, 2.0, 0.0]])
    half = BodyEdge(line, 0.0, (side,), ((0.5, 1.0),))
    whole = image_of(BodyEdge(line, 0.0, (side,)), 0, [patch], [None])
    part = image_of(half, 0, [patch], [None])
    assert whole.gap == pytest.approx(1.0)
    assert part.gap < 1e-15
    assert image_length(half, 0, [patch], [None]) == pytest.approx(0.5)


def test_whole_circles_and_their_halves_are_as_long():
    tube = cg.shapes.cylinder(radius=1.0, height=2.0)
    rim = tube.isocurve(v=0.0)
    side = EdgeUse(0, UNTRIMMED, 2, False)
    for low, high in ((0.0, 1.0), (0.0, 0.5), (0.5, 1.0)):
        edge = BodyEdge(rim, 0.0, (side,), ((low, high),))
        length = image_length(edge, 0, [tube], [None])
        assert length == pytest.approx(2.0 * np.pi * (high - low), rel=1e-4)


def test_images_pass_the_seam_of_a_closed_edge():
    """The nearest place may lie before the edge's end where the nearest sample is its start."""
    square = [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5], [0.5, 0.5]]
    edge = polyline([[*p, 0.0] for p in square])
    image = polyline([[0.5, 0.505], *square[:4], [0.5, 0.505]])
    assert gap_to(edge, image).gap == pytest.approx(0.0, abs=1e-14)
