"""Masters that breathe, twist and fold while points wander about them, some of which fly, too.

At every step the closest points of the shape are found anew, by samples of all of it and a careful
descent from the best of them. What contact says must agree: with half a thickness a point is in
contact where that reaches, without one where it is inside a closed shape; feet lie on the shape, no
farther than the closest points where they are certified; safe distances are none too long.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation
from tests.stress.fields import norm
from tests.stress.shaking import FLAGS
from tests.stress.tally import Clock, Tally
from tests.unit.geometry.test_net import brick

import contiga as cg

HALF = 0.15
"""Half of the thickness of points that have one."""
SAME = 1e-7
"""Distances closer than this are the same; bodies are 2 to 4 long."""
SPACING = 0.04
"""Largest distance of samples next to each other."""
STARTS = 8
"""Samples, the nearest ones, that Newton's method starts from."""
NEWTON_STEPS = 20
CONVERGED = 1e-15
"""Step of the distance that is the last."""
FAR = 0.8
"""Distance from the shape beyond which a point goes back to it."""
SLANTED = 0.2
"""Cosine of the normal and the way to the closest point below which a side is in doubt."""
Move = Callable[[np.ndarray, float], np.ndarray]


def refined(surface: cg.NurbsSurface, n: int) -> cg.NurbsSurface:
    """Return the same surface on elements of n parts of each knot span."""
    new = []
    for knots in surface.knots:
        breaks = np.unique(knots)
        inner = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(1, n) / n
        new.append(inner.ravel())
    return surface.insert_knots(*new)


def breathing(rest: np.ndarray, t: float) -> np.ndarray:
    """Grown and shrunk by a quarter, up and down."""
    return rest * (1.0 + 0.25 * np.sin(2.0 * t)) + [0.0, 0.0, 0.2 * np.sin(3.0 * t)]


def twisting(rest: np.ndarray, t: float) -> np.ndarray:
    """Twisted about the x axis to and fro."""
    angle = 0.5 * np.sin(1.5 * t) * rest[:, 0]
    cosine, sine = np.cos(angle), np.sin(angle)
    out = rest.copy()
    out[:, 1], out[:, 2] = (
        cosine * rest[:, 1] - sine * rest[:, 2],
        sine * rest[:, 1] + cosine * rest[:, 2],
    )
    return out


def folding(rest: np.ndarray, t: float) -> np.ndarray:
    """Rolled up about the y axis: an arc that grows, of a sheet of 4 to one and a half circles."""
    return _rolled(rest, 1.2 * (1.0 - np.cos(1.2 * t)) + 1e-3)


def half_folding(rest: np.ndarray, t: float) -> np.ndarray:
    """Rolled up to three quarters of a circle, so that a slab does not meet itself."""
    return _rolled(rest, 0.6 * (1.0 - np.cos(1.2 * t)) + 1e-3)


def _rolled(rest: np.ndarray, bend: float) -> np.ndarray:
    out = rest.copy()
    angle, radius = bend * rest[:, 0], 1.0 / bend - rest[:, 2]
    out[:, 0], out[:, 2] = radius * np.sin(angle), 1.0 / bend - radius * np.cos(angle)
    return out


def sheet() -> cg.NurbsSurface:
    """A sheet of 4 by 2 and 25 elements of degree 3 by 2."""
    return refined(cg.shapes.plane(width=4.0, length=2.0).k_refined((2, 1)), 5)


def block(sides: Sequence[float], n: int) -> list[cg.NurbsSurface]:
    """A closed box about the origin, each face n by n elements of degree 3."""
    size = np.asarray(sides) / [1.0, 2.0, 3.0]
    faces = []
    for face in brick().patches:
        points = (face.control_points - [0.5, 1.0, 1.5]) * size
        faces.append(refined(cg.NurbsSurface((1, 1), face.knots, points).elevate(2, 2), n))
    return faces


class Master(NamedTuple):
    """A body and how it changes its shape."""

    make: Callable[[], cg.NurbsSurface | list[cg.NurbsSurface]]
    move: Move
    thick: bool
    """Whether the points have a thickness."""


def ball() -> cg.NurbsSurface:
    """A sphere on finer elements."""
    return refined(cg.shapes.sphere(radius=1.5), 2)


def ring() -> cg.NurbsSurface:
    """A torus."""
    return cg.shapes.torus(major=1.5, minor=0.5)


def bumps() -> cg.NurbsSurface:
    """A sheet with bumps."""
    return cg.shapes.bumpy_plate(waves=3).scaled(2.0)


