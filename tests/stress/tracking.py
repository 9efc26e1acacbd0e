"""Tracked feet against closed forms, or the same motion in many tiny steps.

A foot is wrong and unflagged if it is not where the continued one is although its status says that
all is well and it is certified. Where the continued minimum itself ends on the way (the point
crosses a focal surface) there is no right foot: it must not be certified.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from tests.laws.test_search_laws import surface
from tests.stress.fields import norm
from tests.stress.solids import DATA
from tests.stress.tally import Clock, Tally

import contiga as cg
from contiga.records import Projection, SurfacePlaces, empty_projection
from contiga.search.tables import tables_of
from contiga.search.track.project import track
from contiga.statuses import Feature, Status

Foot = Callable[[np.ndarray], np.ndarray]

SMALLEST, LARGEST = 1e-6, 3.0
"""Steps, in widths of an element."""
SAME = 1e-6
"""Feet closer than this, relative to the size, are one: near focal surfaces they are not sharp."""
CALM = 1e-8
"""Ways of feet below this, relative to the size, are no jumps."""
PER_WIDTH = 24
"""Tiny steps a width, at least."""
REACH = 0.1
"""Widths off the surface that contact reaches, for the share of feet that are certified."""
SHORTEST = 1e-10
"""Share of a motion below which a foot that still jumps has lost its branch."""
LEAST = 1e-7
"""Share of a motion that a foot on an edge goes in one step at least."""
FINEST = 4.0 * SHORTEST
WIDTHS = 4.0
"""A foot that goes over an edge may jump by so many of its widths: faces meet no better there."""
CLOSER = 64
"""What looks wrong is looked at again in so many times as small steps: at the inner side of a fold
a step may lead into the other face, and its halves with it."""
SIZES = {0.1: "a tenth of an element", 1.0: "an element", np.inf: "three elements"}


class Tracked(NamedTuple):
    """A surface, how wide its elements are, and its feet in closed form where they have one."""

    name: str
    body: cg.Body
    width: float
    exact: Foot | None = None


def _width(body: cg.Body) -> float:
    spans = [np.prod([len(np.unique(k)) - 1 for k in patch.knots]) for patch in body.patches]
    return float(np.sqrt(body.area(1e-3) / sum(spans)))


def _on_sphere(p: np.ndarray) -> np.ndarray:
    return p / norm(p)[:, None]


def _on_cylinder(p: np.ndarray) -> np.ndarray:
    flat = p[:, :2] / norm(p[:, :2])[:, None]
    return np.column_stack([flat, np.clip(p[:, 2], -1.0, 1.0)])


def _on_plane(p: np.ndarray) -> np.ndarray:
    return np.column_stack([np.clip(p[:, :2], -0.5, 0.5), 0.0 * p[:, 2]])


def _on_torus(p: np.ndarray) -> np.ndarray:
    ring = np.column_stack([p[:, :2] / norm(p[:, :2])[:, None], 0.0 * p[:, 2]])
    d = p - ring
    return ring + 0.4 * d / norm(d)[:, None]


def slivers(patch: cg.NurbsSurface) -> list[cg.NurbsSurface]:
    """A patch cut into 7 × 7, wide and narrow, every other piece turned over and about."""
    share = np.array([0.0, 0.203, 0.2142, 0.4537, 0.5211, 0.5232, 0.8059, 1.0])
    u, v = (low + (high - low) * share for low, high in patch.domain)
    parts = []
    for i in range(7):
        for j in range(7):
            part = patch.restricted((u[i], u[i + 1]), (v[j], v[j + 1]))
            parts.append(part.transposed().flipped() if (i + j) % 2 else part)
    return parts


Cut = cg.NurbsSurface | list[cg.NurbsSurface]
SHAPES: dict[str, tuple[Callable[[], Cut], Foot | None]] = {
    "sphere": (lambda: cg.shapes.sphere(), _on_sphere),
    "torus": (lambda: cg.shapes.torus(major=1.0, minor=0.4), _on_torus),
    "cylinder": (
        lambda: cg.shapes.cylinder(radius=1.0, height=2.0),
        _on_cylinder,
    ),
    "plane": (lambda: cg.shapes.plane(), _on_plane),
    "cone": (lambda: cg.shapes.cone(), None),
    "ellipsoid": (lambda: cg.shapes.ellipsoid(axes=(2.0, 1.0, 0.5)), None),
    "saddle": (lambda: cg.shapes.saddle(), None),
    "bumps": (lambda: cg.shapes.bumpy_plate(waves=(3, 2)), None),
    "high bumps": (lambda: cg.shapes.bumpy_plate(amplitude=0.2, waves=(4, 4)), None),
    "cubic": (lambda: surface(1, log_weights=0.0, rough=0.1), None),
    "rough cubic": (lambda: surface(2, log_weights=0.0, rough=0.3), None),
    "rational": (lambda: surface(3, log_weights=0.5, rough=0.1), None),
    "weights over two decades": (lambda: surface(4, log_weights=1.0, rough=0.1), None),
    "quadratic": (lambda: surface(5, (2, 2), (5, 5), log_weights=0.3, rough=0.1), None),
    "with creases": (lambda: surface(6, (2, 2), (3, 3), log_weights=0.3, multiplicity=2), None),
    "quintic": (lambda: surface(7, (5, 4), (2, 1), log_weights=0.3, rough=0.1), None),
    "degree six": (lambda: surface(8, (6, 3), (2, 2), log_weights=0.3, rough=0.1), None),
    "bilinear net": (lambda: surface(9, (1, 1), (4, 3), log_weights=0.0, rough=0.2), None),
    "many spans": (lambda: surface(10, (3, 3), (12, 12), log_weights=0.3, rough=0.03), None),
    "torus with slivers": (lambda: slivers(cg.shapes.torus(major=1.0, minor=0.4)), _on_torus),
    "bumps with slivers": (lambda: slivers(cg.shapes.bumpy_plate(waves=(3, 2))), None),
}
FILES = (
    "dtmb5415_bulbous_bow.iges",
    "headface_MED_full.step",
    "utah_teapot_32bezier_gismo.xml",
    "nist_ctc_02_asme1_ap242.stp",
)


def names() -> list[str]:
    """All of them; the files where the data folder is there."""
    return [*SHAPES, *(name for name in FILES if (DATA / name).is_file())]


@cache
def tracked(name: str) -> Tracked:
    """A surface of `SHAPES`, or a file of the data folder."""
    if name in SHAPES:
        make, exact = SHAPES[name]
        made = make()
        body = cg.Body(made if isinstance(made, list) else [made])
        return Tracked(name, body, _width(body), exact)
    body = cg.read_cad(DATA / name)
    return Tracked(name, body, _width(body))


def starts(item: Tracked, n: int, rng: np.random.Generator) -> np.ndarray:
    """n points on both sides of the surface, up to a width off, some past its borders."""
    low, high = item.body.bounds()
    p = low + (high - low) * rng.uniform(-0.05, 1.05, (n, 3))
    feet = item.body.project(p)
    gap = item.width * rng.choice([-1.0, 1.0], (n, 1)) * 10.0 ** rng.uniform(-4.0, 0.0, (n, 1))
    return feet.point + gap * feet.normal


def uncertified(body: cg.Body, points: np.ndarray, start: Projection) -> Projection:
    """Tracked feet by Newton's method alone: certificates, which are judged, do not help."""
    out = empty_projection(len(points))
    track(
        tables_of(body),
        np.ascontiguousarray(points),
        SurfacePlaces(start.patch, start.uv),
        out,
    )
    return out


