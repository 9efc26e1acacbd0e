"""Runs whose steps choose themselves, held against runs of the same scenes in far shorter steps."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from tests.stress.random_scenes import Scene, scene
from tests.stress.tally import Clock, Tally

from contiga.dynamics.stepping import GivenTimes

SAME = 0.01
"""Of the scale of a channel: what two runs may differ by."""
SHIFTED = 1e-3
"""Of the run: by how much the time may be off at which a channel jumps."""
SMALL = 0.01
"""Of the largest scale of its kind: what that of a channel is at least."""
ARM = 0.25
"""Of the size of the scene: what turns count as ways by, and moments as forces."""
_PASSED = re.compile(r"time$|wall_time|(.*\.)?n_\w+|step\.|.*error$|(.*\.)?centre_")
"""Columns that are no channels: times, counts, reasons, errors, and places of no force."""
_JUMPS = re.compile(
    r"force|friction_|moment|area|pressure|penetration|energy|work|\.[avw][xyz]$|\.rate$"
)
"""Channels that may jump, or change in a blow shorter than a thousandth of the run, energies where
springs of friction let go: all but places, turns and lengths. They are held against what the other
run goes through in a step."""
_TELLS = re.compile(
    r"energy balance: |step: |.*: in the one step to t = .* went .* deeper|.*: forces jump by "
)
"""Warnings that something is not right, or not to phase."""
PARTS, LEAST = 3, 400
"""Parts of each step that the other run takes, and how many all in all at least."""
_ALIKE = ("moment", 1, "force"), ("spin", -1, "speed"), ("turn", -1, "place")
"""Kinds that others are compared with by an arm to this power."""


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
    told: list[str]
    """Warnings of the run that say that something is not right."""
    sure: float
    """What the short steps differ by from ones a third as long; 0 where that was not asked."""

    @property
    def kind(self) -> str:
        """`same`, `told` where a warning says what is not, `in doubt` where short steps do not
        agree among each other either, or `wrong`."""
        if self.worst.relative <= SAME:
            return "same"
        if self.told:
            return "told"
        return "in doubt" if self.sure > 0.5 * self.worst.relative else "wrong"


def finer(times: np.ndarray, parts: int, least: int) -> tuple[np.ndarray, np.ndarray]:
    """Each step in so many parts, all in at least so many; and the rows of the times given."""
    most = (times[-1] - times[0]) / least
    counts = np.maximum(parts, np.ceil(np.diff(times) / most).astype(int))
    pieces = [
        np.linspace(a, b, k + 1)[1:] for a, b, k in zip(times[:-1], times[1:], counts, strict=True)
    ]
    return np.concatenate([times[:1], *pieces]), np.concatenate([[0], np.cumsum(counts)])


def compared(
    auto: dict[str, Any], fine: dict[str, Any], rows: np.ndarray, size: float
) -> Difference:
    """Where a run differs most from one in shorter steps, whose `rows` are at the same times.

    `size` is that of the scene.
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
    arm = ARM * size
    for kind, factor, of in _ALIKE:
        kinds[kind] = max(kinds.get(kind, 0.0), arm**factor * kinds.get(of, 0.0))
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


def judged(own: Scene, parts: int = PARTS, least: int = LEAST) -> Verdict:
    """A scene in steps that choose themselves and in far shorter ones."""
    result = own.simulation(end=own.end, step="auto").run()
    history, sure = result.history, 0.0
    size = own.parts["contacts"][0].master.size
    times, rows = finer(history["time"], parts, least)
    fine = run_at(own, times)
    worst = compared(history, fine, rows, size)
    if worst.relative > SAME:
        thirds, again = finer(times, 3, 1)
        sure = compared(fine, run_at(own, thirds), again, size).relative
    told = [text for text in result.summary["warnings"] if _TELLS.match(text)]
    return Verdict(own.text, len(history["time"]) - 1, worst, told, sure)


def agree(seeds: Iterable[int], parts: int = PARTS, least: int = LEAST) -> Tally:
    """Scenes by their numbers: what does not agree and is not told is wrong."""
    with Clock(Tally("steps that choose themselves, scenes")) as tally:
        for seed in seeds:
            verdict = judged(scene(seed), parts, least)
            tally.count += 1
            tally.note("steps", verdict.steps)
            tally.wrong += verdict.kind == "wrong"
            tally.flagged += verdict.kind == "told"
            tally.doubtful += verdict.kind == "in doubt"
            if verdict.kind == "wrong":
                worst = verdict.worst._asdict()
                tally.faults.append(
                    {"kind": "another run", "seed": seed, "scene": verdict.text} | worst
                )
    return tally


def run_at(own: Scene, times: np.ndarray) -> dict[str, Any]:
    """The history of a scene whose steps end at given times."""
    return own.simulation(stepping=GivenTimes(times)).run().history
