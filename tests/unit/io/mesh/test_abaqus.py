"""Abaqus decks: what makes or moves nodes is carried out, or refused by name and line."""

from __future__ import annotations

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import ContigaWarning, FileError, MeshError
from contiga.io.mesh.abaqus import read_abaqus
from contiga.io.mesh.abaqus_elements import cell_of
from contiga.slaves.slave import Slave

GRID = [(10 * j + i + 1, float(i), float(j), 0.0) for j in range(3) for i in range(4)]
QUADS = [
    *((1, 1, 2, 12, 11), (2, 2, 3, 13, 12), (3, 3, 4, 14, 13)),
    *((4, 11, 12, 22, 21), (5, 12, 13, 23, 22), (6, 13, 14, 24, 23)),
]


def lines(rows: list[tuple[float, ...]]) -> str:
    return "".join(", ".join(f"{number:.15g}" for number in row) + "\n" for row in rows)


NODES, ELEMENTS = f"*NODE\n{lines(GRID)}", f"*ELEMENT, TYPE=S4R, ELSET=A\n{lines(QUADS)}"
HEAD, UPPER = "*ELEMENT, TYPE=S4R, ELSET=A\n", "*ELEMENT, TYPE=S4R, ELSET=B\n"
PLACES = np.array(GRID)[:, 1:]
POLAR = [(k, np.hypot(x, y), np.degrees(np.arctan2(y, x)), z) for k, x, y, z in GRID]
BALL = [(k, np.hypot(x, y), np.degrees(np.arctan2(y, x)), 0.0) for k, x, y, _ in GRID]
SHEETS = {
    "plain": NODES + ELEMENTS,
    "comments amid": NODES.replace("11,", "** row\n11,") + HEAD + "** all\n" + lines(QUADS),
    "blank lines and lower case": (NODES + "\n" + ELEMENTS).lower(),
    "keyword over two lines": NODES + "*ELEMENT, TYPE=S4R,\n ELSET=A\n" + lines(QUADS),
    "several *NODE": f"*NODE\n{lines(GRID[:4])}*NODE, NSET=N\n{lines(GRID[4:])}{ELEMENTS}",
    "elements before their nodes": ELEMENTS + NODES,
    "*SYSTEM and back": f"*SYSTEM\n9, 9, 9\n*SYSTEM\n{NODES}{ELEMENTS}",
    "*NODE, SYSTEM=C": f"*NODE, SYSTEM=C\n{lines(POLAR)}{ELEMENTS}",
    "*NODE, SYSTEM=S": f"*NODE, SYSTEM=S\n{lines(BALL)}{ELEMENTS}",
    "*ELGEN": NODES + HEAD + lines(QUADS[:1]) + "*ELGEN, ELSET=A\n1, 3, 1, 1, 2, 10, 3\n",
    "*ELCOPY": NODES + HEAD + lines(QUADS[:3])
    + "*ELCOPY, OLD SET=A, NEW SET=A, ELEMENT SHIFT=3, SHIFT NODES=10\n",
    "*NGEN and *NCOPY": f"*NODE\n{lines([GRID[0], GRID[3]])}*NGEN, NSET=R\n1, 4\n"
    f"*NCOPY, OLD SET=R, CHANGE NUMBER=10, SHIFT, MULTIPLE=2\n0., 1.\n{ELEMENTS}",
    "an element over two lines": NODES + HEAD + lines(QUADS[:5]) + "6, 13, 14,\n24, 23\n",
    "reference point, mass and beam": NODES + "*NODE, NSET=REF\n999, 0., 0., 5.\n" + ELEMENTS
    + "*ELEMENT, TYPE=MASS, ELSET=M\n77, 1\n*MASS, ELSET=M\n2.5\n*ELEMENT, TYPE=B31\n78, 1, 999\n",
    "a history": NODES + ELEMENTS + "*STEP\n*STATIC\n*MODEL CHANGE, REMOVE\nA\n*END STEP\n",
}  # fmt: skip


