"""No field of a deck is passed over in silence: it counts in the case, or it is listed."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.decks import UNITS, box, card

from contiga.case.convert import Converted, convert
from contiga.errors import ContigaError
from contiga.io.mesh.lsdyna import read_lsdyna


@pytest.fixture(autouse=True)
def _meshes_are_read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not in a process of their own, which takes most of the time."""
    monkeypatch.setattr(
        "contiga.io.mesh.read_mesh.read_in_worker", lambda reader, path: read_lsdyna(path)
    )


CURVE = ["*DEFINE_CURVE", card(5), *(f"{x:20}{y:20}" for x, y in ((0, 0), (0.5, 1e-3), (0.9, 1)))]
BASE: dict[str, list[str]] = {
    "CONTROL_TERMINATION": [card(5.0)],
    "DATABASE_BINARY_D3PLOT": [card(0.5)],
    "PART_INERTIA": [
        "head", card(1, 1, 1), card(0, 0, 11, 4.5), card(90, 0, 0, 90, 0, 90), card(0, 0, -2),
    ],
    "PART": ["pad", card(2, 3, 2)],
    "SECTION_SOLID": [card(3, 1)],
    "MAT_RIGID": [card(1, 7.8e-6, 210, 0.3), card(1, 0, 7), ""],
    "MAT_LOW_DENSITY_FOAM": [card(2, 1e-7, 0.01, 5, "", 0.1), card(6.0)],
    "SET_NODE_LIST": [card(9), card(11, 12, 13, 14)],
    "BOUNDARY_SPC_SET": [card(9, 0, 1, 1, 1)],
    "CONTACT_AUTOMATIC_SURFACE_TO_SURFACE": [
        card(2, 1, 3, 3), card(0.3, 0.2, 0.1), card(1), card(0), card(0),
    ],
    "INITIAL_VELOCITY_RIGID_BODY": [card(1, 0, 0, -3.0)],
    "LOAD_BODY_Z": [card(8, 0.01)],
}  # fmt: skip
NO_PART = {
    "CONTACT_AUTOMATIC_SURFACE_TO_SURFACE": {(0, 6), (0, 7), (3, 6), (3, 7)},  # printing, sorting
    "DATABASE_BINARY_D3PLOT": {(0, 1), (0, 2), (0, 4), (0, 5)},  # what is in the files
    "MAT_RIGID": {(2, k) for k in range(6)}  # axes of printed results
    | {(0, 1), (0, 2), (0, 3)},  # of a master that has its own inertia
    "BOUNDARY_SPC_SET": {(0, 5), (0, 6), (0, 7)},  # turns: nodes of a case have none
    "SET_NODE_LIST": {(0, 6), *((1, k) for k in range(8))},  # the case names the set alone
    # Solids have no need of their section.
    "SECTION_SOLID": {(0, 0)},
    "PART": {(1, 1)},
    "PART_CONTACT": {(1, 1)},
    "PART_INERTIA": {(1, 1)},
    "MAT_PIECEWISE_LINEAR_PLASTICITY": {(0, 1)},  # the density of a part that rests
}
"""Fields that have no part in the case of these decks."""
OTHER: dict[str, dict[str, list[str]]] = {
    "MAT_ELASTIC": {"MAT_LOW_DENSITY_FOAM": [], "MAT_ELASTIC": [card(2, 1e-7, 0.01, 0.3)]},
    "MAT_MOONEY-RIVLIN_RUBBER": {
        "MAT_LOW_DENSITY_FOAM": [],
        "MAT_MOONEY-RIVLIN_RUBBER": [card(2, 1e-7, 0.4, 1e-3, 1e-4), card(0)],
    },
    "MAT_PIECEWISE_LINEAR_PLASTICITY": {
        "MAT_LOW_DENSITY_FOAM": [],
        "MAT_PIECEWISE_LINEAR_PLASTICITY": [card(2, 1e-7, 0.4, 0.3), card(0), card(0), card(0)],
    },
    "PART_CONTACT": {"PART": [], "PART_CONTACT": ["pad", card(2, 3, 2), card(0)]},
    "BOUNDARY_PRESCRIBED_MOTION_RIGID": {"BOUNDARY_PRESCRIBED_MOTION_RIGID": [card(1, 3, 2, 8)]},
    "INITIAL_VELOCITY": {
        "INITIAL_VELOCITY_RIGID_BODY": [], "INITIAL_VELOCITY": [card(0), card(0, 0, -3.0)],
    },
    "INITIAL_VELOCITY_GENERATION": {
        "INITIAL_VELOCITY_RIGID_BODY": [],
        "INITIAL_VELOCITY_GENERATION": [card(1, 2, 0, 0, 0, -3.0), card(0, 0, 0, 0, 0, 0, 0, 1)],
    },
    "CONSTRAINED_EXTRA_NODES_SET": {
        "BOUNDARY_SPC_SET": [], "CONSTRAINED_EXTRA_NODES_SET": [card(1, 9)],
    },
    "DEFINE_CURVE": {
        "BOUNDARY_PRESCRIBED_MOTION_RIGID": [card(1, 3, 2, 8)],
        "DEFINE_CURVE": [card(8), "0.0, 0.5", "9.0, 1.0"],
        "LOAD_BODY_Z": [],
    },
    "SECTION_SHELL": {
        "SECTION_SHELL": [card(7, 2), card(1.0)],
        "PART_INERTIA": [],
        "PART": ["pad", card(2, 3, 2), "head", card(1, 7, 1)],
        "ELEMENT_SHELL": ["".join(f"{k:8d}" for k in (7, 1, 1, 2, 4, 3))],
    },
    "PART_INERTIA": {"INITIAL_VELOCITY_RIGID_BODY": []},
}  # fmt: skip


