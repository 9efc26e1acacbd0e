"""Closed or open, and by how much: told by the edges."""

from __future__ import annotations

import math
from types import ModuleType

import numpy as np
import pytest

import contiga as cg
from contiga.geometry.edges import UNTRIMMED, BodyEdge, EdgeUse
from contiga.search.borders.openings import openings_of


def bilinear(a, b, c, d):
    """The plane patch a, b along u and a, c along v."""
    net = np.array([[a, c], [b, d]], dtype=float)
    return cg.NurbsSurface((1, 1), ([0, 0, 1, 1], [0, 0, 1, 1]), net)


def box_patches(lift=0.0):
    """Six sides of a unit box, normals outward; the top `lift` too high."""
    faces = []
    for axis in range(3):
        for end in (0.0, 1.0):
            u, v = np.eye(3)[(axis + 1) % 3], np.eye(3)[(axis + 2) % 3]
            if end == 0.0:
                u, v = v, u
            corner = np.eye(3)[axis] * (end + (lift if axis == 2 and end else 0.0))
            faces.append(bilinear(corner, corner + u, corner + v, corner + u + v))
    return faces


def named_edges(patches, near, tolerance):
    """Every side of `patches` as a use of an edge; sides closer than `near` share one."""
    edges = []
    for k, patch in enumerate(patches):
        (u0, u1), (v0, v1) = patch.domain
        for side in range(4):
            curve = patch.isocurve(**{"u" if side < 2 else "v": (u0, u1, v0, v1)[side]})
            ends = curve.evaluate([0.0, 1.0])
            for i, (other, points, uses) in enumerate(edges):
                for turned, own in ((False, ends), (True, ends[::-1])):
                    if np.abs(points - own).max() <= near:
                        edges[i] = other, points, [*uses, EdgeUse(k, UNTRIMMED, side, turned)]
                        break
                else:
                    continue
                break
            else:
                edges.append((curve, ends, [EdgeUse(k, UNTRIMMED, side, False)]))
    return [BodyEdge(curve, tolerance, tuple(uses)) for curve, _, uses in edges]


def test_six_patches_without_edges_are_matched_in_space():
    assert cg.Body(box_patches()).closed
    lidless = cg.Body(box_patches()[:5])
    assert not lidless.closed
    assert lidless.openings.free_edges == 4
    assert lidless.openings.free_length == pytest.approx(4.0)


def test_a_patch_turned_the_other_way_is_named():
    patches = box_patches()
    patches[3] = patches[3].flipped()
    for edges in ((), named_edges(patches, 1e-9, 0.0)):
        body = cg.Body(patches, edges=edges)
        assert body.openings.turned_faces == (3,)
        assert body.openings.free_edges == 0
        assert not body.closed
        assert "patch 3" in " ".join(body.openings.flaws)


def test_edges_used_twice_close_a_body_within_their_tolerance():
    gap = 3e-3
    patches = box_patches(lift=gap)
    wide = cg.Body(patches, edges=named_edges(patches, 2 * gap, gap))
    assert wide.closed
    assert wide.openings.slit == pytest.approx(gap)
    assert wide.openings.slit_point[2] == pytest.approx(1.0, abs=2 * gap)
    assert 5 in wide.openings.slit_patches
    assert "slit" in wide.openings.flaws[0]
    fine = cg.Body(patches, edges=named_edges(patches, 2 * gap, 1e-9))
    assert not fine.closed
    assert fine.openings.gaping_edges == 4
    assert "do not meet" in fine.openings.flaws[0]


@pytest.mark.parametrize("pairs", [((0, 1), (2, 3)), ((0, 2), (1, 3)), ((0, 3), (1, 2))])
def test_boxes_that_touch_along_an_edge_are_closed_however_its_faces_are_paired(pairs):
    patches = box_patches() + [patch.translated([1.0, 1.0, 0.0]) for patch in box_patches()]
    edges = named_edges(patches, 1e-9, 0.0)
    (shared,) = (edge for edge in edges if len(edge.uses) == 4)
    assert cg.Body(patches, edges=edges).closed
    paired = [shared._replace(uses=tuple(shared.uses[k] for k in pair)) for pair in pairs]
    body = cg.Body(patches, edges=[edge for edge in edges if edge is not shared] + paired)
    assert (body.closed, body.flaws) == (True, [])
    assert body.volume() == pytest.approx(2.0)


def test_an_opening_that_the_tolerance_does_not_tell_from_a_point_is_none():
    """The tip of a pyramid is cut off."""

    def pyramid(tip, tolerance):
        base, top = (
            [(h, h, z), (-h, h, z), (-h, -h, z), (h, -h, z)] for h, z in ((1, 0), (tip, 1))
        )
        sides = [bilinear(base[k], base[k - 3], top[k], top[k - 3]) for k in range(4)]
        patches = [*sides, bilinear(base[0], base[3], base[1], base[2])]
        return cg.Body(patches, edges=named_edges(patches, 1e-9, tolerance))

    assert pyramid(1e-5, tolerance=2e-5).closed
    assert pyramid(1e-5, tolerance=2e-5).openings.free_length == 0.0
    assert pyramid(1e-5, tolerance=1e-6).openings.free_edges == 4
    assert pyramid(1e-3, tolerance=2e-5).openings.free_edges == 4


