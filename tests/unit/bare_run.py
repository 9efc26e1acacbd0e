"""What works without any optional package, as one program: run with and without them."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

import contiga as cg

AREAS = {
    "constant": cg.NodalArea(0.01),
    "facets": cg.FacetArea(),
    "cloud": cg.CloudArea(),
    "feet": cg.CloudArea(by="feet"),
    "hull": cg.HullArea("auto"),
    "exact hull": cg.HullArea("auto", mapping="exact"),
}
LAWS = {
    "force": cg.ForceLaw([[0.0, 0.0], [1.0, 5.0]]),
    "stress": cg.StressLaw([[0.0, 0.0], [1.0, 3.0]], damping=0.2),
    "penalty": cg.PenaltyLaw(10.0, per_area=True),
    "adaptive": cg.AdaptiveLaw(),
}
DECK = "*KEYWORD\n*NODE\n{}*ELEMENT_SHELL\n{:8d}{:8d}{:8d}{:8d}{:8d}{:8d}\n*END\n"
PATCH = """<xml><Geometry type="TensorBSpline2" id="0">
<Basis type="TensorBSplineBasis2">
<Basis type="BSplineBasis" index="0"><KnotVector degree="1">0 0 1 1</KnotVector></Basis>
<Basis type="BSplineBasis" index="1"><KnotVector degree="1">0 0 1 1</KnotVector></Basis>
</Basis><coefs geoDim="3">0 0 0 2 0 0 0 3 0 2 3 0</coefs></Geometry></xml>
"""


def results() -> dict[str, Any]:
    """Numbers of every part, by name; plain lists."""
    with tempfile.TemporaryDirectory() as folder:
        return {**_searches(), **_contacts(), **_simulation(), **_files(Path(folder))}


def _sheet() -> cg.Slave:
    n = 9
    points = cg.clouds.sample(cg.shapes.plane(width=2.0, length=2.0), n, n)
    index = np.arange(n * n).reshape(n, n)
    corners = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    facets = np.stack([c.ravel() for c in corners], axis=1)
    each = np.ones(n * n)
    return cg.Slave(points, facets, thickness=0.5 * each, mass=1e-3 * each, name="sheet")


def _ball() -> cg.Body:
    return cg.Body([cg.shapes.sphere(radius=0.5, centre=(0.0, 0.0, 0.55))], name="ball")


def _searches() -> dict[str, Any]:
    ball = _ball()
    points = np.array([[0.0, 0.0, 2.0], [0.3, 0.2, 0.4]])
    mesh = ball.tessellate(1e-2)
    return {
        "gaps": ball.project(points).gap.tolist(),
        "hit": ball.first_hit(points, points[:, [1, 0, 2]] - [0.0, 0.0, 1.7]).fraction.tolist(),
        "mesh": mesh.project(points).gap.tolist(),
    }


def _contacts() -> dict[str, Any]:
    ball, sheet = _ball(), _sheet()
    pressed = cg.motion.pose.translation([0.0, 0.0, -0.2])
    values: dict[str, Any] = {}

    def press(name: str, **options: Any) -> None:
        contact = cg.Contact(ball, sheet, **options)
        state = contact.step(contact.start(sheet.points), sheet.points, pose=pressed, dt=0.1)
        values[name] = [*state.total_force.tolist(), state.total_area, state.energy.stored]

    for name, area in AREAS.items():
        press(name, law=LAWS["stress"], area=area)
    for name, law in LAWS.items():
        press(name, law=law)
        press(f"{name} on the master", law=law, contact_type="master")
    both = cg.StressLaw(2.0, thickness=0.1), cg.StressLaw(3.0, thickness=0.2)
    press("combined", law=both[0], master_law=both[1], contact_type="combined")
    return values


def dipping() -> cg.Simulation:
    """A ball that dips into a sheet in three steps."""
    ball, sheet = _ball(), _sheet()
    dip = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -0.2]])
    contact = cg.Contact(ball, sheet, law=LAWS["stress"])
    return cg.Simulation(
        bodies={"ball": (ball, dip)},
        slaves={"sheet": sheet},
        contacts={"dip": contact},
        times=np.linspace(0.0, 1.0, 4),
    )


def _simulation() -> dict[str, Any]:
    return {"run": dipping().run().history["force"].tolist()}


def _files(folder: Path) -> dict[str, Any]:
    corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    nodes = "".join(
        f"{k + 1:8d}{x:16.6f}{y:16.6f}{0.0:16.6f}\n" for k, (x, y) in enumerate(corners)
    )
    (folder / "deck.k").write_text(DECK.format(nodes, 1, 1, 1, 2, 3, 4))
    (folder / "cloud.csv").write_text("0,0,0\n1,2,3\n")
    (folder / "patch.xml").write_text(PATCH)
    return {
        "deck": cg.read_mesh(folder / "deck.k", unit="mm", file_unit="m").points.tolist(),
        "cloud": cg.read_mesh(folder / "cloud.csv").points.tolist(),
        "patch": cg.read_cad(folder / "patch.xml").project([[1.0, 1.0, 0.5]]).gap.tolist(),
    }
