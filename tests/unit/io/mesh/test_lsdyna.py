"""LS-DYNA decks: card layouts, parts, thickness, mass, included files, refusals."""

from __future__ import annotations

import numpy as np
import pytest

from contiga.errors import FileError, MeshError
from contiga.io.mesh import lsdyna
from contiga.io.mesh.lsdyna_cards import read_blocks
from contiga.io.mesh.read_mesh import read_mesh
from contiga.slaves.mesh_summary import mesh_summary

NODES = """*NODE
$#   nid               x               y               z      tc      rc
       1             0.0             0.0             0.0       0       0
       2             1.0             0.0             0.0       0       0
       3             1.0             1.0             0.0       0       0
       4             0.0             1.0             0.0       0       0
       5             2.0             0.0             0.0       0       0
       6             2.0             1.0             0.0       0       0
"""
SHELLS = """*ELEMENT_SHELL
$#   eid     pid      n1      n2      n3      n4
       1       7       1       2       3       4
       2       8       2       5       6       6
"""
PARTS = """*PART
$ title
left half
$      pid     secid       mid
         7        70         1
right half
         8        80         1
"""
SECTIONS = """*SECTION_SHELL
$    secid    elform      shrf       nip     propt   qr/irid     icomp
        70        16
$       t1        t2        t3        t4
       2.0       2.0       2.0       2.0
        80         2
       0.5
"""


@pytest.fixture
def deck(tmp_path):
    def write(*text, name="a.k"):
        path = tmp_path / name
        path.write_text("*KEYWORD\n" + "".join(text) + "*END\n")
        return path

    return write


def test_shells_by_part_with_triangles_told_from_equal_nodes(deck):
    slave = read_mesh(deck(NODES, SHELLS, PARTS))
    assert dict(slave.cells) == {"quad": 1, "triangle": 1}
    assert slave.area.sum() == pytest.approx(1.5)
    assert [part["label"] for part in mesh_summary(slave)["parts"]] == [
        "7 (left half)",
        "8 (right half)",
    ]


@pytest.mark.parametrize("key", [8, "8", "right half", "Right Half"])
def test_a_part_is_chosen_by_number_or_title(deck, key):
    slave = read_mesh(deck(NODES, SHELLS, PARTS), parts=key)
    assert len(slave) == 6
    assert np.flatnonzero(slave.active).tolist() == [1, 4, 5]
    assert slave.area.sum() == pytest.approx(0.5)


def test_an_unknown_part_is_refused_with_those_there_are(deck):
    with pytest.raises(MeshError, match=r"found 9; allowed: 7 \(left half\), 8 \(right half\)"):
        read_mesh(deck(NODES, SHELLS, PARTS), parts=9)


def test_thickness_comes_from_the_section_of_the_part(deck):
    slave = read_mesh(deck(NODES, SHELLS, PARTS, SECTIONS))
    # Node 2 stands on a shell of each part, node 3 on the left one only.
    assert slave.thickness == pytest.approx([2.0, 1.25, 2.0, 2.0, 0.5, 0.5])
    assert mesh_summary(slave)["thickness"] == [0.5, 2.0]


def test_thickness_of_the_chosen_parts_only(deck):
    slave = read_mesh(deck(NODES, SHELLS, PARTS, SECTIONS), parts=8)
    assert slave.thickness == pytest.approx([0, 0.5, 0, 0, 0.5, 0.5])


def test_without_sections_there_is_no_thickness(deck):
    assert read_mesh(deck(NODES, SHELLS, PARTS)).thickness is None


def test_thickness_is_a_length_and_follows_the_unit(deck):
    slave = read_mesh(deck(NODES, SHELLS, PARTS, SECTIONS), unit="mm", file_unit="m")
    assert slave.thickness.max() == pytest.approx(2000.0)


