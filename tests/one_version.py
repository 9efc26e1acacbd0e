"""`python -m tests.one_version [FOLDER]`: which kernels were compiled in more than one version.

Each version costs time at the first run. Asked after the demo and before the tests, whose scenes
need some that no run does. Ends with 1 if there is any.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from contiga.jit.folder import kernel_folder

ALLOWED = frozenset(
    {"element_nb.bicubic", "newton_nb.polynomial_at", "newton_nb.weight_at", "rows_nb.put"}
)
"""Kernels, as "module.name", that may have several: a few lines each, put into kernels that read
the coefficients of a record, and into others that read those of lanes; rows of any length."""


def more_than_one(folder: Path) -> dict[str, int]:
    """Kernels kept under `folder` in several versions, and in how many."""
    kept = Counter(file.name.rsplit(".", 2)[0] for file in folder.rglob("*.nbc"))  # of one stamp
    several = {name.partition("-")[0]: n for name, n in sorted(kept.items()) if n > 1}
    return {name: n for name, n in several.items() if name not in ALLOWED}


def main(arguments: list[str]) -> int:
    """Print them."""
    folder = Path(arguments[0]) if arguments else kernel_folder()
    if folder is None or not any(folder.rglob("*.nbc")):
        print(f"no kernel is kept under {folder}: run the demo first", file=sys.stderr)
        return 1
    result = more_than_one(folder)
    for name, n in result.items():
        print(f"{name}: {n} versions", file=sys.stderr)
    return 1 if result else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
