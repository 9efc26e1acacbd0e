"""The certificate of tracked feet: proved means on the branch, whatever the step."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from tests.laws.test_search_laws import pieces
from tests.sample import full
from tests.unit.search.folds import natural_fold, trimmed_fold
from tests.unit.search.plain import tracking_tables_of

import contiga as cg
from contiga.search.certify.kernels import branch_nb
from contiga.statuses import Feature, Status


def trough(elements=1):
    """The parabola z = x² over [-1, 1], drawn out in y from -1 to 1; normals up."""
    net = [[[x, y, z] for y in (-1.0, 1.0)] for x, z in ((-1.0, 1.0), (0.0, -1.0), (1.0, 1.0))]
    patch = cg.NurbsSurface((2, 1), ([0, 0, 0, 1, 1, 1], [0, 0, 1, 1]), np.array(net))
    return cg.Body([patch.insert_knots(u=np.linspace(0.0, 1.0, elements + 1)[1:-1])])


def foot_on_trough(x, branch):
    """x of the foot of (x, ·, 1): 2 f³ − f − x = 0, on the branch of the right (0) or left."""
    roots = np.roots([2.0, 0.0, -1.0, -x])
    real = np.sort(roots.real[np.abs(roots.imag) < 1e-9])
    return real[-1] if branch == 0 else real[0]


END = 2 * 6**-1.5 - 6**-0.5
"""x where the right-hand minimum of points at height 1 vanishes: −0.272."""


def test_a_foot_that_jumps_across_a_trough_is_not_proved():
    """The right-hand minimum ends on the way; Newton's method lands 1.2 farther left, silently."""
    body = trough()
    start = body.project([[0.3, 0.0, 1.0]])
    feet = body.project([[-0.3, 0.0, 1.0]], start=start, mode="track")
    assert np.linalg.norm(feet.point - start.point) > 1.19
    assert feet.status.tolist() == [Status.OK]
    assert feet.certified.tolist() == [0]
    left = foot_on_trough(-0.3, 1)
    np.testing.assert_allclose(feet.point, [[left, 0.0, left**2]], atol=1e-10)


@pytest.mark.parametrize("steps", [1, 7, 100, 1600])
def test_where_the_branch_ends_nothing_is_proved_whatever_the_steps(steps):
    body = trough(elements=64)
    feet = body.project([[0.3, 0.0, 1.0]])
    proved = []
    for x in np.linspace(0.3, -0.3, steps + 1)[1:]:
        feet = body.project([[x, 0.0, 1.0]], start=feet, mode="track")
        proved.append(feet.certified[0])
        root = foot_on_trough(x, 0 if x > END else 1)
        np.testing.assert_allclose(feet.point[0, 0], root, atol=1e-8)
    jump = int(np.ceil((0.3 - END) * steps / 0.6)) - 1
    assert proved[jump] == 0
    assert steps < 1000 or np.mean(proved) > 0.8


def test_a_foot_that_stands_where_the_minimum_has_vanished_is_an_event():
    """Of a point that rises along the normal of the bottom, past the focal point at 0.5."""
    body = trough()
    start = body.project([[0.0, 0.0, 0.4]])
    feet = body.project([[0.0, 0.0, 1.0]], start=start, mode="track")
    assert feet.status.tolist() == [Status.BRANCH_EVENT]
    assert feet.certified.tolist() == [1]
    np.testing.assert_allclose(np.abs(feet.point), [[np.sqrt(0.5), 0.0, 0.5]], atol=1e-9)
    np.testing.assert_allclose(feet.gap, body.project([[0.0, 0.0, 1.0]]).gap, atol=1e-12)


@pytest.mark.parametrize("end", [-0.2, -0.27, -0.272])
def test_up_to_the_focal_surface_one_step_stays_on_its_branch(end):
    body = trough()
    start = body.project([[0.3, 0.0, 1.0]])
    feet = body.project([[end, 0.0, 1.0]], start=start, mode="track")
    assert feet.status.tolist() == [Status.OK]
    np.testing.assert_allclose(feet.point[0, 0], foot_on_trough(end, 0), atol=1e-7)
    assert body.project([[end, 0.0, 1.0]]).point[0, 0] < 0


