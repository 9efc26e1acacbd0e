"""Describe in one line what set the lengths of the steps of a run."""

from __future__ import annotations

from typing import Any

MAX_REASONS = 3
"""Number of reasons that the line names, the most frequent ones."""


def steps_line(summary: dict[str, Any]) -> str:
    """Return the line for a summary's `step_reasons`; empty for steps of a given length.

    It names the first three reasons with their shares of the steps, which are the most frequent.

    >>> reason = {"told": "a body turns (body 'wheel')", "steps": 30}
    >>> steps_line({"least": 0.01, "when": 2.0, "tries": 60, "reasons": [reason], "let_pass": 0})
    "steps set by: a body turns (body 'wheel') 100 %; the shortest 0.01 at t = 2; 2 attempts a step"
    """
    if not summary:
        return ""
    count = sum(reason["steps"] for reason in summary["reasons"])
    shares = [
        f"{reason['told']} {100.0 * reason['steps'] / count:.0f} %"
        for reason in summary["reasons"][:MAX_REASONS]
    ]
    line = f"steps set by: {', '.join(shares)}; the shortest {summary['least']:.3g} at t = "
    line += f"{summary['when']:.4g}"
    attempts = f"{summary['tries'] / count:.2g}"
    if attempts != "1":
        line += f"; {attempts} attempts a step"
    if summary["let_pass"]:
        line += f"; {summary['let_pass']} have an energy balance error that shorter ones would not"
        line += " reduce"
    return line
