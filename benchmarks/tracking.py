"""Feet of a million moving points beside splinepy and FCPW, on the same surface.

The points are shuffled: neighbours in memory are none in space. Records written are timed along.
"""

from __future__ import annotations

from collections.abc import Iterator
from time import process_time
from typing import Any

import numpy as np

import contiga as cg
from benchmarks import operations
from benchmarks.rivals import fcpw_feet, for_fcpw, grid_mesh, missing, splinepy_feet
from benchmarks.scene import STEP, Tracker, moved, points, surface, with_feet
from benchmarks.sizes import Sizes
from benchmarks.table import Row, not_measured
from benchmarks.timing import Given, in_turns, on_threads
from contiga.arrays.threads import thread_count
from contiga.search.balls.radii import balls_of

BESIDE_SPLINEPY = Row("tracked, shuffled, beside splinepy", "×", 250.0, None, at_least=True)
BESIDE_FCPW = Row("tracked, shuffled, beside FCPW", "×", 12.0, None, at_least=True)
COLD = Row("cold, near, shuffled: share of FCPW's time", "×", 0.5, None)
SWEPT = Row("swept points that miss, each", "ns", 150.0, None)
THREADS = Row("2 threads, tracked, over 1", "×", 1.8, None, at_least=True)


def rows(size: Sizes) -> Iterator[Row]:
    """Tracked feet beside both rivals."""
    patch = surface()
    start, feet = with_feet(patch, size.points, "shuffled")
    tracker = Tracker(cg.Body(patch), start, feet)
    works: dict[str, Any] = {"contiga": Given(tracker, lambda k: moved(start, k))}
    lacks = {name: missing(name) for name in ("splinepy", "fcpw")}
    if lacks["fcpw"] is None:
        query = fcpw_feet(grid_mesh(patch, size.triangles_a_side), size.points)
        works["fcpw"] = Given(query, lambda k: for_fcpw(moved(start, k)))
    if lacks["splinepy"] is None:
        few, other = start[: size.rival_points], splinepy_feet(patch)
        works["splinepy"] = Given(other, lambda k: moved(few, k))
    seconds = in_turns(works, min(size.rounds, 5))
    with on_threads(1):
        alone = in_turns({"contiga": works["contiga"]}, min(size.rounds, 5), process_time)
    counts = {"contiga": size.points, "fcpw": size.points, "splinepy": size.rival_points}
    each = {name: 1e9 * t / counts[name] for name, t in seconds.items()}
    proved = float(tracker.feet.certified.mean())
    last = moved(start, min(size.rounds, 5))
    detail = {
        "nanoseconds": each,
        "processor": 1e9 * alone["contiga"] / size.points,
        "worst_miss": worst_miss(patch, tracker.feet, last),
        "certified": proved,
        "points": size.points,
        "cost": cost(patch, last, tracker.feet),
    }
    for row, name in ((BESIDE_SPLINEPY, "splinepy"), (BESIDE_FCPW, "fcpw")):
        if lacks[name] is not None:
            yield not_measured(row, lacks[name])
            continue
        note = f"{each[name]:,.0f} ns beside {each['contiga']:.0f} ns, {100 * proved:.4g} % proved"
        yield row._replace(value=each[name] / each["contiga"], note=note, detail=detail)


def cost(patch: cg.NurbsSurface, p: np.ndarray, feet: cg.Projection) -> dict[str, float]:
    """Operations and bytes of a step of a tracked point, counted; of points that go on from `p`."""
    few = np.flatnonzero(feet.feature == cg.Feature.FACE)[:3200]
    rounds = operations.rounds(patch, moved(p[few], 1), feet.uv[few])
    counts = operations.counted()
    done = rounds * counts["round"] + counts["record"] + counts["proof"]
    moved_bytes = sum(operations.READ.values()) + sum(operations.WRITTEN.values())
    return {"rounds": rounds, "operations": done, "bytes": moved_bytes} | counts


