"""Section 5.4.2: the force and the stress model over the penetration, with three kinds of area."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from contiga import AreaInput, AreaMethod, Areas, Contact, ForceLaw, HullArea, NodalArea, StressLaw
from contiga.errors import ContigaError
from contiga_validation.engine.arrays import FloatArray
from contiga_validation.engine.drawing import INK, LINES, MUTED
from contiga_validation.engine.experiment import Cell, Claim, Experiments, Outcome, Picture, Table
from contiga_validation.thesis.chapter5_area import STEPS, THESIS, TRUE
from contiga_validation.thesis.play import SceneRun, run_simulation
from contiga_validation.thesis.variants import simulation_of, slave_of, variant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

EXPERIMENTS = Experiments()

COEFFICIENT = 0.5
NODAL = 0.1
OWN = "thesis' own"
DAMPING, THICKNESS = 0.2, 0.1
MODULUS = 0.5
"""Elastic modulus of the stress model; the thesis names none, its force model's is taken."""
STIFFER = 3.0
"""Modulus of the master over that of the slave, where both deform."""


@dataclass(frozen=True)
class SharedArea:
    """Area method with given total areas, shared equally by the points in contact.

    Parameters
    ----------
    of_count : the area by the number of points in contact
    """

    of_count: dict[int, float]

    def measure(self, inp: AreaInput) -> Areas:
        """Return an equal share of the total area for each point, all in cluster 0.

        An unknown number of points raises a KeyError.
        """
        n = len(inp.rows)
        share = self.of_count[n] / n if n else 0.0
        return Areas(np.full(n, share), np.zeros(n, np.int32), "master")


def kinds() -> dict[str, AreaMethod]:
    """Return the area methods of Fig. 5.25 and 5.27 by name, with the thesis' own areas last."""
    true = {20: TRUE[0], 40: TRUE[-1], 60: 0.4, 80: 0.4, 100: 0.4}
    thesis = {20: THESIS[0], 40: THESIS[-1], 60: 0.394, 80: 0.394, 100: 0.394}
    return {
        "analytic": SharedArea(true),
        "approximated": HullArea(1),
        "constant 0.1": NodalArea(NODAL),
        OWN: SharedArea(thesis),
    }


