"""Control points of a ball over time, for `gallery/breathing.toml`, written for NumPy.

    python make_breath.py breath.npz

It swells by a quarter in 4 ms, and becomes flat where it shrinks. Lengths in mm, times in ms.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import contiga as cg

RADIUS, END, ROWS, SWELLS, FLAT = 30.0, 8.0, 33, 0.25, 0.5


def shapes_of(times: np.ndarray) -> np.ndarray:
    """(k, m, 3) control points at times."""
    rest = cg.Body([cg.shapes.sphere(radius=RADIUS)]).net.points
    breath = 0.5 * (1.0 - np.cos(2.0 * np.pi * times / END))
    late = np.clip(2.0 * times / END - 1.0, 0.0, 1.0)
    wide = 1.0 + SWELLS * breath
    high = wide * (1.0 - FLAT * late**2 * (3.0 - 2.0 * late))
    return rest * np.stack([wide, wide, high], axis=1)[:, None]


def main(target: Path) -> None:
    """Write the table."""
    target.parent.mkdir(parents=True, exist_ok=True)
    times = np.linspace(0.0, END, ROWS)
    np.savez_compressed(target, times=times, control_points=shapes_of(times))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
