"""Closed bodies that pierce themselves, or whose pieces pierce each other, from a seed.

Each is made so that it does: the tube reaches over the other strand, the lid below the floor. A
place that is told must lie on two sheets of the surface, which cross there at an angle.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from tests.stress import closed, parts
from tests.stress.tally import Clock, Tally
from tests.stress.valid import Rng, maybe, pick, ridge, whole

import contiga as cg
from contiga.errors import ContigaWarning

NEAR = 1e-6
"""Share of the size within which a place must lie on both sheets."""
GRID = 41
"""Places along u and along v from which the sheets through a place are looked for."""

Vector = np.ndarray


class Pierced(NamedTuple):
    """A closed body that pierces itself."""

    name: str
    body: Callable[[], cg.Body]
    """Makes it: reading some of them raises what is told."""


class Told(NamedTuple):
    """What contiga says of it."""

    name: str
    text: str
    """"" if nothing is said."""
    off: float
    """How far the place is from the farther of two sheets, share of the size; NaN if none is."""

    @property
    def fault(self) -> str:
        """What is wrong, "" if nothing is."""
        if not self.text:
            return "not told"
        return "" if self.off <= NEAR else f"the place is off by {self.off:.1e}: {self.text}"


def tube(centre: Callable[[Vector], Vector], radius: Callable[[Vector], Vector], ends: bool,
         n: int = 60) -> cg.NurbsSurface:  # fmt: skip
    """A bicubic tube about a curve over 0 … 1: closed on itself, or with a pole at both ends."""
    s, about = np.linspace(0.0, 1.0, n + 1), np.linspace(0.0, 2.0 * np.pi, 17)
    step = 1e-5
    # Of an open curve the share that is past its ends is that of a straight line on.
    way = centre(s + step) - centre(s - step)
    way /= np.linalg.norm(way, axis=1)[:, None]
    one, rows = np.cross(way[0], [0.3, -0.2, 0.9]), []
    for t in way:  # carried along the curve without a twist
        one = one - (one @ t) * t
        one = one / np.linalg.norm(one)
        rows.append(one)
    frame = np.array(rows)
    if not ends:  # the twist of a whole turn is shared out
        other = np.cross(way[-1], frame[-1])
        turn = math.atan2(frame[0] @ other, frame[0] @ frame[-1]) * s
        frame = np.cos(turn)[:, None] * frame + np.sin(turn)[:, None] * np.cross(way, frame)
    side = np.cross(way, frame)
    r = radius(s)[:, None, None]
    c, z = np.cos(about)[:, None], np.sin(about)[:, None]
    points = centre(s)[:, None] + r * (c * frame[:, None] + z * side[:, None])
    points[:, -1] = points[:, 0]
    kind: Any = None if ends else "periodic"
    if not ends:
        points[-1] = points[0]
    along = make_interp_spline(s, points, 3, bc_type=kind)
    around = make_interp_spline(about, np.moveaxis(along.c, 1, 0), 3, bc_type="periodic")
    return _clamped(along.t, around.t, np.moveaxis(around.c, 0, 1))


def _clamped(u: Vector, v: Vector, net: Vector) -> cg.NurbsSurface:
    """A spline by its values, its knots at the ends repeated."""
    from scipy.interpolate import BSpline

    for axis, knots in enumerate((u, v)):
        spline = BSpline(knots, np.moveaxis(net, axis, 0), 3)
        breaks = np.unique(knots[(knots >= knots[3]) & (knots <= knots[-4])])
        full = np.concatenate([[breaks[0]] * 3, breaks, [breaks[-1]] * 3])
        # Averages of knots, at which a spline of degree 3 is determined.
        sites = np.clip((full[1:-3] + full[2:-2] + full[3:-1]) / 3.0, full[0], full[-1])
        anew = make_interp_spline(sites, spline(sites), 3, t=full)
        net = np.moveaxis(anew.c, 0, axis)
        u, v = (full, v) if axis == 0 else (u, full)
    return cg.NurbsSurface((3, 3), (u, v), net)


def _welded(patch: cg.NurbsSurface, poles: bool, closed_u: bool) -> cg.NurbsSurface:
    """The sides of a net made to meet to the last bit, which interpolation leaves by rounding."""
    net = patch.control_points.copy()
    net[:, -1] = net[:, 0]
    if closed_u:
        net[-1] = net[0]
    if poles:
        net[0], net[-1] = net[0].mean(axis=0), net[-1].mean(axis=0)
    return cg.NurbsSurface(patch.degrees, patch.knots, net)


def rings(rng: Rng) -> list[cg.NurbsSurface]:
    """A closed tube along an eight, or a clover, whose strands pass each other too near."""
    a, b = pick(rng, (1, 2), (2, 3), (1, 3))
    height = float(rng.uniform(0.15, 0.45))

    def centre(s: Vector) -> Vector:
        t = 2.0 * np.pi * np.asarray(s)
        if (a, b) == (2, 3):  # a trefoil
            reach = 2.0 + np.cos(3.0 * t)
            return np.stack(
                [reach * np.cos(2 * t), reach * np.sin(2 * t), height * np.sin(3 * t)], 1
            )
        return np.stack([3 * np.sin(a * t), 1.5 * np.sin(b * t), height * np.cos(t)], axis=1)

    r = float(rng.uniform(0.5, 0.6))
    return [_welded(tube(centre, lambda s: np.full_like(s, r), False), False, True)]


def bottles(rng: Rng) -> list[cg.NurbsSurface]:
    """A bottle whose neck bends round and goes through its wall."""
    bend, thick = float(rng.uniform(2.2, 3.0)), float(rng.uniform(1.0, 1.4))
    lift = float(rng.uniform(-0.3, 0.3))

    def centre(s: Vector) -> Vector:
        s = np.asarray(s)
        turn = 1.5 * np.pi * np.clip((s - 0.4) / 0.6, 0.0, None)
        upright = np.minimum(s, 0.4) / 0.4 * 5.0
        x = bend * (1.0 - np.cos(turn))
        z = upright + bend * np.sin(turn)
        # Back over the wall: a spiral that draws in.
        x -= bend * np.clip((turn - np.pi) / (0.5 * np.pi), 0.0, None) ** 2
        return np.stack([x, lift * np.sin(turn), z], axis=1)

    def radius(s: Vector) -> Vector:
        neck = 0.35 + (thick - 0.35) * 0.5 * (1.0 + np.cos(np.pi * np.clip((s - 0.3) / 0.2, 0, 1)))
        ends = np.sqrt(np.clip(1.0 - np.clip(1.0 - s / 0.08, 0, 1) ** 2, 0.0, None))
        ends *= np.sqrt(np.clip(1.0 - np.clip(1.0 - (1.0 - s) / 0.05, 0, 1) ** 2, 0.0, None))
        return neck * ends

    return [_welded(tube(centre, radius, True, 80), True, False)]


def _sheet(rim: float, push: Vector, at: tuple[float, float], wide: float) -> cg.NurbsSurface:
    """A bicubic sheet over 0 … 1, `rim` high, of which a bump is pushed by a vector."""
    n = 12
    knots = np.concatenate([[0.0] * 3, np.linspace(0.0, 1.0, n - 2), [1.0] * 3])
    sites = (knots[1:-3] + knots[2:-2] + knots[3:-1]) / 3.0
    x, y = np.meshgrid(sites, sites, indexing="ij")
    off = np.hypot(x - at[0], y - at[1]) / wide
    bump = np.where(off < 1.0, 0.5 * (1.0 + np.cos(np.pi * np.minimum(off, 1.0))), 0.0)
    bump[[0, -1]] = bump[:, [0, -1]] = 0.0
    net = np.stack([x, y, np.full_like(x, rim)], axis=2) + bump[:, :, None] * push
    return cg.NurbsSurface((3, 3), (knots, knots), net)


def _open_box(height: float) -> list[cg.NurbsSurface]:
    """A box over the unit square without its lid, in spans like those of a sheet."""
    floor = _sheet(0.0, np.zeros(3), (0.5, 0.5), 0.3)
    walls = []
    for side in ({"v": 0.0}, {"u": 1.0}, {"v": 1.0}, {"u": 0.0}):
        foot = floor.isocurve(**side)
        wall = cg.shapes.ruled(foot, foot.translated([0.0, 0.0, height]))
        walls.append(wall if side in ({"v": 0.0}, {"u": 1.0}) else wall.flipped())
    return [floor.flipped(), *walls]


def lids(rng: Rng) -> list[cg.NurbsSurface]:
    """A box whose lid is pushed through the floor, deep or by a hair."""
    height = float(rng.uniform(0.3, 1.0))
    at, wide = rng.uniform(0.4, 0.6, 2), float(rng.uniform(0.3, 0.39))
    lid = _sheet(height, np.zeros(3), tuple(at), wide)
    lowest = _sheet(0.0, np.array([0.0, 0.0, 1.0]), tuple(at), wide)
    reach = float(
        lowest.evaluate(np.stack(np.meshgrid(*2 * [np.linspace(0, 1, 201)]), -1).reshape(-1, 2))[
            :, 2
        ].max()
    )
    deep = pick(rng, 0.003, 0.03, 0.3)
    aside = rng.uniform(-0.05, 0.05, 2)
    lid = _sheet(height, np.array([*aside, -(height + deep) / reach]), tuple(at), wide)
    return [*_open_box(height), lid]


def bulges(rng: Rng) -> list[cg.NurbsSurface]:
    """A box whose lid bulges up and sideways out over a wall, and back through it or the floor."""
    height = float(rng.uniform(0.25, 0.4))
    way = np.array([float(rng.uniform(1.6, 2.4)), float(rng.uniform(-0.2, 0.2)), -0.75 * height])
    return [*_open_box(height), _sheet(height, way, (0.6, 0.5), 0.35)]


def turned_eights(rng: Rng) -> list[cg.NurbsSurface]:
    """A figure of eight turned about an axis that it keeps off: in one patch, or in four."""
    t = np.linspace(0.0, 2.0 * np.pi, 33) + 0.7  # nor does it cross itself where it begins
    tilt, r = float(rng.uniform(0.0, 3.0)), float(rng.uniform(3.0, 6.0))
    x, y = np.sin(t), float(rng.uniform(0.3, 0.9)) * np.sin(2.0 * t + float(rng.uniform(-0.3, 0.3)))
    rows = np.stack([r + math.cos(tilt) * x - math.sin(tilt) * y, 0 * t,
                     math.sin(tilt) * x + math.cos(tilt) * y], axis=1)  # fmt: skip
    rows[-1] = rows[0]
    spline = make_interp_spline(t, rows, 3, bc_type="periodic")
    breaks = t
    full = np.concatenate([[breaks[0]] * 3, breaks, [breaks[-1]] * 3])
    sites = np.clip((full[1:-3] + full[2:-2] + full[3:-1]) / 3.0, t[0], t[-1])
    anew = make_interp_spline(sites, spline(sites), 3, t=full)
    net = anew.c.copy()
    net[-1] = net[0]
    curve = cg.NurbsCurve(3, full, net)
    if maybe(rng):
        return [cg.shapes.revolved(curve)]
    cuts = [t[0], *(t[0] + np.sort(rng.uniform(0.3, 6.0, 3))).tolist(), t[-1]]
    return [cg.shapes.revolved(curve.restricted(a, b)) for a, b in pairwise(cuts)]


def dented_balls(rng: Rng) -> list[cg.NurbsSurface]:
    """A closed spline like a ball, of which the top is pushed in until it comes out elsewhere."""
    n, m = 24, 24
    u, v = np.linspace(0.0, 2.0 * np.pi, m + 1), np.linspace(-0.5 * np.pi, 0.5 * np.pi, n + 1)
    uu, vv = np.meshgrid(u, v, indexing="ij")
    points = np.stack([np.cos(uu) * np.cos(vv), np.sin(uu) * np.cos(vv), np.sin(vv)], axis=2)
    bump = np.clip((points[:, :, 2] - 0.4) / 0.6, 0.0, None) ** 1.5
    aside = rng.uniform(-0.7, 0.7, 2)
    points += bump[:, :, None] * np.array([*aside, -float(rng.uniform(2.3, 3.0))])
    points[-1] = points[0]
    along = make_interp_spline(u, points, 3, bc_type="periodic")
    across = make_interp_spline(v, np.moveaxis(along.c, 1, 0), 3)
    patch = _clamped(along.t, across.t, np.moveaxis(across.c, 0, 1))
    net = patch.control_points.copy()
    net[-1] = net[0]
    for k in (0, -1):
        net[:, k] = net[:, k].mean(axis=0)
    return [cg.NurbsSurface(patch.degrees, patch.knots, net)]


def pits(rng: Rng) -> Any:
    """A block of plane faces with a pit that is deeper than the block: one shell, sewn."""
    a, b = rng.uniform(0.5, 1.5, 2), rng.uniform(2.0, 3.5, 2)
    tall, deep = 2.0, 2.0 + float(pick(rng, 0.02, 0.3, 1.0))
    lean = rng.uniform(-0.3, 0.3, 2)
    low = [np.array([x, y, 0.0]) for x, y in ((0, 0), (5, 0), (5, 5), (0, 5))]
    top = [np.add(p, (0.0, 0.0, tall)) for p in low]
    rim = [np.array([x, y, tall]) for x, y in (a, (b[0], a[1]), b, (a[0], b[1]))]
    foot = [np.add(p, (*lean, -deep)) for p in rim]
    faces = [low[::-1], foot]
    for k in range(4):
        j = (k + 1) % 4
        faces += [[low[k], low[j], top[j], top[k]], [top[k], top[j], rim[j], rim[k]]]
        faces.append([rim[k], rim[j], foot[j], foot[k]])
    return parts.polyhedron(faces)


def springs(rng: Rng) -> Any:
    """A thread by itself whose coils are thicker than the pitch."""
    pitch = float(rng.uniform(1.0, 1.5))
    half = pitch * float(rng.uniform(0.55, 0.8))
    reach = float(rng.uniform(0.5, 1.0))
    profile = [(0.0, -half), (reach, -0.8 * half), (reach, 0.8 * half), (0.0, half)]
    return ridge(4.0, pitch, float(rng.uniform(1.6, 2.6)), profile)


def overlapping(rng: Rng) -> list[cg.NurbsSurface]:
    """Closed pieces that cross and are not united."""
    ball = cg.shapes.sphere(radius=1.0)
    kind = whole(rng, 0, 3)
    off = rng.normal(size=3)
    off /= np.linalg.norm(off)
    if kind == 0:
        r = float(rng.uniform(0.5, 1.0))
        return [ball, cg.shapes.sphere(radius=r, centre=off * (1.0 + r - pick(rng, 0.01, 0.4)))]
    if kind == 1:
        return [ball, *cg.Body(cg.shapes.torus(major=1.2, minor=0.5, centre=0.3 * off)).patches]
    turn = cg.motion.pose.rotation(off, float(rng.uniform(0.2, 1.2)), [0.0, 0.0, 0.0])
    box = cg.Body([*_open_box(1.0), _sheet(1.0, np.zeros(3), (0.5, 0.5), 0.3)])
    if kind == 2:
        return [*box.patches, *box.transformed(turn).translated([0.5, 0.4, 0.7]).patches]
    return [*box.patches, cg.shapes.sphere(radius=0.6, centre=(0.9, 0.5, 0.5))]


FAMILIES: dict[Callable[[Rng], Any], int] = {
    rings: 8,
    bottles: 8,
    lids: 10,
    bulges: 6,
    turned_eights: 8,
    dented_balls: 6,
    pits: 6,
    springs: 4,
    overlapping: 8,
}
"""How many of each: 64."""


def made(family: Callable[[Rng], Any], number: int) -> Pierced:
    """A body of a family by its number, in a place and of a size of its own."""
    rng = np.random.default_rng([number, *family.__name__.encode()])
    thing = family(rng)
    name = f"{family.__name__} {number}"
    factor = pick(rng, 1.0, 1e-3, 1e3, 25.4)
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=int(rng.integers(1 << 31))).as_matrix()
    pose[:3, 3] = factor * rng.uniform(-5.0, 5.0, 3)
    if isinstance(thing, list):
        return Pierced(name, lambda: cg.Body(thing, name=name).scaled(factor).transformed(pose))
    shape = parts.placed(thing, pose[:3, :3], 10.0 * rng.uniform(-1.0, 1.0, 3))
    return Pierced(name, lambda: closed.handed_over(shape, "direct"))


def told(pierced: Pierced) -> Told:
    """What is said of a body, and how far its place is from two sheets of the surface."""
    body = pierced.body()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ContigaWarning)
        openings = body.openings
    found = openings.crossing or next(iter(openings.meetings), None)
    if found is None or body.closed:
        return Told(pierced.name, "", np.nan)
    place = np.array(found.point)
    off = off_sheets(body, found.patches, place) / body.size
    return Told(pierced.name, "; ".join(body.flaws), off)


def taken(family: Callable[[Rng], Any], numbers: Iterable[int]) -> Tally:
    """Bodies of a family as a part of the stress counts them."""
    with Clock(Tally(f"piercing bodies, {family.__name__}")) as tally:
        for number in numbers:
            said = told(made(family, number))
            tally.count += 1
            tally.wrong += bool(said.fault)
            if said.fault:
                tally.faults.append({"kind": "body", "name": said.name, "fault": said.fault})
    return tally


def off_sheets(body: cg.Body, patches: tuple[int, ...], place: Vector) -> float:
    """Distance of a place to the farther of two sheets of patches that cross at an angle there."""
    sheets: list[tuple[float, Vector]] = []
    for patch in dict.fromkeys(patches):
        sheets += [(off, normal) for off, normal in _feet(body.patches[patch], place, body.size)]
    worst = np.inf
    for k, (a, n) in enumerate(sheets):
        for b, m in sheets[k + 1 :]:
            if np.linalg.norm(np.cross(n, m)) > 1e-3:
                worst = min(worst, max(a, b))
    return float(worst)


def _feet(patch: cg.NurbsSurface, place: Vector, size: float) -> list[tuple[float, Vector]]:
    """Distance and normal of the places of a patch nearest to a point, one for each sheet."""
    (u0, u1), (v0, v1) = patch.domain
    spans = max(len(np.unique(knots)) for knots in patch.knots)
    n = max(GRID, 6 * spans)
    u, v = np.linspace(u0, u1, n), np.linspace(v0, v1, n)
    grid = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1)
    away = np.linalg.norm(patch.evaluate(grid.reshape(-1, 2)) - place, axis=1).reshape(n, n)
    padded = np.pad(away, 1, constant_values=np.inf)
    around = [padded[1 + i : n + 1 + i, 1 + j : n + 1 + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    least = (away <= np.min(around, axis=0)) & (away < 0.2 * size)
    low, high = np.array([u0, v0]), np.array([u1, v1])
    found = []
    for start in grid[least]:
        result = least_squares(
            lambda uv: (patch.evaluate(np.clip(uv, low, high)[None])[0] - place) / size,
            np.clip(start, low + 1e-9 * (high - low), high - 1e-9 * (high - low)),
            bounds=(low, high), xtol=1e-15, ftol=1e-15, gtol=1e-15,
        )  # fmt: skip
        uv = np.clip(result.x, low, high)[None]
        off = float(np.linalg.norm(patch.evaluate(uv)[0] - place))
        found.append((off, patch.normal(uv)[0]))
    return found
