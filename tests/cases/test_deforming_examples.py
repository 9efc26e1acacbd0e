"""Examples of slaves that deform: meshes as their scripts say, and the rubber ring as it begins.

What the whole runs come to is on the gallery's page, which test_gallery.py compares.
"""

from __future__ import annotations

import runpy
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import contiga as cg
from contiga.matter import Part, assemble

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def _made(name: str) -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLES / f"make_{name}.py"))


def _mass(points: np.ndarray, cells: np.ndarray) -> float:
    """Of density one; what is inside out is refused."""
    material = cg.materials.NeoHooke(young=1.0, poisson=0.3)
    kind, thickness = ("hex8", None) if cells.shape[1] == 8 else ("tri3", 1.0)
    part = Part(kind=kind, elements=cells, material=material, density=1.0, thickness=thickness)
    return float(assemble(points, [part]).mass.sum())


def test_the_pad_is_as_thick_everywhere_as_the_characteristic_says() -> None:
    made = _made("foam_pad")
    assert _mass(*made["foam_mesh"]()) == pytest.approx(200.0 * 220.0 * 60.0)
    face = _made("pad")["pad_mesh"]()[0]
    own = made["foam_mesh"]()[0]
    front = own[: len(own) // (made["COUNTS"][0] + 1)]
    for axis in range(3):
        assert np.ptp(front[:, axis]) == pytest.approx(np.ptp(face[:, axis]))
    assert front[:, 0].max() == pytest.approx(face[:, 0].max())


def test_the_ring_has_its_section_all_round() -> None:
    made = _made("rubber_ring")
    corners = made["AROUND"]
    share = np.sin(2.0 * np.pi / corners) / (2.0 * np.pi / corners)  # of a polygon
    volume = made["SIDE"] ** 2 * 2.0 * np.pi * made["RADIUS"]
    assert _mass(*made["ring_mesh"]()) == pytest.approx(volume * share, rel=1e-9)


def test_normals_of_the_tyre_point_outward() -> None:
    made = _made("tyre")
    points, triangles = made["tyre_mesh"]()
    a, b, c = (points[triangles[:, k]] for k in range(3))
    normal, middle = np.cross(b - a, c - a), (a + b + c) / 3.0
    away = middle.copy()
    away[:, [0, 2]] *= (1.0 - 240.0 / np.hypot(middle[:, 0], middle[:, 2]))[:, None]
    tread = np.hypot(middle[:, 0], middle[:, 2]) > 245.0
    assert ((normal * away).sum(axis=1)[tread] > 0.0).all()
    assert (normal[~tread, 1] * middle[~tread, 1] > 0.0).all()
    beads = np.abs(points[:, 1]).max()
    assert (np.isclose(np.abs(points[:, 1]), beads)).sum() == 2 * made["AROUND"]


def test_the_airbag_is_closed_with_discs_of_one_size() -> None:
    made = _made("airbag")
    points, triangles = made["airbag_mesh"]()
    assert len(triangles) == 12 * made["RINGS"] ** 2
    sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
    there = {tuple(side) for side in sides.tolist()}
    assert len(there) == len(sides)
    assert all((b, a) in there for a, b in there)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    cone = made["RISE"] * np.pi * made["RADIUS"] ** 2 / 2.0  # under a paraboloid
    assert (a * np.cross(b, c)).sum() / 6.0 == pytest.approx(cone, rel=0.02)
    radius = np.hypot(points[:, 0], points[:, 1])
    assert np.isclose(radius, made["RADIUS"]).sum() == 6 * made["RINGS"]


@pytest.mark.full
def test_the_airbag_fills_with_its_energy_closed(tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    _made("airbag")["write_airbag"](tmp_path / "generated" / "airbag.vtu")
    shutil.copy(EXAMPLES / "10_airbag.toml", tmp_path)
    case = cg.load_case(tmp_path / "10_airbag.toml", set={"time.end": 6.0})
    history = cg.build(case).run().history
    came = history["bag.flow_in"][-1]
    assert history["bag.volume"][-1] > 3.0 * history["bag.volume"][0]
    assert np.abs(history["energy.error"]).max() < 1e-4 * came


@pytest.mark.full
def test_the_ring_takes_the_eye_up_with_its_energy_closed(tmp_path: Path) -> None:
    pytest.importorskip("meshio")
    _made("rubber_ring")["write_ring"](tmp_path / "generated" / "rubber_ring.vtu")
    shutil.copy(EXAMPLES / "09_rubber_ring.toml", tmp_path)
    case = cg.load_case(tmp_path / "09_rubber_ring.toml", set={"time.end": 1.0})
    history = cg.build(case).run().history
    eye = _mass_of_eye() * (history["lower eye.vz"][-1] + 8.0)
    force, time = history["below.force_z"], history["time"]
    pull = -np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(time))  # on the eye
    weight = -9.81e-3 * _mass_of_eye() * time[-1]
    assert eye == pytest.approx(pull + weight, rel=1e-6)
    assert pull > 5.0
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]


def _mass_of_eye() -> float:
    return 7.85e-3 * 2.0 * np.pi**2 * 14.0 * 5.0**2
