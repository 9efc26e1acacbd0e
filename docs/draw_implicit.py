"""Draw the pictures of the page on implicit codes: ``python docs/draw_implicit.py [NAME …]``.

Runs the examples, in two minutes, prints the numbers of the page, and needs felupe, scikit-fem
and jax.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

import contiga as cg
from contiga.report import style

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
IMAGES = Path(__file__).parent / "images"
GOOD = style.REGIONS[0]


def pair() -> tuple[Figure, Axes, Axes]:
    """Two axes side by side."""
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    left, right = figure.subplots(1, 2)
    for ax in (left, right):
        ax.spines[["top", "right"]].set_visible(False)
    return figure, left, right


def converging(ax: Axes, runs: list[list[float]], label: str, first: int = 0) -> None:
    """Residuals of load steps over their iterations, from the `first`."""
    for residuals in runs:
        ax.semilogy(
            first + np.arange(len(residuals)),
            residuals,
            "o-",
            color=GOOD,
            alpha=0.35,
            ms=3.5,
            lw=1.2,
        )
    ax.set(xlabel="iteration", ylabel=label, title="each line is a load step")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))


def iron_membrane() -> Figure:
    """The membrane at the end of pressing and of ironing."""
    from examples import iron_membrane as example

    steps = example.iron()
    figure, left, right = pair()
    left.remove()
    left = figure.add_subplot(1, 2, 1, projection="3d")
    x, y, z = steps[-1].x.T
    sheet = cg.Body([cg.shapes.plane(width=example.WIDTH, length=example.LENGTH)])
    triangles = sheet.tessellate(1.0, size=6.0).triangles
    left.plot_trisurf(
        x, y, z, triangles=triangles, cmap=style.colour_map(), lw=0.1, edgecolor=style.MUTED
    )
    angle, along = np.meshgrid(np.linspace(-1.6, 1.6, 25), np.linspace(y.min(), y.max(), 2))
    axis = example.RADIUS + 0.5 * example.THICK - 10.0
    across = 20.0 + example.RADIUS * np.sin(angle), axis - example.RADIUS * np.cos(angle)
    left.plot_wireframe(across[0], along, across[1], color=style.INK, lw=0.7, rcount=2, ccount=25)
    left.set(xlabel="x [mm]", title="pressed 10 mm, ironed 20 mm")
    left.set_box_aspect((np.ptp(x), np.ptp(y), 30.0), zoom=1.1)
    left.set_yticks([])
    left.set_zticks([])
    left.view_init(25.0, -62.0)
    converging(right, [step.residuals for step in steps], "largest residual [N]")
    counts = [len(step.residuals) - 1 for step in steps]
    print(f"membrane: iterations {np.mean(counts):.1f} on average, at most {max(counts)}")
    return figure


def press_shell() -> Figure:
    """The arch of splines under the roller, and its force, with all residuals."""
    from examples import press_shell as example

    shell, steps = example.press()
    drawn = shell.drawn(3)
    figure, left, right = pair()
    left.remove()
    left = figure.add_subplot(1, 2, 1, projection="3d")
    x, y, z = drawn.points(steps[-1].q).T
    left.plot_trisurf(
        x, y, z, triangles=drawn.facets, cmap=style.colour_map(), lw=0.1, edgecolor=style.MUTED
    )
    left.set(title=f"pressed 6 mm: {steps[-1].force:.1f} N")
    left.set_box_aspect((np.ptp(x), np.ptp(y), np.ptp(z)), zoom=1.1)
    left.set_yticks([])
    left.set_zticks([])
    left.view_init(20.0, -70.0)
    converging(right, [step.residuals for step in steps], "largest residual [N]")
    counts = [len(step.residuals) - 1 for step in steps]
    top = max(step.force for step in steps)
    print(f"shell: iterations {np.mean(counts):.1f} on average, at most {max(counts)}; {top:.3f} N")
    return figure


def hertz_scikit_fem() -> Figure:
    """Pressure of three meshes beside Hertz's, and the errors."""
    from examples import hertz_scikit_fem as example

    figure, left, right = pair()
    r = np.linspace(0.0, example.RADIUS, 200)
    top = 1.5 * example.FORCE / (np.pi * example.RADIUS**2)
    left.plot(r, top * np.sqrt(1.0 - (r / example.RADIUS) ** 2), color=style.INK, label="Hertz")
    sizes, errors = (32, 64, 128), []
    for n, colour in zip(sizes, style.LINES, strict=False):
        state, residuals = example.press(n)
        at, force = state.points_B[:, 0], -state.force[:, 2]
        on = (at < 1.3 * example.RADIUS) & (state.points_B[:, 2] > -example.BALL)
        rows = np.flatnonzero(on)[np.argsort(at[on])]
        left.plot(at[rows], state.pressure[rows], "o", ms=3.0, color=colour, label=f"{n} x {n}")
        radius = np.sqrt(2.5 * force @ at**2 / force.sum())
        errors.append([force.sum() / example.FORCE - 1.0, radius / example.RADIUS - 1.0])
        print(f"Hertz, {n}: errors {errors[-1]}, {len(residuals) - 1} iterations", residuals)
    for error, marker, what in zip(abs(np.array(errors)).T, "os", ("force", "radius"), strict=True):
        right.loglog(sizes, 100.0 * error, f"{marker}-", color=GOOD, label=what)
        print(f"order of the {what}: {np.log2(error[:-1] / error[1:])}")
    right.loglog(sizes, [1.5, 0.75, 0.375], "--", color=style.MUTED, lw=1.0, label="order 1")
    left.set(xlabel="r [mm]", ylabel="pressure [N/mm²]")
    right.set(xlabel="elements a side", ylabel="error [%]", xticks=sizes, xticklabels=sizes)
    right.minorticks_off()
    left.legend(frameon=False)
    right.legend(frameon=False)
    return figure


