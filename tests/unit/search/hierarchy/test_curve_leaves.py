"""Leaves over trimming curves."""

from __future__ import annotations

import numpy as np
from numba import njit
from tests import occ_solids
from tests.unit.search.holed import holed_plate, leaf_boxes

import contiga as cg
from contiga.geometry.kernels.trim_nb import point_in_trim
from contiga.search.hierarchy.kernels import curve_nb
from contiga.search.hierarchy.kernels.curve_leaves_nb import MAX_DEVIATION
from contiga.search.tables import tables_of


@njit
def piece_parameters(trims, piece, t, c):
    curve_nb.piece_parameters(trims, piece, t, c)


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


def trimmed_solid(tmp_path):
    return cg.read_cad(occ_solids.write(occ_solids.crossing_bores(), tmp_path / "solid.step"))


def test_the_way_into_the_face_is_never_farther_off_than_it_says(tmp_path):
    known = 0
    for body in (holed_plate(), holed_plate().flipped(), trimmed_solid(tmp_path)):
        tables = tables_of(body)
        h, d = np.empty((4, 6)), np.empty((3, 3))
        for leaf in tables.leaves[tables.leaves["element"] < 0]:
            way, off = leaf["bound"][3:6], leaf["bound"][6]
            if off >= MAX_DEVIATION:
                continue
            piece, (t0, t1) = -1 - leaf["element"], leaf["box"][:2]
            middle = 0.5 * (t0 + t1)
            curve_nb.curve_point(tables.elements, tables.grid, tables.trims, piece, middle, h, d)
            tangent = d[1] / np.linalg.norm(d[1])
            for t in np.linspace(t0, t1, 5):
                curve_nb.curve_point(tables.elements, tables.grid, tables.trims, piece, t, h, d)
                across_side = np.cross(np.cross(h[:3, 1], h[:3, 2]), d[1])
                across_side *= np.copysign(1.0, across_side @ way) / np.linalg.norm(across_side)
                assert np.linalg.norm(across_side - way) <= off + 1e-9
                normal = np.cross(h[:3, 1], h[:3, 2]) / np.linalg.norm(np.cross(h[:3, 1], h[:3, 2]))
                middle_normal = leaf["bound"][7] * np.cross(tangent, way)
                assert np.linalg.norm(np.cross(normal, middle_normal)) <= leaf["bound"][8] + 1e-9
                assert normal @ middle_normal > 0.0
            known += 1
            assert leads_in(body, tables, leaf)
    assert known > 100


def leads_in(body, tables, leaf):
    """Whether the face goes on from the middle of a leaf that way, and not the other way."""
    piece, t = -1 - leaf["element"], 0.5 * leaf["box"][:2].sum()
    c, h, d = np.empty((3, 3)), np.empty((4, 6)), np.empty((3, 3))
    piece_parameters(tables.trims, piece, t, c)
    e = curve_nb.curve_point(tables.elements, tables.grid, tables.trims, piece, t, h, d)[0]
    patch = int(tables.trims.piece_patch[piece])
    box = tables.elements.table["box"][e].reshape(2, 2)
    step = np.linalg.lstsq(h[:3, 1:3], leaf["bound"][3:6], rcond=None)[0] * np.ptp(box, axis=1)
    step *= 1e-4 / np.abs(step / np.diff(body.patches[patch].domain)[:, 0]).max()
    low, high = np.array(body.patches[patch].domain).T

    def inside(uv):
        there = (low <= uv).all() and (uv <= high).all()
        return there and point_in_trim(tables.trims, patch, *uv) == 1

    return inside(c[0, :2] + step) and not inside(c[0, :2] - step)
