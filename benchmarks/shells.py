"""Internal forces of 10⁴ elements of a Kirchhoff-Love shell, beside Kratos' IGA shell.

`python -m benchmarks shells`. Both answer the forces on the same control points of one patch of
degree 2, nine Gauss points an element, on one thread, and agree. Kratos is not an extra of
contiga: `pip install KratosMultiphysics KratosIgaApplication KratosStructuralMechanicsApplication`.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from time import process_time
from typing import Any

import numpy as np

import contiga as cg
from benchmarks.timing import in_turns, on_threads
from contiga.matter.iga import Shell, assemble_shell

SIDE, ROUNDS = 100, 5
YOUNG, POISSON, THICKNESS = 3.0, 0.3, 0.1
SAME = 1e-11
"""Share of the largest force by which those of Kratos may differ."""
MATERIALS = {
    "elastic": cg.materials.Elastic(young=YOUNG, poisson=POISSON),
    "neo-Hooke, three layers": cg.materials.NeoHooke(young=YOUNG, poisson=POISSON),
}


def run(side: int = SIDE) -> list[str]:
    """The lines of the table."""
    cuts = np.arange(1, side) / side
    patch = cg.shapes.plane(width=2.0, length=1.0).k_refined((1, 1), cuts, cuts)
    shells = {
        name: assemble_shell([patch], material=material, density=1.0, thickness=THICKNESS)
        for name, material in MATERIALS.items()
    }
    q = shells["elastic"].nodes
    q = q + 0.02 * np.sin(5.0 * q[:, [1, 2, 0]])
    works = {name: asked(shell, q) for name, shell in shells.items()}
    n = 9 * side * side
    lines = []
    rival = kratos(patch, shells["elastic"], q)
    with on_threads(1):
        times = in_turns(works, ROUNDS, process_time)
        for name in works:
            lines.append(f"{name:26s} {n} Gauss points, {1e9 * times[name] / n:6.1f} ns each")
        if isinstance(rival, str):
            return [*lines, f"beside Kratos: not measured: {rival}"]
        both = {"ours": works["elastic"], "theirs": rival}
        found = in_turns(both, ROUNDS, process_time)
    return [
        *lines,
        f"Kratos' Shell3pElement takes {found['theirs'] / found['ours']:.0f} times as long, "
        f"{1e9 * found['theirs'] / n:.0f} ns each, for the same forces",
    ]


def asked(shell: Shell, q: np.ndarray) -> Callable[[int], Any]:
    """A work that asks for the forces."""
    state, v = shell.start(), np.zeros_like(q)
    return lambda _: shell.forces(state, q, v, 0.0)


def kratos(patch: cg.NurbsSurface, shell: Shell, q: np.ndarray) -> Callable[[int], Any] | str:
    """A work that asks Kratos for the same forces (m, 3); why not, where it cannot be asked."""
    try:
        KM = import_module("KratosMultiphysics")
        import_module("KratosMultiphysics.IgaApplication")
        mechanics = import_module("KratosMultiphysics.StructuralMechanicsApplication")
    except ImportError as error:
        return str(error)
    KM.Logger.GetDefaultOutput().SetSeverity(KM.Logger.Severity.WARNING)
    KM.ParallelUtilities.SetNumThreads(1)
    model = KM.Model()
    part = model.CreateModelPart("shell")
    for variable in (KM.DISPLACEMENT, KM.REACTION, KM.VOLUME_ACCELERATION):
        part.AddNodalSolutionStepVariable(variable)
    properties = part.GetProperties()[1]
    properties.SetValue(KM.THICKNESS, THICKNESS)
    properties.SetValue(KM.YOUNG_MODULUS, YOUNG)
    properties.SetValue(KM.POISSON_RATIO, POISSON)
    properties.SetValue(KM.DENSITY, 1.0)
    properties.SetValue(KM.CONSTITUTIVE_LAW, mechanics.LinearElasticPlaneStress2DLaw())
    # Its first parameter runs first, and its knots are without the first and the last.
    order = shell.net.control[0].T.ravel()
    nodes = KM.NodesVector()
    for k, place in enumerate(shell.nodes[order].tolist(), 1):
        nodes.append(part.CreateNewNode(k, *place))
    knots = [KM.Vector(each[1:-1].tolist()) for each in patch.knots]
    surface = KM.NurbsSurfaceGeometry3D(nodes, *patch.degrees, *knots)
    points = KM.GeometriesVector()
    surface.CreateQuadraturePointGeometries(points, 3)
    ways = (
        (KM.DISPLACEMENT_X, KM.REACTION_X),
        (KM.DISPLACEMENT_Y, KM.REACTION_Y),
        (KM.DISPLACEMENT_Z, KM.REACTION_Z),
    )
    for way, reaction in ways:
        KM.VariableUtils().AddDof(way, reaction, part)
    for k in range(len(points)):
        part.CreateNewElement("Shell3pElement", k + 1, points[k], properties)
    for element in part.Elements:
        element.Initialize(part.ProcessInfo)
    for node, place, moved in zip(part.Nodes, shell.nodes[order], q[order], strict=True):
        node.SetSolutionStepValue(KM.DISPLACEMENT, KM.Array3((moved - place).tolist()))
        node.X, node.Y, node.Z = moved.tolist()
    scheme = KM.ResidualBasedIncrementalUpdateStaticScheme()
    solver = KM.ResidualBasedBlockBuilderAndSolver(KM.SkylineLUFactorizationSolver())
    solver.SetUpDofSet(scheme, part)
    solver.SetUpSystem(part)
    residual = KM.Vector(q.size, 0.0)
    rows = [[node.GetDof(way).EquationId for way, _ in ways] for node in part.Nodes]

    def residual_of(_: int) -> Any:
        solver.BuildRHS(scheme, part, residual)
        return model, residual  # the model lives as long as what asks it

    force = np.empty(q.shape)
    force[order] = np.array(residual_of(0)[1])[np.array(rows)]
    expected = shell.forces(shell.start(), q, np.zeros_like(q), 0.0).force
    off = np.abs(force - expected).max() / np.abs(expected).max()
    if off > SAME:
        raise RuntimeError(f"Kratos has other forces: {off:.0e} of the largest")
    return residual_of
