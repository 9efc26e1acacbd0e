"""What starting costs: the import, and a second run of the demo with its kernels cached."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
DEMO = ROOT / "examples" / "01_headform.toml"
PART = ROOT / "examples" / "generated" / "headform.step"
RUNS = 7


def _seconds(*command: str) -> float:
    start = perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return perf_counter() - start


def import_cost() -> float:
    """Seconds `import contiga` takes more than `import numpy, numba`: median of pairs in turn."""
    base = [sys.executable, "-c", "import numpy, numba"]
    ours = [sys.executable, "-c", "import numpy, numba, contiga"]
    _seconds(*ours)
    return median(_seconds(*ours) - _seconds(*base) for _ in range(RUNS))


def demo() -> tuple[float, float, float]:
    """Seconds of the first and second start of the demo, and what the second lost to compiling."""
    with tempfile.TemporaryDirectory() as folder:
        times = []
        for k in range(2):
            out = Path(folder) / f"run{k}"
            command = [sys.executable, "-m", "contiga", "run", str(DEMO), "-o", str(out)]
            times.append(_seconds(*command, "--quiet"))
        summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    return times[0], times[1], float(summary["timings"]["compile"])


def run() -> list[str]:
    """The lines of the table."""
    lines = [f"import contiga: {import_cost():+.3f} s on top of numpy and numba"]
    if not PART.is_file():
        return [*lines, "contiga run on the demo: make demo generates its part first"]
    first, second, compiling = demo()
    lines.append(
        f"contiga run on the demo: {first:.1f} s, then {second:.1f} s "
        f"({compiling:.2f} s of it compiling)"
    )
    return lines