def read(tmp_path: Path, text: str, **options: object) -> Slave:
    path = tmp_path / "deck.inp"
    path.write_text(text)
    return cg.read_mesh(path, **options)


@pytest.mark.parametrize("name", SHEETS)
def test_one_sheet_in_many_words(tmp_path: Path, name: str) -> None:
    sheet = read(tmp_path, SHEETS[name])
    assert len(sheet.facets) == 12
    assert sheet.area.sum() == pytest.approx(6.0, rel=1e-12)
    assert np.allclose(np.sort(sheet.points[sheet.active], axis=0), np.sort(PLACES, axis=0))


@pytest.mark.parametrize(
    ("text", "active"),
    [
        ("*ELSET, ELSET=S\nA, B\n", 12),
        ("*ELSET, ELSET=S, GENERATE\n1, 6, 1\n", 12),
        ("*ELSET, ELSET=S\nA\n*ELSET, ELSET=s\n4, 5, 6\n", 12),
        ("*NSET, NSET=S\n1, 2, 3, 4\n*NSET, NSET=S\n11, 12, 13, 14\n", 8),
        ("*NSET, NSET=S, ELSET=B\n", 8),
        ("*NSET, NSET=T, GENERATE\n1, 4\n*NSET, NSET=S\nT, 11\n", 5),
        ('*NSET, NSET="S"\n1, 2\n', 2),
        ('*NSET, NSET="a, b"\n1, 2\n*NSET, NSET=S\n"a, b", 3\n', 3),
        ("*NSET, NSET=S, GENERATE\n2\n3,\n11, , 1\n", 3),
        ("*ELEMENT, TYPE=T3D2, ELSET=L\n9, 1, 24\n*NSET, NSET=S, ELSET=L\n", 2),
        ("*STEP\n*NSET, NSET=S\n1, 2\n*END STEP\n", 2),
    ],
)
def test_sets_are_as_long_as_the_deck_has_them(tmp_path: Path, text: str, active: int) -> None:
    deck = NODES + HEAD + lines(QUADS[:3]) + UPPER + lines(QUADS[3:]) + text
    assert read(tmp_path, deck, parts="S").active.sum() == active


def test_systems_move_and_turn(tmp_path: Path) -> None:
    """x' points along y, y' against x."""
    sheet = read(tmp_path, f"*SYSTEM\n100, 0, 0, 100, 1, 0\n99, 0, 0\n{NODES}{ELEMENTS}")
    there = PLACES @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.allclose(sheet.points, there + np.array([100.0, 0.0, 0.0]))
    left_out = read(tmp_path, f"*SYSTEM\n, , , 0, 1, 0\n-1, 0, 0\n{NODES}{ELEMENTS}")
    assert np.allclose(left_out.points, there)


ASSEMBLY = f"""*PART, NAME=P
{NODES}{ELEMENTS}*NSET, NSET=LOW
1, 2, 3, 4
*END PART
*ASSEMBLY, NAME=ALL
*INSTANCE, NAME=One, PART=P
*END INSTANCE
*INSTANCE, NAME=Two, PART=p
0., 0., 5.
0., 0., 5., 0., 0., 6., 90.
*END INSTANCE
*NODE, NSET=REF
1, 9., 9., 9.
*NSET, NSET=BOTH, INSTANCE=One
1
*NSET, NSET=BOTH, INSTANCE=Two
1, 2
*NSET, NSET=NAMED
Two.LOW, One.24
*END ASSEMBLY
"""


