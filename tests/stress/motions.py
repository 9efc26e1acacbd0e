"""Whole motions of a contact: refined in time, sliding round a solid, turning against arcs."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator

import numpy as np
from tests.stress import truth
from tests.stress.fields import norm
from tests.stress.shaking import FLAGS, in_body
from tests.stress.solids import BLADE, GEAR, RECIPES, Solid, solid
from tests.stress.tally import Clock, Tally
from tests.stress.tracking import continued

import contiga as cg

SAME = 1e-9
"""Penetrations and feet closer than this, relative to the size, are the same."""
Pose = Callable[[float], np.ndarray]


def walk(contact: cg.Contact, points: np.ndarray, pose: Pose, steps: int) -> Iterator[cg.State]:
    """The states of `points` while the body goes through pose(0) … pose(1) in even steps."""
    state = contact.start(points, pose(0.0))
    for k in range(1, steps + 1):
        state = contact.step(state, points, pose(k / steps))
        yield state


def touch(body: cg.Body, points: np.ndarray, foot: str = "nearest") -> cg.Contact:
    """A contact of a body with a cloud, search by intersection."""
    slave = cg.Slave(points, area=np.ones(len(points)))
    return cg.Contact(body, slave, law=cg.PenaltyLaw(1.0), foot=foot)


# Refinement: the same motion in n, 10 n, 100 n steps.


def _sheet(half: float, n: int, bend: float = 0.0) -> np.ndarray:
    x, y = np.meshgrid(*2 * [np.linspace(-half, half, n)])
    return np.stack([x.ravel(), y.ravel(), bend * (x**2 - 0.3 * y**2).ravel()], axis=1)


def _lowered(depth: float, aside: float, start: float) -> Pose:
    def pose(s: float) -> np.ndarray:
        return cg.motion.pose.translation([aside * s, 0.5 * aside * s, start - depth * s])

    return pose


def _turned(angle: float, axis: tuple[float, float, float]) -> Pose:
    return lambda s: cg.motion.pose.rotation(axis, angle * s)


def _about_block(n: int, seed: int) -> np.ndarray:
    """Points near the corners and edges of the block, where turning takes them over fillets."""
    rng = np.random.default_rng(seed)
    block = solid("block, fillets 3")
    p = truth.on_surface(block, 4 * n, rng)
    deep = np.abs(p) - [27.0, 17.0, 7.0] > 0.0
    p = p[deep.sum(axis=1) >= 2][:n]
    return p + 0.3 * truth.gradient(RECIPES["block, fillets 3"].field, p, 1e-6)


MOTIONS: dict[str, tuple[Callable[[], cg.Body], Callable[[], np.ndarray], Pose, int]] = {
    "ball lowered on a sheet": (
        lambda: cg.Body([cg.shapes.sphere()]),
        lambda: _sheet(0.3, 41),
        _lowered(0.02, 0.05, 1.001),
        4,
    ),
    "head on a curved sheet": (
        lambda: cg.Body([cg.shapes.ellipsoid(axes=(0.75, 0.9, 1.15))]),
        lambda: _sheet(0.4, 41, bend=0.2),
        _lowered(0.03, 0.1, 1.16),
        5,
    ),
    "filleted block turned": (
        lambda: solid("block, fillets 3").body,
        lambda: _about_block(1500, 5),
        _turned(0.03, (1.0, 2.0, -1.5)),
        6,
    ),
    "torus turned through its own cloud": (
        lambda: solid("torus").body,
        lambda: truth.on_surface(solid("torus"), 1500, np.random.default_rng(6)) * 1.004,
        _turned(0.02, (1.0, 0.3, 0.0)),
        5,
    ),
}


def refine(name: str, finest: int) -> Tally:
    """One motion in n, 10 n, … steps: the same contacts and penetrations at the end."""
    make, points_of, pose, n = MOTIONS[name]
    with Clock(Tally(f"refinement, {name}")) as tally:
        body, points = make(), points_of()
        contact = touch(body, points)
        ends = []
        for factor in (1, 10, 100)[:finest]:
            for state in walk(contact, points, pose, factor * n):
                tally.count += len(points)
                tally.flagged += int(np.isin(state.status, FLAGS).sum())
            ends.append(state)
        p_B = in_body(pose(1.0), points)
        values = {"point": p_B, "penetration": ends[0].penetration, "status": ends[0].status}
        clear = np.abs(body.project(p_B).gap) > SAME * body.size
        tally.doubtful += int((~clear).sum())
        for other in ends[1:]:
            changed = clear & (other.in_contact != ends[0].in_contact)
            off = np.abs(other.penetration - ends[0].penetration) > SAME * body.size
            tally.fault("contact depends on the steps", np.flatnonzero(changed), **values)
            tally.fault("depth depends on the steps", np.flatnonzero(off & ~changed), **values)
        tally.notes["contacts"] = int(ends[0].n_contact)
    return tally


# Sliding round a solid at constant depth.


def paths_round(item: Solid, depth: float, n: int, steps: int, seed: int) -> np.ndarray:
    """(steps, n, 3) places at `depth` under the surface, along cuts through it by planes."""
    assert item.field is not None
    rng = np.random.default_rng(seed)
    across = rng.normal(size=(n, 3))
    across /= norm(across)[:, None]

    def gradient(p: np.ndarray) -> np.ndarray:
        g = truth.gradient(item.field, p, 1e-7 * item.size)
        g -= (g * across).sum(axis=1)[:, None] * across
        return g / np.maximum(norm(g), 1e-3)[:, None]

    p = truth.on_surface(item, 8 * n, rng)[:n]
    places = []
    for _ in range(steps + 1):
        for _ in range(8):
            p = p - (item.field(p) + depth)[:, None] * gradient(p)
        places.append(p)
        p = p + 2.5 * item.size / steps * np.cross(across, gradient(p))
    return np.array(places[1:])


def _continuous(
    item: Solid,
    path: tuple[np.ndarray, np.ndarray],
    states: tuple[cg.State, cg.State],
    rows: np.ndarray,
    tally: Tally,
    values: dict[str, np.ndarray],
) -> None:
    """Feet that went faster than their points are those of the same motion in tiny steps."""
    (before, now), (last, state) = path, states
    way, jump = norm(now - before)[rows], norm(state.foot - last.foot)[rows]
    rows = rows[jump > 3.0 * way + SAME * item.size]
    told = state.certified[rows] == 0
    tally.note("fast feet said not to be certified", int(told.sum()))
    rows = rows[~told]
    if len(rows) == 0:
        return
    feet = item.body.project(before[rows])._replace(
        patch=last.patch[rows], uv=last.uv[rows], point=last.foot[rows], normal=last.normal[rows],
        gap=-last.penetration[rows],
    )  # fmt: skip
    foot, ended = continued(item.body, feet, before[rows], now[rows], 1.0 / 64.0)
    tally.fault("end of branch unnoticed", rows[ended], **values)
    elsewhere = ~ended & ~(norm(foot - state.foot[rows]) <= 1e-6 * item.size)
    tally.fault("foot elsewhere", rows[elsewhere], **values)


def slide(item: Solid, n: int, steps: int, seed: int) -> Tally:
    """n points pressed at constant depth travel round: feet that are followed go without a jump.

    Where a foot jumps all the same, the status must say so: NEW for a point that went out and in
    again, or that its foot was found anew.
    """
    with Clock(Tally(f"sliding, {item.name}")) as tally:
        depth = 2e-4 * item.size
        paths = paths_round(item, depth, n, steps, seed)
        outside = paths[0] + 3.0 * depth * truth.gradient(item.field, paths[0], 1e-7 * item.size)
        contact = touch(item.body, outside, "tracked")
        last = state = contact.step(contact.start(outside), paths[0])
        for before, now in itertools.pairwise(paths):
            state = contact.step(last, now)
            inside = np.asarray(item.field(now)) < -truth.BAND * item.size
            flagged = np.isin(state.status, FLAGS)
            tally.count += n
            tally.flagged += int(flagged.sum())
            values = {"before": before, "point": now, "foot": state.foot, "was": last.foot,
                      "status": state.status}  # fmt: skip
            lost = inside & ~state.in_contact & ~flagged
            tally.fault("inside without contact", np.flatnonzero(lost), **values)
            goes_on = last.in_contact & state.in_contact & ~flagged
            goes_on &= state.status != cg.ContactStatus.NEW
            _continuous(item, (before, now), (last, state), np.flatnonzero(goes_on), tally, values)
            last = state
    return tally


# Turning against points: entries in closed form.


def _meets_blade(radius: np.ndarray) -> np.ndarray:
    """Angle from the blade's chord at which a circle of `radius` crosses its upper arc."""
    inner, outer, bulge = BLADE
    half, middle = 0.5 * (outer - inner), 0.5 * (inner + outer)
    R = (half**2 + bulge**2) / (2.0 * bulge)
    down = R - bulge
    # |x − c| = R for x = radius (cos a, sin a), c = (middle, −down).
    k = (radius**2 + middle**2 + down**2 - R**2) / (2.0 * radius)
    return np.arccos(np.clip(k / np.hypot(middle, down), -1.0, 1.0)) + np.arctan2(-down, middle)


