"""Run all checks of a model before its run."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from contiga.simulation.checks.coarse_checks import check_coarse
from contiga.simulation.checks.depth_checks import check_depth
from contiga.simulation.checks.facing import check_facing
from contiga.simulation.checks.finding import Finding
from contiga.simulation.checks.gas_checks import check_gas
from contiga.simulation.checks.joint_checks import check_joints
from contiga.simulation.checks.law_checks import check_laws
from contiga.simulation.checks.layout_checks import check_pairs, check_parts, check_times
from contiga.simulation.checks.mass_checks import check_masses
from contiga.simulation.checks.material_checks import check_materials
from contiga.simulation.checks.matter_checks import check_matter
from contiga.simulation.checks.mesh_checks import check_meshes
from contiga.simulation.checks.motion_checks import check_motion
from contiga.simulation.checks.scene import Scene
from contiga.simulation.checks.size_checks import check_places, check_sizes
from contiga.simulation.checks.surface_checks import check_surfaces
from contiga.simulation.model import Model
from contiga.simulation.step import place

_CHECKS: tuple[Callable[[Scene], Iterator[Finding]], ...] = (
    check_parts,
    check_times,
    check_pairs,
    check_surfaces,
    check_sizes,
    check_places,
    check_motion,
    check_facing,
    check_depth,
    check_coarse,
    check_laws,
    check_masses,
    check_joints,
    check_matter,
    check_materials,
    check_meshes,
    check_gas,
)


def check_model(model: Model) -> tuple[Finding, ...]:
    """Return findings about `model`: properties that its author most likely did not intend.

    The search alone follows the motion in a few steps, as far as it is known: to the end if it is
    prescribed, to the first touch if bodies are free. Those of the model's files come first; each
    finding is returned once.

    Raises
    ------
    InputError
        A motion with a wrong result at the start, an impossible velocity or place of a point.
    """
    # Motions with wrong output raise here as in the first step.
    place(model, None, model.stepping.start)
    scene = Scene(model)
    findings = (finding for check in _CHECKS for finding in check(scene))
    return tuple(dict.fromkeys([*model.findings, *findings]))
