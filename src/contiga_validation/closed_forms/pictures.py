"""Pictures of the cases: measurements on the curve of the formula."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import LINES, MUTED

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Drawing = Callable[["Figure"], None]
Curve = tuple[str, FloatArray, FloatArray]
"""Label, abscissae and values."""
_N_DOTS = 40


def comparison(
    axes_names: tuple[str, str], exact: Sequence[Curve], measured: Sequence[Curve]
) -> Drawing:
    """Return a drawing of formulas as lines and of runs as dots (`fill`)."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        fill(axes, axes_names, exact, measured)

    return draw


def fill(
    axes: Axes, names: tuple[str, str], exact: Sequence[Curve], measured: Sequence[Curve]
) -> None:
    """Draw formulas as lines and runs as dots into axes, with labels of x and y and a legend.

    Of a run about 40 dots are drawn, or all of fewer than 80 rows.
    """
    for k, (label, x, y) in enumerate(exact):
        axes.plot(x, y, color=LINES[k % len(LINES)], lw=1.3, label=label)
    for k, (label, x, y) in enumerate(measured):
        stride = max(1, len(x) // _N_DOTS)
        axes.plot(
            x[::stride], y[::stride], "o", ms=3.4, mfc="white", mew=1.0,
            color=LINES[k % len(LINES)], label=label,
        )  # fmt: skip
    axes.set(xlabel=names[0], ylabel=names[1])
    axes.axhline(0.0, color=MUTED, lw=0.5)
    if exact or measured:
        axes.legend()


def errors_over(axes_names: tuple[str, str], curves: Sequence[Curve]) -> Drawing:
    """Return a drawing of errors as lines; `axes_names` are the labels of x and y."""

    def draw(figure: Figure) -> None:
        axes = figure.subplots()
        for k, (label, x, y) in enumerate(curves):
            axes.plot(x, y, color=LINES[k % len(LINES)], lw=0.9, label=label)
        axes.set(xlabel=axes_names[0], ylabel=axes_names[1])
        axes.legend()

    return draw
