"""Force noise: a torus turns about its own axis against a cloud at rest."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga import Body, Master, clouds
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import INK, LINES
from contiga_validation.engine.experiment import Claim, Outcome, Picture, Table
from contiga_validation.rivals.comparison import DEPTH, NURBS, bodies
from contiga_validation.rivals.rival_meshes import SAMPLES, rival_meshes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

POINTS = 400
STRIP = 2.0
"""Width of the strip of points, degrees about the axis."""
DEGREES = 45.0
FINEST = 4
"""Meshes of the test: 1e-2 to 1e-5."""
MAX_TRIANGLES = 1_000_000


class Noise(NamedTuple):
    """Force while a torus turns about its own axis against a cloud at rest."""

    angles: FloatArray
    """Radians."""
    force: dict[str, FloatArray]
    """Sum of penetrations, by master."""
    triangles: dict[str, int]

    def spread(self, name: str) -> float:
        """Return the range of the force over its mean."""
        force = self.force[name]
        return float(np.ptp(force) / force.mean())


def noise(points: int = POINTS, turns: int = 361, finest: int = FINEST) -> Noise:
    """Return the force (stiffness 1) of a fixed cloud on a turning torus, for the torus and meshes.

    It is constant on the exact torus. There are `turns` angles from 0 to `DEGREES`, and meshes of
    the first `finest` errors.
    """
    body = bodies()["torus"]
    cloud, on = _cloud(body, points)
    angles = np.linspace(0.0, np.deg2rad(DEGREES), turns)
    masters: dict[str, Master] = {NURBS: body}
    triangles = {}
    for _, rival in zip(range(finest), rival_meshes(body, on, MAX_TRIANGLES), strict=False):
        if rival.mesh is not None:
            masters[f"mesh {rival.target:.0e}"] = rival.mesh
            triangles[f"mesh {rival.target:.0e}"] = rival.triangles
    force = {name: np.array([_force(m, cloud, a) for a in angles]) for name, m in masters.items()}
    return Noise(angles, force, triangles)


def _cloud(body: Body, points: int) -> tuple[FloatArray, FloatArray]:
    """Return points under a narrow strip of the torus, and points all over it.

    The force on a strip as narrow as a facet changes with each edge that passes.
    """
    share = STRIP / 360.0
    on = clouds.random_on(body.patches[0], int(points / share), seed=3)
    strip = on[np.abs(np.arctan2(on[:, 1], on[:, 0])) < np.deg2rad(0.5 * STRIP)]
    feet = body.project(strip)
    depth = DEPTH * body.size * np.random.default_rng(7).random((len(strip), 1))
    return feet.point - depth * feet.normal, on[:: max(1, len(on) // SAMPLES)]


def _force(master: Master, cloud: FloatArray, angle: float) -> float:
    """Return the sum of penetrations with the master turned by an angle, radians."""
    c, s = np.cos(angle), np.sin(angle)
    rotated = np.column_stack(
        [c * cloud[:, 0] + s * cloud[:, 1], c * cloud[:, 1] - s * cloud[:, 0], cloud[:, 2]]
    )
    return float(np.maximum(-master.project(rotated).gap, 0.0).sum())


def turning() -> Outcome:
    """Run the experiment and return its outcome."""
    result = noise()
    spread = {name: result.spread(name) for name in result.force}
    rows = tuple((name, result.triangles.get(name), value) for name, value in spread.items())
    return Outcome(
        tables=(
            Table(
                "8.2",
                f"Force noise while a torus turns by {DEGREES:g} degrees, in {len(result.angles)} "
                "places.",
                ("master", "triangles", "(largest − least force) / mean"),
                rows,
            ),
        ),
        pictures=(Picture("8.2", _CAPTION, lambda f: _draw(f, result), (6.8, 4.2)),),
        claims=(
            Claim(
                "The exact master's force is constant to 1e-9 while the torus turns.",
                spread[NURBS] < 1e-9,
                f"{spread[NURBS]:.1e} of the force",
            ),
            Claim(
                "Every mesh is noisier, and a finer one less so.",
                list(spread.values())[1:] == sorted(spread.values(), reverse=True)[:-1],
                ", ".join(f"{name}: {value:.1e}" for name, value in spread.items()),
            ),
        ),
        difference=(
            "Not in the thesis. A facet's middle lies deeper than its edges: each that comes by "
            "makes a tooth of a saw. Finer meshes have smaller teeth, and more of them."
        ),
    )


_CAPTION = (
    "A torus turns about its own axis against a cloud at rest: change of the force over its mean. "
    "Exactly nothing changes; the facets of a mesh make a saw-tooth. Below, the size of the change "
    "on a logarithmic scale."
)


def _draw(figure: Figure, result: Noise) -> None:
    top, bottom = figure.subplots(2, 1, sharex=True)
    degrees = np.rad2deg(result.angles)
    for colour, (name, force) in zip((INK, *LINES), result.force.items(), strict=False):
        change = force / force.mean() - 1.0
        above = 2 if name == NURBS else 1
        if name in (NURBS, "mesh 1e-02", "mesh 1e-03"):
            top.plot(degrees, 1e3 * change, color=colour, lw=1.2, zorder=above)
        size = np.maximum(np.abs(change), 1e-17)
        bottom.semilogy(degrees, size, color=colour, lw=0.9, label=name)
    top.set_ylabel("change of force, 1e-3")
    bottom.set(xlabel="angle, degrees", ylabel="size of the change", ylim=(1e-17, 1.0))
    figure.legend(ncols=6, loc="outside upper center", fontsize=7.5, columnspacing=1.2)
