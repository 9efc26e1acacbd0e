"""A quarter of a rubber block under a punch read from STEP, by FElupe and its Newton method."""

import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import felupe as fem
import numpy as np
import scipy.sparse as sp
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common as Common
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder as MakeCylinder
from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere as MakeSphere
from OCP.gp import gp_Pnt

import contiga as cg
from contiga_validation.rivals.headform import write_step

BALL, SHANK, SIDE, SHEAR, BULK = 100.0, 20.0, 500.0, 1.0, 50.0


class LoadStep(NamedTuple):
    state: cg.State  # of the quarter
    residuals: list[float]  # relative, after each iteration


class RigidContact:
    """An item of FElupe, which keeps the state of a load step once its iterations converge."""

    def __init__(self, contact: cg.Contact, field: fem.FieldContainer) -> None:
        self.contact, self.field, self.pose = contact, field, np.eye(4)
        self.assemble = fem.mechanics.Assemble(self._vector, self._matrix, multiplier=-1.0)
        self.results = fem.mechanics.Results()
        self.results.statevars = contact.start(contact.slave.points)

    def update(self, depth: float) -> None:
        self.pose = cg.motion.pose.translation([0.0, 0.0, -depth])

    def _vector(self, field: fem.FieldContainer, **_: Any) -> sp.csr_matrix:
        x = self.contact.slave.points + field[0].values
        self.results._statevars = self.contact.step(self.results.statevars, x, self.pose)
        return sp.csr_matrix(self.results._statevars.force.reshape(-1, 1))

    def _matrix(self, **_: Any) -> sp.csr_matrix:
        return sp.csr_matrix(self.contact.tangent(self.results._statevars))


def punch() -> cg.Body:
    """Make it with OpenCASCADE, write it as STEP and read that."""
    ball, shank = MakeSphere(gp_Pnt(0.0, 0.0, BALL), BALL), MakeCylinder(SHANK, BALL)
    with tempfile.TemporaryDirectory() as folder:
        write_step(Common(ball.Shape(), shank.Shape()).Shape(), Path(folder) / "punch.step")
        return cg.read_cad(Path(folder) / "punch.step")


def solve(K: sp.csr_matrix, residual: np.ndarray) -> np.ndarray:
    """Solve a symmetric system, whose factors fill in less."""
    how = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
    return sp.linalg.splu(K.tocsc(), "MMD_AT_PLUS_A", **how).solve(residual)


def press(n: int, depths: list[float]) -> list[LoadStep]:
    """Press the punch into n by n by n elements, which grow away from the contact."""
    mesh = fem.Cube(a=(0.0, 0.0, -1.0), b=(1.0, 1.0, 0.0), n=n + 1)
    mesh.update(points=SIDE * np.sinh(6.0 * mesh.points) / np.sinh(6.0))
    field = fem.FieldContainer([fem.Field(fem.RegionHexahedron(mesh), dim=3)])
    boundaries = fem.dof.symmetry(field[0], axes=(True, True, False))
    boundaries["bottom"] = fem.Boundary(field[0], fz=-SIDE, skip=(1, 1, 0))
    rubber = fem.SolidBodyNearlyIncompressible(fem.NeoHooke(mu=SHEAR), field, bulk=BULK)
    top = fem.RegionHexahedronBoundary(mesh, mask=mesh.z == 0.0).mesh.cells_faces
    slave = cg.Slave(mesh.points, top, elements={"hexahedron": mesh.cells})
    item = RigidContact(cg.Contact(punch(), slave, law=cg.PenaltyLaw(30.0, per_area=True)), field)
    step = fem.Step([rubber, item], ramp={item: depths}, boundaries=boundaries)
    found = step.generate(x0=field, solver=solve, verbose=False)
    return [LoadStep(item.results.statevars, each.fnorms) for each in found]


if __name__ == "__main__":
    for state, residuals in press(12, [0.25 * k for k in range(1, 9)]):
        print(f"{-4.0 * state.total_force[2]:.3f} N,", *(f"{size:.0e}" for size in residuals))