def test_titled_and_layered_sections_and_parts_with_inertia(deck):
    parts = """*PART_INERTIA
left half
         7        70         1
       0.0       0.0       0.0       1.0         1
       1.0       0.0       0.0       1.0       0.0       1.0
       0.0       0.0       0.0
       1.0       0.0       0.0       0.0       1.0       0.0
right half
         8        80         1
       0.0       0.0       0.0       1.0
       1.0       0.0       0.0       1.0       0.0       1.0
       0.0       0.0       0.0
"""
    sections = """*SECTION_SHELL_TITLE
nine layers
        70        16       0.0         9       0.0         0         1
       3.0       3.0       3.0       3.0
       0.0       0.0       0.0       0.0       0.0       0.0       0.0       0.0
      90.0
another
        80         2
       0.5
"""
    slave = read_mesh(deck(NODES, SHELLS, parts, sections))
    assert slave.thickness == pytest.approx([3.0, 1.75, 3.0, 3.0, 0.5, 0.5])


def test_thickness_on_the_element_goes_before_the_section(deck):
    shells = """*ELEMENT_SHELL_THICKNESS
       1       7       1       2       3       4
             4.0             5.0             6.0             7.0
       2       8       2       5       6       6
             0.0             0.0             0.0             0.0
"""
    slave = read_mesh(deck(NODES, shells, PARTS, SECTIONS))
    assert slave.thickness == pytest.approx([4.0, 2.75, 6.0, 7.0, 0.5, 0.5])


def test_nodal_mass_adds_up_and_is_none_where_there_is_none(deck):
    mass = """*ELEMENT_MASS
       1       3             2.5
       2       3             0.5
       3       5             1.0
"""
    assert read_mesh(deck(NODES, SHELLS, mass)).mass == pytest.approx([0, 0, 3.0, 0, 1.0, 0])
    assert read_mesh(deck(NODES, SHELLS)).mass is None


def free(text):
    return "\n".join(
        line if line.startswith(("*", "$")) else ",".join(line.split()) for line in text.split("\n")
    )


def long(text):
    return "\n".join(
        line if line.startswith(("*", "$")) else "".join(f"{f:>20}" for f in line.split())
        for line in text.split("\n")
    )


def test_free_and_long_formats_read_like_the_fixed_one(deck, tmp_path):
    fixed = read_mesh(deck(NODES, SHELLS))
    decks = [deck(free(NODES), free(SHELLS))]
    both = long(NODES) + long(SHELLS)
    (tmp_path / "long.k").write_text(f"*KEYWORD LONG=Y\n{both}*END\n")
    decks.append(tmp_path / "long.k")
    plus = both.replace("*NODE", "*NODE+").replace("*ELEMENT_SHELL", "*ELEMENT_SHELL +")
    decks.append(deck(plus.replace(" +", "+"), name="plus.k"))
    for path in decks:
        slave = read_mesh(path)
        assert np.array_equal(slave.points, fixed.points)
        assert np.array_equal(slave.facets, fixed.facets)


def test_only_plain_cards_are_read_by_columns(deck):
    def plain(*text):
        nodes, elements = list(read_blocks(deck(*text)))
        return (
            lsdyna._node_columns(nodes) is not None,
            lsdyna._element_columns(elements) is not None,
        )

    assert plain(NODES, SHELLS) == (True, True)
    assert plain(free(NODES), SHELLS) == (False, True)
    assert plain(NODES, free(SHELLS)) == (True, False)
    assert plain(long(NODES).replace("*NODE", "*NODE+"), SHELLS) == (False, True)
    assert plain(NODES.replace("             1.0", "             1.x", 1), SHELLS)[0] is False
    assert plain(NODES.replace("             1.0", "             \u0661.0", 1), SHELLS)[0] is False
    assert plain(NODES, SHELLS.replace("SHELL", "SHELL_BETA"))[1] is False
    assert plain(NODES, SHELLS.replace("       6       6\n", "       6\n"))[1] is False


@pytest.mark.parametrize("keyword", ["NODE", "ELEMENT_SHELL", "ELEMENT_SOLID", "ELEMENT_MASS"])
def test_a_keyword_without_cards_says_nothing(deck, keyword):
    slave = read_mesh(deck(NODES, SHELLS, f"*{keyword}\n"))
    assert len(slave.facets) == 3


def test_mass_of_a_set_is_shared_out_to_its_nodes(deck):
    given = """*SET_NODE_LIST
         4
         1         3         5         3
*ELEMENT_MASS_NODE_SET
       1       4             1.5       0
       2       9             7.0       0
*ELEMENT_MASS
       3       3             2.0
"""
    assert read_mesh(deck(NODES, SHELLS, given)).mass == pytest.approx([0.5, 0, 2.5, 0, 0.5, 0])