MASTERS = {
    "breathing ball, thick": Master(ball, breathing, True),
    "breathing torus, thick": Master(ring, breathing, True),
    "twisting sheet, thick": Master(sheet, twisting, True),
    "twisting torus, thick": Master(lambda: refined(ring(), 2), twisting, True),
    "twisting bar, thick": Master(lambda: block((4.0, 1.2, 0.8), 2), twisting, True),
    "folding sheet, thick": Master(sheet, folding, True),
    "folding bumps, thick": Master(bumps, folding, True),
    "breathing ball": Master(ball, breathing, False),
    "breathing torus": Master(ring, breathing, False),
    "twisting torus": Master(lambda: refined(ring(), 2), twisting, False),
    "twisting bar": Master(lambda: block((4.0, 1.2, 0.8), 2), twisting, False),
    "folding slab": Master(lambda: block((4.0, 1.6, 0.4), 3), half_folding, False),
}


class Closest(NamedTuple):
    """Closest points by brute force, one row each."""

    distance: np.ndarray
    side: np.ndarray
    """(n,) cosine of the normal there and the way to the point; where patches meet, the sum of
    those of all."""


def closest(surfaces: Sequence[cg.NurbsSurface], points: np.ndarray) -> Closest:
    """The closest points of points (n, 3) on any of the surfaces, by the nearest of all samples."""
    uv = [_grid(surface) for surface in surfaces]
    samples = [surface.evaluate(at) for surface, at in zip(surfaces, uv, strict=True)]
    patches = np.repeat(np.arange(len(surfaces)), [len(at) for at in uv])
    _, near = cKDTree(np.concatenate(samples)).query(points, STARTS)
    patch, starts = patches[near], np.concatenate(uv)[near]
    distance, side = np.empty(near.shape), np.empty(near.shape)
    for k, surface in enumerate(surfaces):
        which = np.nonzero(patch == k)
        distance[which], side[which] = _descend(surface, starts[which], points[which[0]])
    best = distance.min(axis=1, keepdims=True)
    # Of feet on one patch within rounding the first stands for all.
    first = np.ones(near.shape, bool)
    for j in range(1, STARTS):
        same = (patch[:, :j] == patch[:, j : j + 1]) & (distance[:, :j] <= best + SAME)
        first[:, j] = ~same.any(axis=1)
    side = np.where((distance <= best + SAME) & first, side, 0.0).sum(axis=1)
    return Closest(best[:, 0], side)


def _grid(surface: cg.NurbsSurface) -> np.ndarray:
    """Parameters (k, 2) of samples all over a surface, by the lengths of its control polygons."""
    net = surface.control_points
    lengths = (np.linalg.norm(np.diff(net, axis=k), axis=2).sum(axis=k).max() for k in (0, 1))
    ends = (
        np.linspace(*domain, int(length / SPACING) + 2)
        for domain, length in zip(surface.domain, lengths, strict=True)
    )
    return np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 2)