def test_instances_are_placed_where_the_assembly_has_them(tmp_path: Path) -> None:
    sheets = read(tmp_path, ASSEMBLY)
    assert len(sheets) == 25
    assert sheets.area.sum() == pytest.approx(12.0)
    two = read(tmp_path, ASSEMBLY, parts="Two")
    turned = PLACES @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert np.allclose(two.points[two.active], turned + np.array([0.0, 0.0, 5.0]))
    assert read(tmp_path, ASSEMBLY, parts="BOTH").active.sum() == 3
    assert read(tmp_path, ASSEMBLY, parts="NAMED").active.sum() == 5
    assert read(tmp_path, ASSEMBLY, parts="One.LOW").active.sum() == 4
    labels = [part.label for part in sheets.parts]
    assert labels == ["One", "Two", "One.A", "Two.A", "REF", "BOTH", "NAMED", "One.LOW", "Two.LOW"]


def test_a_part_placed_once_keeps_its_names(tmp_path: Path) -> None:
    text = ASSEMBLY[: ASSEMBLY.index("*INSTANCE, NAME=Two")] + "*END ASSEMBLY\n"
    assert [part.label for part in read(tmp_path, text).parts] == ["A", "LOW"]


def test_sets_of_one_name_in_a_part_and_the_assembly_are_two(tmp_path: Path) -> None:
    text = ASSEMBLY[: ASSEMBLY.index("*INSTANCE, NAME=Two")]
    text += "*NSET, NSET=Low, INSTANCE=One\n1, 22\nOne.LOW\n*ELSET, ELSET=a, INSTANCE=One\n1\n"
    path = tmp_path / "deck.inp"
    path.write_text(text + "*END ASSEMBLY\n")
    groups = {group.name: group for group in read_abaqus(path).groups}
    assert {k: len((g.nodes, *(g.cells or ()))[-1]) for k, g in groups.items()} == {
        "a": 1,
        "One.A": 6,
        "Low": 5,
        "One.LOW": 4,
    }


def test_files_are_included(tmp_path: Path) -> None:
    (tmp_path / "nodes.txt").write_text(lines(GRID))
    (tmp_path / "more.inp").write_text(ELEMENTS)
    deck = "*NODE, INPUT=nodes.txt\n*INCLUDE, INPUT=more.inp\n"
    assert len(read(tmp_path, deck).facets) == 12
    with pytest.raises(FileError, match=r"line 1: \*INCLUDE: no such included file; found 'no"):
        read(tmp_path, "*INCLUDE, INPUT=none.inp\n")
    with pytest.raises(FileError, match="a file includes itself"):
        read(tmp_path, "*INCLUDE, INPUT=deck.inp\n")


def test_members_of_sets_that_are_not_there_are_told(tmp_path: Path) -> None:
    with pytest.warns(ContigaWarning, match=r"\*NSET S: 2 \(777, 778\)"):
        read(tmp_path, NODES + ELEMENTS + "*NSET, NSET=S\n1, 777, 778\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("*ELSET, ELSET=L\n1, 99\n*NSET, NSET=S, ELSET=L\n", r"\*NSET: elements that.*1 \(99\)"),
        (
            "*ELEMENT, TYPE=SPRINGA, ELSET=L\n9, 1, One.24\n*NSET, NSET=S, ELSET=L\n",
            r"line \d+: \*NSET: elements that are not there, or whose nodes are not: 1 \(9\)",
        ),
        ("*TIE, NAME=T\nA, B\n", r"line \d+: \*TIE: nodes stay where they are"),
        ("*CONTACT PAIR, ADJUST=0.1\nA, B\n", r"\*CONTACT PAIR: nodes stay"),
        ("*CONTACT CLEARANCE, NAME=C\n", r"\*CONTACT CLEARANCE: nodes stay"),
    ],
)
def test_what_a_deck_says_and_is_not_carried_out_is_told(
    tmp_path: Path, text: str, message: str
) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ContigaWarning)
        assert len(read(tmp_path, NODES + ELEMENTS + text).facets) == 12
    assert any(re.search(message, str(one.message)) for one in caught)


