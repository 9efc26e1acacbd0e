"""What a part of the stress counts, and the line it prints."""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

# Reproducers kept of each kind of fault.
KEPT = 5


@dataclass
class Tally:
    """Counts of one part on one body."""

    what: str
    count: int = 0
    wrong: int = 0
    """Wrong and not flagged."""
    flagged: int = 0
    """Rows whose status says that they were not solved, or what had to be mended."""
    doubtful: int = 0
    """Rows within rounding of the surface: not judged."""
    seconds: float = 0.0
    notes: dict[str, Any] = field(default_factory=dict)
    faults: list[dict[str, Any]] = field(default_factory=list)

    def fault(self, kind: str, rows: np.ndarray, **values: np.ndarray) -> None:
        """Count the rows that are wrong in one way and keep the first few to be reproduced."""
        self.wrong += len(rows)
        if len(rows):
            self.notes[kind] = self.notes.get(kind, 0) + len(rows)
        known = sum(fault["kind"] == kind for fault in self.faults)
        for row in rows[: max(KEPT - known, 0)]:
            kept = {name: np.asarray(value[row]).tolist() for name, value in values.items()}
            self.faults.append({"kind": kind, **kept})

    def note(self, name: str, value: int) -> None:
        """Add to a count that is told but not judged."""
        if value:
            self.notes[name] = self.notes.get(name, 0) + value

    def add(self, other: Tally) -> None:
        """Take the counts of another tally in."""
        for name in ("count", "wrong", "flagged", "doubtful", "seconds"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        for name, value in other.notes.items():
            self.notes[name] = self.notes.get(name, 0) + value
        self.faults += other.faults[:KEPT]

    def line(self) -> str:
        """One line for a person."""
        notes = ", ".join(f"{name} {value:,}" for name, value in self.notes.items())
        return (
            f"{self.what}: {self.count:,}, wrong and unflagged {self.wrong:,}, "
            f"flagged {self.flagged:,}, in doubt {self.doubtful:,}, {self.seconds:.1f} s"
            + (f" ({notes})" if notes else "")
        )


class Clock:
    """Adds the time of a with-block to a tally."""

    def __init__(self, tally: Tally) -> None:
        self.tally = tally

    def __enter__(self) -> Tally:
        self.begun = time.perf_counter()
        return self.tally

    def __exit__(self, *_: object) -> None:
        self.tally.seconds += time.perf_counter() - self.begun


def write(tallies: list[Tally], path: Path) -> None:
    """All tallies as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps([asdict(tally) for tally in tallies], indent=1) + "\n")
