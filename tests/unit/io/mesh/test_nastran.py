"""Nastran decks: systems, layouts and includes are carried out; the rest is refused by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import FileError, MeshError
from contiga.io.mesh.nastran import read_nastran
from contiga.slaves.slave import Slave

CUBE = [(x, y, z) for z in (0.0, 1.0) for x, y in ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))]
LOW, HIGH = (0.0, 0.0, 0.0), (1.0, 1.0, 0.0)


def card(name: str, *values: object) -> str:
    """Fixed fields of eight, continued where they are more than eight."""
    text = f"{name:<8}"
    for k, value in enumerate(values):
        if k and k % 8 == 0:
            text += f"{'+':<8}\n{'+':<8}"
        text += f"{value:>8}" if not isinstance(value, float) else f"{value:>8.5g}"
    return text + "\n"


def grid(system: object = "", places: list[tuple[float, ...]] = CUBE) -> str:
    return "".join(card("GRID", k, system, *place) for k, place in enumerate(places, start=1))


QUAD = card("CQUAD4", 1, 3, 1, 2, 3, 4)
SHIFT = card("CORD2R", 5, 0, 10.0, 0.0, 0.0, 10.0, 0.0, 1.0, 11.0, 0.0, 0.0)
DRUM = card("CORD2C", 5, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
GLOBE = card("CORD2S", 5, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0)
TURNED = card("CORD2R", 6, 5, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0)
POLAR = [(0, 0, 0), (1, 0, 0), (2**0.5, 45, 0), (1, 90, 0)]
ROUND = [(0, 0, 0), (1, 90, 0), (2**0.5, 90, 45), (1, 90, 90)]
FEET = (
    card("GRID", 91, "", 10, 0, 0) + card("GRID", 92, "", 10, 0, 1) + card("GRID", 93, "", 11, 0, 0)
)
ALL_IN_5, ON_FEET = card("GRDSET", "", 5), card("CORD1R", 5, 91, 92, 93)
NO_SURFACE = "".join(
    [
        *(card("CBAR", 7, 1, 1, 2), card("RBE2", 8, 1, 123456, 2), card("PSHELL", 3, 1)),
        *(card("CONM2", 9, 1, 0, 2.5), card("MAT1", 1, 7.0), card("SPC1", 1, 123, 4)),
    ]
)
HEXA = f"{'CHEXA':<8}" + "".join(f"{x:>8}" for x in (1, 1, 1, 2, 3, 4, 5, 6))
LONG = "".join(
    f"{'GRID*':<8}{k:>16}{'':>16}{x:>16}{y:>16}*\n{'*':<8}{z:>16}\n"
    for k, (x, y, z) in enumerate(CUBE, start=1)
)
FREE = "".join(f"GRID,{k},,{x},{y},{z}\n" for k, (x, y, z) in enumerate(CUBE, start=1))
ODD = "".join(
    f"GRID,{k},,{x:.0f}.+0,{y:.0f}.D0,{z:.0f}.-0\n" for k, (x, y, z) in enumerate(CUBE, 1)
)
DECKS = {
    "plain": (grid() + QUAD, 2, LOW, HIGH),
    "a system moved": (SHIFT + grid(5) + QUAD, 2, (10, 0, 0), (11, 1, 0)),
    "moved, of all that name none": (SHIFT + ALL_IN_5 + grid() + QUAD, 2, (10, 0, 0), (11, 1, 0)),
    "moved, but for those that name 0": (SHIFT + ALL_IN_5 + grid(0) + QUAD, 2, LOW, HIGH),
    "within another, turned": (SHIFT + TURNED + grid(6) + QUAD, 2, (9, 0, 0), (10, 1, 0)),
    "by grid points": (FEET + ON_FEET + grid(5) + QUAD, 2, (10, 0, 0), (11, 1, 0)),
    "round a drum": (DRUM + grid(5, POLAR) + QUAD, 2, LOW, HIGH),
    "on a globe": (GLOBE + grid(5, ROUND) + QUAD, 2, LOW, HIGH),
    "an included file": (grid() + QUAD + "INCLUDE 'more.bdf'\n", 4, LOW, (1, 1, 1)),
    "included over two lines": (grid() + QUAD + "INCLUDE 'mo\n  re.bdf'\n", 4, LOW, (1, 1, 1)),
    "THETA": (grid() + card("CQUAD4", 1, 1, 1, 2, 3, 4, "30."), 2, LOW, HIGH),
    "T1 to T4": (grid() + card("CQUAD4", 1, 1, 1, 2, 3, 4, "", "", "", "", 1.0, 1.0), 2, LOW, HIGH),
    "long fields": (LONG + QUAD, 2, LOW, HIGH),
    "free fields": (FREE + "CQUAD4,1,3,1,2,3,4\n", 2, LOW, HIGH),
    "numbers of Fortran": (ODD + QUAD, 2, LOW, HIGH),
    "tabs": (grid() + "CQUAD4\t1\t3\t5\t6\t7\t8\n", 2, (0, 0, 1), (1, 1, 1)),
    "unmarked continuation": (grid() + HEXA + f"\n{'':<8}{7:>8}{8:>8}\n", 12, LOW, (1, 1, 1)),
    "marked continuation": (grid() + HEXA + f"+H1\n{'+H1':<8}{7:>8}{8:>8}\n", 12, LOW, (1, 1, 1)),
    "free continuation": (FREE + "CHEXA,1,1,1,2,3,4,5,6\n,7,8\n", 12, LOW, (1, 1, 1)),
    "what has no surface": (grid() + QUAD + NO_SURFACE, 2, LOW, HIGH),
}  # fmt: skip


def read(tmp_path: Path, bulk: str) -> Slave:
    path = tmp_path / "deck.bdf"
    path.write_text(f"SOL 101\nCEND\n$ a remark\nBEGIN BULK\n{bulk}ENDDATA\nleft over\n")
    return cg.read_mesh(path)


@pytest.mark.parametrize("name", DECKS)
def test_decks_are_read_as_they_are_meant(tmp_path: Path, name: str) -> None:
    bulk, facets, low, high = DECKS[name]
    (tmp_path / "more.bdf").write_text(card("CQUAD4", 2, 1, 5, 6, 7, 8))
    slave = read(tmp_path, bulk)
    assert len(slave.facets) == facets
    assert np.allclose(slave.bounds(), [low, high], atol=1e-4)


def test_a_file_of_cards_alone_is_a_deck(tmp_path: Path) -> None:
    (tmp_path / "bulk.nas").write_text(grid() + QUAD)
    slave = cg.read_mesh(tmp_path / "bulk.nas")
    assert len(slave.facets) == 2
    assert [part.label for part in slave.parts] == ["3"]


def test_kinds_that_alternate_are_one_block_each_with_its_properties(tmp_path: Path) -> None:
    corners = [(1, 2, 3, 4), (5, 6, 7), (1, 2, 6, 5), (2, 3, 7), (3, 4, 8, 7), (5, 7, 8)]
    names = {3: "CTRIA3", 4: "CQUAD4"}
    cards = [card(names[len(c)], k, (9, 3, 5)[k % 3], *c) for k, c in enumerate(corners, 1)]
    path = tmp_path / "deck.bdf"
    path.write_text(grid() + "".join(cards))
    mesh = read_nastran(path)
    assert [(block.kind, len(block.nodes)) for block in mesh.blocks] == [
        ("quad", 3),
        ("triangle", 3),
    ]
    rows = {group.id: [own.tolist() for own in group.cells or ()] for group in mesh.groups}
    assert rows == {3: [[0], [1]], 5: [[2], [0]], 9: [[1], [2]]}


@pytest.mark.parametrize(("name", "count"), [("CHEXA", 20), ("CPENTA", 15), ("CQUAD8", 8)])
def test_mid_side_nodes_stand_where_nastran_counts_them(
    tmp_path: Path, name: str, count: int
) -> None:
    """Solids: those of the bottom, those between, those of the top."""
    corners = {20: CUBE, 15: [CUBE[k] for k in (0, 1, 3, 4, 5, 7)], 8: CUBE[:4]}[count]
    half = len(corners) // 2 if count > 8 else len(corners)
    turn = [(k, (k + 1) % half) for k in range(half)]
    pairs = [*turn, *((k, k + half) for k in range(half)), *((a + half, b + half) for a, b in turn)]
    places = np.array(corners)
    middles = [0.5 * (places[a] + places[b]) for a, b in pairs[: count - len(corners)]]
    points = [tuple(place) for place in [*places.tolist(), *np.array(middles).tolist()]]
    slave = read(tmp_path, grid("", points) + card(name, 1, 1, *range(1, count + 1)))
    area = {20: 6.0, 15: 3.0 + 2**0.5, 8: 1.0}[count]
    assert slave.area.sum() == pytest.approx(area, rel=1e-4)
    assert slave.active.all()


@pytest.mark.parametrize(
    ("bulk", "message"),
    [
        (card("CTRIAX6", 1, 1, 1, 2, 3), r"line \d+: CTRIAX6: a card that is not known here"),
        (card("SEBULK", 1), "SEBULK: a card that is not known"),
        ("GRID,=,*1\n", "not a whole number"),
        ("BEGIN SUPER=1\n", "superelements"),
        (card("GRID", 1, "", 5.0, 0.0, 0.0), "a grid point is given twice.*1"),
        (card("GRID", 9, 77, 5.0, 0.0, 0.0), "no system of that number; found 77"),
        (card("GRID", 9, "", "nan", 0.0, 0.0), "GRID: not a finite number; found 'nan'"),
        (card("CQUAD4", 1, 3, 1, 2, 3, 4), "an element is given twice"),
        (card("CQUAD4", 9, 3, 1, 2, 3, 99), r"line \d+: CQUAD4.*found 'node 99'"),
        (
            card("CQUAD4", 8, 3, 5, 6, 7, 8) + card("CQUAD4", 9, 3, 1, 2, 3, 99),
            r"line 15: CQUAD4.*found 'node 99'",
        ),
        (card("CQUAD4", 9, 3, 1, 2, 3), "a corner is left out"),
        (card("CQUAD8", 9, 3, 1, 2, 3, 4, 5, 6), "some mid-side nodes are left out"),
        (
            card("CORD2R", 7, 7, *[0.0] * 9) + card("GRID", 9, 7),
            "a coordinate system is defined by itself",
        ),
        (card("CORD2R", 7, 0, *[0.0] * 9) + card("GRID", 9, 7), "of a system lie on a line"),
        (HEXA + f"+H1\n{'+H2':<8}{7:>8}{8:>8}\n", "a continuation that does not follow its card"),
    ],
)
def test_what_is_not_understood_is_refused_by_name_and_line(
    tmp_path: Path, bulk: str, message: str
) -> None:
    with pytest.raises(MeshError, match=message):
        read(tmp_path, grid() + QUAD + bulk)


def test_included_files_must_be_there(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"line 5: no such included file; found 'none.bdf'"):
        read(tmp_path, "INCLUDE 'none.bdf'\n")
    with pytest.raises(FileError, match="a file includes itself"):
        read(tmp_path, "INCLUDE 'deck.bdf'\n")
    with pytest.raises(MeshError, match=r"line 5: the quotes of an INCLUDE are not closed"):
        read(tmp_path, "INCLUDE 'none.bdf\n" + grid() + QUAD)
