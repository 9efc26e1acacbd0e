"""A Bézier element is the surface over its part of the patch, with derivatives."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.elements.kernels import element_nb
from contiga.search.tables import tables_of

PATCHES = {
    "torus": cg.shapes.torus(),
    "bumps": cg.shapes.bumpy_plate(waves=2),
    "ninth": cg.NurbsSurface(
        (9, 2),
        [np.repeat([0.0, 1.0], 10), np.repeat([0.0, 1.0], 3)],
        np.random.default_rng(0).random((10, 3, 3)),
    ),
}


@pytest.mark.parametrize("name", PATCHES)
def test_elements_are_the_surface_and_its_derivatives(name):
    patch, rng, h = PATCHES[name], np.random.default_rng(1), np.empty((4, 6))
    elements = tables_of(cg.Body([patch])).elements
    for e in range(0, len(elements.table), 3):
        row = elements.table[e]
        u0, u1, v0, v1 = row["box"]
        for s, t in rng.uniform(-0.5, 0.5, (5, 2)):
            element_nb.evaluate(elements, e, s, t, h)
            uv = [u0 + (s + 0.5) * (u1 - u0), v0 + (t + 0.5) * (v1 - v0)]
            D = patch.derivatives(np.array([uv]), 2)[0]
            expected = [D[0, 0] - row["origin"], D[1, 0] * (u1 - u0), D[0, 1] * (v1 - v0)]
            expected += [D[2, 0] * (u1 - u0) ** 2, D[1, 1] * (u1 - u0) * (v1 - v0)]
            expected += [D[0, 2] * (v1 - v0) ** 2]
            size = np.abs(expected).max()
            np.testing.assert_allclose(h[:3].T, expected, rtol=0, atol=1e-11 * size)
