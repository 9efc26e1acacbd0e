"""Cases of the list in README.md that are tested nowhere else: folds, and trims of every kind."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from tests.stress.fields import norm
from tests.stress.solids import BLADE, CLOSED_FILES, solid

import contiga as cg
from contiga.records import empty_hit
from contiga.search.sweep import piece_lists
from contiga.search.sweep.kernels import hit_nb
from contiga.statuses import Feature, Status


def polygon(corners):
    """A loop of straight p-curves."""
    ends = [*corners, corners[0]]
    return tuple(cg.NurbsCurve(1, [0, 0, 1, 1], [[*a, 0.0], [*b, 0.0]]) for a, b in pairwise(ends))


def folded():
    """A sheet folded like an S: three flat layers 0.4 apart, joined by round bends."""
    there = np.linspace(0.0, 2.0, 5)
    x = [*there, 2.4, 2.4, *there[::-1], -0.4, -0.4, *there]
    y = 6 * [0.0] + 7 * [0.4] + 6 * [0.8]
    points = np.column_stack([x, y, np.zeros(19)])
    knots = np.concatenate([4 * [0.0], np.arange(1, 16) / 16.0, 4 * [1.0]])
    return cg.Body.from_profile(cg.NurbsCurve(3, knots, points))


@pytest.mark.parametrize("finer", [1, 16])
def test_a_foot_on_a_folded_sheet_stays_on_its_layer_where_the_closest_point_jumps(finer):
    body = folded()
    heights = np.linspace(0.05, 0.38, 12 * finer + 1)
    x = np.linspace(0.7, 1.3, 25)
    at = np.column_stack([x, np.full(25, heights[0]), 0.0 * x])
    feet = first = body.project(at)
    for y in heights[1:]:
        at[:, 1] = y
        feet = body.project(at, start=feet, mode="track")
        assert (feet.status == Status.OK).all()
    closest = body.project(at)
    assert (np.abs(closest.gap) < np.abs(feet.gap) - 0.1).all()
    assert (np.abs(feet.uv - first.uv)[:, 0] < 0.1).all()
    # The same feet, however many steps it took.
    once = body.project(at, start=first, mode="track")
    np.testing.assert_allclose(feet.point, once.point, rtol=0, atol=1e-11)


def test_feet_on_a_plate_with_a_thousand_holes():
    n, radius = 32, 0.01
    centres = (np.arange(n) + 0.5) / n
    square = polygon([(0, 0), (1, 0), (1, 1), (0, 1)])
    holes = [
        (cg.shapes.circle(radius=radius, centre=[u, v, 0.0]),) for u in centres for v in centres
    ]
    body = cg.Body([cg.shapes.plane(centre=(0.5, 0.5, 0.0))], trims=[[square, *holes]])
    rng = np.random.default_rng(4)
    p = rng.uniform([0.0, 0.0, -0.01], [1.0, 1.0, 0.01], (4000, 3))
    p[::2, :2] = rng.choice(centres, (2000, 2)) + radius * rng.normal(scale=0.6, size=(2000, 2))
    feet = body.project(p)
    to_centre = p[:, :2] - (np.floor(p[:, :2] * n) + 0.5) / n
    over = np.maximum(radius - np.hypot(*to_centre.T), 0.0)
    np.testing.assert_allclose(np.abs(feet.gap), np.hypot(over, p[:, 2]), rtol=0, atol=1e-12)
    np.testing.assert_array_equal(feet.status[over > 1e-9], Status.TRIMMED)
    np.testing.assert_array_equal(feet.status[over == 0.0], Status.OK)


def around(p, angles, heights):
    """Distances to a rectangle in (angle, z) of the unit cylinder: its inside and its border."""
    a, rho = np.arctan2(p[:, 1], p[:, 0]) % (2.0 * np.pi), np.hypot(p[:, 0], p[:, 1])
    z = np.clip(p[:, 2], *heights)
    within = (a >= angles[0]) & (a <= angles[1])
    inside = np.hypot(rho - 1.0, p[:, 2] - z)
    to_lines = [
        np.sqrt((p[:, 0] - np.cos(t)) ** 2 + (p[:, 1] - np.sin(t)) ** 2 + (p[:, 2] - z) ** 2)
        for t in angles
    ]
    return np.where(within, inside, np.minimum(*to_lines))


def test_feet_on_a_cylinder_trimmed_to_270_degrees():
    loop = polygon([(0, 0), (0.75, 0), (0.75, 1), (0, 1)])
    body = cg.Body([cg.shapes.cylinder(height=2.0)], trims=[[loop]])
    p = np.random.default_rng(5).uniform(-1.6, 1.6, (3000, 3))
    away = around(p, (0.0, 1.5 * np.pi), (-1.0, 1.0))
    feet = body.project(p)
    np.testing.assert_allclose(np.linalg.norm(p - feet.point, axis=1), away, rtol=0, atol=1e-11)


def test_feet_about_a_window_that_crosses_the_seam():
    """Cut out of both ends of the rectangle: −45° to 45°, the middle two fifths of the height."""
    loop = polygon([(0, 0), (1, 0), (1, 0.3), (0.875, 0.3), (0.875, 0.7), (1, 0.7), (1, 1), (0, 1),
                    (0, 0.7), (0.125, 0.7), (0.125, 0.3), (0, 0.3)])  # fmt: skip
    body = cg.Body([cg.shapes.cylinder(height=2.0)], trims=[[loop]])
    p = np.random.default_rng(6).uniform([0.2, -1.2, -1.2], [1.6, 1.2, 1.2], (3000, 3))
    eighth = 0.25 * np.pi
    whole = (0.0, 2.0 * np.pi)
    away = np.minimum.reduce([
        around(p, (eighth, 7.0 * eighth), (-1.0, 1.0)),
        around(p, whole, (-1.0, -0.4)),
        around(p, whole, (0.4, 1.0)),
    ])  # fmt: skip
    feet = body.project(p)
    np.testing.assert_allclose(np.linalg.norm(p - feet.point, axis=1), away, rtol=0, atol=1e-11)
    assert (feet.status == Status.TRIMMED).sum() > 200


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9, 1e-6])
def test_paths_through_the_pole_of_a_cap_enter_it(off):
    """OpenCASCADE ends the cap 4e-13 before its pole: no hole is left there."""
    body = solid("lens").body
    start = np.array([[off, -0.5 * off, 20.0], [off - 3.0, 1.0, 7.5]])
    end = np.array([[off, -0.5 * off, 0.0], [off + 3.0, -1.0, 4.5]])
    hit = body.first_hit(start, end)
    np.testing.assert_array_equal(hit.status, Status.OK)
    at = 2 * [[off, -0.5 * off, 6.0]]
    np.testing.assert_allclose(hit.point, at, rtol=0, atol=2.0 * off + 1e-9)


@pytest.mark.parametrize("shift", [0.0, 3e-3, -0.011])
def test_a_grazing_path_hits_a_face_that_has_one_wide_edge_where_it_crosses_it(data_dir, shift):
    """Fillets of a CAD file, exact where they join along their length, wide where they end.

    Far from the wide edge the face is as sharp as any other, and nothing else is close by.
    """
    body = solid(CLOSED_FILES[0]).body
    a = np.array(
        [
            [305.7398651177043, 141.32151156892743, -38.380034279452666],
            [255.86446, 359.81415721652877, -41.61166716563831],
            [155.3064683946501, 556.2510300501287, -326.63731560263625],
        ]
    )
    b = np.array(
        [
            [305.73839771324486, 141.32072230243966, -38.382533904418075],
            [255.85302225630818, 359.81481884764236, -41.617368943255066],
            [167.20404181586107, 505.38186143026377, -307.5478503497215],
        ]
    )
    a, b = a + shift * (b - a), b + shift * (b - a)
    hit = body.first_hit(a, b)
    assert (hit.status == Status.OK).all()
    place = a + hit.fraction[:, None] * (b - a)
    assert (norm(place - hit.point) < 1e-9 * body.size).all()


def across(curve, t, rng):
    """Unit vectors square to a curve at its parameters t."""
    low, high = curve.domain
    h = 1e-6 * (high - low)
    d = curve.evaluate(np.minimum(t + h, high)) - curve.evaluate(np.maximum(t - h, low))
    d /= norm(d)[:, None]
    e = rng.normal(size=d.shape)
    e -= (e * d).sum(axis=1)[:, None] * d
    return e / norm(e)[:, None]


def test_points_beside_an_edge_whose_faces_reach_past_each_other_keep_their_sides():
    """The nearest place of all may be the back of a face that overhangs."""
    bores = solid("small bores")
    rng = np.random.default_rng(6)
    for edge in bores.body.edges:
        if edge.tolerance < 1e-9 * bores.size:
            continue
        t = rng.uniform(*edge.curve.domain, 3000)
        off = edge.tolerance * rng.uniform(2.05, 12.0, 3000)
        p = edge.curve.evaluate(t) + off[:, None] * across(edge.curve, t, rng)
        height = bores.field(p)
        clear = np.abs(height) > 2e-9 * bores.size
        outside = bores.body.project(p).gap > 0.0
        np.testing.assert_array_equal(outside[clear], height[clear] > 0.0)


@pytest.mark.parametrize("end", [0, 1])
def test_points_in_the_plane_of_a_face_beside_the_end_of_a_sharp_edge_are_outside(end):
    """The face at the end is seen edge on, and the two that make the edge from behind."""
    body = solid("blade").body
    rng = np.random.default_rng(7)
    tips = np.array([[x, 0.0, z] for x in BLADE[:2] for z in (-15.0, 15.0)])[2 * end : 2 * end + 2]
    n = 3000
    off = body.size * 10.0 ** rng.uniform(-8.5, -5.5, (n, 1)) * rng.normal(size=(n, 3))
    off[np.arange(n), rng.integers(3, size=n)] = 0.0
    p = tips[rng.integers(2, size=n)] + off
    height = solid("blade").field(p)
    clear = height > 2e-10 * body.size
    assert clear.sum() > n // 2
    assert (body.project(p[clear]).gap > 0.0).all()


def test_what_pieces_near_voxels_say_of_paths_beside_wide_edges_changes_no_bit(data_dir):
    """Grazing paths across edges up to 0.0096 wide, and short ones beside them."""
    body = solid(CLOSED_FILES[0]).body
    tables = body.surface.tables
    rng = np.random.default_rng(8)
    wide = sorted(body.edges, key=lambda edge: -edge.tolerance)[:60]
    starts, ways = [], []
    for edge in wide:
        t = rng.uniform(*edge.curve.domain, 120)
        way = across(edge.curve, t, rng) * edge.tolerance * 10.0 ** rng.uniform(-2.0, 4.0, (120, 1))
        off = across(edge.curve, t, rng) * edge.tolerance * 10.0 ** rng.uniform(-1.0, 1.6, (120, 1))
        starts.append(edge.curve.evaluate(t) + off - rng.random((120, 1)) * way)
        ways.append(way)
    a = np.concatenate(starts)
    b = a + np.concatenate(ways)
    rows = np.arange(len(a), dtype=np.int32)
    found = []
    for lists in (piece_lists.NO_LISTS, piece_lists.build_lists(tables)):
        first, last, verdict = empty_hit(len(a)), empty_hit(len(a)), np.zeros((len(a), 2))
        hit_nb.first_hits(tables, lists, a, b, rows, first, 0, len(a))
        hit_nb.last_crossings(tables, lists, a, b, (2.0, 0.0), last, verdict, 0, len(a))
        found.append((*first, *last, verdict))
    for own, other in zip(*found, strict=True):
        np.testing.assert_array_equal(own, other)
    assert (found[0][-1][:, 0] != 0.0).mean() > 0.2


def test_paths_that_slip_between_the_faces_of_a_casting_enter(data_dir):
    """NIST CTC 2, whose fillets are up to 0.0096 apart where they end.

    The first grazes such a slit at a slope of 0.006; the second is shorter than the way from the
    edge to where it meets the carriers; the third meets none of them.
    """
    body = solid(CLOSED_FILES[0]).body
    a = np.array(
        [
            [-54.69370101356522, 780.9119225383685, -226.15656414696306],
            [-101.50094699265635, 784.2250678992531, -148.71702026150265],
            [-254.78825868516668, 312.25720564999807, -218.23975595961332],
        ]
    )
    b = np.array(
        [
            [-54.00657321615985, 781.991802837062, -226.51445933567678],
            [-101.50331797111836, 784.3206296053538, -148.63047663158895],
            [-248.2764055560037, 316.50988550876093, -209.71441717818695],
        ]
    )
    assert not body.contains(a).any()
    assert body.contains(b).all()
    hit = body.first_hit(a, b)
    assert (hit.status == Status.OK).all()
    place = a + hit.fraction[:, None] * (b - a)
    assert (norm(place - hit.point) < 0.02).all()
    _, sense = body.surface.last_crossings(a[:2], b[:2], np.arange(2, dtype=np.int32))
    assert (sense == 1).all()


@pytest.mark.parametrize("name", ["cone", "blade"])
def test_a_flat_path_over_a_seam_is_hit_where_it_is(name):
    """Beyond the side of a patch by rounding as seen along the path, by 4e-6 in space."""
    ends = {
        "cone": [
            [4.085658626450983, -0.027555138896022627, 35.80726817315354],
            [4.09010759982856, 0.0008892519380987939, 35.79725789774822],
        ],
        "blade": [
            [50.000372197642086, -0.00011422671713443369, 14.999627961410525],
            [49.998937053796354, 0.0003262160787812078, 15.00106249197087],
        ],
    }
    body = solid(name).body
    a, b = np.array(ends[name])[:, None]
    hit = body.first_hit(a, b)
    assert hit.status[0] == Status.OK
    assert norm(a + hit.fraction[:, None] * (b - a) - hit.point)[0] < 1e-9 * body.size


def test_a_path_that_skims_a_bent_face_is_hit_where_it_passes_the_edge():
    """It meets the carrier 0.8 beyond the edge, where no plane nor parabola tells where that is."""
    body = solid("bores off centre").body
    a = np.array([[8.012096175174873, 8.173658171031036, 8.49347914302832]])
    b = np.array([[-28.920828164961165, 1.7373047942176143, 10.807941734521794]])
    hit = body.first_hit(a, b)
    assert hit.status[0] == Status.OK
    assert norm(a + hit.fraction[:, None] * (b - a) - hit.point) < 1e-6
    edge = np.array([0.86545732, 6.92820322, 8.94133507])  # where the path comes nearest to it
    assert norm(hit.point - edge) < 1e-5


def test_a_point_a_billionth_of_the_size_above_a_large_face_beside_its_rim():
    """The wall below the rim is some times farther, the middle of the face 3e9 times."""
    body = solid("link rod").body
    rng = np.random.default_rng(6)
    n = 4000
    height = body.size * 10.0 ** rng.uniform(-10.0, -8.0, n)
    radius = 22.0 - height * rng.uniform(2.0, 8.0, n)
    angle = np.radians(rng.uniform(230.0, 260.0, n))
    p = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 8.0 + height])
    feet = body.project(p)
    np.testing.assert_allclose(feet.gap, p[:, 2] - 8.0, rtol=0, atol=1e-13 * body.size)
    assert (feet.feature == Feature.FACE).all()


def test_a_path_through_a_riser_that_meets_neither_carrier_enters(data_dir):
    """It comes in 0.0023 above one face, skims it, and ends below the next, 0.0004 lower."""
    a = np.array([[254.9399286343657, 81.26820124440859, -169.45168914853832]])
    b = np.array([[249.0034311943592, 80.4001800336463, -171.90764744534755]])
    hit = solid(CLOSED_FILES[0]).body.first_hit(a, b)
    assert hit.status[0] == Status.OK
    assert 0.15 < hit.fraction[0] < 0.25