def text_of(cards: dict[str, list[str]]) -> str:
    blocks = [line for name, rows in cards.items() if rows for line in (f"*{name}", *rows)]
    mesh = [*box(1, 1, 1, 1.0, 21.0), *box(11, 2, 2, -20.0, 0.0)]
    level = ["*DEFINE_CURVE", card(8), "0.0, 1.0", "9.0, 1.0"] * ("DEFINE_CURVE" not in cards)
    return "\n".join(["*KEYWORD", *blocks, *mesh, *CURVE, *level, "*END", ""])


def made(folder: Path, cards: dict[str, list[str]]) -> Converted:
    (folder / "deck.k").write_text(text_of(cards), encoding="utf-8")
    return convert(folder / "deck.k", UNITS, folder)


def listed(folder: Path, cards: dict[str, list[str]]) -> str:
    return " ".join(made(folder, BASE | cards).unknown)


def changed(row: str, field: int, value: object) -> str:
    fields = [row[10 * k : 10 * k + 10].strip() for k in range(8)]
    fields[field] = str(value)
    return card(*fields)


@pytest.mark.parametrize("keyword", sorted({*BASE, *OTHER}))
def test_every_field_counts_or_is_listed(tmp_path: Path, keyword: str) -> None:
    cards = BASE | OTHER.get(keyword, {})
    plain = made(tmp_path, cards)

    def is_reported(rows: list[str]) -> bool:
        try:
            other = made(tmp_path, cards | {keyword: rows})
        except ContigaError:
            return True
        return other[:4] != plain[:4]

    silent = []
    rows = cards[keyword]
    for k, row in enumerate(rows):
        for field in range(8) if row[:1] in (" ", "") else ():
            others = [[*rows[:k], changed(row, field, v), *rows[k + 1 :]] for v in (3, 7, "")]
            if not any(map(is_reported, others)):
                silent.append((k, field))
    assert set(silent) == NO_PART.get(keyword, set())


def test_a_deck_of_what_is_read_lists_nothing(tmp_path: Path) -> None:
    assert made(tmp_path, BASE).unknown == {}


DEFAULTS: dict[str, list[str]] = {
    "CONTACT_AUTOMATIC_SURFACE_TO_SURFACE": [
        card(2, 1, 3, 3), card(0.3, 0.2, 0.1, 0.0, 0.0, 0, 0.0, "1.0E+20"),
        card("1.0", 1, 0.0, 0, "1.", 1.0, 1.0, 1.0), card(0, 0.1, 0, 1.025, "2.0", 2, 10, 1),
        card(0), card(1), card(0), card(0, 0, 0, 0, 1.0), card(0, 0, 2.0),
    ],
    "MAT_LOW_DENSITY_FOAM": [card(2, 1e-7, 0.01, 5, "1.0E20", 0.1, 0, 0.05), card(6.0, 0, 0)],
    "LOAD_BODY_Z": [card(8, 0.01, 0, "0.0", 0, 0, 0, 0)],
    "CONTROL_TERMINATION": [card(5.0, 0, "0.0", 0, 1e8, 0, 0, 0)],
    "PART_INERTIA": [
        "head", card(1, 1, 1, 0, 0, 0, 0, 0), card(0, 0, 11, 4.5, 0, 0, 0, 0),
        card(90, 0, 0, 90, 0, 90, 0, "0.0"), card(0, 0, -2, 0, 0, 0, 0, 0),
    ],
    "SET_NODE_LIST": [card(9, 0.0, 0.0, 0.0, 0.0, "MECH"), card(11, 12, 13, 14)],
    "DEFINE_CURVE": [card(8, 0, 1.0, 1.0, 0.0, 0.0), "0.0, 1.0", "9.0, 1.0"],
    "SECTION_SHELL": [card(7, 2, 1.0, 2, 1.0, 0, 0, 1), card(1.0, 1.0, 1.0, 1.0, 0.0)],
}  # fmt: skip