@pytest.mark.parametrize("parts", ["crease", "trimmed edge"])
def test_feet_on_an_edge_are_right_and_not_proved(parts):
    """Two planes meet at a right angle along y: of points above it the foot is on the edge."""
    turn = 0.5 * np.pi
    body = trimmed_fold(turn) if parts == "trimmed edge" else natural_fold(turn)
    x, slope = np.linspace(-0.5, 0.5, 2001), np.array([np.sqrt(0.5), 0.0, -np.sqrt(0.5)])
    path = np.column_stack([x, 0.1 + 0.0 * x, 0.3 + 0.0 * x])
    along = np.maximum(np.abs(x) * slope[0] + 0.3 * slope[2], 0.0)
    wanted = along[:, None] * slope * np.sign(x)[:, None] ** [1, 0, 0] + [0.0, 0.1, 0.0]
    feet, proved = body.project(path[:1]), []
    for point, foot in zip(path, wanted, strict=True):
        feet = body.project(point[None], start=feet, mode="track")
        np.testing.assert_allclose(feet.point[0], foot, atol=1e-9)
        proved.append(feet.certified[0])
    on_edge = along == 0.0
    assert feet.status.tolist() == [Status.OK]
    assert not np.array(proved)[on_edge].any()
    assert np.array(proved)[along > 0.05].mean() > 0.9


def folded(kind):
    """A sheet folded like a U or an S: walls 0.4 apart, drawn out in y."""
    x, z = {
        "U": ([-0.2, -0.2, -0.2, -0.2, 0.2, 0.2, 0.2, 0.2], [2, 1.4, 0.8, 0, 0, 0.8, 1.4, 2]),
        "S": (
            [2, 1.2, 0.4, -0.4, -0.4, 0.6, 0.6, -0.4, -1.2, -2],
            [0.4, 0.4, 0.4, 0.4, 0.0, 0.0, -0.4, -0.4, -0.4, -0.4],
        ),
    }[kind]
    net = np.array([[[a, y, c] for y in (-1.0, 1.0)] for a, c in zip(x, z, strict=True)])
    n = len(x)
    knots = np.concatenate([np.zeros(3), np.linspace(0, 1, n - 2), np.ones(3)])
    return cg.NurbsSurface((3, 1), (knots, [0, 0, 1, 1]), net)


@pytest.mark.parametrize("kind", ["U", "S"])
def test_a_foot_on_a_folded_sheet_stays_on_its_wall_where_the_closest_point_jumps(kind):
    """The point goes over the middle between two walls; the same feet at dt and dt/16."""
    patch = folded(kind)
    body = cg.Body([patch])
    rng = np.random.default_rng(0)
    u = rng.uniform(0.08, 0.2, 40)
    uv = np.column_stack([u, rng.uniform(0.2, 0.8, 40)])
    foot, normal = patch.evaluate(uv), patch.normal(uv)
    toward = np.sign((0.0 - foot[:, 2 if kind == "S" else 0]) * normal[:, 2 if kind == "S" else 0])
    normal = normal * toward[:, None]
    a, b = foot + 0.02 * normal, foot + 0.36 * normal + [0.0, 0.05, 0.0]
    found = []
    for steps in (4, 64):
        feet = body.project(a)
        np.testing.assert_allclose(feet.point, foot, atol=1e-9)
        for t in np.linspace(0, 1, steps + 1)[1:]:
            feet = body.project(a + t * (b - a), start=feet, mode="track")
            assert (feet.status == Status.OK).all()
            assert (feet.certified == 1).all()
        found.append(feet.point)
    np.testing.assert_allclose(found[0], found[1], atol=1e-9)
    np.testing.assert_allclose(found[0][:, [0, 2]], foot[:, [0, 2]], atol=1e-8)
    apart = np.linalg.norm(body.project(b).point - found[0], axis=1)
    assert (apart > 0.2).mean() > 0.5


SURFACES = {
    "torus": cg.shapes.torus(major=1.0, minor=0.4),
    "sphere": cg.shapes.sphere(),
    "bumps": cg.shapes.bumpy_plate(waves=2, amplitude=0.1),
    "cylinder": cg.shapes.cylinder(),
    "saddle": cg.shapes.saddle(height=0.5),
}


