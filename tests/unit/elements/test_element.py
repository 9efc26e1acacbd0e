"""A Bézier element is the surface over its part of the patch, in every form."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.elements.extraction import elements_of
from contiga.elements.kernels import element_nb


def patch_of(seed, p, q, weights=2.0):
    rng = np.random.default_rng(seed)
    net = rng.normal(size=(p + 1, q + 1, 3))
    w = 10 ** rng.uniform(-weights / 2, weights / 2, (p + 1, q + 1))
    U, V = (np.repeat([0.0, 1.0], d + 1) for d in (p, q))
    return cg.NurbsSurface((p, q), (U, V), net, w)


@pytest.mark.interpreted
@pytest.mark.parametrize("degree", [(1, 1), (3, 3), (4, 5), (6, 3), (15, 2)])
def test_elements_evaluate_as_their_surface_in_every_form(degree):
    patch = patch_of(sum(degree), *degree, weights=1.0)
    body = cg.Body([patch])
    elements = elements_of(body, body.trim_tables)[0]
    h = np.empty((4, 6))
    for u, v in [(0.0, 0.0), (0.3, 0.8), (1.0, 0.5)]:
        element_nb.evaluate(elements, 0, u - 0.5, v - 0.5, h)
        D = patch.derivatives([[u, v]], order=2)[0]
        expected = np.stack([D[0, 0], D[1, 0], D[0, 1], D[2, 0], D[1, 1], D[0, 2]], axis=1)
        expected[:, 0] -= elements.table[0]["origin"]
        scale = 1.0 + np.abs(expected).max()
        np.testing.assert_allclose(h[:3], expected, rtol=0, atol=1e-10 * scale)