def worst_miss(patch: cg.NurbsSurface, feet: cg.Projection, p: np.ndarray) -> float:
    """Largest tangential miss |S_u·(S − P)|/|S_u| of feet inside the patch, on a sample."""
    of_faces = np.flatnonzero(feet.feature == cg.Feature.FACE)[::97]
    d = patch.derivatives(feet.uv[of_faces], 1)
    r = d[:, 0, 0] - p[of_faces]
    misses = [
        np.abs((r * d[:, a, b]).sum(1)) / np.linalg.norm(d[:, a, b], axis=1)
        for a, b in ((1, 0), (0, 1))
    ]
    return float(np.max(misses, initial=0.0))


def cold(size: Sizes) -> Iterator[Row]:
    """Closest points of the whole body, of points of which nothing is known."""
    patch, n = surface(), size.cold_points
    start, body = points(patch, n, "shuffled"), cg.Body(patch)
    lack = missing("fcpw")
    if lack is not None:
        yield not_measured(COLD, lack)
        return
    query = fcpw_feet(grid_mesh(patch, size.triangles_a_side), n)
    at_once = process_time()
    balls_of(body.surface.tables)
    at_once = process_time() - at_once
    works = {
        "contiga": Given(body.project, lambda k: moved(start, k)),
        "fcpw": Given(query, lambda k: for_fcpw(moved(start, k))),
    }
    each = {name: 1e9 * t / n for name, t in in_turns(works, min(size.rounds, 4)).items()}
    note = (
        f"{each['contiga']:,.0f} ns beside {each['fcpw']:,.0f} ns; touching balls, once: "
        f"{at_once:.1f} s of processor time"
    )
    detail = {"nanoseconds": each, "balls": at_once, "points": n}
    yield COLD._replace(value=each["contiga"] / each["fcpw"], note=note, detail=detail)


def swept(size: Sizes) -> Iterator[Row]:
    """Ways of points that pass over the surface, as near as a step is long, and do not enter."""
    patch = surface()
    body = cg.Body(patch)
    _, feet = with_feet(patch, size.points, "shuffled")
    rng = np.random.default_rng(4)
    gap = (0.2 + rng.random(size.points)) * STEP * 10
    start = feet.point + gap[:, None] * feet.normal
    side = np.cross(feet.normal, rng.standard_normal(3))
    side *= STEP / np.linalg.norm(side, axis=1)[:, None]
    entered = 0

    def work(k: int) -> None:
        nonlocal entered
        hit = body.first_hit(start + (k - 1) * side, start + k * side)
        entered = int(np.isfinite(hit.fraction).sum())

    with on_threads(1):
        seconds = in_turns({"swept": work}, min(size.rounds, 5), process_time)
    value = 1e9 * seconds["swept"] / size.points
    note = f"{STEP:g} long, {2 * STEP:g} to {12 * STEP:g} away; one thread"
    assert entered == 0
    yield SWEPT._replace(value=value, note=note, detail={"points": size.points})


def threads(size: Sizes) -> Iterator[Row]:
    """The same steps on one thread and on two, in turns; each continues feet of its own."""
    if thread_count() < 2:
        yield not_measured(THREADS, "this process has one thread")
        return
    patch = surface()
    start, feet = with_feet(patch, size.points, "shuffled")
    body = cg.Body(patch)

    def work(count: int, tracker: Tracker, p: np.ndarray) -> None:
        with on_threads(count):
            tracker(p)

    works = {}
    for n in range(1, thread_count() + 1):
        tracker = Tracker(body, start, feet)
        works[str(n)] = Given(
            lambda p, n=n, tracker=tracker: work(n, tracker, p), lambda k: moved(start, k)
        )
    seconds = in_turns(works, size.rounds)
    detail = {"nanoseconds": {n: 1e9 * t / size.points for n, t in seconds.items()}}
    note = f"{detail['nanoseconds']['1']:.0f} ns and {detail['nanoseconds']['2']:.0f} ns a point"
    yield THREADS._replace(value=seconds["1"] / seconds["2"], note=note, detail=detail)