def element_size(patch, uv):
    """The smaller extent of an element of the patch, about."""
    D = patch.derivatives(uv, order=1)
    spans = [np.diff(np.unique(k)).mean() for k in patch.knots]
    along = [np.median(np.linalg.norm(D[:, a, b], axis=1)) for a, b in ((1, 0), (0, 1))]
    return min(x * y for x, y in zip(spans, along, strict=True))


def principal(patch, uv):
    """Largest absolute normal curvature."""
    D, n = patch.derivatives(uv, order=2), patch.normal(uv)
    first = np.stack([D[:, 1, 0], D[:, 0, 1]], axis=1)
    metric = np.einsum("kax,kbx->kab", first, first)
    rows = [[D[:, 2, 0], D[:, 1, 1]], [D[:, 1, 1], D[:, 0, 2]]]
    form = np.array([[(d * n).sum(1) for d in row] for row in rows]).transpose(2, 0, 1)
    return np.abs(np.linalg.eigvals(np.linalg.solve(metric, form)).real).max(axis=1)


def motions(patch, n, size, depth, seed):
    """Feet away from the poles with points to `depth`/κ off them, and where these go."""
    rng = np.random.default_rng(seed)
    low, high = np.transpose(patch.domain)
    uv = low + (high - low) * rng.uniform(0.02, 0.98, (n, 2))
    normal = patch.normal(uv)
    gap = rng.uniform(-depth, depth, n) / np.maximum(principal(patch, uv), 1.0)
    p = patch.evaluate(uv) + gap[:, None] * normal
    way = rng.normal(size=(n, 3))
    way *= size * element_size(patch, uv) / np.linalg.norm(way, axis=1)[:, None]
    zero = np.zeros(n, np.int8)
    feet = cg.Projection(
        np.zeros(n, np.int32), uv, patch.evaluate(uv), normal, gap, zero, zero, zero
    )
    return feet, p, p + way


def continued(patch, uv, a, b, steps):
    """Oracle: the stationary point in many small steps of Newton's method.

    Returns the points and whether the branch stayed: a minimum, and on the patch. Parameters wrap
    round where the patch is closed.
    """
    low, high = np.transpose(patch.domain)
    edge = patch.evaluate(np.array([low, [high[0], low[1]], [low[0], high[1]]]))
    closed = [np.linalg.norm(edge[1 + k] - edge[0]) < 1e-9 for k in range(2)]
    closed[1] = closed[1] and not np.allclose(
        patch.evaluate(np.column_stack([[0.3, 0.6], [low[1]] * 2]))[0],
        patch.evaluate(np.column_stack([[0.3, 0.6], [low[1]] * 2]))[1],
    )
    uv, stays = uv.copy(), np.ones(len(uv), bool)
    for t in np.arange(1, steps + 1) / steps:
        p = a + t * (b - a)
        for _ in range(3):
            D = patch.derivatives(uv, order=2)
            r = D[:, 0, 0] - p
            g = np.stack([(r * D[:, 1, 0]).sum(1), (r * D[:, 0, 1]).sum(1)], axis=1)
            h_uu = (D[:, 1, 0] ** 2 + r * D[:, 2, 0]).sum(1)
            h_uv = (D[:, 1, 0] * D[:, 0, 1] + r * D[:, 1, 1]).sum(1)
            h_vv = (D[:, 0, 1] ** 2 + r * D[:, 0, 2]).sum(1)
            det = h_uu * h_vv - h_uv**2
            stays &= (det > 0) & (h_uu > 0)
            step = np.stack([h_uv * g[:, 1] - h_vv * g[:, 0], h_uv * g[:, 0] - h_uu * g[:, 1]], 1)
            step /= np.where(np.abs(det) > 1e-14, det, 1.0)[:, None]
            stays &= np.abs(step / (high - low)).max(axis=1) < 0.05  # else it has jumped
            uv[stays] += step[stays]
            for k in range(2):
                if closed[k]:
                    uv[:, k] = low[k] + (uv[:, k] - low[k]) % (high[k] - low[k])
                stays &= (uv[:, k] >= low[k] - 1e-12) & (uv[:, k] <= high[k] + 1e-12)
            uv = np.clip(uv, low, high)
    return patch.evaluate(uv), stays