def _meets_tooth(radius: np.ndarray) -> np.ndarray:
    """Angle at which a circle of `radius` crosses the first flank, from root to tip."""
    count, root, tip = GEAR
    pitch = 2.0 * np.pi / count
    a = root * np.array([np.cos(0.45 * pitch), np.sin(0.45 * pitch)])
    b = tip * np.array([np.cos(0.5 * pitch), np.sin(0.5 * pitch)])
    d = b - a
    normal = np.array([-d[1], d[0]]) / np.sqrt(d @ d)
    level = normal @ a
    return np.arctan2(normal[1], normal[0]) + np.arccos(np.clip(level / radius, -1.0, 1.0))


TURNS: dict[str, tuple[str, Callable[[np.ndarray], np.ndarray], tuple[float, float], float]] = {
    "blade": ("blade", _meets_blade, (12.0, 48.0), 1.0),
    "internal teeth": ("internal gear", _meets_tooth, (GEAR[2] + 0.2, GEAR[1] - 0.2), -1.0),
}
"""Solid, where its first flank is met, the radii of the points, and the sense it turns in."""
WHOLE = 0.04
"""Angle turned by in all."""


def turn(name: str, n: int, steps: int, seed: int) -> Tally:
    """A blade, or internal teeth, turning against points: who is touched at each step.

    A point is entered when the body has turned by the angle that lies between the point and the
    place where its own circle crosses the flank; no blade or tooth is so thin that the point comes
    out behind it by the end.
    """
    of, meets, (low, high), sense = TURNS[name]
    with Clock(Tally(f"turning, {name}")) as tally:
        item = solid(of)
        rng = np.random.default_rng(seed)
        radius = rng.uniform(low, high, n)
        entry = meets(radius)
        ahead = rng.uniform(0.5, 1.2, n) * WHOLE
        angle = entry + sense * ahead
        points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle),
                                  rng.uniform(-5.0, 5.0, n)])  # fmt: skip
        contact = touch(item.body, points)
        pose = _turned(sense * WHOLE, (0.0, 0.0, 1.0))
        for k, state in enumerate(walk(contact, points, pose, steps), 1):
            gone = WHOLE * k / steps
            touched = gone > ahead
            clear = np.abs(gone - ahead) * radius > 1e-9 * item.size
            flagged = np.isin(state.status, FLAGS)
            tally.count += n
            tally.flagged += int(flagged.sum())
            tally.doubtful += int((~clear).sum())
            wrong = clear & ~flagged & (state.in_contact != touched)
            values = {"point": points, "radius": radius, "ahead": ahead,
                      "gone": np.full(n, gone), "status": state.status}  # fmt: skip
            tally.fault("not touched when the arc says", np.flatnonzero(wrong), **values)
    return tally