def _across(body: cg.Body, here: Projection, there: Projection) -> np.ndarray:
    """(n,) how far feet may be apart and be one: from an edge on, some widths of that."""
    table = tables_of(body).elements.table
    widest = np.zeros(len(body.patches))
    np.maximum.at(widest, table["patch"], table["edge_tolerance"])
    beside = (here.feature != Feature.FACE) | (there.feature != Feature.FACE)
    return np.maximum(SAME * body.size, np.where(beside, WIDTHS * widest[here.patch], 0.0))


def continued(
    body: cg.Body, feet: Projection, a: np.ndarray, b: np.ndarray, longest: float
) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) feet after the motion a → b in tiny steps, and (n,) whose branch ends on the way.

    A step of at most `longest` shares is taken if two halves of it lead to the same foot and share
    its way among them; else it is halved. Where the foot jumps however short the step, the branch
    has ended.
    """
    n, size = len(a), body.size
    t, dt = np.zeros(n), np.full(n, longest)
    ended = np.zeros(n, bool)
    length = norm(b - a)
    feet = Projection(*(x.copy() for x in feet))
    rows = np.arange(n)
    while len(rows):
        # On an edge a point could pass over a face in one step, and both halves agree.
        kink = feet.feature[rows] != Feature.FACE
        most = np.maximum(0.25 * np.abs(feet.gap[rows]) / length[rows], LEAST)
        dt[rows] = np.where(kink, np.minimum(dt[rows], most), dt[rows])
        end = np.minimum(t[rows] + dt[rows], 1.0)
        middle = 0.5 * (t[rows] + end)
        here = Projection(*(x[rows] for x in feet))
        p, q = (a[rows] + s[:, None] * (b - a)[rows] for s in (middle, end))
        whole = uncertified(body, q, here)
        half = uncertified(body, p, here)
        twice = uncertified(body, q, half)
        way = norm(whole.point - here.point)
        most = np.maximum(norm(half.point - here.point), norm(twice.point - half.point))
        calm = (way <= CALM * size) & (most <= CALM * size)
        # Faces meant to be smooth may join with a small kink: feet that close are one.
        calm |= (dt[rows] <= FINEST) & (most <= _across(body, here, twice))
        taken = (norm(whole.point - twice.point) <= CALM * size) & (calm | (most <= 0.85 * way))
        for kept, now in zip(feet, twice, strict=True):
            kept[rows[taken]] = now[taken]
        t[rows[taken]] = end[taken]
        dt[rows] = np.where(taken, np.minimum(2.0 * dt[rows], longest), 0.5 * dt[rows])
        ended[rows] = ~taken & (dt[rows] < SHORTEST)
        rows = rows[~ended[rows] & (t[rows] < 1.0)]
    return feet.point, ended


def judge(
    item: Tracked, before: Projection, a: np.ndarray, b: np.ndarray, tally: Tally, step: float
) -> None:
    """Track the feet of points that go from a to b, and compare."""
    body, size = item.body, item.body.size
    feet = body.project(b, start=before, mode="track")
    sure = feet.certified > 0
    flagged = ~np.isin(feet.status, (Status.OK, Status.BORDER, Status.TRIMMED))
    ended = np.zeros(len(a), bool)
    if item.exact is not None:
        truth = item.exact(b)
    else:
        longest = min(0.25, 1.0 / (PER_WIDTH * step))
        truth, ended = continued(body, before, a, b, longest)
        off = norm(feet.point - truth)
        again = np.flatnonzero(~flagged & sure & (ended | ~(off <= SAME * size)))
        if len(again):
            start = Projection(*(x[again] for x in before))
            found = continued(body, start, a[again], b[again], longest / CLOSER)
            truth[again], ended[again] = found
    off = norm(feet.point - truth)
    tally.count += len(a)
    tally.flagged += int(flagged.sum())
    wrong = ~flagged & (ended | ~(off <= SAME * size))
    values = {"a": a, "b": b, "start": before.point, "foot": feet.point, "status": feet.status}
    elsewhere, unnoticed = wrong & sure & ~ended, wrong & sure & ended
    tally.fault("foot elsewhere", np.flatnonzero(elsewhere), truth=truth, **values)
    tally.fault("end of branch unnoticed", np.flatnonzero(unnoticed), **values)
    tally.note("wrong, said not to be certified", int((wrong & ~sure).sum()))
    # The share certified is told of feet inside faces, of points in reach of contact.
    plain = (before.status == Status.OK) & (feet.status == Status.OK)
    plain &= np.abs(before.gap) <= REACH * item.width
    limit = next(name for most, name in SIZES.items() if step <= most)
    tally.note(f"steps up to {limit}", int(plain.sum()))
    tally.note(f"certified of those up to {limit}", int((plain & sure).sum()))


def follow(item: Tracked, n: int, seed: int, scales: int = 8) -> Tally:
    """About n tracked steps on one surface, of all sizes."""
    tally = Tally(f"tracking, {item.name}")
    steps = np.geomspace(SMALLEST, LARGEST, scales)
    for k, step in enumerate(steps):
        rng = np.random.default_rng([seed, k])
        left = max(n // scales, 1)
        while left > 0:
            with Clock(tally):
                a = starts(item, min(left, 20_000), rng)
                before = item.body.project(a)
                d = rng.normal(size=a.shape)
                b = (
                    a
                    + step * item.width * rng.uniform(0.5, 1.0, (len(a), 1)) * d / norm(d)[:, None]
                )
                judge(item, before, a, b, tally, float(step))
            left -= 20_000
    return tally