@pytest.mark.parametrize(
    ("name", "size"),
    [
        *(("torus", 0.1), ("bumps", 0.3), ("cylinder", 0.1), ("saddle", 0.02)),
        *full(("torus", 0.01), ("torus", 0.3), ("bumps", 0.01), ("bumps", 0.1)),
        *full(("cylinder", 0.01), ("cylinder", 0.3), ("saddle", 0.01)),
    ],
)
def test_what_is_certified_is_where_a_thousand_small_steps_lead(name, size):
    patch = SURFACES[name]
    body = cg.Body([patch])
    start, a, b = motions(patch, 300, size, 0.9, seed=1)
    feet = body.project(b, start=start, mode="track")
    point, stays = continued(patch, start.uv, a, b, 1000)
    proved = (feet.certified == 1) & (feet.status == Status.OK)
    assert proved.sum() > 10
    assert stays[proved].all()
    np.testing.assert_allclose(feet.point[proved], point[proved], atol=1e-6 * body.size)


@pytest.mark.parametrize(
    ("name", "size"),
    [("torus", 0.03), *full(("torus", 0.01), ("bumps", 0.01), ("bumps", 0.03))],
)
def test_what_is_certified_over_joints_is_where_many_small_steps_lead(name, size):
    """The same surfaces in 49 pieces, of which some are turned over."""
    patch = SURFACES[name]
    body = cg.Body(pieces(patch, 7))
    at, a, b = motions(patch, 20_000, size, 0.9, seed=3)
    start = body.project(at.point)._replace(normal=at.normal, gap=at.gap)
    feet = body.project(b, start=start, mode="track")
    proved = (feet.certified == 1) & (feet.status == Status.OK)
    over = np.flatnonzero(proved & (feet.patch != start.patch))
    assert len(over) >= 100
    point, stays = continued(patch, at.uv[over], a[over], b[over], 200)
    assert stays.all()
    np.testing.assert_allclose(feet.point[over], point, atol=1e-6 * body.size)


@njit
def path_across_side(table, neighbourhoods, foot, start):
    return branch_nb.path_across_side(table, neighbourhoods, foot, start)


SIDES = {
    0: lambda x: (-0.5, x),
    1: lambda x: (0.5, x),
    2: lambda x: (x, -0.5),
    3: lambda x: (x, 0.5),
}


def corners_of_way(row, foot, side, start):
    """The path that `path_across_side` measures: from a foot along a side, over it, to a start;
    its places (s, t) in the two elements."""
    s, t = foot
    x0 = start[1] if row["neighbour_side"][side] < 2 else start[0]
    x = -x0 if row["flip"][side] else x0
    beside = (s, x) if side < 2 else (x, t)
    return (foot, beside, SIDES[side](x)), (SIDES[row["neighbour_side"][side]](x0), start)


@pytest.mark.parametrize("name", ["torus", "bumps"])
def test_a_way_over_a_side_is_no_shorter_than_on_the_surface(name):
    body = cg.Body(pieces(SURFACES[name], 5))
    tables = tracking_tables_of(body)
    table, rng = tables.elements.table, np.random.default_rng(4)

    def along(e, a, b):
        box, patch = table[e]["box"], body.patches[table[e]["patch"]]
        x = np.linspace(a, b, 200) + 0.5
        return patch.evaluate(box[[0, 2]] + x * (box[[1, 3]] - box[[0, 2]]))

    told = flips = 0
    for _ in range(800):
        e, side = rng.integers(len(table)), rng.integers(4)
        row = table[e]
        n, there = row["neighbour"][side], row["neighbour_side"][side]
        if n < 0 or table[n]["patch"] == row["patch"]:
            continue
        x, x0 = rng.uniform(-0.5, 0.5, 2)
        foot = SIDES[side](x)
        foot = np.array(foot) * np.where(np.abs(foot) == 0.5, rng.uniform(0.4, 1.0), 1.0)
        start = np.array(SIDES[there](x0))
        start *= np.where(np.abs(start) == 0.5, rng.uniform(0.4, 1.0), 1.0)
        way = path_across_side(table, tables.neighbourhoods, (e, *foot), (n, *start))
        here, beyond = corners_of_way(row, foot, side, start)
        lines = [along(e, here[0], here[1]), along(e, here[1], here[2]), along(n, *beyond)]
        np.testing.assert_allclose(lines[1][-1], lines[2][0], atol=1e-9)
        length = sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines)
        if abs(x - (-x0 if row["flip"][side] else x0)) > 0.5:
            assert way == np.inf
        elif way < np.inf:
            told += 1
            flips += int(row["flip"][side])
            assert length * (1.0 - 1e-6) <= way <= 2.0 * length
    assert told > 50
    assert flips > 10