@pytest.mark.parametrize("keyword", DEFAULTS)
def test_a_default_that_is_written_out_is_not_listed(tmp_path: Path, keyword: str) -> None:
    assert listed(tmp_path, {keyword: DEFAULTS[keyword]}) == ""


@pytest.mark.parametrize(
    ("keyword", "rows", "what"),
    [
        (
            "MAT_LOW_DENSITY_FOAM",
            [card(2, 1e-7, 0.01, 5, 1e-5, 0.1, 0.3, 0.2), card(6.0, 1.0)],
            "(TC 1e-05, BETA 0.3, DAMP 0.2, FAIL 1.0)",
        ),
        ("SECTION_SOLID", [card(3, -1)], "(ELFORM -1)"),
        ("SECTION_SHELL_MISC", [card(7, 16), card(1.0), card(0.5)], "(ELFORM 16, THKSCL 0.5)"),
        ("PART", ["pad", card(2, 3, 2, 0, 4)], "(HGID 4)"),
        ("CONTROL_TERMINATION", [card(5.0, 900)], "(ENDCYC 900)"),
        ("LOAD_BODY_Z", ["8, 0.01, &late"], "(LCIDDR &late)"),
        ("LOAD_BODY_Z", ["8, 0.01,,,,,,,1.5"], "(field 9 1.5)"),
        ("CONTROL_TERMINATION", [card(5.0), card(0, 2.5)], "(card 2: 0 2.5)"),
    ],
)
def test_names_and_values_are_said(
    tmp_path: Path, keyword: str, rows: list[str], what: str
) -> None:
    assert listed(tmp_path, {keyword: rows}) == f"*{keyword} {what}"


@pytest.mark.parametrize(
    ("third", "more", "what"),
    [
        (card(1, 0.5, 0.1, 0.2, 0.9, 0.8), [], "SFM 0.5, SST 0.1, MST 0.2, SFST 0.9, SFMT 0.8"),
        (card(1), [card(2, 0.3)], "SOFT 2, SOFSCL 0.3"),
        (card(1), [card(0), card(0), card(1, 2)], "IGNORE 2"),
    ],
)
def test_of_a_contact_its_optional_cards(
    tmp_path: Path, third: str, more: list[str], what: str
) -> None:
    name = "CONTACT_AUTOMATIC_SURFACE_TO_SURFACE"
    rows = [*BASE[name][:2], third, *more]
    assert listed(tmp_path, {name: rows}) == f"*{name} ({what})"


def test_many_cards_alike_are_one_entry_with_their_first_values(tmp_path: Path) -> None:
    rows = [row for k in range(1, 8) for row in ("*MAT_ELASTIC", card(20 + k, 1, 1, 0.3, k))]
    unknown = made(tmp_path, BASE | {"MAT_ELASTIC": rows[1:]}).unknown
    assert [(name, len(lines)) for name, lines in unknown.items()] == [
        ("*MAT_ELASTIC (DA 1/2/3/4/…)", 7)
    ]


def test_nodes_that_are_held_on_their_own_cards_are_listed(tmp_path: Path) -> None:
    text = text_of(BASE)
    node = next(line for line in text.splitlines() if line.startswith("      11    "))
    (tmp_path / "deck.k").write_text(text.replace(node, f"{node}{7:8d}{0:8d}"), encoding="utf-8")
    assert list(convert(tmp_path / "deck.k", UNITS, tmp_path).unknown) == ["*NODE (TC 7)"]


@pytest.mark.parametrize(
    ("keyword", "more", "what"),
    [
        ("ELEMENT_SHELL_BETA", [f"{1.0:16}{1.0:16}{1.0:16}{1.0:16}{45.0:16}"], "BETA 45.0"),
        ("ELEMENT_SHELL_OFFSET", [f"{0.25:16}"], "OFFSET 0.25"),
        ("ELEMENT_SHELL_THICKNESS", [f"{1.0:16}{1.0:16}{1.0:16}{1.0:16}{0.0:16}"], ""),
    ],
)
def test_what_elements_say_beside_the_mesh_is_listed(
    tmp_path: Path, keyword: str, more: list[str], what: str
) -> None:
    shell = "".join(f"{k:8d}" for k in (7, 5, 1, 2, 4, 3))
    assert listed(tmp_path, {keyword: [shell, *more]}) == (f"*{keyword} ({what})" if what else "")


