"""Run the headform into foam by a characteristic and by elements, and write the page that compares.

``python docs/draw_foam.py`` takes a few minutes.
"""

from __future__ import annotations

import runpy
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import contiga as cg
from contiga.report import style

ROOT = Path(__file__).resolve().parents[1]
PAGE, PICTURE = ROOT / "docs" / "foam.md", ROOT / "docs" / "images" / "foam_beside.png"
SOFT = 0.5
"""Modulus in tension of foam that hardly pulls, MPa; that of the example is its first slope."""
KEY = "slave.pad.motion.material.tension"
CASES: dict[str, tuple[str, dict[str, float]]] = {
    "characteristic": ("01_headform.toml", {}),
    "elements": ("06_headform_foam.toml", {}),
    "elements, weak in tension": ("06_headform_foam.toml", {KEY: SOFT}),
}
LOW = 0.01
"""Of the peak force: what is less is no blow."""
GRAVITY = 9.80665e-3
"""mm/ms²."""
TEXT = """# Foam as a characteristic, and as elements

*Made by `docs/draw_foam.py`, which runs the cases.*

A characteristic is foam made of columns side by side: each node of the face has a stress by its
own depth over the thickness, and the next one knows nothing of it. Elements of
[foam](elements.md) are pulled along by their neighbours, have mass, and yield to the side. All
cases have the same headform, the same pad of 60 mm and the same curve in compression; where foam
unloads they are only alike. [`01_headform.toml`](../examples/01_headform.toml) has the
characteristic, [`06_headform_foam.toml`](../examples/06_headform_foam.toml) 1,440 hexahedra. In
tension these follow the first slope of the curve, 7.5 MPa; the third column is the same with
{soft} MPa, foam that hardly pulls.

![force over time and over depth, by all three](images/foam_beside.png)

| | {names} |
|---|---|---|---|
{rows}

In brackets, how far the characteristic is off: its value against that of the elements.

- Foam beside the head carries, too, as it is pulled along and sheared. Columns leave that out: they
  are too soft, the head goes too deep, and peak, acceleration and HIC come out too low, on the
  unsafe side.
- How much depends on what a uniaxial curve in compression does not say, the tension and the shear
  of the foam; but most of the error is there with hardly any tension, too.
- A flat punch as wide as the pad has no such error: there is nothing beside it.
- It costs a fraction: {cheap:,} steps against {dear:,}.

A characteristic that was measured with an impactor like the one in the case has the share of the
neighbours in it already. One from a uniaxial test of the material has not: then take elements, or
measure anew. None of the three is a test: real foam tears at the rim of the dent and hardens with
the rate, which all leave out here.
"""


class Blow(NamedTuple):
    """What a run gives of the blow."""

    time: np.ndarray
    force: np.ndarray
    depth: np.ndarray
    """Way of the head since it touched."""
    rows: dict[str, tuple[float, str]]
    """Numbers by what they are, with units."""
    steps: int


def blow(case: str, settings: dict[str, float]) -> Blow:
    """Run a case and read off what the page tells."""
    with tempfile.TemporaryDirectory() as folder:
        made = cg.load_case(ROOT / "examples" / case, set=settings)
        result = cg.run(made, out=Path(folder))
    history, said = result.history, result.summary["sensors"]["head_cg"]["criteria"]
    time, force, speed = history["time"], history["force"], history["headform.vx"]
    depth = history["headform.x"] - history["headform.x"][np.argmax(history["n_contact"] > 0)]
    struck = np.flatnonzero(force > LOW * force.max())
    rows = {
        "peak force": (float(force.max()), "N"),
        "peak acceleration, CFC1000": (float(history["head_cg.filtered_a"].max()) / GRAVITY, "g"),
        **{name: (float(one["value"]), one.get("unit", "")) for name, one in said.items()},
        "way of the head into the pad": (float(depth.max()), "mm"),
        "force above 1 % of its peak": (float(np.ptp(time[struck[[0, -1]]])), "ms"),
        "speed at the end, back": (float(-speed[-1]), "mm/ms"),
    }
    return Blow(time, force, depth, rows, int(result.summary["steps"]))


def draw(blows: dict[str, Blow]) -> None:
    """Force over time and over depth."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.4, 3.2), layout="constrained")
    over_time, over_depth = figure.subplots(1, 2, sharey=True)
    for (name, one), colour in zip(blows.items(), style.LINES, strict=False):
        over_time.plot(one.time, 1e-3 * one.force, color=colour, lw=2.0)
        over_depth.plot(one.depth, 1e-3 * one.force, color=colour, lw=2.0, label=name)
    over_time.set(xlabel="time [ms]", ylabel="force [kN]")
    over_depth.set(xlabel="way into the pad [mm]")
    over_depth.set_xlim(left=0.0)
    over_depth.legend(frameon=False, loc="upper left")
    for axes in (over_time, over_depth):
        axes.grid(color=style.GRID)
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(PICTURE, dpi=110)


def page(blows: dict[str, Blow]) -> str:
    """The page with its numbers."""
    first, *others = blows.values()
    rows = []
    for label, (value, unit) in first.rows.items():
        cells = [f"{style.number(value)} {unit}".strip()]
        for one in others:
            exact = one.rows[label][0]
            shown = f"{style.number(exact)} {unit}".strip()
            cells.append(f"{shown} ({100.0 * (value / exact - 1.0):+.0f} %)")
        rows.append(f"| {label} | {' | '.join(cells)} |")
    return TEXT.format(
        names=" | ".join(blows),
        rows="\n".join(rows),
        soft=SOFT,
        cheap=first.steps,
        dear=others[0].steps,
    )


def main() -> None:
    """Run, draw, write."""
    make: Any = runpy.run_path(str(ROOT / "docs" / "draw_gallery.py"))["_make_files"]
    for case, _ in CASES.values():
        make(ROOT / "examples" / case)
    blows = {name: blow(*given) for name, given in CASES.items()}
    draw(blows)
    PAGE.write_text(page(blows), encoding="utf-8")


if __name__ == "__main__":
    main()