@pytest.mark.parametrize(
    ("name", "size", "share"),
    [
        *(("torus", 0.01, 0.999), ("sphere", 0.01, 0.999), ("cylinder", 0.01, 0.99)),
        *(("bumps", 0.01, 0.93), ("torus", 0.1, 0.7)),
    ],
)
def test_nearly_all_small_steps_are_certified(name, size, share):
    """Of those whose branch goes on: they end on a face."""
    depth = 0.1 if name == "sphere" else 0.5  # bounds at a pole are some times the curvature
    start, _, b = motions(SURFACES[name], 2000, size, depth, seed=2)
    feet = cg.Body([SURFACES[name]]).project(b, start=start, mode="track")
    going = (feet.feature == Feature.FACE) & (feet.status == Status.OK)
    assert feet.certified[going].mean() >= share


def test_a_closest_point_is_certified_and_a_spent_budget_is_not():
    body = cg.Body([cg.shapes.torus()])
    p = np.random.default_rng(0).normal(size=(50, 3))
    assert (body.project(p).certified == 1).all()


def test_feet_held_at_a_border_are_not_certified():
    body = cg.Body([cg.shapes.plane()])
    feet = body.project([[0.4, 0.0, 0.1]])
    feet = body.project([[0.7, 0.0, 0.1]], start=feet, mode="track")
    assert feet.status.tolist() == [Status.BORDER]
    assert feet.certified.tolist() == [0]
    back = body.project([[0.3, 0.0, 0.1]], start=feet, mode="track")
    assert back.status.tolist() == [Status.OK]
    assert back.certified.tolist() == [0]


def test_a_foot_that_runs_over_seams_knots_and_joints_is_certified():
    """Round a torus in one piece and cut into four that are turned over; over the sphere's pole."""
    patch = SURFACES["torus"]
    (u0, u1), (v0, v1) = patch.domain
    parts = []
    for i in range(2):
        for j in range(2):
            u, v = np.linspace(u0, u1, 3), np.linspace(v0, v1, 3)
            part = patch.restricted((u[i], u[i + 1]), (v[j], v[j + 1]))
            parts.append(part.transposed().flipped() if (i + j) % 2 else part)
    angle = np.linspace(0.0, 2.0 * np.pi, 161)
    round_it = np.column_stack([1.4 * np.cos(angle), 1.4 * np.sin(angle), 0.2 * np.sin(3 * angle)])
    fine = np.linspace(-0.2, 0.2, 161)
    arc = 0.98 * np.column_stack([0.8 * np.sin(fine), 0.6 * np.sin(fine), np.cos(fine)])
    for body, path in (
        (cg.Body([patch]), round_it),
        (cg.Body(parts), round_it),
        (cg.Body([SURFACES["sphere"]]), arc),
    ):
        feet = body.project(path[:1])
        for p in path[1:]:
            feet = body.project(p[None], start=feet, mode="track")
            assert feet.status.tolist() == [Status.OK]
            assert feet.certified.tolist() == [1]


def test_where_two_patches_meet_at_a_border_feet_need_not_be_followed():
    """The bounds kept there reach across the joint, however the second patch is turned."""
    plane = cg.shapes.plane()
    (u0, u1), _ = plane.domain
    left, right = plane.split(u=0.5 * (u0 + u1))
    for other in (right, right.transposed().flipped()):
        neighbourhoods = tracking_tables_of(cg.Body([left, other])).neighbourhoods
        assert (neighbourhoods["room"] > 0.1).all()
