"""Damaged files of every kind end in one message: those that once ended the interpreter, too."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import CaseError, FileError, MeshError
from contiga.io.cad.occ_geometry import quiet
from contiga.io.mesh.read_mesh import read_mesh


def box(path: Path) -> str:
    """The text of a STEP or IGES file of a box."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.IGESControl import IGESControl_Writer
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    shape = BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()
    with quiet():
        if path.suffix == ".igs":
            iges = IGESControl_Writer("MM", 1)
            iges.AddShape(shape)
            iges.ComputeModel()
            iges.Write(str(path))
        else:
            step = STEPControl_Writer()
            step.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
            step.Write(str(path))
    return path.read_text()


def damaged_step(path: Path) -> Path:
    """Lines whose direction is no entity: OpenCASCADE follows a null pointer."""
    text, count = re.subn(r"(= LINE\('',#\d+,)#\d+", r"\1#Na", box(path))
    assert count >= 12
    path.write_text(text)
    return path


def damaged_iges(path: Path) -> Path:
    """The first line of the shell's entry in the directory is gone."""
    lines = box(path).splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if line.startswith("     514") and line[72] == "D")
    path.write_text("".join(lines[:at] + lines[at + 1 :]))
    return path


def contiga(*args: object) -> subprocess.CompletedProcess[str]:
    env = {**os.environ, "PYTHONPATH": str(Path(cg.__file__).parents[1])}
    return subprocess.run(
        [sys.executable, "-c", "from contiga.cli.commands import main; main()", *map(str, args)],
        capture_output=True,
        text=True,
        env=env,
    )


def test_a_step_file_that_crashes_its_reader_is_one_message(tmp_path):
    path = damaged_step(tmp_path / "part.step")
    with pytest.raises(FileError, match=r"part.step: the reader crashed on this file"):
        cg.read_cad(path)
    sound = tmp_path / "sound.step"
    box(sound)
    assert len(cg.read_cad(sound).patches) == 6


@pytest.mark.parametrize("command", ["info", "mesh"])
def test_the_command_line_says_so_with_exit_code_2_and_writes_nothing(tmp_path, command):
    path = damaged_step(tmp_path / "part.step")
    out = tmp_path / "part.stl"
    done = contiga(command, path, *(("--tol", 0.1, "-o", out) if command == "mesh" else ()))
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith(f"contiga: error: {path}: the reader crashed on this file (")
    assert done.stderr.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == [path]


def test_an_iges_file_that_lost_a_line_of_its_directory_is_refused(tmp_path):
    path = damaged_iges(tmp_path / "part.igs")
    with pytest.raises(FileError, match=r"part\.igs"):
        cg.read_cad(path)


DECK = """*KEYWORD
*NODE
       1             0.0             0.0             0.0
       2             1.0             0.0             0.0
       3             1.0             1.0             0.0
*ELEMENT_SHELL
       1       1       1       2       3       3
"""


@pytest.mark.parametrize(
    "layers", ["1e17", "99999999999999", "9999999999", "1.0E15", "4611686018427387904"]
)
def test_layers_a_section_claims_are_not_counted_one_by_one(tmp_path, monkeypatch, layers):
    monkeypatch.setenv("CONTIGA_READ_SECONDS", "5")
    path = tmp_path / "a.k"
    first = f"2,2,1.0,{layers},0,0,1"
    path.write_text(f"{DECK}*SECTION_SHELL\n{first}\n{'0.5,' * 3}0.5\n*END\n")
    assert len(read_mesh(path).points) == 3


@pytest.mark.parametrize("number", ["1e400", "-inf", "nan", "9" * 30, "1e30"])
def test_counts_beyond_all_counting_are_refused_with_their_line(tmp_path, number):
    path = tmp_path / "a.k"
    path.write_text(f"{DECK}*ELEMENT_SHELL\n2,1,1,2,3,{number}\n*END\n")
    with pytest.raises(MeshError, match=r"a.k, line 9: \*ELEMENT_SHELL: .*whole number"):
        read_mesh(path)


@pytest.mark.parametrize(
    "damage",
    [
        lambda text: text.replace("*NODE\n", "*NODE\n\x0b"),
        lambda text: text.replace("             1.0", "\x00            1.0", 1),
        lambda text: text.replace("       3  ", "      \r3  ", 1),
        lambda text: text.replace("\n", "\x1c", 3),
        lambda text: text[: text.index("       3       3")],
    ],
)
def test_decks_with_odd_characters_end(tmp_path, monkeypatch, damage):
    monkeypatch.setenv("CONTIGA_READ_SECONDS", "5")
    path = tmp_path / "a.k"
    path.write_text(damage(DECK))
    try:
        said = f"{len(read_mesh(path).points)} points"
    except (FileError, MeshError) as error:
        said = str(error)
    assert "CONTIGA_READ_SECONDS" not in said  # it ends by itself, not at the bound


def test_an_array_shorter_than_its_head_says_takes_no_memory(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.zeros((10, 3)))
    data = path.read_bytes()
    path.write_bytes(data.replace(b"(10, 3), }          ", b"(9999999999999, 3),}", 1))
    assert path.read_bytes() != data
    with pytest.raises(FileError, match="not a plain NumPy array"):
        read_mesh(path)


def test_a_line_without_end_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("0,0,0\n" + "1" * 20_000)
    with pytest.raises(FileError, match="line 2: a line is longer than 10000 characters"):
        read_mesh(path)


def test_coordinates_that_cannot_be_squared_are_refused(tmp_path):
    knots = "".join(f'<KnotVector degree="1">0 0 1 1</KnotVector><i>{k}</i>' for k in range(2))
    path = tmp_path / "a.xml"
    path.write_text(
        f'<xml><Geometry type="TensorBSpline2">{knots}<coefs geoDim="3">'
        "0 0 0 1 0 0 0 1 0 1e300 1 0</coefs></Geometry></xml>"
    )
    with pytest.raises(
        FileError, match=r"patch 0: a control point is too far from the origin.*1e\+300"
    ):
        cg.read_cad(path)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x = " + "[" * 100_000, "nested too deeply"),
        ("x = " + "9" * 5000, "5000 digits"),
        ("#" * (32 * 1024**2 + 1), "too large for a case file"),
    ],
)
def test_cases_that_overrun_their_parser_are_refused(tmp_path, text, said):
    path = tmp_path / "case.toml"
    path.write_text(text)
    with pytest.raises((CaseError, FileError), match=said):
        cg.load_case(path)
