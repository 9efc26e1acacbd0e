"""The comparison on the page: table, picture and claims."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from contiga.arrays.threads import thread_count
from contiga_validation.engine.drawing import INK, LINES, MUTED
from contiga_validation.engine.experiment import (
    Cell,
    Claim,
    Experiment,
    Options,
    Outcome,
    Picture,
    Table,
)
from contiga_validation.rivals.cad_body import cad_body
from contiga_validation.rivals.comparison import NURBS, POINTS, Row, accuracy, bodies
from contiga_validation.rivals.turning import turning

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAX_TRIANGLES = 1_000_000
"""Largest number of triangles in a reproduction of five minutes."""
TRIANGLE_BYTES = 700
"""Measured peak memory for building the search tables of a mesh, per triangle."""
MEMORY_SHARE = 0.8
"""Largest share of the machine's free memory for the finest mesh."""


def max_triangles(options: Options) -> int:
    """Return the number of triangles of the largest mesh: a million, or what memory allows.

    The free memory counts in a full reproduction only; it is 8 GB if the system does not say.
    """
    if not options.full:
        return MAX_TRIANGLES
    try:
        lines = Path("/proc/meminfo").read_text(encoding="utf-8").splitlines()
        facts = dict(line.split(":") for line in lines)
        free_bytes = 1024.0 * float(facts["MemAvailable"].split()[0])
    except (OSError, KeyError, ValueError):
        free_bytes = 8e9
    return max(MAX_TRIANGLES, int(MEMORY_SHARE * free_bytes / TRIANGLE_BYTES))


def measured(options: Options) -> tuple[list[Row], str]:
    """Measure all masters of the three bodies; return rows, and the source of the third body."""
    named_bodies = bodies()
    part = cad_body(options.cad, options.data)
    named_bodies[part.name] = part.body
    rows = []
    for name, body in named_bodies.items():
        rows += accuracy(name, body, max_triangles(options), POINTS)
    return rows, part.source


def compare(options: Options) -> Outcome:
    """Run the comparison and return it as the outcome of an experiment."""
    rows, source = measured(options)
    hint = "" if options.full else "; contiga reproduce --full builds what memory allows"
    return Outcome(
        tables=(Table("8.1", _TITLE, _HEADS, tuple(_cells(row) for row in rows)),),
        pictures=(Picture("8.1", _CAPTION, lambda f: draw(f, rows), (7.6, 5.4)),),
        claims=claims(rows),
        difference=(
            "The thesis times its exact method against its mesh method, neither of them tuned. "
            "Here both sides track from the last foot, compiled and on all threads, taking turns. "
            f"{source} Each mesh is coarsened until its measured error is the wanted one; how many "
            "triangles the best possible mesh would take stands beside. Meshes of more than "
            f"{max_triangles(options):,} triangles are not built, their numbers are extrapolated"
            f"{hint}. FCPW works in single precision and starts anew each step; it is told how far "
            "the surface can be at most."
        ),
    )


_TITLE = (
    f"A step of up to {POINTS:,} tracked points, {thread_count()} threads, warm. Errors are over "
    "the size of the body; those of the exact side are bounds, from its feet evaluated anew."
)
_HEADS = (
    "body",
    "master",
    "measured Hausdorff error",
    "elements",
    "fewest possible",
    "ns a point",
    "NURBS beside it, ns",
    "FCPW on it, ns",
    "error of the largest penetration",
    "largest error of a penetration",
    "error of the force",
    "MB",
    "built",
)


def _cells(row: Row) -> tuple[Cell, ...]:
    """Return a row of the table; times are nanoseconds a point."""

    def by_point(seconds: float | None) -> float | None:
        return None if seconds is None else 1e9 * seconds / row.points

    exact = None if row.seconds is None or row.master == NURBS else by_point(row.exact_seconds)
    return (
        row.body, row.master, row.error, row.elements,
        None if row.fewest is None else round(row.fewest), by_point(row.seconds), exact,
        by_point(row.peer_seconds), row.depth_error, row.worst_error, row.force_error,
        row.megabytes, "no" if row.seconds is None else "yes",
    )  # fmt: skip


def claims(rows: list[Row]) -> tuple[Claim, ...]:
    """Return the claims on accuracy, and measured times."""
    built = [row for row in rows if row.target and row.seconds is not None]
    return (*_accuracy_claims(rows, built), *_time_claims(built))


def _accuracy_claims(rows: list[Row], built: list[Row]) -> tuple[Claim, ...]:
    """Return the claims on errors."""
    exact = {row.body: row for row in rows if row.master == NURBS}
    worst = max(row.depth_error or 0.0 for row in exact.values())
    accurate = all((row.worst_error or 0) > (exact[row.body].worst_error or 0) for row in built)
    excess = max((row.error or np.nan) / row.target for row in built)
    return (
        Claim(
            "The exact side's largest penetration is right to 1e-10.",
            worst <= 1e-10,
            f"bound {worst:.1e} of the size",
        ),
        Claim("No mesh is as accurate.", accurate, f"{len(built)} meshes"),
        Claim(
            "No mesh is coarser than its error asks for.",
            excess <= 1.25,
            f"the measured error is {excess:.2f} times the wanted one at most",
        ),
    )


