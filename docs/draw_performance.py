"""Table and pictures of the page on performance: ``python docs/draw_performance.py [bench.json]``.

The file is what `python -m benchmarks` writes; the page's table is replaced by that of the file.
The picture of whole runs is of runs.json beside it, as `python -m benchmarks runs` writes it. What
has no file stays as it is.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

INK, PALE, SKY = "#22303c", "#d8dee4", "#2c6fbb"
DOCS = Path(__file__).parent
TABLE = re.compile(r"(<!-- table -->\n).*?(<!-- end of the table -->)", re.DOTALL)

Found = dict[str, Any]


def table_of(found: Found) -> str:
    """Markdown of all goals."""
    lines = ["| work | measured | goal | | behind it |", "|---|---:|---|---|---|"]
    for row in found["rows"]:
        unit = f" {row['unit']}" if row["unit"] else ""
        value = "–" if row["value"] is None else f"{number(row['value'])}{unit}"
        goal = f"{'≥' if row['at_least'] else '≤'} {row['goal']:g}{unit}"
        result = {True: "reached", False: "**missed**", None: "–"}[row["passed"]]
        lines.append(f"| {row['work']} | {value} | {goal} | {result} | {row['note']} |")
    return "\n".join(lines) + "\n"


def number(value: float) -> str:
    """Three digits."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def over(ax: Axes, times: dict[str, float], label: str) -> None:
    """Nanoseconds a point over a count."""
    counts = np.array([float(n) for n in times])
    ax.plot(counts, list(times.values()), "o-", color=SKY, markersize=5)
    ax.set(xlabel=label, ylim=(0.0, 1.25 * max(times.values())))
    if counts.max() / counts.min() > 10.0:
        ax.set_xscale("log")
    else:
        ax.set_xticks(counts)
    ax.grid(color=PALE, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)


def scaling(found: Found) -> plt.Figure:
    """Cost of a tracked point over the counts of points, faces and threads."""
    rows = found["rows"]
    wanted = (("10⁷ points", "points"), ("faces over", "faces"), ("2 threads", "threads"))
    figure, axes = plt.subplots(1, 3, figsize=(9.6, 3.0), constrained_layout=True)
    for ax, (part, label) in zip(axes, wanted, strict=True):
        row = next(row for row in rows if part in row["work"])
        if row["value"] is not None:
            over(ax, row["detail"]["nanoseconds"], label)
    axes[0].set_ylabel("ns a tracked point")
    return figure


def roofline(found: Found) -> plt.Figure:
    """What a core can do at an intensity, and where the tracked point is."""
    limits = found["limits"]
    work = next(row for row in found["rows"] if "tracked, shuffled" in row["work"])["detail"]
    intensity = np.geomspace(0.05, 200.0, 200)
    figure, ax = plt.subplots(figsize=(6.4, 3.6), constrained_layout=True)
    for name, style, above in (("fused", "-", 1.1), ("apart", "--", 0.7)):
        top = np.minimum(limits["gigabytes"] * intensity, limits[name])
        ax.plot(intensity, top, style, color=INK, linewidth=1.4)
        ax.text(200.0, above * limits[name], name, ha="right", fontsize=8, color=INK)
    operations = work["cost"]["operations"]
    here, reached = operations / work["cost"]["bytes"], operations / work["processor"]
    ax.plot(here, reached, "o", color=SKY, markersize=7)
    label = f"tracked point\n{reached:.1f} of {limits['fused']:.0f}"
    ax.annotate(label, (here, reached), (1.5 * here, 0.6 * reached), fontsize=9, color=SKY)
    ax.set(xscale="log", yscale="log", xlabel="operations a byte", ylabel="10⁹ operations a second")
    ax.grid(color=PALE, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)
    return figure


def whole_runs(found: Found) -> plt.Figure:
    """Shares of the rooms in a step of each run, with its time and what it is of its kernels'."""
    runs, rooms = found["runs"][::-1], found["rooms"]
    figure, ax = plt.subplots(figsize=(9.6, 0.9 + 0.26 * len(runs)), constrained_layout=True)
    colours = plt.get_cmap("tab20c")(np.array([4, 0, 1, 8, 12, 13, 16, 18]))
    left = np.zeros(len(runs))
    names = [run["name"] for run in runs]
    for room, colour in zip(rooms, colours, strict=True):
        share = np.array([100.0 * run["rooms"][room] / run["whole"] for run in runs])
        ax.barh(names, share, left=left, color=colour, label=room, height=0.72)
        left += share
    for k, run in enumerate(runs):
        said = f"{number(run['whole'] / 1e3)} ms, {number(run['ratio'])} ×"
        ax.text(101.5, k, said, va="center", fontsize=8, color=INK)
    ax.set(xlim=(0.0, 122.0), xlabel="% of a step, its processor time, and that over its kernels'")
    ax.set_xticks(range(0, 101, 20))
    ax.tick_params(labelsize=8)
    ax.margins(y=0.01)
    ax.legend(ncols=len(rooms), fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0, 1))
    ax.spines[["top", "right"]].set_visible(False)
    return figure


PICTURES = {"performance_scaling": scaling, "performance_roofline": roofline}


def main(path: Path) -> None:
    """Write the pictures, and the table into the page."""
    runs = path.with_name("runs.json")
    if path.is_file():
        found = json.loads(path.read_text(encoding="utf-8"))
        page = DOCS / "performance.md"
        text = page.read_text(encoding="utf-8")
        page.write_text(TABLE.sub(lambda m: m[1] + table_of(found) + m[2], text), encoding="utf-8")
        for name, draw in PICTURES.items():
            _save(name, draw(found))
    if runs.is_file():
        _save("performance_runs", whole_runs(json.loads(runs.read_text(encoding="utf-8"))))


def _save(name: str, figure: plt.Figure) -> None:
    figure.savefig(DOCS / "images" / f"{name}.png", dpi=130)
    plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS.parent / "out" / "bench.json")