def test_numbers_in_any_way_fortran_writes_them(deck):
    nodes = NODES.replace("             2.0             0.0", "            .2D1           0.0-3")
    assert read_mesh(deck(nodes, SHELLS)).points[4].tolist() == [2.0, 0.0, 0.0]
    nodes = NODES.replace("             2.0             1.0", "           2.0+0         10.0E-1")
    assert read_mesh(deck(nodes, SHELLS)).points[5].tolist() == [2.0, 1.0, 0.0]


def test_node_numbers_need_not_be_in_order_nor_dense(deck):
    lines = NODES.splitlines(keepends=True)
    nodes = "".join(lines[:2] + lines[:1:-1]).replace("       6  ", "87654321  ")
    slave = read_mesh(deck(nodes, SHELLS.replace("       6       6", "8765432187654321")))
    assert slave.points[0].tolist() == [2.0, 1.0, 0.0]
    assert slave.area.sum() == pytest.approx(1.5)


CUBE = """*NODE
       1             0.0             0.0             0.0
       2             1.0             0.0             0.0
       3             1.0             1.0             0.0
       4             0.0             1.0             0.0
       5             0.0             0.0             1.0
       6             1.0             0.0             1.0
       7             1.0             1.0             1.0
       8             0.0             1.0             1.0
"""


def card(*numbers):
    return "".join(f"{number:8d}" for number in numbers) + "\n"


def test_solids_on_one_card_or_two(deck):
    eight, four = range(1, 9), [1, 2, 4, 5, 5, 5, 5, 5]
    head = "*ELEMENT_SOLID\n"
    one = head + card(1, 2, *eight)
    two = head + card(1, 2) + card(*eight)
    tetra = head + card(1, 2, *four)
    for solids, area in ((one, 6.0), (two, 6.0), (tetra, 1.5 + np.sqrt(3) / 2)):
        slave = read_mesh(deck(CUBE, solids))
        assert slave.area.sum() == pytest.approx(area)


def test_ten_node_tetrahedra(deck):
    nodes = CUBE + "".join(
        f"{i:8d}{x:16.1f}{y:16.1f}{z:16.1f}\n"
        for i, x, y, z in [
            *((11, 0.5, 0, 0), (12, 0.5, 0.5, 0), (13, 0, 0.5, 0)),
            *((14, 0, 0, 0.5), (15, 0.5, 0, 0.5), (16, 0, 0.5, 0.5)),
        ]
    )
    numbers = [1, 2, 4, 5, 11, 12, 13, 14, 15, 16]
    solids = "*ELEMENT_SOLID\n       1       2\n" + "".join(f"{n:8d}" for n in numbers) + "\n"
    slave = read_mesh(deck(nodes, solids))
    assert dict(slave.cells) == {"tetra10": 1}
    assert len(slave.facets) == 16
    assert slave.area.sum() == pytest.approx(1.5 + np.sqrt(3) / 2)


