"""What a run leaves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contiga.display import Facts
from contiga.records import FloatArray
from contiga.simulation.history_over_time import HistoryOverTime
from contiga.simulation.system_state import SystemState


@dataclass(frozen=True, eq=False, repr=False)
class Result(HistoryOverTime):
    """The results of a run: history, states, summary."""

    history: dict[str, FloatArray]
    """Columns by name, one row a step."""
    out: Path | None
    """Output folder, None where nothing was written."""
    state: SystemState
    """At the end."""
    states: tuple[SystemState, ...]
    """Those that were to be kept, in the order of time."""
    summary: dict[str, Any]
    """Counts, timings, statuses: the content of summary.json."""

    def _facts(self) -> Facts:
        return [
            ("steps", len(self.history["time"])),
            ("end", float(self.state.time)),
            ("in contact", self.state.n_contact),
            ("warnings", len(self.summary["warnings"])),
            ("states kept", len(self.states)),
            ("folder", self.out or "none"),
        ]