def _time_claims(built: list[Row]) -> tuple[Claim, ...]:
    """Return measured times as claims that always hold: times depend on the machine."""
    with_peer = [row for row in built if row.target == 1e-4 and row.peer_seconds is not None]
    fine = [row for row in built if row.target <= 1e-5]
    faster_meshes = [row for row in built if _ratio(row) < 1.0]
    return (
        _measurement(
            "tracking on NURBS against FCPW on a mesh with 1e-4 error",
            [
                f"{row.body}: {(row.peer_seconds or 0.0) / row.exact_seconds:.1f} times as fast"
                for row in with_peer
            ]
            or ["FCPW is not installed (contiga[bench])"],
        ),
        _measurement(
            "against tracking on our own meshes with error 1e-5 and less",
            [f"{row.body}, {row.master}: {_ratio(row):.2f} times as fast" for row in fine],
        ),
        _measurement(
            "where the meshes win",
            [
                f"{row.body}, {row.master}: {1.0 / _ratio(row):.1f} times as fast at an error of "
                f"{row.worst_error:.0e}"
                for row in faster_meshes
            ]
            or ["nowhere"],
        ),
    )


def _measurement(subject: str, texts: Sequence[str]) -> Claim:
    """Return a claim that states a measurement and always holds."""
    return Claim(f"Measured: {subject}.", True, "; ".join(texts))


def _ratio(row: Row) -> float:
    """Return the time of a mesh over the time of the exact master."""
    return (row.seconds or np.nan) / row.exact_seconds


_CAPTION = (
    "Largest error of a point's penetration over the time a tracked point takes (top) and over the "
    "memory of the master (bottom). Each line is one body's meshes from coarse to fine, with their "
    "numbers of triangles; each star is the exact geometry."
)


def draw(figure: Figure, rows: list[Row]) -> None:
    """Draw error over time and over memory, one column of panels for each body."""
    names = list(dict.fromkeys(row.body for row in rows))
    grid = figure.subplots(2, len(names), sharey=True, sharex="row", squeeze=False)
    for k, name in enumerate(names):
        built = [row for row in rows if row.body == name and row.seconds is not None]
        time = [1e9 * (row.seconds or 0.0) / row.points for row in built]
        _panel(grid[0, k], built, time)
        peers = [row for row in built if row.peer_seconds is not None]
        grid[0, k].plot(
            [1e9 * (row.peer_seconds or 0.0) / row.points for row in peers],
            [row.worst_error for row in peers], "s--", color=LINES[2], lw=1.0, ms=3.5,
            label="meshes, FCPW (cold)",
        )  # fmt: skip
        _panel(grid[1, k], built, [row.megabytes for row in built])
        extrapolated = [row for row in rows if row.body == name and row.seconds is None]
        grid[1, k].plot([row.megabytes for row in extrapolated],
                        [row.target for row in extrapolated], "o",
                        color=LINES[0], mfc="none", label="meshes, extrapolated")  # fmt: skip
        grid[0, k].set(title=name, xlabel="ns a point")
        grid[1, k].set(xlabel="MB")
    for axes in grid[:, 0]:
        axes.set_ylabel("penetration error / size")
    entries = {}
    for axes in grid[:, 0]:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries[label] = handle
    figure.legend(entries.values(), entries.keys(), ncols=4, loc="outside upper center")


def _panel(axes: Axes, rows: list[Row], x: list[float]) -> None:
    """Draw errors over `x`; the first row is the exact master, a star, and meshes are a line."""
    from matplotlib.ticker import LogLocator, NullFormatter

    error = [row.worst_error or 0.0 for row in rows]
    axes.loglog(x[1:], error[1:], "o-", color=LINES[0], label="meshes, contiga (tracked)")
    for row, at, miss in zip(rows[1:], x[1:], error[1:], strict=True):
        count = row.elements
        unit, size = ("M", 1e6) if count >= 1e6 else ("k", 1e3)
        digits = 0 if count >= 10 * size else 1
        label = f"{count / size:.{digits}f}{unit}" if count >= size else str(count)
        axes.annotate(label, (at, miss), (5, 3), fontsize=6.5,
                      textcoords="offset points", color=MUTED)  # fmt: skip
    axes.loglog(x[0], max(error[0], 1e-17), "*", color=LINES[1], ms=12, label="NURBS, contiga")
    axes.axvline(x[0], color=LINES[1], lw=0.6, ls=":")
    axes.margins(x=0.2, y=0.12)
    axes.tick_params(which="both", labelcolor=INK)
    for axis, n_ticks in ((axes.xaxis, 6), (axes.yaxis, 7)):
        axis.set_major_locator(LogLocator(numticks=n_ticks))
        axis.set_minor_formatter(NullFormatter())


def experiments(options: Options) -> tuple[Experiment, ...]:
    """Return the experiments beyond the thesis; they run when their `run` is called."""
    return (
        Experiment(
            "8-accuracy", "Accuracy against time", "beyond chapter 6",
            lambda: compare(options),
            "The thesis claims 50 to 60 % of the time saved at equal accuracy.",
        ),
        Experiment(
            "8-noise", "Force noise of a turning body", "beyond chapter 6", turning,
            "The thesis does not look at it.",
        ),
    )  # fmt: skip