def test_ties_that_move_nothing_are_passed_over(tmp_path: Path) -> None:
    read(tmp_path, NODES + ELEMENTS + "*TIE, NAME=T, ADJUST=NO\nA, B\n*CONTACT PAIR\nA, B\n")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("*IMPERFECTION, FILE=x\n", r"line \d+: \*IMPERFECTION: a keyword that is not known"),
        ("*NFILL\nA, B, 3\n", r"\*NFILL: a keyword that is not known"),
        ("*ADJUST, NODE SET=N\n", r"\*ADJUST: a keyword that is not known"),
        ("*NGEN\n5\n", r"line \d+: not two nodes and an even step"),
        ("*NGEN\n1, 999\n", "no node of that number; found 999"),
        ("*NSET, NSET=N\n1, 777\n*NCOPY, OLD SET=N, CHANGE NUMBER=100, SHIFT\n1\n", "found 777"),
        ("*ELEMENT, TYPE=B31\n,,\n", r"line \d+: a line without its first number"),
        ("*ELEMENT, TYPE=S4\n,,\n", r"line \d+: a line without its first number"),
        ("*ELGEN\n,,\n", r"line \d+: a line without its first number"),
        ("*NSET, NSET=S, GENERATE\n,\n", r"line \d+: a line without its first number"),
        ("*NGEN, LINE=C\n1, 4\n", r"\*NGEN: the parameter LINE is not carried out"),
        ("*NCOPY, OLD SET=N, CHANGE NUMBER=1, REFLECT=POINT\n", "REFLECT is not carried out"),
        ("*ELEMENT, TYPE=U12\n9, 1\n", r"a type of element.*TYPE=U12"),
        ("*ELEMENT, TYPE=S4\n9, 1, 2, 99, 3\n", "element 9 names a node that is not there.*99"),
        ("*ELEMENT, TYPE=S4\n9, 1, 2, 3\n", r"an element of 4 nodes.*3 numbers"),
        ("*ELEMENT, TYPE=S4\n1, 1, 2, 3, 4\n", "an element is given twice"),
        ("*NODE\n1, 5., 0., 0.\n", "a node is given twice, in different places.*node 1"),
        ("*NODE\n77, nan, 0., 0.\n", r"line \d+: not a finite number; found 'nan'"),
        ("*NODE\n77, 1e999, 0., 0.\n", "not a finite number"),
        ("*NODE\nx, 0., 0., 0.\n", "not a whole number; found 'x'"),
        ("*ELSET, ELSET=S\nnone\n", r"no set of that name before this line.*allowed: A"),
        ("*INSTANCE, NAME=I, PART=Q\n*END INSTANCE\n", "no part of that name.*'Q'"),
        ("*SYSTEM\n0, 0, 0, 1, 0, 0\n2, 0, 0\n", "three points of a system lie on a line"),
    ],
)
def test_what_is_not_understood_is_refused_by_name_and_line(
    tmp_path: Path, text: str, message: str
) -> None:
    with pytest.raises(MeshError, match=message):
        read(tmp_path, NODES + ELEMENTS + text)


@pytest.mark.parametrize(
    ("name", "cell"),
    [
        *(("S3RS", "triangle"), ("S8R5", "quad8"), ("STRI65", "triangle6"), ("M3D4R", "quad")),
        *(
            ("R3D4", "quad"),
            ("CPE6M", "triangle6"),
            ("C3D8R", "hexahedron"),
            ("C3D10MH", "tetra10"),
        ),
        *(("C3D15", "wedge15"), ("SC8R", "hexahedron"), ("COH3D6", "wedge"), ("C3D5", "pyramid")),
        *(("T3D2", ""), ("CONN3D2", ""), ("SPRINGA", ""), ("ROTARYI", ""), ("B33", "")),
        *(("C3D27", None), ("U1", None), ("SAX1", None), ("FOO", None), ("C3D81", None)),
    ],
)
def test_types_of_elements_are_told_by_their_names(name: str, cell: str | None) -> None:
    assert cell_of(name) == cell