def _descend(
    surface: cg.NurbsSurface, at: np.ndarray, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distances (k,) of points from the feet that Newton's method finds, and their sides; where its
    steps lead up, shorter ones are tried, and steps along one parameter."""
    low, high = np.transpose(surface.domain)
    cell = 0.02 * (high - low)
    best = norm(surface.evaluate(at) - points)
    rows = np.arange(len(at))
    for _ in range(NEWTON_STEPS):
        if len(rows) == 0:
            break
        x, place, last = points[rows], at[rows], best[rows]
        d = surface.derivatives(place, 2)
        r = d[:, 0, 0] - x
        g = np.stack([(r * d[:, 1, 0]).sum(1), (r * d[:, 0, 1]).sum(1)], axis=1)
        aa = (d[:, 1, 0] ** 2).sum(1) + (r * d[:, 2, 0]).sum(1)
        bb = (d[:, 0, 1] ** 2).sum(1) + (r * d[:, 0, 2]).sum(1)
        ab = (d[:, 1, 0] * d[:, 0, 1]).sum(1) + (r * d[:, 1, 1]).sum(1)
        det = aa * bb - ab * ab
        full = (det > 1e-12 * np.abs(aa * bb)) & (aa > 0.0)
        det = np.where(full, det, 1.0)
        step = np.stack([-(bb * g[:, 0] - ab * g[:, 1]), -(aa * g[:, 1] - ab * g[:, 0])], axis=1)
        step = np.where(full[:, None], step / det[:, None], -np.sign(g) * cell)
        with np.errstate(divide="ignore", invalid="ignore"):
            along = np.stack([-g[:, 0] / np.abs(aa), -g[:, 1] / np.abs(bb)], axis=1)
        along[~np.isfinite(along)] = 0.0
        shortest, there = last.copy(), place.copy()
        for way in (step, along * [1.0, 0.0], along * [0.0, 1.0], along):
            for share in (1.0, 0.3, 0.05):
                tried = np.clip(place + share * np.clip(way, -2.0 * cell, 2.0 * cell), low, high)
                length = norm(surface.evaluate(tried) - x)
                better = length < shortest
                there[better], shortest[better] = tried[better], length[better]
        at[rows], best[rows] = there, shortest
        rows = rows[last - shortest > CONVERGED]
    d = surface.derivatives(at, 1)
    normal = np.cross(d[:, 1, 0], d[:, 0, 1])
    normal /= np.maximum(norm(normal), 1e-300)[:, None]
    away = (points - d[:, 0, 0]) / np.maximum(best, 1e-300)[:, None]
    return best, (normal * away).sum(axis=1)


class Scene:
    """A master in one of its shapes after the other, and points that wander about it."""

    def __init__(self, name: str, rate: float, n: int, seed: Sequence[int]) -> None:
        self.master, self.rate = MASTERS[name], rate
        made = self.master.make()
        self.body = cg.Body(made if isinstance(made, list) else [made])
        self.rng = np.random.default_rng(seed)
        # Every other scene flies, and turns.
        self.flies = seed[-1] % 2 == 1
        self.time, self.pose = self.rng.uniform(0.0, 4.0), np.eye(4)
        self.net = self._net()
        self.points = self._beside(n)

    def _net(self) -> np.ndarray:
        shape = self.master.move(self.body.net.points, self.time)
        return np.asarray(shape @ self.pose[:3, :3].T + self.pose[:3, 3])

    def surfaces(self) -> list[cg.NurbsSurface]:
        """The patches in their shape."""
        return [
            cg.NurbsSurface(patch.degrees, patch.knots, self.net[rows], patch.weights)
            for patch, rows in zip(self.body.patches, self.body.net.control, strict=True)
        ]

    def _beside(self, n: int) -> np.ndarray:
        """n points within half of `FAR` of the shape."""
        surfaces = self.surfaces()
        which, out = self.rng.integers(0, len(surfaces), n), np.empty((n, 3))
        for k, surface in enumerate(surfaces):
            rows = np.flatnonzero(which == k)
            low, high = np.transpose(surface.domain)
            out[rows] = surface.evaluate(self.rng.uniform(low, high, (len(rows), 2)))
        way = self.rng.standard_normal((n, 3))
        return out + 0.5 * FAR * self.rng.uniform(0.0, 1.0, (n, 1)) * way / norm(way)[:, None]

    def advance(self, distance: np.ndarray) -> None:
        """One step: the shape changes, points wander, half of them flying along, and those that
        are too far go back."""
        self.time += self.rate
        last = self.pose
        if self.flies:
            turn = Rotation.from_rotvec(0.5 * self.rate * self.rng.standard_normal(3)).as_matrix()
            self.pose = np.eye(4)
            self.pose[:3, :3] = turn @ last[:3, :3]
            self.pose[:3, 3] = last[:3, 3] + self.rate * self.rng.standard_normal(3)
        self.net = self._net()
        carried = cg.motion.pose.compose(self.pose, cg.motion.pose.invert(last))
        half = slice(0, None, 2)
        points = self.points.copy()
        points[half] = cg.motion.pose.apply(carried, points[half])
        walk = (0.002 + 0.5 * self.rate) * self.rng.standard_normal(points.shape)
        back = distance > FAR
        points = np.where(back[:, None], self._beside(len(points)), points + walk)
        self.points = points


def _judge_thick(scene: Scene, state: cg.State, truth: Closest, tally: Tally) -> None:
    """Compare points that have a thickness: in contact where half of it reaches."""
    closed, held = scene.body.closed, state.in_contact
    signed = np.where(closed & (truth.side < 0.0), -truth.distance, truth.distance)
    doubtful = np.abs(truth.distance - HALF) < SAME
    doubtful |= closed & (np.abs(truth.side) < SLANTED) & (truth.distance > SAME)
    # Who came behind a sheet round its border waits until it has been out of reach.
    waits = (state.safe_distance < 0.0) & (not closed)
    foot = state.foot - HALF * state.normal
    away = norm(foot - scene.points)
    flagged = np.isin(state.status, FLAGS) | (held & (state.certified == 0))
    tally.flagged += int(flagged.sum())
    tally.doubtful += int((doubtful | waits).sum())
    judged = ~doubtful & ~waits
    values = {
        "point": scene.points, "distance": signed, "foot": foot, "uv": state.uv,
        "status": state.status, "safe_distance": state.safe_distance,
    }  # fmt: skip
    depth = np.abs(state.penetration - (HALF - np.copysign(away, signed)))
    kinds = {
        "foot is not the closest point": held & ~flagged & (away > truth.distance + SAME),
        "within reach without contact": judged & ~held & ~flagged & (truth.distance < HALF),
        "contact out of reach": judged & held & (truth.distance > HALF),
        "depth is not that of the foot": judged & held & closed & (depth > SAME),
        "safe distance too long": ~held
        & (state.safe_distance > np.abs(truth.distance - HALF) + SAME),
        "foot not on the shape": held & (_off_shape(scene, state, foot) > SAME),
    }
    for kind, rows in kinds.items():
        tally.fault(kind, np.flatnonzero(rows), **values)


def _judge_thin(scene: Scene, state: cg.State, truth: Closest, tally: Tally) -> None:
    """Compare points without a thickness at a closed body: in contact where they are inside."""
    held, inside = state.in_contact, truth.side < 0.0
    doubtful = (truth.distance < SAME) | (np.abs(truth.side) < SLANTED)
    flagged = np.isin(state.status, FLAGS)
    tally.flagged += int(flagged.sum())
    tally.doubtful += int(doubtful.sum())
    # Where a wall opposite to the nearest holds a point, that is deeper. What is nearer than the
    # descent has come, on a crease say, is right: it is a point of the shape.
    deeper = ~state.guard_B.any(axis=1) & (state.penetration > truth.distance + SAME)
    away = norm(state.foot - scene.points)
    values = {
        "point": scene.points, "distance": truth.distance, "side": truth.side,
        "penetration": state.penetration, "status": state.status, "uv": state.uv,
    }  # fmt: skip
    kinds = {
        "inside without contact": ~doubtful & inside & ~held & ~flagged,
        "contact without being inside": ~doubtful & ~inside & held,
        "foot is not the closest point": ~doubtful & inside & held & ~flagged & deeper,
        "depth is not that of the foot": held & (np.abs(state.penetration - away) > SAME),
        "safe distance too long": ~held & (np.abs(state.safe_distance) > truth.distance + SAME),
        "foot not on the shape": held & (_off_shape(scene, state, state.foot) > SAME),
    }
    for kind, rows in kinds.items():
        tally.fault(kind, np.flatnonzero(rows), **values)


def _off_shape(scene: Scene, state: cg.State, foot: np.ndarray) -> np.ndarray:
    """Distance (n,) of feet from the place on the shape that is told with them."""
    out = np.zeros(len(foot))
    for k, surface in enumerate(scene.surfaces()):
        rows = np.flatnonzero(state.patch == k)
        out[rows] = norm(surface.evaluate(state.uv[rows]) - foot[rows])
    return out


def wander(name: str, rate: float, n: int, steps: int, seed: Sequence[int]) -> Tally:
    """Points about one master that changes by `rate` of its time in a step."""
    with Clock(Tally(f"deforming, {name}")) as tally:
        thick = MASTERS[name].thick
        scene = Scene(name, rate, n if thick else 3 * n, seed)
        if not thick:  # all are outside at first
            truth = closest(scene.surfaces(), scene.points)
            scene.points = scene.points[(truth.side > SLANTED) & (truth.distance > SAME)][:n]
        search = "penetration" if thick or seed[-1] % 4 >= 2 else "intersection"
        contact = cg.Contact(
            scene.body,
            cg.Slave(scene.points, area=np.ones(len(scene.points))),
            law=cg.PenaltyLaw(1.0),
            search=search,
            **({"shell_thickness": 2.0 * HALF, "on_edge": "hold", "depth": HALF} if thick else {}),
        )
        state = contact.start(scene.points, control_points=scene.net)
        distance = np.zeros(len(scene.points))
        for _ in range(steps):
            scene.advance(distance)
            state = contact.step(state, scene.points, dt=rate, control_points=scene.net)
            truth = closest(scene.surfaces(), scene.points)
            distance = truth.distance
            tally.count += len(distance)
            tally.note("in contact", int(state.n_contact))
            (_judge_thick if thick else _judge_thin)(scene, state, truth, tally)
    return tally


def deformed(name: str, rates: np.ndarray, n: int, steps: int, seed: int) -> Tally:
    """One master at all rates."""
    whole = Tally(f"deforming, {name}")
    for k, rate in enumerate(rates):
        whole.add(wander(name, float(rate), n, steps, (seed, k)))
    return whole
