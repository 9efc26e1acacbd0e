"""Runs whose steps choose themselves, held against runs of the same scenes in far shorter steps."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np
from tests.stress.random_scenes import Scene, scene
from tests.stress.tally import Clock, Tally

import contiga as cg
from contiga.dynamics.stepping import GivenTimes

SAME = 0.01
"""Of the scale of a channel: what two runs may differ by."""
SHIFTED = 1e-3
"""Of the run: by how much the time may be off at which a channel jumps."""
SMALL = 1e-4
"""Of the largest scale of its kind: what that of a channel is at least."""
_PASSED = re.compile(r"time$|wall_time|(.*\.)?n_\w+|step\.|.*error$|(.*\.)?centre_")
"""Columns that are no channels: times, counts, reasons, errors, and places of no force."""
_JUMPS = re.compile(r"force|friction_|moment|area|pressure|\.a[xyz]$|\.rate$")
"""Channels that may jump: they are held against what the other run goes through in a step."""


class Difference(NamedTuple):
    """Where two runs differ most."""

    relative: float
    """Over the scale of the channel."""
    channel: str
    time: float


class Verdict(NamedTuple):
    """A scene in its own steps and in short ones."""

    text: str
    steps: int
    worst: Difference
    warnings: list[str]
    sure: float
    """What the short steps differ by from ones half as many; inf where that was not asked."""


def finer(times: np.ndarray, parts: int, least: int) -> tuple[np.ndarray, np.ndarray]:
    """Each step in so many parts, all in at least so many; and the rows of the times given."""
    most = (times[-1] - times[0]) / least
    counts = np.maximum(parts, np.ceil(np.diff(times) / most).astype(int))
    pieces = [
        np.linspace(a, b, k + 1)[1:]
        for a, b, k in zip(times[:-1], times[1:], counts, strict=True)
    ]
    return np.concatenate([times[:1], *pieces]), np.concatenate([[0], np.cumsum(counts)])


def compared(
    auto: dict[str, Any], fine: dict[str, Any], rows: np.ndarray, size: float
) -> Difference:
    """Where a run differs most from one in shorter steps, whose `rows` are at the same times.

    `size` is that of the scene: moments count for no less than their forces at a small part of it
    as an arm, turns as ways.
    """
    groups: dict[str, float] = {}
    kinds: dict[str, float] = {}
    names = [name for name in auto if not _PASSED.match(name)]
    names = [name for name in names if np.issubdtype(np.asarray(auto[name]).dtype, np.floating)]
    for name in names:
        group, kind = _group(name)
        values = fine[name]
        if kind in ("place", "turn"):
            values = values - values[0]
        most = float(np.nanmax(np.abs(values), initial=0.0))
        groups[group] = max(groups.get(group, 0.0), most)
        kinds[kind] = max(kinds.get(kind, 0.0), most)
    for kind, arm, of in (("moment", size, "force"), ("spin", 1 / size, "speed"), ("turn", 1 / size, "place")):
        kinds[kind] = max(kinds.get(kind, 0.0), arm * kinds.get(of, 0.0))
    worst, windows = Difference(0.0, "", 0.0), _windows(auto["time"], fine["time"])
    for name in names:
        group, kind = _group(name)
        scale = max(groups[group], SMALL * kinds[kind])
        if scale == 0.0:
            continue
        if _JUMPS.search(name):
            off = _beyond(auto[name], fine[name], windows) / scale
        else:
            off = np.abs(auto[name] - fine[name][rows]) / scale
        at = int(np.argmax(off))
        worst = max(worst, Difference(float(off[at]), name, float(auto["time"][at])))
    return worst


def _group(name: str) -> tuple[str, str]:
    """The channels that share a scale, and those of the same dimension."""
    group = re.sub(r"(?<=[._])([avw]?|q)[wxyz]$", r"\1", name)
    last = group.rpartition(".")[2]
    kinds = {"": "place", "v": "speed", "w": "spin", "a": "acceleration", "q": "turn"}
    if last in kinds:
        return group, kinds[last]
    if "energy" in name or last == "work":
        return group, "energy"
    for kind in ("force", "friction", "moment", "pressure"):
        if kind in last:
            return group, kind.replace("friction", "force")
    return group, last


def _windows(times: np.ndarray, fine: np.ndarray) -> np.ndarray:
    """(n, 2) rows of a run in short steps that lie as near in time as a jump may be off: a step of
    the other, or a small part of the run."""
    steps = np.diff(times, prepend=times[0], append=times[-1])
    near = SHIFTED * (times[-1] - times[0])
    low = np.searchsorted(fine, times - np.maximum(steps[:-1], near))
    high = np.searchsorted(fine, times + np.maximum(steps[1:], near), side="right")
    return np.column_stack([low, high])


def _beyond(auto: np.ndarray, fine: np.ndarray, windows: np.ndarray) -> np.ndarray:
    """(n,) how far the values of a run are from all that the other goes through near by."""
    low = np.array([fine[a:b].min() for a, b in windows])
    high = np.array([fine[a:b].max() for a, b in windows])
    return np.maximum(0.0, np.maximum(low - auto, auto - high))


def judged(own: Scene, parts: int = 4, least: int = 2000) -> Verdict:
    """A scene in steps that choose themselves and in far shorter ones."""
    result = own.simulation(end=own.end, step="auto").run()
    history, worst, sure = result.history, Difference(0.0, "", 0.0), np.inf
    size = own.parts["contacts"][0].master.size
    times, rows = finer(history["time"], parts, least)
    fine = run_at(own, times)
    worst = compared(history, fine, rows, size)
    if worst.relative > SAME:
        twice, again = finer(times, 3, 1)
        sure = compared(fine, run_at(own, twice), again, size).relative
    warnings = list(result.summary["warnings"])
    return Verdict(own.text, len(history["time"]) - 1, worst, warnings, sure)


def run_at(own: Scene, times: np.ndarray) -> dict[str, Any]:
    """The history of a scene whose steps end at given times."""
    return own.simulation(stepping=GivenTimes(times)).run().history
