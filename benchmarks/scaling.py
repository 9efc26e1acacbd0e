"""What a tracked point costs over the count of faces and over the count of points."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from statistics import median
from time import perf_counter

import numpy as np

import contiga as cg
from benchmarks.scene import Tracker, moved, points, surface, with_feet
from benchmarks.sizes import Sizes
from benchmarks.table import Row
from benchmarks.timing import Given, in_turns

FACES = Row("a point's cost, 10,000 faces over 1", "×", 1.5, None)
TURNS = 3
"""Times as many rounds as elsewhere: steps are short, and the goal is near."""
FAR = 8
"""Steps that points go on before they come back."""
POINTS = Row("a point's cost, largest over smallest of 10⁴ to 10⁷ points", "×", 1.2, None)


def cut(patch: cg.NurbsSurface, faces: int) -> cg.Body:
    """A body of the patch cut into so many, a square number, along even parameters."""
    side = round(np.sqrt(faces))
    borders = np.linspace(0.0, 1.0, side + 1)
    spans = [(float(a), float(b)) for a, b in pairwise(borders)]
    return cg.Body([patch.restricted(u, v) for u in spans for v in spans])


def rows(size: Sizes) -> Iterator[Row]:
    """Both; the points are shuffled."""
    yield faces(size)
    yield counts(size)


def faces(size: Sizes) -> Row:
    """Equal points on the same surface, whole and cut."""
    patch = surface()
    start = points(patch, size.face_points, "shuffled")
    trackers = {str(n): Tracker(cut(patch, n), start) for n in size.faces}
    works = {n: Given(t, lambda k: moved(start, _there_and_back(k))) for n, t in trackers.items()}
    each = _each(in_turns(works, TURNS * size.rounds), len(start))
    first, last = str(size.faces[0]), str(size.faces[-1])
    note = ", ".join(f"{int(n):,} faces: {t:.0f} ns" for n, t in each.items())
    detail = {"nanoseconds": each, "points": len(start)}
    return FACES._replace(value=each[last] / each[first], note=note, detail=detail)


def counts(size: Sizes) -> Row:
    """More and more points near the same surface.

    Of few points as many more steps are taken, one after the other as in a run: one alone would
    tell how long threads take to wake up. Where the points are is worked out before each step, for
    which the clock stands still: all steps at once, those of few points would be read from farther
    away. The counts take turns, and of each it is the median step that counts: what else the
    machine does falls on all of them alike.
    """
    patch = surface()
    body = cg.Body(patch)
    given = {n: with_feet(patch, n, "shuffled") for n in size.counts}
    trackers = {n: Tracker(body, *given[n]) for n in size.counts}
    took: dict[int, list[float]] = {n: [] for n in size.counts}
    for k in range(size.rounds):
        for n, tracker in trackers.items():
            found = _seconds(tracker, _some(given[n][0], k, max(size.counts) // n))
            took[n] += found if k else []
    each = _each({str(n): median(times) / n for n, times in took.items()}, 1)
    note = ", ".join(f"{int(n):,}: {t:.0f} ns" for n, t in each.items())
    value = max(each.values()) / min(each.values())
    return POINTS._replace(value=value, note=note, detail={"nanoseconds": each})


def _seconds(tracker: Tracker, steps: Iterable[np.ndarray]) -> list[float]:
    """What each step takes, without what it takes to make its points."""
    times = []
    for points_of_step in steps:
        begun = perf_counter()
        tracker(points_of_step)
        times.append(perf_counter() - begun)
    return times


def _some(start: np.ndarray, k: int, steps: int) -> Iterator[np.ndarray]:
    """Where the points are at the next of so many steps in turn k, each as long as every other."""
    for i in range(steps):
        yield moved(start, _there_and_back(k * steps + i + 1))


def _there_and_back(k: int) -> int:
    """Steps from the start after k steps: thousands of them on would lead off the surface, and
    twenty to where its normals meet."""
    return FAR - abs(k % (2 * FAR) - FAR)


def _each(seconds: dict[str, float], n: int) -> dict[str, float]:
    return {name: 1e9 * t / n for name, t in seconds.items()}
