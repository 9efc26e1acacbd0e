"""Leaves over trimming curves."""

from __future__ import annotations

import numpy as np
from tests.unit.search.holed import holed_plate, leaf_boxes

from contiga.search.hierarchy.kernels import curve_nb
from contiga.search.tables import tables_of


def test_leaves_of_trimming_curves_cover_them_and_their_bounds_hold():
    tables = tables_of(holed_plate())
    low, high = leaf_boxes(tables)
    curves = np.flatnonzero(tables.leaves["element"] < 0)
    length = np.zeros(len(tables.trims.piece_degree))
    h, d = np.empty((4, 6)), np.empty((3, 3))
    for k in curves:
        leaf = tables.leaves[k]
        piece = -1 - leaf["element"]
        t0, t1 = leaf["box"][:2]
        length[piece] += t1 - t0
        for t in np.linspace(t0, t1, 7)[1:-1]:
            e = curve_nb.curve_point(tables.elements, tables.grid, tables.trims, piece, t, h, d)[0]
            x = d[0] + tables.elements.table[e]["origin"]
            assert (low[k] <= x).all()
            assert (x <= high[k]).all()
            assert np.linalg.norm(d[1]) <= leaf["bound"][0] * (1 + 1e-12)
            assert np.linalg.norm(d[2]) <= leaf["bound"][1] * (1 + 1e-12)
    np.testing.assert_allclose(length, 1.0, atol=1e-10)