def test_included_files_are_read_in_their_place(deck, tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "nodes.k").write_text(NODES)
    (tmp_path / "shells.k").write_text(SHELLS + "*END\nnot read\n")
    path = deck("*INCLUDE_PATH\nsub\n*INCLUDE\nnodes.k\nshells.k\n", PARTS)
    slave = read_mesh(path)
    assert slave.area.sum() == pytest.approx(1.5)
    assert slave.parts[0].name == "left half"


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        (
            "*INCLUDE\nmissing.k\n",
            FileError,
            r"line 3: \*INCLUDE: no such included file.*missing.k",
        ),
        ("*INCLUDE\na.k\n", FileError, "includes itself"),
        ("*INCLUDE_TRANSFORM\nb.k\n", MeshError, "INCLUDE_TRANSFORM"),
        ("*TITLE\nnothing\n", MeshError, "no nodes"),
        (NODES.replace("             2.0", "             two", 1), MeshError, "line 8.*'two'"),
        (NODES.replace("             2.0", "           &size", 1), MeshError, r"No \*PARAMETER"),
        (
            NODES.replace("             2.0", "             nan", 1),
            MeshError,
            "line 8.*number.*nan",
        ),
        ("*KEYWORD I10=Y\n" + NODES, MeshError, r"\*KEYWORD: fields of ten characters.*LONG=Y"),
        (NODES.replace("*NODE", "*NODE %"), MeshError, r"\*NODE: fields of ten characters"),
        (
            NODES + NODES.replace("1.0", "1.5"),
            MeshError,
            r"line 13: \*NODE: node 2 is given twice, at another place in line 5 of a.k",
        ),
        (NODES + SHELLS.replace("       6       6", "      66      66"), MeshError, "node 66"),
        (NODES + SHELLS.replace("SHELL", "SHELL_COMPOSITE"), MeshError, "COMPOSITE.*THICKNESS"),
        (NODES + "*ELEMENT_SOLID_H20\n1,1\n", MeshError, "ELEMENT_SOLID_H20"),
        (NODES + "*ELEMENT_SOLID\n1,1\n", MeshError, "card with the element's nodes"),
        (NODES + SHELLS.replace("SHELL", "SHELL_OFFSET").rstrip() + "\n", MeshError, None),
    ],
)
def test_bad_decks_are_refused_with_file_and_line(deck, text, kind, message):
    if message is None:
        text = text.rsplit("\n", 2)[0] + "\n"  # a shell without its second card
        message = "each shell takes 2 cards"
    with pytest.raises(kind, match=message) as caught:
        read_mesh(deck(text))
    assert "a.k" in str(caught.value)


PART_1 = "*PART\nhead\n" + "".join(f"{k:10d}" for k in (1, 4, 5)) + "\n"
SECTION_4 = f"*SECTION_SHELL\n{4:10d}{2:10d}\n{0.5:10}\n"


@pytest.mark.parametrize(
    ("given", "again", "message"),
    [
        (PART_1, PART_1.replace("5", "6"), r"line 18: \*PART: part 1 is given"),
        (PART_1, PART_1.replace("head", "neck"), r"line 18: \*PART: part 1 is given"),
        (
            SECTION_4,
            SECTION_4.replace("0.5", "0.6"),
            r"line 18: \*SECTION_SHELL: section 4 is given",
        ),
    ],
)
def test_numbers_are_given_once_or_alike(deck, given, again, message):
    plain = read_mesh(deck(NODES + SHELLS + given))
    alike = read_mesh(deck(NODES + SHELLS + given + "$ again\n" + given.replace("\n*", "   \n*")))
    assert [part.label for part in alike.parts] == [part.label for part in plain.parts]
    with pytest.raises(MeshError, match=rf"{message} twice, otherwise in line 15 of a\.k"):
        read_mesh(deck(NODES + SHELLS + given + again))


def test_a_file_without_keywords_is_no_deck(tmp_path):
    path = tmp_path / "a.key"
    path.write_text("hello\n")
    with pytest.raises(FileError, match="not an LS-DYNA keyword deck"):
        read_mesh(path)


THREE_NODES = "".join(
    f"{number:8d}{x:16.6f}{y:16.6f}{0.0:16.6f}\n"
    for number, x, y in ((1, 0.0, 0.0), (2, 1.0, 0.0), (3, 0.0, 1.0))
)
ONE_SHELL = "       1       1       1       2       3       3\n"


@pytest.mark.parametrize("node", ["*NODE", "*node"])
@pytest.mark.parametrize("shell", ["*ELEMENT_SHELL", "*Element_Shell"])
def test_keywords_may_be_in_small_letters(tmp_path, node, shell):
    path = tmp_path / "deck.k"
    path.write_text(f"*KEYWORD\n{node}\n{THREE_NODES}{shell}\n{ONE_SHELL}*END\n")
    mesh = read_mesh(path)
    assert mesh.points.tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    assert mesh.facets.tolist() == [[0, 1, 2]]


def test_nodes_that_are_moved_by_a_card_are_refused(tmp_path):
    path = tmp_path / "deck.k"
    path.write_text(f"*KEYWORD\n*NODE_TRANSFORM\n       1       1\n*NODE\n{THREE_NODES}*END\n")
    with pytest.raises(FileError, match="NODE_TRANSFORM, which is not carried out"):
        read_mesh(path)
