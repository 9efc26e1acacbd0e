"""Proofs that triangles stay within a distance of the surface above them."""

from __future__ import annotations

import numpy as np
import pytest

from contiga import shapes
from contiga.geometry.kernels import chord_nb as chord

from .distances import distance_to_triangle


@pytest.mark.interpreted
def test_distance_to_a_triangle_in_every_region():
    rng = np.random.default_rng(0)
    a, b, c = rng.normal(size=(3, 3))
    for x in rng.normal(size=(200, 3)) * 3.0:
        expected = distance_to_triangle(x, a, b, c)
        assert chord.triangle_distance(x, a, b, c) == pytest.approx(expected, abs=1e-14)
    line = chord.triangle_distance(
        np.array([0.5, 1.0, 0.0]), *np.array([[0, 0, 0]] * 2 + [[1, 0, 0]], float)
    )
    assert line == pytest.approx(1.0)


@pytest.mark.interpreted
def test_proof_refuses_a_dome_that_is_too_high_and_takes_one_that_is_not():
    """A biquadratic dome over a flat quad has its top at a quarter of the middle point's height."""
    net = np.ones((3, 3, 4))
    net[..., 0], net[..., 1] = np.meshgrid([0, 0.5, 1], [0, 0.5, 1], indexing="ij")
    net[..., 2] = 0.0
    net[1, 1, 2] = 0.4
    one = np.ones(1, np.int64)
    for tol, proved in ((0.099, False), (0.101, True)):
        missed = np.ones((1, 1), dtype=np.bool_)
        chord.elements_within(net[None, None], one, one, tol, missed)
        assert missed[0, 0] != proved


@pytest.mark.interpreted
def test_proof_sees_what_bridges_the_edge_between_the_triangles():
    """All four points of a twisted bilinear patch lie on its triangles; its middle does not.

    The middle (½, ½, ¼) of the patch is 1/√24 = 0.204 from both triangles z = 0…y and z = 0…x.
    """
    net = np.ones((2, 2, 4))
    net[..., :3] = [[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 1]]]
    one = np.ones(1, np.int64)
    middle, quad = np.array([0.5, 0.5, 0.25]), net[[0, 1, 1, 0], [0, 0, 1, 1], :3]
    true = min(
        chord.triangle_distance(middle, quad[0], quad[1], quad[2]),
        chord.triangle_distance(middle, quad[0], quad[2], quad[3]),
    )
    for tol, proved in ((0.95 * true, False), (1.3 * true, True)):
        missed = np.ones((1, 1), dtype=np.bool_)
        chord.elements_within(net[None, None], one, one, tol, missed)
        assert missed[0, 0] != proved


@pytest.mark.interpreted
def test_restriction_is_the_part_of_the_polynomial():
    coefs = np.random.default_rng(0).normal(size=(4, 1, 2))
    part, turned = coefs.copy(), coefs.transpose(1, 0, 2).copy()
    chord.restrict(part, 0, 0.2, 0.7)
    chord.restrict(turned, 1, 0.2, 0.7)
    np.testing.assert_array_equal(turned[0], part[:, 0])
    ends = shapes.NurbsCurve(3, [0, 0, 0, 0, 1, 1, 1, 1], coefs[:, 0]).restricted(0.2, 0.7)
    np.testing.assert_allclose(part[:, 0], ends.control_points[:, :2], rtol=0, atol=1e-15)