class Forces(NamedTuple):
    """The cylinder's run with every kind of area, by its name."""

    runs: dict[str, SceneRun]

    def nodal(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces (n,) of points in contact at steps 6 to 14, in a row."""
        states = [self.runs[name].states[k] for k in STEPS]
        depth = [state.penetration[state.in_contact] for state in states]
        force = [np.linalg.norm(state.force[state.in_contact], axis=1) for state in states]
        return np.concatenate(depth), np.concatenate(force)

    def total(self, name: str) -> FloatArray:
        """Return the total force (9,) at steps 6 to 14."""
        return self.runs[name].history["force"][STEPS.start : STEPS.stop]

    def depth(self) -> FloatArray:
        """Return the largest penetration (9,) at steps 6 to 14."""
        run = self.runs["analytic"]
        return run.history["max_penetration"][STEPS.start : STEPS.stop]


def forces(law: ForceLaw | StressLaw) -> Forces:
    """Run the cylinder through the flat master by one law, with each of `kinds`."""
    simulation = simulation_of("cylinder_flat")
    runs = {
        name: run_simulation(variant(simulation, law=law, area=area))
        for name, area in kinds().items()
    }
    return Forces(runs)


# ---------------------------------------------------------------- force model, Fig. 5.24 to 5.26


@EXPERIMENTS.add(
    "5.4-force",
    "Contact model force",
    "5.4.2, Fig. 5.24 to 5.26, Eq. 3.1 to 3.3",
    "With the elastic coefficient 0.5 the total force is linear in the largest penetration; "
    "nodal forces by the approximated area are within O(1e-12) of those by the analytic one.",
)
def _force_model() -> Outcome:
    model = forces(ForceLaw(COEFFICIENT, share="penetration"))
    depth = model.depth()
    totals = {name: model.total(name) for name in model.runs}
    rows = [
        (k, float(depth[i]), *(float(totals[name][i]) for name in model.runs))
        for i, k in enumerate(STEPS)
    ]
    return Outcome(
        tables=(
            Table(
                "5.24",
                "Force model, coefficient 0.5: total force by kind of area.",
                ("step", "largest penetration", *(f"F, {name}" for name in model.runs)),
                tuple(rows),
            ),
        ),
        pictures=(
            Picture("5.24", "F over the largest penetration.", lambda f: _draw_total(f, model),
                    (4.8, 3.2)),
            Picture("5.25", _CAPTION_NODAL, lambda f: _draw_nodal(f, model), (7.8, 3.0)),
            Picture("5.26", _CAPTION_DELTA, lambda f: _draw_delta(f, model), (5.6, 3.2)),
        ),
        claims=_force_model_claims(depth, model, totals),
        difference=(
            "Eq. 3.3 divides by the sum of penetration times area: an area that is the same at "
            "all points drops out. So the difference of 1e-12 says nothing about the area, and the "
            "constant area of MADYMO gives the same nodal forces too; the thesis shows others for "
            "it, and calls its own far more accurate. What the area does is seen in the stress "
            "model."
        ),
    )  # fmt: skip


def _force_model_claims(
    depth: FloatArray, model: Forces, totals: dict[str, FloatArray]
) -> tuple[Claim, ...]:
    line = max(float(np.abs(total - COEFFICIENT * depth).max()) for total in totals.values())
    reference = model.nodal("analytic")[1]
    differences = {n: float(np.abs(model.nodal(n)[1] - reference).max()) for n in model.runs}
    return (
        Claim(
            "The total force is linear in the largest penetration, whatever the area.",
            line < 1e-14,
            f"farthest from 0.5 λ_max: {line:.1e}",
        ),
        Claim(
            "Approximated area: nodal forces within O(1e-12) of those by the analytic area.",
            differences["approximated"] < 1e-12,
            f"largest difference {differences['approximated']:.1e}",
        ),
        Claim(
            "A constant nodal area gives the same forces in this model (against the thesis).",
            differences["constant 0.1"] < 1e-12,
            f"largest difference {differences['constant 0.1']:.1e}; with the thesis' own areas "
            f"{differences[OWN]:.1e}",
        ),
    )


_CAPTION_NODAL = (
    "F_i over the penetration of the point, one colour a step: analytic, approximated and constant "
    "area."
)
_CAPTION_DELTA = "Difference of the nodal forces by approximated and by analytic area."


def _draw_total(figure: Figure, model: Forces) -> None:
    axes = figure.subplots()
    depth = model.depth()
    axes.plot([0.0, depth.max()], [0.0, COEFFICIENT * depth.max()], color=MUTED, lw=0.9)
    looks = (("o", LINES[0], 7.0), ("s", LINES[1], 4.0), ("+", INK, 9.0))
    for (marker, colour, size), name in zip(looks, model.runs, strict=False):
        axes.plot(depth, model.total(name), marker, color=colour, ms=size, label=name)
    axes.set(xlabel="largest penetration", ylabel="F")
    axes.legend()


def _draw_nodal(figure: Figure, model: Forces, *, constant_axis: bool = False) -> None:
    names = ("analytic", "approximated", "constant 0.1")
    plots = figure.subplots(1, 3, sharey=not constant_axis, sharex=True)
    for axes, name in zip(plots, names, strict=True):
        _draw_steps(axes, model.runs[name])
        axes.set(title=name, xlabel="penetration")
    if constant_axis:
        top = max(float(model.nodal(name)[1].max()) for name in names[:2])
        for axes in plots[:2]:
            axes.set_ylim(0.0, 1.05 * top)
    plots[0].set_ylabel("$F_i$")
    handles, steps = plots[0].get_legend_handles_labels()
    figure.legend(handles, steps, title="step", loc="outside right upper", handletextpad=0.2)


def _draw_steps(axes: Axes, run: SceneRun) -> None:
    for i, k in enumerate(STEPS):
        state, on = run.states[k], run.states[k].in_contact
        depth, force = state.penetration[on], np.linalg.norm(state.force[on], axis=1)
        shade = step_colour(i / (len(STEPS) - 1))
        axes.plot(depth, force, "o", color=shade, ms=3.2, label=f"{k}")


def step_colour(share: float) -> tuple[float, float, float]:
    """Return a colour from dark blue (0) over green to orange (1), distinct in grey, too."""
    stops = np.array(
        [[0.13, 0.22, 0.45], [0.16, 0.50, 0.55], [0.52, 0.72, 0.38], [0.93, 0.64, 0.2]]
    )
    at = share * (len(stops) - 1)
    low = min(int(at), len(stops) - 2)
    red, green, blue = stops[low] + (at - low) * (stops[low + 1] - stops[low])
    return float(red), float(green), float(blue)


def _draw_delta(figure: Figure, model: Forces) -> None:
    axes = figure.subplots()
    depth, force = model.nodal("approximated")
    difference = force - model.nodal("analytic")[1]
    axes.plot(depth, difference, "o", color=LINES[0], ms=3.2)
    axes.set(xlabel="penetration", ylabel="$\\Delta F_i$")
    axes.axhline(0.0, color=MUTED, lw=0.8)
    axes.set_ylim(-1e-12, 1e-12)
    axes.set_title(f"largest {np.abs(difference).max():.1g}; the axis ends at the thesis' O(1e-12)")


# ---------------------------------------------------------------- stress model, Fig. 5.27


@EXPERIMENTS.add(
    "5.4-stress",
    "Contact model stress",
    "5.4.2, Fig. 5.27, Eq. 3.4",
    "With C_d = 0.2 and t = 0.1 the approximated area gives the pattern of the analytic one, "
    "the constant nodal area of 0.1 does not.",
)
def _stress_model() -> Outcome:
    damped = forces(StressLaw(MODULUS, THICKNESS, damping=DAMPING))
    plain = forces(StressLaw(MODULUS, THICKNESS))
    share = damped.total("analytic")[1] / plain.total("analytic")[1]
    return Outcome(
        tables=_stress_model_tables(damped, plain),
        pictures=(
            Picture(
                "5.27",
                "Stress model with C_d = 0.2 and t = 0.1: F_i over the penetration. The third "
                "plot has an axis of its own.",
                lambda f: _draw_nodal(f, damped, constant_axis=True),
                (7.4, 3.0),
            ),
            Picture(
                "5.27-elastic",
                "The same without damping: one line for each area shared by the points.",
                lambda f: _draw_nodal(f, plain, constant_axis=True),
                (7.4, 3.0),
            ),
        ),
        claims=_stress_model_claims(plain),
        difference=(
            "Section 3.2.2 leaves the damping term out, section 5.4.2 has C_d = 0.2: both are "
            f"shown. Damping counts here: at step 7, where the cylinder has moved by 0.28 in one "
            f"step, it makes the force {share:.1f} times as large, and where the cylinder comes "
            "back it would pull, which contact does not. The thesis names no elastic curve; "
            "0.5 is taken from its force model."
        ),
    )


def _stress_model_claims(plain: Forces) -> tuple[Claim, ...]:
    true, approximated = plain.total("analytic"), plain.total("approximated")
    deep = np.arange(len(true)) > 0
    deviation = float(np.abs(approximated[deep] / true[deep] - 1.0).max())
    constant_ratio = plain.total("constant 0.1")[deep] / true[deep]
    theirs = plain.total(OWN)[deep] / true[deep] - 1.0
    return (
        Claim(
            "With the approximated area the stress model gives the analytic area's force.",
            deviation < 1e-6,
            f"largest relative difference {deviation:.1e}; with the thesis' own areas "
            f"{100 * np.abs(theirs).max():.1f} %",
        ),
        Claim(
            "The constant nodal area does not.",
            bool((constant_ratio > 10.0).all()),
            f"{constant_ratio.min():.1f} to {constant_ratio.max():.1f} times the force",
        ),
    )


def _stress_model_tables(damped: Forces, plain: Forces) -> tuple[Table, ...]:
    names = tuple(damped.runs)
    rows: list[tuple[Cell, ...]] = [
        (label, k, float(run.depth()[i]), *(float(run.total(name)[i]) for name in names))
        for label, run in (("C_d = 0.2", damped), ("C_d = 0", plain))
        for i, k in enumerate(STEPS)
    ]
    return (
        Table(
            "5.27",
            "Stress model, t = 0.1, with the damping of the thesis' example and without.",
            ("damping", "step", "largest penetration", *(f"F, {name}" for name in names)),
            tuple(rows),
        ),
    )


# ---------------------------------------------------------------- contact types, 3.2


class TypeRow(NamedTuple):
    """One contact type on the cylinder at step 10."""

    name: str
    area: float
    force: float


def contact_types() -> tuple[list[TypeRow], str]:
    """Return area and force by contact type at step 10, and the error of the force model.

    That is its message about the type "combined"; empty if it is accepted.
    """
    simulation = simulation_of("cylinder_flat")
    law, own = StressLaw(MODULUS, THICKNESS), StressLaw(STIFFER * MODULUS, 2.0 * THICKNESS)
    rows = []
    for name, options in (
        ("slave", {"law": law}),
        ("master", {"law": own}),
        ("combined", {"law": law, "master_law": own}),
    ):
        run = run_simulation(variant(simulation, contact_type=name, **options))
        state = run.states[10]
        rows.append(TypeRow(name, state.total_area, float(np.linalg.norm(state.total_force))))
    (part,) = simulation.contacts
    try:
        Contact(
            part.contact.master,
            slave_of(simulation),
            law=ForceLaw(COEFFICIENT, share="penetration"),
            area=HullArea(1),
            weights="area",
            contact_type="combined",
            master_law=own,
        )
    except ContigaError as error:
        return rows, str(error)
    return rows, ""


@EXPERIMENTS.add(
    "3.2-types",
    "Contact types slave, master and combined",
    "3.2, Fig. 3.3",
    "Three contact types: the slave deforms, the master does, or both. The force model does "
    "not work with the third.",
)
def _types() -> Outcome:
    rows, refusal = contact_types()
    force = {row.name: row.force for row in rows}
    return Outcome(
        tables=(
            Table(
                "3.2",
                "The three contact types of the stress model, step 10.",
                ("type", "area", "F"),
                tuple((row.name, row.area, row.force) for row in rows),
            ),
        ),
        claims=_types_claims(force, refusal),
        difference=(
            "The thesis runs type slave only. The master here is twice as thick and three times as "
            "stiff as the slave, so that each type has a force of its own formula."
        ),
    )


def _types_claims(force: dict[str, float], refusal: str) -> tuple[Claim, ...]:
    # Two linear layers in series: λ splits so that both stresses agree.
    soft, hard = MODULUS / THICKNESS, STIFFER * MODULUS / (2.0 * THICKNESS)
    series = hard / (soft + hard)
    miss = abs(force["combined"] / force["slave"] - series)
    return (
        Claim(
            "Combined splits the penetration so that both sides have one stress.",
            miss < 1e-12,
            f"{force['combined'] / force['slave']:.12f} of the slave's force, two layers in "
            f"series {series:.12f}",
        ),
        Claim(
            "The force model does not work with type combined.",
            bool(refusal),
            refusal.splitlines()[0] if refusal else "it was accepted",
        ),
    )