def rubber_felupe() -> Figure:
    """Force over depth of three meshes beside Hertz's, and how the finest converges."""
    from examples import rubber_felupe as example

    figure, left, right = pair()
    young = 9.0 * example.BULK * example.SHEAR / (3.0 * example.BULK + example.SHEAR)
    modulus = young / (1.0 - (0.5 * young / example.SHEAR - 1.0) ** 2)
    depths = 0.25 * np.arange(1, 9)
    hertz = 4.0 / 3.0 * modulus * np.sqrt(example.BALL) * depths**1.5
    left.plot(depths, hertz, color=style.INK, label="Hertz")
    for n, colour in zip((8, 12, 16), style.LINES, strict=False):
        steps = example.press(n, depths.tolist())
        force = np.array([-4.0 * step.state.total_force[2] for step in steps])
        left.plot(depths, force, "o", ms=4.0, color=colour, label=f"{n} x {n} x {n}")
        error = abs(force / hertz - 1.0)
        most = max(len(step.residuals) for step in steps)
        print(f"rubber, {n}: errors {error.mean():.1%}, {error.max():.1%}; {most} iterations")
    left.set(xlabel="depth [mm]", ylabel="force [N]")
    left.legend(frameon=False)
    converging(right, [step.residuals for step in steps], "relative residual", first=1)
    return figure


def throw_jax() -> Figure:
    """The first and the last throw, and the misses."""
    import jax.numpy as jnp
    from examples import throw_jax as example

    figure, left, right = pair()
    tried = example.aim(example.VELOCITY)
    for velocity, colour in ((tried[0], style.LINES[1]), (tried[-1], GOOD)):
        course = np.asarray(example.path(velocity))
        left.plot(course[:, example.MIDDLE, 0], course[:, example.MIDDLE, 2], color=colour, lw=1.2)
        left.plot(course[-1, :, 0], course[-1, :, 2], "o-", color=colour, ms=4.0)
    angle = np.linspace(0.0, 2.0 * np.pi, 100)
    for x in (-0.5, 0.5):
        left.plot(x + 0.25 * np.cos(angle), 0.25 * np.sin(angle), color=style.INK, lw=1.5)
    left.plot(*example.TARGET[[0, 2]], "x", color=style.INK, ms=9.0, mew=2.0)
    left.set(
        xlabel="x [m]", ylabel="z [m]", title="first and last throw, seen along y", aspect="equal"
    )
    misses = [float(jnp.linalg.norm(example.miss(velocity))) for velocity in tried]
    right.semilogy(range(len(misses)), misses, "o-", color=GOOD)
    right.set(xlabel="iteration", ylabel="distance from the target [m]")
    print("throw: misses", misses)
    return figure


PICTURES: dict[str, Callable[[], Figure]] = {
    made.__name__: made
    for made in (iron_membrane, press_shell, hertz_scikit_fem, rubber_felupe, throw_jax)
}


if __name__ == "__main__":
    for name in sys.argv[1:] or PICTURES:
        PICTURES[name]().savefig(IMAGES / f"implicit_{name}.png", dpi=100)
