"""Tracked steps on the simulator of CUDA: a program, as it is asked for before numba comes.

``python simulated.py case.pickle feet.pickle``: tables, feet, where the points were, and where they
go step by step; then the feet of every step, and the rows that the CPU did.
"""

from __future__ import annotations

import pickle
import sys
from pathlib import Path

from contiga.arrays.device import resident
from contiga.search.track import device


def main(given: Path, answered: Path) -> None:
    """Take the steps."""
    answers = []
    for tables, feet, before, steps in pickle.loads(given.read_bytes()):
        tracked = device.start(tables, feet, before)
        for points in steps:
            tracked, rows = device.track(tracked, resident(points) if len(answers) % 2 else points)
            answers.append((device.feet_of(tracked), rows))
    answered.write_bytes(pickle.dumps(answers))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