TWICE = {
    "INITIAL_VELOCITY_RIGID_BODY": ([card(1, 0, 0, -3.0), card(1, 0, 0, -4.0)], "part 1"),
    "BOUNDARY_PRESCRIBED_MOTION_RIGID": ([card(1, 3, 2, 8), card(1, 3, 2, 5)], "DOF 3 again"),
    "INITIAL_VELOCITY_NODE": ([card(1, 0, 0, -3.0), card(1, 0, 0, -4.0)], "node 1"),
}


@pytest.mark.parametrize("keyword", TWICE)
def test_of_two_loads_of_one_kind_the_one_that_is_lost_is_told(
    tmp_path: Path, keyword: str
) -> None:
    rows, what = TWICE[keyword]
    assert what in listed(tmp_path, {keyword: rows})
    assert what not in listed(tmp_path, {keyword: rows[:1]})


def test_gravity_that_is_given_twice_is_told(tmp_path: Path) -> None:
    deck = made(tmp_path, BASE | {"LOAD_BODY_Z+": [f"{8:20}{0.02:20}"]})
    assert "*LOAD_BODY_Z (again in line" in " ".join(deck.unknown)
    assert "gravity = [0.0, 0.0, -0.02]" in deck.text


@pytest.mark.parametrize(
    ("cards", "why"),
    [
        ({"SET_NODE_LIST": [], "SET_NODE_GENERAL": [card(9), card("PART", 2)]},
         "set 9 is a *SET_NODE_GENERAL, line"),
        ({"SET_NODE_LIST": []}, "there is no set of nodes 9"),
    ],
)  # fmt: skip
def test_a_set_that_is_not_understood_is_named_where_it_is_needed(
    tmp_path: Path, cards: dict[str, list[str]], why: str
) -> None:
    more = {
        "CONTACT_NODES_TO_SURFACE": [card(9, 1, 4, 3), card(0.1), ""],
        "ELEMENT_MASS_NODE_SET": [f"{1:8d}{9:8d}{2.5:16}"],
    }
    found = listed(tmp_path, more | cards)
    for name in ("CONTACT_NODES_TO_SURFACE", "BOUNDARY_SPC_SET", "ELEMENT_MASS_NODE_SET"):
        assert f"*{name} ({why}" in found


@pytest.mark.parametrize(
    ("rows", "interval"),
    [([card(0.001)], 0.025), ([card(0.5)], 0.5), ([card(0, 0, 0, 20)], 0.25), ([], 0.025)],
)
def test_a_case_writes_no_more_than_two_hundred_states(
    tmp_path: Path, rows: list[str], interval: float
) -> None:
    deck = made(tmp_path, BASE | {"DATABASE_BINARY_D3PLOT": rows})
    assert f"[output]\ninterval = {interval:g}" in deck.text
    assert ("# *DATABASE_BINARY_D3PLOT" in deck.text) == (interval > 0.025)


def in_commas(row: str) -> str:
    return ",".join(row[k : k + 10].strip() for k in range(0, len(row), 10))


def wide(row: str) -> str:
    return "".join(f"{row[k : k + 10]:>20}" for k in range(0, len(row), 10))


@pytest.mark.parametrize(("spelt", "plus"), [(in_commas, ""), (wide, "+"), (str, "")])
@pytest.mark.parametrize("keyword", [str.upper, str.lower])
def test_formats_say_the_same_and_leave_the_same(
    tmp_path: Path, spelt: Callable[[str], str], plus: str, keyword: Callable[[str], str]
) -> None:
    cards = BASE | {"MAT_LOW_DENSITY_FOAM": [card(2, 1e-7, 0.01, 5, 1e-5, 0.1), card(6.0, 1)]}
    other = {
        keyword(name) + plus: [spelt(row) if row[:1] == " " else row for row in rows]
        for name, rows in cards.items()
    }
    plain, same = made(tmp_path, cards), made(tmp_path, other)
    assert same.text == plain.text
    assert same.unknown == plain.unknown
    assert list(plain.unknown) == ["*MAT_LOW_DENSITY_FOAM (TC 1e-05, FAIL 1)"]
