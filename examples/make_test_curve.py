"""The curve of a test for `15_test_curve.toml`, as csv: there was no test.

    python make_test_curve.py test_curve.csv

The case itself is run with a finer mesh; its acceleration and force get noise, and its clock starts
earlier. Depth is the way of the headform.
"""

from __future__ import annotations

import runpy
import sys
import tempfile
from pathlib import Path

import numpy as np

import contiga as cg

HERE = Path(__file__).parent
COUNTS = (15, 15, 9)
"""Hexahedra of the finer mesh along its axes."""
ROWS = 200
EARLIER = 3.0
"""The clock of the test against that of the run, ms."""
NOISE = 0.015
"""Standard deviation, as a share of the largest value."""
SEED = 18571


def finer_run() -> dict[str, np.ndarray]:
    """Columns (n,) of the history of the case with a finer mesh."""
    with tempfile.TemporaryDirectory() as folder:
        mesh = Path(folder) / "finer.vtu"
        runpy.run_path(str(HERE / "make_foam_block.py"))["write_block"](mesh, COUNTS)
        change = {"slave.block.points.file": str(mesh), "reference": []}
        return cg.run(cg.load_case(HERE / "15_test_curve.toml", set=change)).history


def test_curve(history: dict[str, np.ndarray]) -> np.ndarray:
    """Rows (ROWS, 4) of time, acceleration, depth and force, in ms, g, mm and kN."""
    times = np.linspace(history["time"][0], history["time"][-1], ROWS)
    noise = np.random.default_rng(SEED).normal(0.0, NOISE, (2, ROWS))

    def at(column: str) -> np.ndarray:
        return np.interp(times, history["time"], history[column])

    acceleration = at("head_cg.filtered_a") * 1e3 / 9.80665
    depth, force = at("head_cg.z")[0] - at("head_cg.z"), at("force") * 1e-3
    acceleration += noise[0] * acceleration.max()
    force += noise[1] * force.max()
    return np.column_stack([times + EARLIER, acceleration, depth, force])


def main(target: Path) -> None:
    """Write the file."""
    rows = test_curve(finer_run())
    target.parent.mkdir(parents=True, exist_ok=True)
    head = "time [ms], acceleration [g], depth [mm], force [kN]"
    np.savetxt(target, rows, "%.4f", ", ", header=head, comments="")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "test_curve.csv"))
