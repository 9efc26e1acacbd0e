"""The strip of what set each step."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from tests.figures import checked

from contiga.report.run_folder import Run, units_of
from contiga.report.steps import steps_figure, steps_section

TIMES = np.array([0.0, 1.0, 2.0, 4.0, 5.0, 6.0])
REASONS = {
    "least": 1.0, "when": 1.0, "tries": 9, "let_pass": 2, "energy_error": 0.1,
    "reasons": [
        {"number": [4, 0], "told": "swings (contact 'a<b')", "steps": 3, "time": 4.0},
        {"number": [11, -1], "told": "energy", "steps": 2, "time": 2.0},
    ],
}  # fmt: skip
COLUMNS = {
    "reason": np.array([0.0, 4, 4, 11, 11, 4]),
    "of": np.array([-1.0, 0, 0, -1, -1, 0]),
}


def run(told: dict, steps: dict) -> Run:
    units = units_of({"length": "mm", "mass": "g", "time": "ms"})
    return Run(
        Path(), {"step_reasons": told}, TIMES, {}, "", units, {}, {}, {}, {}, {}, True, steps
    )


def test_a_lane_has_the_time_of_the_steps_that_its_reason_set() -> None:
    swing, energy = checked(steps_figure(run(REASONS, COLUMNS), REASONS, 2.0)).data
    np.testing.assert_array_equal(swing.x, [0.0, 2.0, np.nan, 5.0, 6.0, np.nan])
    np.testing.assert_array_equal(energy.x, [2.0, 5.0, np.nan])
    assert swing.y[0] > energy.y[0]


def test_the_section_tells_and_escapes_and_is_not_there_for_given_steps() -> None:
    text = steps_section(run(REASONS, COLUMNS), None)
    assert "swings (contact &#x27;a&lt;b&#x27;)</td>" in text
    assert "2 have an energy balance error" in text
    assert steps_section(run({}, {}), None) == ""
