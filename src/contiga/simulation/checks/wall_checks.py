"""Find jumps of forces where the wall that pushes deep points changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Pair, Scene
from contiga.simulation.reasons import Reason
from contiga.simulation.step_columns import REASON
from contiga.simulation.system_state import SystemState

# Smallest jump, as a share of the largest normal force.
_JUMP = 0.05
# Smallest ratio of the rate in a step to the rates in the steps before and after.
_SUDDEN = 5.0
_AXES = "xyz"
_COMES_AND_GOES = ("n_new", "n_released", "n_through", "n_slid_off", "n_lost")


def jump_columns(history: Mapping[str, FloatArray], prefix: str) -> dict[str, FloatArray]:
    """Return the columns of the contact with `prefix` and of the steps that `force_jumps` reads."""
    names = [*_COMES_AND_GOES, *(f"{of}_{axis}" for of in ("force", "friction") for axis in _AXES)]
    columns = {name: history[prefix + name] for name in names if prefix + name in history}
    return columns | {name: history[name] for name in (REASON,) if name in history}


def force_jumps(
    scene: Scene, pair: Pair, columns: Mapping[str, FloatArray], last: SystemState
) -> Iterator[Finding]:
    """Report the largest jump of the normal force while the same points touch, in automatic steps.

    A jump is more than `_JUMP` of the largest force, at more than `_SUDDEN` times the rate of the
    steps before and after. A point at equal distance from two walls changes between them at once.
    The time of the change affects all that follows, and depends on the last digits of its position.
    """
    if REASON not in columns or len(columns["time"]) < 3:  # longer steps jump for other reasons
        return
    forces = np.column_stack(
        [columns[f"force_{axis}"] - columns.get(f"friction_{axis}", 0.0) for axis in _AXES]
    )
    largest = float(np.sqrt(np.square(forces).sum(axis=1)).max())
    jumps = np.sqrt(np.square(np.diff(forces, axis=0)).sum(axis=1))
    rates = jumps / np.diff(columns["time"])
    neighbour_rates = np.maximum(np.r_[0.0, rates[:-1]], np.r_[rates[1:], 0.0])
    # At a kink velocities may jump, and damping with them.
    is_same = (columns["n_contact"][1:] == columns["n_contact"][:-1]) & (
        columns[REASON][1:] != Reason.KINK
    )
    for name in set(columns).intersection(_COMES_AND_GOES):
        is_same &= columns[name][1:] == 0
    jumps = np.where(is_same & (rates > _SUDDEN * neighbour_rates), jumps, 0.0)
    at = int(np.argmax(jumps))
    if jumps[at] > _JUMP * largest:
        yield Finding(
            "jump",
            pair.where,
            f"forces jump by {100.0 * jumps[at] / largest:.3g} % of the largest in the one step to "
            f"t = {scene.fmt(float(columns['time'][at + 1]), 'time')}, while the same points "
            f"touch: some are as near to another wall of {pair.part.master} as to the one that "
            "pushed them. What comes after depends on when that happens, at any step",
            'Take a stiffer law, or foot = "tracked", which keeps the wall they came in by',
        )
