"""The occupant: its files are those of its scripts, its dummy has the mass and the chest that its
page says, and its first steps keep joints and ledger closed."""

from __future__ import annotations

import runpy
import tomllib
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import contiga as cg

EXAMPLES = Path(__file__).parents[2] / "examples"
FOLDER = EXAMPLES / "occupant"
CASE = FOLDER / "occupant.toml"
CHANNELS = {
    "head_cg.filtered_a",
    "chest_cg.filtered_a",
    "pelvis_cg.filtered_a",
    "ribs.travel",
    "retractor.force",
    "retractor.travel",
    "shoulder start.force",
    "lap start.force",
    "bag.pressure",
    "excursion.x",
    "excursion.z",
}
UPRIGHT = Rotation.from_euler("y", 20.0, degrees=True)
POUND, INCH = 4.4482216152605, 25.4
"""In N and mm."""
IMPACT = """
title = "The impactor of 49 CFR 572.34"
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 45.0, step = "auto" }
[[include]]
file = "FOLDER/dummy.toml"
placement = [{ rotate = { axis = "y", degrees = 20 } }]
[[body]]
name = "impactor"
geometry = { shape = "ellipsoid", axes = [30.0, 76.0, 76.0], centre = [147, 0, 290] }
mass = { total = 23400.0 }
motion = { kind = "free", velocity = [-6.71, 0, 0], hold = ["y", "z", "rx", "ry", "rz"] }
[[slave]]
name = "face"
points = { body = "impactor", size = 12.0 }
[[contact]]
master = "sternum"
slave = "face"
law = { kind = "penalty", stiffness = 0.03, per_area = true }
"""


def script(path: Path) -> dict[str, Any]:
    """The names that a script defines."""
    return runpy.run_path(str(path))


def dummy() -> dict[str, Any]:
    """The tables of the dummy's file."""
    return tomllib.loads((FOLDER / "dummy.toml").read_text(encoding="utf-8"))


def carried(history: dict[str, Any], body: str, points: np.ndarray) -> np.ndarray:
    """Return the places at the end of `points` (n, 3) of the start that move with `body`."""
    centres = np.stack([history[f"{body}.{axis}"] for axis in "xyz"], axis=1)[[0, -1]]
    turns = Rotation.from_quat(
        np.stack([history[f"{body}.q{axis}"] for axis in "xyzw"], axis=1)[[0, -1]]
    )
    return centres[1] + (turns[1] * turns[0].inv()).apply(points - centres[0])


def widest_gap(history: dict[str, Any], placement: Rotation) -> float:
    """How far the points of spherical and revolute joints are apart at the end."""
    gaps = []
    for joint in dummy()["joint"]:
        if joint["kind"] in ("spherical", "revolute"):
            point = placement.apply([joint["at"]])
            first, second = (carried(history, body, point) for body in joint["between"])
            gaps.append(np.abs(second - first).max())
    return max(gaps)


def test_the_files_are_those_that_the_scripts_write() -> None:
    written = script(FOLDER / "make_dummy.py")["dummy"]()
    assert (FOLDER / "dummy.toml").read_text(encoding="utf-8") == written
    bag = script(EXAMPLES / "make_airbag.py")["airbag_mesh"](8)
    seat = script(FOLDER / "make_seat.py")["cushion"]()
    for name, (points, cells) in {"bag.vtu": bag, "seat.vtu": seat}.items():
        mesh = meshio.read(FOLDER / name)
        np.testing.assert_allclose(mesh.points, points, atol=1e-9)
        np.testing.assert_array_equal(mesh.cells[0].data, cells)


def test_the_dummy_has_fifteen_bodies_fourteen_joints_and_the_mass_of_a_median_man() -> None:
    tables = dummy()
    assert (len(tables["body"]), len(tables["joint"])) == (15, 14)
    assert sum(body["mass"]["total"] for body in tables["body"]) == pytest.approx(77.7e3, rel=1e-3)


def test_the_chest_answers_the_impactor_within_the_corridors_of_the_regulation(
    tmp_path: Path,
) -> None:
    case = tmp_path / "impact.toml"
    case.write_text(IMPACT.replace("FOLDER", FOLDER.as_posix()), encoding="utf-8")
    history = cg.run(case, out=tmp_path / "out").history
    force, depth = history["force"], history["ribs.travel"]
    deepest = int(depth.argmax()) + 1
    loop, loading = (np.trapezoid(force[:n], depth[:n]) for n in (len(force), deepest))
    assert force.max() == pytest.approx(1242.5 * POUND, abs=82.5 * POUND)
    assert depth.max() == pytest.approx(2.68 * INCH, abs=0.18 * INCH)
    assert 0.69 < loop / loading < 0.85
    assert np.ptp(history["left knee.angle"]) > 0.01
    assert widest_gap(history, UPRIGHT) < 1e-9


def test_nothing_looks_wrong_at_the_start() -> None:
    assert not cg.build(cg.load_case(CASE)).check()


def test_the_first_steps_keep_joints_and_ledger_closed_and_have_all_channels(
    tmp_path: Path,
) -> None:
    case = cg.load_case(CASE, set={"time.end": 0.5, "output.report": False})
    result = cg.run(case, out=tmp_path / "out")
    history = result.history
    assert set(history) >= CHANNELS
    assert result.summary["energy"]["relative"] < 1e-3
    assert widest_gap(history, Rotation.identity()) < 1e-9


@pytest.mark.full
def test_a_run_gives_the_figures_of_its_page(tmp_path: Path) -> None:
    result = cg.run(CASE, out=tmp_path / "out")
    history, sensors = result.history, result.summary["sensors"]
    air = history["bag.pressure"][0]
    figures = {
        "HIC15": (sensors["head_cg"]["criteria"]["HIC15"]["value"], 80.0),
        "chest, 3 ms": (sensors["chest_cg"]["criteria"]["chest3ms"]["value"], 41.7),
        "compression of the chest": (np.abs(history["ribs.travel"]).max(), 60.0),
        "V·C": (sensors["thorax"]["criteria"]["VC"]["value"], 0.91),
        "excursion": (history["excursion.x"].max() - history["excursion.x"][0], 432.0),
        "limiter": (history["retractor.force"].max() / 1e3, 3.0),
        "shoulder belt": (history["shoulder start.force"].max() / 1e3, 4.0),
        "lap belt": (history["lap start.force"].max() / 1e3, 7.9),
        "airbag": ((history["bag.pressure"].max() - air) * 1e3, 46.0),
    }
    assert {
        name: value
        for name, (value, page) in figures.items()
        if value != pytest.approx(page, rel=0.03)
    } == {}
    error = np.abs(history["energy.error"]).max()
    assert error < 1e-3 * history["energy.kinetic"][0]
    assert widest_gap(history, Rotation.identity()) < 1e-9
