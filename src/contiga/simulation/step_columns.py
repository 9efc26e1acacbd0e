"""What a run says of its steps: why each was as long as it was, and what came of all."""

from __future__ import annotations

from typing import Any

import numpy as np

from contiga.records import FloatArray
from contiga.simulation.model import Model
from contiga.simulation.reasons import Choice, Cut, Reason

REASON, OF, TRIES, ENERGY_ERROR = "step.reason", "step.of", "step.tries", "step.energy_error"
SINGLE = "step.single"
COLUMNS = (REASON, OF, TRIES, ENERGY_ERROR, SINGLE)
"""Of steps that choose themselves: number of the `Reason`, of what in `names_of` (−1 of nothing),
steps worked out, energy balance error that no shorter one would have reduced, and ω h of single
points that swing and are not followed."""


FOLLOWED = 0.3
"""ω h up to which a swing is right to about 1 % over half of it."""


def names_of(model: Model) -> list[str]:
    """What asks for short steps, in words, by its number in histories."""
    return [
        *(f"contact {part.name!r}" for part in model.contacts),
        *(f"viscous friction of contact {part.name!r}" for part in model.contacts),
        *(f"spring {name!r}" for name in model.springs),
        *(f"body {name!r}" for name in model.bodies),
    ]


def step_columns(model: Model, choice: Choice | None) -> dict[str, float]:
    """The columns of one step; of the start those of none."""
    if choice is None:
        return dict(zip(COLUMNS, (float(Reason.LARGEST), -1.0, 0.0, 0.0, 0.0), strict=True))
    names = names_of(model)
    of = names.index(choice.cut.of) if choice.cut.of in names else -1
    why, tries = float(choice.cut.reason), float(choice.tries)
    told = why, float(of), tries, choice.energy_error, choice.single
    return dict(zip(COLUMNS, told, strict=True))


def single_warnings(history: dict[str, FloatArray]) -> list[str]:
    """Says that single points swing faster than steps follow, if any do."""
    single = history.get(SINGLE, np.zeros(1))
    if not single.any():
        return []
    at = int(np.argmax(single))
    time, step = history["time"][at], history["time"][at] - history["time"][at - 1]
    return [
        f"step: single nodes, or points that share one force, swing faster than steps follow, most "
        f"at t = {time:g} (ω h = {single[at]:.2g}): what one of them does, and how what stands on "
        "them rocks, is stable there and not right to phase; sums and ways of whole bodies are. "
        f"A time.largest of {step * FOLLOWED / single[at]:.2g} follows them"
    ]


def steps_summary(model: Model, history: dict[str, FloatArray]) -> dict[str, Any]:
    """Of steps that choose themselves: each reason, how often it had the last word, by whom.

    Keys: `least` step and `when`, `tries` worked out, `let_pass` steps with an energy
    balance error that shorter ones would not reduce, its sum `energy_error`, and `reasons`, a list
    with the most frequent first: `number` (as columns have it), `reason`, `of`, `told`, `steps`,
    `time`. Empty of other steps.
    """
    if REASON not in history or len(history["time"]) < 2:
        return {}
    lengths, names = np.diff(history["time"]), names_of(model)
    reasons, of, tries, error = (history[name][1:] for name in (REASON, OF, TRIES, ENERGY_ERROR))
    found = []
    for reason, who in sorted({*zip(reasons.tolist(), of.tolist(), strict=True)}):
        own = (reasons == reason) & (of == who)
        cut = Cut(0.0, Reason(int(reason)), names[int(who)] if who >= 0 else "")
        found.append(
            {
                "number": [int(reason), int(who)],
                "reason": cut.reason.name.lower(),
                "of": cut.of,
                "told": cut.said(),
                "steps": int(own.sum()),
                "time": float(lengths[own].sum()),
            }
        )
    least = int(np.argmin(lengths))
    return {
        "least": float(lengths[least]),
        "when": float(history["time"][least + 1]),
        "tries": int(tries.sum()),
        "let_pass": int(np.count_nonzero(error)),
        "energy_error": float(error.sum()),
        "reasons": sorted(found, key=lambda one: -one["steps"]),
    }
