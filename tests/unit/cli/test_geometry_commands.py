"""The commands on geometry alone: info, mesh and preview."""

from __future__ import annotations

import re
from pathlib import Path
from types import ModuleType

import pytest
from tests import occ_rig

from .conftest import Command, one_message

TETRAHEDRON = """OFF
4 4 0
0 0 0
1 0 0
0 1 0
0 0 1
3 0 2 1
3 0 1 3
3 0 3 2
3 1 2 3
"""


PATCH = """<xml><Geometry type="TensorBSpline2" id="0">
<Basis type="TensorBSplineBasis2">
<Basis type="BSplineBasis" index="0"><KnotVector degree="1">0 0 1 1</KnotVector></Basis>
<Basis type="BSplineBasis" index="1"><KnotVector degree="1">0 0 1 1</KnotVector></Basis>
</Basis><coefs geoDim="3">0 0 0 2 0 0 0 3 0 2 3 0</coefs></Geometry></xml>
"""


def test_info_of_a_mesh_counts(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "tetrahedron.off"
    path.write_text(TETRAHEDRON, encoding="utf-8")
    code, out, _ = command("info", path)
    assert code == 0
    facts = dict(line.split(maxsplit=1) for line in out.splitlines() if " " in line.strip())
    assert facts["nodes"].strip() == "4"
    assert facts["facets"].strip() == "4"
    assert float(facts["area"]) == pytest.approx(1.5 + 3**0.5 / 2, rel=1e-5)


def test_info_of_cad_names_patches_and_area(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "patch.xml"
    path.write_text(PATCH, encoding="utf-8")
    code, out, _ = command("info", path)
    assert code == 0
    facts = dict(line.split(maxsplit=1) for line in out.splitlines() if " " in line.strip())
    assert facts["patches"].strip() == "1"
    assert float(facts["area"].split()[0]) == pytest.approx(6.0)


def test_info_lists_the_parts_of_an_assembly(command: Command, tmp_path: Path) -> None:
    path = occ_rig.rig(tmp_path / "rig.step")
    code, out, _ = command("info", path)
    said = " ".join(out.split())
    assert code == 0
    assert (
        "part 1 box (box 1), solid, faces 1-6, closed, normals outward, volume 24 mm³, "
        "area 52 mm², #ff0000 x 0 to 2 mm, y 0 to 3 mm, z 0 to 4 mm" in said
    )
    assert "part 2 cup (cup 1), shell, faces 7-11, open, area 5 mm²" in said
    assert "part 6 block (right arm/back)" in said
    assert "x 198 to 200 mm, y 50 to 54 mm, z 0 to 1 mm" in said
    assert "face 1 " not in said
    _, out, _ = command("info", path, "--faces")
    assert "face 35 plane, area 8 mm², part 6, x 198 to 200 mm" in " ".join(out.split())


def test_mesh_of_some_parts_of_an_assembly(command: Command, tmp_path: Path) -> None:
    path, out = occ_rig.rig(tmp_path / "rig.step"), tmp_path / "some.stl"
    code, said, _ = command("mesh", path, "--tol", 1, "--part", "box", "--part", 3, "-o", out)
    assert code == 0
    assert "24 triangles, 16 vertices in mm, area 80, closed" in said  # 52 + 28
    code, _, err = command("mesh", path, "--tol", 1, "--part", "boxx", "-o", out)
    assert code == 2
    assert "Did you mean 'box'?" in one_message(err)


def test_info_has_no_faces_of_a_mesh(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_text("0,0,0\n1,0,0\n")
    code, out, err = command("info", path, "--faces")
    assert (code, out) == (2, "")
    assert "only CAD has faces" in one_message(err)


def test_info_says_how_far_a_surface_is_open(command: Command, tmp_path: Path) -> None:
    path = tmp_path / "patch.xml"
    path.write_text(PATCH, encoding="utf-8")
    _, out, _ = command("info", path)
    assert "open, 4 free edges, 10 long in all" in out


def test_info_of_a_solid_shows_its_tolerance_and_largest_gap(
    command: Command, solids: ModuleType, tmp_path: Path
) -> None:
    code, out, _ = command("info", solids.write(solids.cup(), tmp_path / "cup.step"))
    facts = dict(line.split("  ", maxsplit=1) for line in out.splitlines() if "  " in line)
    assert code == 0
    assert facts["surface"].strip() == "closed"
    tolerance, unit = facts["largest tolerance"].split()
    assert float(tolerance) > 0.0
    assert unit == "mm"
    assert "between patches" in facts["largest gap"]
    assert facts["largest gap"].split()[1] == "mm"


@pytest.mark.parametrize("suffix", [".step", ".iges", ".xml", ".3dm", ".off", ".vtu"])
def test_info_of_garbage_is_one_message(command: Command, tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"garbage{suffix}"
    path.write_bytes(b"\x00garbage\xff" * 20)
    code, out, err = command("info", path)
    assert code == 2
    assert out == ""
    assert "garbage" in one_message(err)


@pytest.mark.parametrize("suffix", [".msh", ".vtu", ".stl"])
def test_mesh_of_cad_is_written(command: Command, tmp_path: Path, suffix: str) -> None:
    cad, path = tmp_path / "patch.xml", tmp_path / f"patch{suffix}"
    cad.write_text(PATCH, encoding="utf-8")
    code, out, err = command("mesh", cad, "--tol", 0.1, "--size", 0, "-o", path)
    assert (code, err) == (0, "")
    assert out == f"{path}: 2 triangles, 4 vertices, area 6, 4 open edges\n"
    code, out, err = command("mesh", cad, "--tol", 0.1, "-o", path)
    assert (code, err) == (0, "")
    assert int(re.match(rf"{path}: (\d+) triangles, .*area 6, ", out)[1]) > 100
    assert command("info", path)[0] == 0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["patch.xml", "--tol", 0.0, "-o", "a.msh"], "a tolerance must be positive; found 0.0"),
        (["patch.xml", "--tol", "nan", "-o", "a.msh"], "a tolerance must be positive"),
        (["patch.xml", "--tol", 1, "--method", "fan", "-o", "a.msh"], "not a method; found 'fan'"),
        (["patch.xml", "--tol", 1, "-o", "a.obj"], "found '.obj'; allowed: .msh, .vtu, .stl"),
        (["none.step", "--tol", 1, "-o", "a.msh"], "no such file"),
        (["patch.xml", "--tol", 1, "-o", "none/a.msh"], "a folder that exists"),
        (["patch.xml", "--tol", 1, "--size", -1, "-o", "a.msh"], "--size: must be a length"),
        (["patch.xml", "--tol", 1, "--size", 1e-9, "-o", "a.msh"], "size: would take more than"),
        (["patch.xml", "--tol", 1, "--unit", "kg", "-o", "a.msh"], "kg"),
    ],
)
def test_mesh_that_cannot_be_written_is_one_message(
    command: Command,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[object],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "patch.xml").write_text(PATCH, encoding="utf-8")
    code, out, err = command("mesh", *arguments)
    assert (code, out) == (2, "")
    assert message in one_message(err)
    assert [path.name for path in tmp_path.iterdir()] == ["patch.xml"]
