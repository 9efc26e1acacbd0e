"""Surroundings beside narrow elements: as deep as rows and columns of parts make them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numba import njit
from tests.sample import few
from tests.stress.tracking import slivers
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.search.certify.kernels import branch_nb
from contiga.search.hierarchy.table_types import Tables

SHARES = np.array([0.0, 0.203, 0.2142, 0.4537, 0.5211, 0.5232, 0.8059, 1.0])
"""Where `slivers` cuts."""


def uneven_plane(shares: np.ndarray = SHARES) -> cg.NurbsSurface:
    """The unit square in one patch whose knots are where `slivers` cuts."""
    knots = np.concatenate([[0.0, 0.0], shares, [1.0, 1.0]])
    x = 0.5 * (knots[1:-2] + knots[2:-1])
    net = np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((len(x), len(x)))], axis=-1)
    return cg.NurbsSurface((2, 2), (knots, knots), net)


def parts_of(tables) -> np.ndarray:
    """(elements, 16, 4) u0, u1, v0, v1 of all parts."""
    box = tables.elements.table["box"]
    i, j = np.divmod(np.arange(16), 4)
    u, v = box[:, :1], box[:, 2:3]
    du, dv = (box[:, 1:2] - u) / 4, (box[:, 3:4] - v) / 4
    return np.stack([u + i * du, u + (i + 1) * du, v + j * dv, v + (j + 1) * dv], axis=-1)


def depth(parts: np.ndarray, block: np.ndarray) -> np.ndarray:
    """How far the rim of a block is from a part in it."""
    return np.abs(parts - block).min(axis=-1)


@pytest.fixture(scope="module")
def uneven() -> Tables:
    """Of the uneven plane; without the compiler of one with a narrow row and column alone."""
    return tracking_tables_of(cg.Body([uneven_plane(few(SHARES, SHARES[[0, 4, 5, 7]]))]))


@pytest.mark.interpreted
def test_no_way_as_short_as_the_room_leads_out_of_a_block_of_a_plane(uneven):
    tables = uneven
    neighbourhoods, parts = tables.neighbourhoods, parts_of(tables)
    inside = neighbourhoods["ends"].sum(axis=-1) == 0
    room, deep = (
        neighbourhoods["room"][inside],
        depth(parts[inside], neighbourhoods["block"][inside]),
    )
    assert inside.sum() > few(400, 80)
    assert (room <= deep * (1.0 + 1e-9)).all()
    # A tenth of the parts are so narrow that a plain neighbourhood of parts is less deep than this.
    width = np.minimum(*(parts[inside][:, k + 1] - parts[inside][:, k] for k in (0, 2)))
    assert (width < 1e-3).mean() > 0.1
    assert np.percentile(room, 1) > 2e-3


def test_a_surface_cut_and_turned_has_the_surroundings_of_one_that_is_not_turned():
    """Rooms and curvatures of parts in the same place."""
    patch = cg.shapes.torus(major=1.0, minor=0.4)
    u, v = (low + (high - low) * SHARES for low, high in patch.domain)
    whole = [patch.restricted(u[i : i + 2], v[j : j + 2]) for i in range(7) for j in range(7)]
    found = []
    for patches in (whole, slivers(patch)):
        body = cg.Body(patches)
        tables = tracking_tables_of(body)
        parts, of = parts_of(tables), tables.elements.table["patch"]
        middle = np.stack([parts[..., :2].mean(axis=-1), parts[..., 2:].mean(axis=-1)], axis=-1)
        at = np.concatenate(
            [body.patches[p].evaluate(uv) for p, uv in zip(of, middle, strict=True)]
        )
        order = np.lexsort(at.round(9).T)
        neighbourhoods = tables.neighbourhoods.ravel()[order]
        # Turned over, inner and outer curvatures change places.
        bend = np.sort(neighbourhoods["curvature"], axis=-1)
        found.append((at[order], neighbourhoods["room"], bend, neighbourhoods["ends"].sum(axis=-1)))
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9)


def test_speeds_widths_and_curvatures_hold_within_wide_blocks():
    patch = cg.shapes.bumpy_plate(waves=1)
    body = cg.Body(slivers(patch))
    tables, rng = tracking_tables_of(body), np.random.default_rng(0)
    table = tables.elements.table
    for e in rng.choice(len(table), 60):
        neighbourhood, own = (
            tables.neighbourhoods[e, rng.integers(16)],
            body.patches[table[e]["patch"]],
        )
        u0, u1, v0, v1 = neighbourhood["block"]
        uv = rng.uniform([u0, v0], [u1, v1], (200, 2))
        D = own.derivatives(uv, 2)
        u, v = D[:, 1, 0], D[:, 0, 1]
        assert (np.linalg.norm(u, axis=1) <= neighbourhood["speed"][0] * (1.0 + 1e-9)).all()
        assert (np.linalg.norm(v, axis=1) <= neighbourhood["speed"][1] * (1.0 + 1e-9)).all()
        n = np.cross(u, v)
        area = np.linalg.norm(n, axis=1)
        assert (area / np.linalg.norm(v, axis=1) >= neighbourhood["width"][0] * (1.0 - 1e-9)).all()
        n /= area[:, None]
        first = np.stack([(u * u).sum(1), (u * v).sum(1), (u * v).sum(1), (v * v).sum(1)], -1)
        second = [(D[:, 2, 0] * n).sum(1), (D[:, 1, 1] * n).sum(1), (D[:, 0, 2] * n).sum(1)]
        second = np.stack([second[0], second[1], second[1], second[2]], -1)
        shape = np.linalg.solve(first.reshape(-1, 2, 2), second.reshape(-1, 2, 2))
        bend = np.linalg.eigvals(shape).real
        assert bend.max() <= neighbourhood["curvature"][0] * (1.0 + 1e-9) + 1e-9
        assert -bend.min() <= neighbourhood["curvature"][1] * (1.0 + 1e-9) + 1e-9


@njit
def path_across_side(table, neighbourhoods, foot, start):
    return branch_nb.path_across_side(table, neighbourhoods, foot, start)


@pytest.mark.parametrize("name", ["plane", "torus"])
def test_ways_over_sides_slivers_and_corners_are_no_shorter_than_the_straight_ones(name):
    """And infinite where the surroundings, those of the surface in one piece, hold no start."""
    patch = uneven_plane() if name == "plane" else cg.shapes.torus(major=1.0, minor=0.4)
    body, whole = cg.Body(slivers(patch)), tracking_tables_of(cg.Body([uneven_plane()]))
    tables, rng = tracking_tables_of(body), np.random.default_rng(2)
    table, parts = tables.elements.table, parts_of(whole).reshape(-1, 4)
    low, high = np.array(patch.domain).T
    on = patch.evaluate(low + (high - low) * rng.random((6000, 2)))
    foot = body.project(on)
    start = body.project(on + 10.0 ** rng.uniform(-3, -1, (6000, 1)) * rng.normal(size=on.shape))
    box, told, corners = table["box"], 0, 0
    of = [np.flatnonzero(table["patch"] == p) for p in range(len(body.patches))]

    def place(feet, k):
        for e in of[feet.patch[k]]:
            low, high = box[e, ::2], box[e, 1::2]
            if (low <= feet.uv[k]).all() and (feet.uv[k] <= high).all():
                return int(e), *((feet.uv[k] - low) / (high - low) - 0.5).tolist()
        raise AssertionError

    for k in np.flatnonzero(foot.patch != start.patch):
        here, there = place(foot, k), place(start, k)
        way = path_across_side(table, tables.neighbourhoods, here, there)
        straight = np.linalg.norm(foot.point[k] - start.point[k])
        assert way >= straight * (1.0 - 1e-9)
        if way < np.inf:
            told += 1
            corners += int(there[0] not in table["neighbour"][here[0]])
            assert way < 4.0 * straight + 0.05
            if name == "plane":  # parameters of the whole are coordinates
                x, y, _ = foot.point[k]
                own = (parts[:, 0] <= x) & (x <= parts[:, 1]) & (parts[:, 2] <= y)
                block = whole.neighbourhoods["block"].reshape(-1, 4)[own & (y <= parts[:, 3])][0]
                off = start.point[k, :2]
                assert (block[::2] - 1e-9 <= off).all()
                assert (off <= block[1::2] + 1e-9).all()
    assert told > 100
    assert corners > 8


def test_parts_beside_a_face_that_is_trimmed_have_no_room_there():
    """Whether a hole is within reach is told by the patch of a foot alone."""
    left, right = cg.shapes.plane().split(u=0.5)
    hole = np.array([[0.55, 0.3], [0.7, 0.3], [0.7, 0.7], [0.55, 0.7], [0.55, 0.3]])
    (u0, u1), (v0, v1) = right.domain
    rim = np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1], [u0, v0]])

    def loop(points):
        return [cg.shapes.line([*a, 0.0], [*b, 0.0]) for a, b in pairwise(points)]

    whole = tracking_tables_of(cg.Body([left, right]))
    holed = tracking_tables_of(cg.Body([left, right], trims=[None, [loop(rim), loop(hole)]]))
    beside = np.arange(16) >= 12
    assert whole.neighbourhoods["reach"][0, beside].any(axis=-1).all()
    assert (whole.neighbourhoods["room"][0, beside] > 0.0).all()
    assert (holed.neighbourhoods["room"][0, beside] == 0.0).all()
    assert (holed.neighbourhoods["room"][0, ~beside] > 0.0).all()


@pytest.mark.interpreted
def test_what_is_reached_beyond_a_side_is_what_the_block_holds_of_the_next_element(uneven):
    tables = uneven
    table, seen = tables.elements.table, set()
    for e, part in np.ndindex(tables.neighbourhoods.shape):
        neighbourhood = tables.neighbourhoods[e, part]
        for side, n in enumerate(table["neighbour"][e]):
            if n >= 0:
                box = table["box"][n]
                wide = (box[2 * (side // 2) + 1] - box[2 * (side // 2)]) / 4
                beyond = (neighbourhood["block"][side] - table["box"][e][side]) * (
                    1 if side % 2 else -1
                )
                assert neighbourhood["reach"][side] == np.clip(round(beyond / wide), 0, 4)
                seen.add(int(neighbourhood["reach"][side]))
    assert seen == {0, 1, 2, 3, 4}


@pytest.mark.parametrize("count", [3, 5])
def test_where_other_than_four_elements_meet_there_are_no_rows_and_columns(count):
    """Kites of a plane around one corner: there is no wider rectangle about it than one part."""
    angle = np.pi / count * np.arange(2 * count + 1)
    rim = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    body = cg.Body(
        [
            cg.shapes.bilinear([0, 0, 0], rim[2 * k], rim[2 * k + 2], 1.5 * rim[2 * k + 1])
            for k in range(count)
        ]
    )
    tables = tracking_tables_of(body)
    assert (tables.elements.table["kind"][:, [0, 2]] == 0).all()
    at_corner = tables.neighbourhoods[:, 0]
    assert (at_corner["room"] > 0.0).all()
    assert at_corner["reach"][:, [0, 2]].max() == 1
    assert at_corner["reach"][:, [1, 3]].max() == 0