def test_the_patches_of_a_slit_are_named():
    patches = box_patches(lift=3e-3)
    wide = cg.Body(patches, edges=named_edges(patches, 6e-3, 3e-3)).openings
    told = dict(wide.rows)["largest gap"]
    first, second = wide.slit_patches
    assert f" between patches {first} and {second} at (" in told
    alone = wide._replace(slit_patches=(first,))
    assert f" within patch {first} at (" in dict(alone.rows)["largest gap"]


def test_no_tolerance_closes_a_hundredth_of_the_size():
    gap = 0.03
    patches = box_patches(lift=gap)
    assert not cg.Body(patches, edges=named_edges(patches, 2 * gap, 10 * gap)).closed


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e4])
def test_tolerances_are_made_true_and_grow_with_the_body(factor):
    gap = 3e-3
    patches = box_patches(lift=gap)
    body = cg.Body(patches, edges=named_edges(patches, 2 * gap, 1e-9)).scaled(factor)
    worst = max(body.edges, key=lambda edge: edge.gap)
    assert worst.gap == pytest.approx(gap * factor, rel=1e-9)
    assert worst.tolerance >= worst.gap
    assert worst.stated == pytest.approx(1e-9 * factor)
    moved = body.rotated([1, 2, 3], 0.7).translated([5, 6, 7])
    assert max(edge.gap for edge in moved.edges) == pytest.approx(gap * factor, rel=1e-6)
    assert moved.closed == body.closed


def test_an_uneven_stretch_measures_gaps_anew():
    patches = box_patches(lift=3e-3)
    body = cg.Body(patches, edges=named_edges(patches, 6e-3, 1e-9))
    stretched = body.transformed(np.diag([1.0, 1.0, 10.0, 1.0]))
    assert max(edge.gap for edge in stretched.edges) == pytest.approx(3e-2, rel=1e-9)


def test_a_band_with_a_twist_cannot_agree_on_a_side():
    n = 3
    turn = [math.tau * k / n for k in range(n + 1)]

    def rim(k, sign):
        tilt = 0.5 * turn[k]
        r = 2.0 + sign * 0.5 * math.cos(tilt)
        return np.array([r * math.cos(turn[k]), r * math.sin(turn[k]), sign * math.sin(tilt)])

    patches = [bilinear(rim(k, -1), rim(k + 1, -1), rim(k, 1), rim(k + 1, 1)) for k in range(n)]
    assert cg.Body(patches).openings.one_sided == 1


def test_one_patch_closed_upon_itself():
    assert cg.Body([cg.shapes.sphere(radius=2.0)]).closed
    assert cg.Body([cg.shapes.torus(major=2.0, minor=0.5)]).closed
    cylinder = cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)])
    assert not cylinder.closed
    assert cylinder.openings.free_edges == 2
    assert cylinder.openings.free_length == pytest.approx(2 * math.tau, rel=2e-3)


def test_a_long_side_against_two_short_ones_is_whole():
    """An edge may meet several of the next face, one after the other."""
    wall = bilinear([0, 0, 0], [2, 0, 0], [0, 1, 0], [2, 1, 0])
    left = bilinear([1, 0, 0], [0, 0, 0], [1, 0, 1], [0, 0, 1])
    right = bilinear([2, 0, 0], [1, 0, 0], [2, 0, 1], [1, 0, 1])
    line = wall.isocurve(v=0.0)
    uses = (
        EdgeUse(0, UNTRIMMED, 2, False),
        EdgeUse(1, UNTRIMMED, 2, True),
        EdgeUse(2, UNTRIMMED, 2, True),
    )
    named = openings_of(cg.Body([wall, left, right], edges=[BodyEdge(line, 0.0, uses)]))
    assert named.crowded_edges == 0
    assert named.turned_faces == ()
    part = bilinear([2, 0, 0], [1.5, 0, 0], [2, 0, 1], [1.5, 0, 1])
    left_over = openings_of(cg.Body([wall, left, part], edges=[BodyEdge(line, 0.0, uses)]))
    assert left_over.crowded_edges == 1
    assert not left_over.closed


@pytest.mark.parametrize("flip", [False, True])
def test_holes_and_outer_loops_count_by_the_even_odd_rule(solids: ModuleType, tmp_path, flip):
    body = cg.read_cad(solids.write(solids.crossing_bores(), tmp_path / "bores.step"))
    body = body.flipped() if flip else body
    assert body.openings.turned_faces == ()
    assert body.closed
