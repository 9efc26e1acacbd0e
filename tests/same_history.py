"""`python -m tests.same_history A B`: whether two runs' histories agree to the last bit.

All columns but the seconds they took. Ends with 1 if they differ.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

CLOCK = "wall_time"


def columns(folder: str) -> dict[str, list[str]]:
    """Of the history in an output folder, as text: digits enough for each bit."""
    with (Path(folder) / "history.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    named = zip(*rows, strict=True)
    return {name: values for name, *values in named if not name.startswith(CLOCK)}


def main(arguments: list[str]) -> int:
    """Compare them."""
    one, other = (columns(folder) for folder in arguments)
    apart = [name for name in one.keys() | other.keys() if one.get(name) != other.get(name)]
    for name in sorted(apart):
        print(f"{name} differs", file=sys.stderr)
    return 1 if apart or not one else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
