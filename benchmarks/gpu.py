"""Tracked feet of ten million points on a GPU, beside all threads of the processor.

`python -m benchmarks gpu`, where numba-cuda and a GPU are. Tables, feet and points stay on the
device; the points are moved there, too. A step is timed in three ways: the launch alone, by events
of the device; with the rows that come back to the processor; and with points that come from the
host.
"""

from __future__ import annotations

from collections.abc import Iterator
from statistics import median
from time import perf_counter
from typing import Any, NamedTuple

import numba
import numpy as np

import contiga as cg
from benchmarks.scene import STEP, moved, surface, with_feet
from contiga.arrays.device import check_device, launch, resident
from contiga.errors import ContigaError
from contiga.records import Projection, SurfacePlaces, empty_projection
from contiga.search.hierarchy.table_types import Tables
from contiga.search.tables import tables_of
from contiga.search.track import device, project

POINTS = 10_000_000
STEPS = 7
"""The first is left out of the medians."""
EXACT = ("patch", "feature", "status", "certified")
CLOSE = ("uv", "point", "normal", "gap")


class Scene(NamedTuple):
    """Points near a body, with their feet."""

    name: str
    tables: Tables
    feet: Projection
    points: np.ndarray
    """(n, 3) length, body frame."""
    step: float
    """Length of a step."""


class Steps(NamedTuple):
    """Seconds of each step, and what came of them."""

    kernel: list[float]
    whole: list[float]
    rows: int
    """That the processor did in the last one."""
    tracked: device.Tracked


def run(points: int = POINTS) -> list[str]:
    """The lines of the table."""
    try:
        check_device()
    except ContigaError as reason:
        return [f"not measured: {reason}"]
    lines = [described()]
    for order in ("sorted", "shuffled"):
        lines += measured(patch_scene(points, order))
    return lines


def described() -> str:
    """The device and the versions."""
    from numba import cuda

    name = cuda.get_current_device().name
    name = name.decode() if isinstance(name, bytes) else name
    return f"{name}, numba {numba.__version__}, {numba.config.NUMBA_NUM_THREADS} threads beside it"


def patch_scene(points: int, order: str) -> Scene:
    """The rational patch of the other benchmarks."""
    patch = surface()
    p, feet = with_feet(patch, points, order)
    return Scene(f"patch, {order}", tables_of(cg.Body(patch)), feet, p, STEP)


def measured(scene: Scene) -> Iterator[str]:
    """Yield the lines of a scene: speed, and differences from the processor's feet."""
    n = len(scene.points)
    steps = on_device(scene)
    sent = from_host(scene)
    feet, alone = by_the_cpu(scene)
    kernel, total = median(steps.kernel[1:]), median(steps.whole[1:])
    share = steps.rows / n
    yield (
        f"{scene.name}: {n:,} points, {n / kernel:.3g} a second by the launch alone, "
        f"{n / total:.3g} with the {100 * share:.2g} % left to the CPU, {n / sent:.3g} with points "
        f"from the host; the CPU {n / alone:.3g}: {alone / kernel:.3g}, {alone / total:.3g} and "
        f"{alone / sent:.3g} times"
    )
    yield f"{scene.name}: {differences(device.feet_of(steps.tracked), feet)}"


def on_device(scene: Scene) -> Steps:
    """Run steps of points that are moved on the device."""
    from numba import cuda

    start = resident(scene.points)
    buffers = [resident(np.empty_like(scene.points)) for _ in range(2)]
    steps = Steps([], [], 0, device.start(scene.tables, scene.feet, start))
    for k in range(1, STEPS + 1):
        now = buffers[k % 2]
        launch(shifted, len(now), start, resident(moved(np.zeros((1, 3)), k, scene.step)), now)
        cuda.synchronize()
        before, after = cuda.event(), cuda.event()
        started = perf_counter()
        before.record()
        device.start_on_device(steps.tracked, now)
        after.record()
        tracked, rows = device.finish_on_host(steps.tracked, now)
        cuda.synchronize()
        steps.whole.append(perf_counter() - started)
        steps.kernel.append(cuda.event_elapsed_time(before, after) / 1e3)
        steps = steps._replace(tracked=tracked, rows=len(rows))
    return steps


@numba.njit  # type: ignore[untyped-decorator]
def shifted(start: Any, by: Any, now: Any, k: int) -> None:
    """Move point k by a step; the work of one thread."""
    for c in range(3):
        now[k, c] = start[k, c] + by[0, c]


def from_host(scene: Scene) -> float:
    """Return the median seconds of the same steps with points sent from the host."""
    tracked = device.start(scene.tables, scene.feet, scene.points)
    times = []
    for k in range(1, STEPS + 1):
        now = moved(scene.points, k, scene.step)
        started = perf_counter()
        tracked, _ = device.track(tracked, now)
        times.append(perf_counter() - started)
    return median(times[1:])


def by_the_cpu(scene: Scene) -> tuple[Projection, float]:
    """Return feet of the last step by all threads of the processor, and the median seconds."""
    feet, before = scene.feet, scene.points
    out = empty_projection(len(before))
    times = []
    for k in range(1, STEPS + 1):
        now = moved(scene.points, k, scene.step)
        started = perf_counter()
        project.track(scene.tables, now, SurfacePlaces(feet.patch, feet.uv), out, before)
        times.append(perf_counter() - started)
        feet, before = out, now
    return feet, median(times[1:])


def differences(actual: Projection, expected: Projection) -> str:
    """Return the largest differences of feet, and the numbers of rows whose codes differ."""
    n_rows = {name: int(np.sum(getattr(actual, name) != getattr(expected, name))) for name in EXACT}
    largest = {
        name: float(np.max(np.abs(getattr(actual, name) - getattr(expected, name))))
        for name in CLOSE
    }
    texts = [f"{name} {value:.1e}" for name, value in largest.items()]
    texts += [f"{name} {count} rows" for name, count in n_rows.items()]
    return "largest differences: " + ", ".join(texts)
