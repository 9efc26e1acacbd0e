"""Find forces that jump, since deep points are pushed by one wall and at once by another."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.scene import Pair, Scene
from contiga.simulation.reasons import Reason
from contiga.simulation.step_columns import REASON
from contiga.simulation.system_state import SystemState

# Of the largest normal force: a jump that shows in what moves.
_JUMP = 0.05
# Times the rate of the steps before and after: what changes smoothly does so over several.
_SUDDEN = 5.0
_AXES = "xyz"
_COMES_AND_GOES = ("n_new", "n_released", "n_through", "n_slid_off", "n_lost")


def jump_columns(history: Mapping[str, FloatArray], prefix: str) -> dict[str, FloatArray]:
    """Return the columns of the contact with `prefix` and of the steps that `jumped` reads."""
    names = [*_COMES_AND_GOES, *(f"{of}_{axis}" for of in ("force", "friction") for axis in _AXES)]
    columns = {name: history[prefix + name] for name in names if prefix + name in history}
    return columns | {name: history[name] for name in (REASON,) if name in history}


def jumped(
    scene: Scene, pair: Pair, own: Mapping[str, FloatArray], last: SystemState
) -> Iterator[Finding]:
    """Report normal forces that jump while the same points touch, in automatic steps.

    A point as near to two walls changes from one to the other at once. When it does decides what
    comes after, and hangs on the last digits of where it stands.
    """
    if REASON not in own or len(own["time"]) < 3:  # longer steps jump for other reasons
        return
    forces = np.column_stack(
        [own[f"force_{axis}"] - own.get(f"friction_{axis}", 0.0) for axis in _AXES]
    )
    most = float(np.sqrt(np.square(forces).sum(axis=1)).max())
    jumps = np.sqrt(np.square(np.diff(forces, axis=0)).sum(axis=1))
    rates = jumps / np.diff(own["time"])
    around = np.maximum(np.r_[0.0, rates[:-1]], np.r_[rates[1:], 0.0])
    # At a kink velocities may jump, and damping with them.
    same = (own["n_contact"][1:] == own["n_contact"][:-1]) & (own[REASON][1:] != Reason.KINK)
    for name in set(own).intersection(_COMES_AND_GOES):
        same &= own[name][1:] == 0
    jumps = np.where(same & (rates > _SUDDEN * around), jumps, 0.0)
    at = int(np.argmax(jumps))
    if jumps[at] > _JUMP * most:
        yield Finding(
            "jump",
            pair.where,
            f"forces jump by {100.0 * jumps[at] / most:.3g} % of the largest in the one step to "
            f"t = {scene.said(float(own['time'][at + 1]), 'time')}, while the same points touch: "
            f"some are as near to another wall of {pair.part.master} as to the one that pushed "
            "them. What comes after depends on when that happens, at any step",
            'Take a stiffer law, or foot = "tracked", which keeps the wall they came in by',
        )
