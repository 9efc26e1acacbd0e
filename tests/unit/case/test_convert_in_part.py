"""Decks understood in part: what counts is taken as LS-DYNA does, the rest is listed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.decks import (
    CONTACT,
    END,
    FLIGHT,
    FOAM,
    PARTS,
    RIGID,
    card,
    converted,
    deck,
    mesh,
    sphere,
)

from contiga.case import deck_parts
from contiga.errors import ContigaWarning, FileError, MeshError

BOLT = ["*PART", "bolt", card(3, 12, 23)]
STIFF = ["*MAT_RIGID", card(23, 7.8e-6, 210.0, 0.3), card(1, 7, 7), ""]
FOAM_AND_BOLT = ["*SET_PART_LIST", card(9), card(2, 3)]


def bolt_in_the_pad() -> list[str]:
    """The last solid of the pad as an element of part 3."""
    lines = mesh()
    return [*lines[:-1], lines[-1][:8] + f"{3:8d}" + lines[-1][16:]]


def contact(*sides: int, rub: tuple[float, ...] = (0.4,), kind: str = "SURFACE_TO_SURFACE") -> list:
    return [f"*CONTACT_AUTOMATIC_{kind}", card(*sides), card(*rub), ""]


@pytest.mark.parametrize(
    "sides",
    [contact(1, 9, 3, 2), contact(9, 1, 2, 3), contact(0, 0, 5, 0, kind="SINGLE_SURFACE")],
)
def test_every_rigid_part_meets_what_is_on_the_other_side(tmp_path: Path, sides: list) -> None:
    pieces = [*bolt_in_the_pad(), *BOLT]
    text = deck(pieces, RIGID, STIFF, FOAM, FOAM_AND_BOLT, sides, END)
    text = text.replace("\n".join(mesh()) + "\n", "")
    case, _ = converted(tmp_path, text)
    pairs = {frozenset((c.master, c.slave.removesuffix(" points"))) for c in case.contact}
    expected = {frozenset(("head form", "foam pad")), frozenset(("head form", "bolt"))}
    if "SINGLE" in sides[0]:
        expected.add(frozenset(("bolt", "foam pad")))
    assert pairs == expected
    assert len(case.contact) == len(expected)
    rigid = [c.master for c in case.contact if c.slave == "foam pad"]
    assert "head form" in rigid


def start(folder: Path, *pieces: list[str], parts: list[str] = PARTS) -> tuple[list[float], str]:
    """Velocity at the start of the head form, and the text of its case."""
    case, text = converted(folder, deck(RIGID, FOAM, CONTACT, END, *pieces, parts=parts))
    return case.body[0].motion.velocity, text


def generated(number: int, kind: int, *more: float, rigid: int = 0) -> list[str]:
    last = card(0, 0, 0, 0, 0, 0, 0, rigid)
    return [FLIGHT[0], card(number, kind, 0.0, 0.0, 0.0, -2.0, *more), last]


REST = [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("pieces", "velocity", "why"),
    [
        (generated(77, 1), REST, "(there is no set of parts 77)"),
        (generated(0, 1), [0.0, 0.0, -2.0], ""),
        (generated(1, 2, 0, 4), REST, "(in axes of its own, ICID)"),
        (["*INITIAL_VELOCITY", card(0), card(0, 0, -3)], [0.0, 0.0, -3.0], ""),
        (["*INITIAL_VELOCITY", card(0, 0, 9), card(0, 0, -3)], REST, "(in box 9 only, BOXID)"),
        (["*INITIAL_VELOCITY", card(0, 0, 0, 0, 4), card(0, 0, -3)], REST, "ICID)"),
        (["*INITIAL_VELOCITY_RIGID_BODY", card(1, 0, 0, -3, 0, 0, 0, 4)], REST, "ICID)"),
    ],
)
def test_a_start_is_that_of_the_parts_it_is_said_of(
    tmp_path: Path, pieces: list[str], velocity: list[float], why: str
) -> None:
    found, text = start(tmp_path, pieces)
    assert found == velocity
    assert why in text
    assert ("Not understood" in text) == bool(why)


def of_nodes(count: int, *rates: float, last: tuple[float, ...] | None = None) -> list[str]:
    """Velocities of the first nodes, which are those of the head form."""
    cards = [card(k, *rates) for k in range(1, count + 1)]
    return ["*INITIAL_VELOCITY_NODE", *cards[:-1], card(count, *(last or rates))]


HEAD = len(sphere()[0])


@pytest.mark.parametrize(
    ("pieces", "velocity", "left"),
    [
        (of_nodes(HEAD, 0, 0, -2.5), [0.0, 0.0, -2.5], 0),
        (of_nodes(HEAD + 9, 0, 0, -2.5), [0.0, 0.0, -2.5], 9),
        (of_nodes(HEAD - 1, 0, 0, -2.5), REST, HEAD - 1),
        (of_nodes(HEAD, 0, 0, -2.5, last=(0, 0, -3)), REST, HEAD),
        (of_nodes(HEAD, 0, 0, -2.5, 0, 0, 1), REST, HEAD),
    ],
)
def test_velocities_of_nodes_are_those_of_the_part_they_make_up(
    tmp_path: Path, pieces: list[str], velocity: list[float], left: int
) -> None:
    found, text = start(tmp_path, pieces)
    assert found == velocity
    assert (f"({left} nodes, first " in text) == bool(left)
    assert ("Not understood" in text) == bool(left)


def test_nodes_come_between_their_part_and_all(tmp_path: Path) -> None:
    nodes, everything = of_nodes(HEAD, 0, 0, -2.5), ["*INITIAL_VELOCITY", card(0), card(0, 0, -3)]
    assert start(tmp_path, nodes, everything)[0] == [0.0, 0.0, -2.5]
    part = ["*INITIAL_VELOCITY_RIGID_BODY", card(1, 0, 0, -4)]
    assert start(tmp_path, nodes, part)[0] == [0.0, 0.0, -4.0]


OWN = [
    "*PART_INERTIA", "head form", card(1, 11, 21), card(0.0, 0.0, 20.5, 0.08),
    card(20.0, 0.0, 0.0, 20.0, 0.0, 20.0), card(0.0, 0.0, -5.0), *PARTS[3:],
]  # fmt: skip


@pytest.mark.parametrize(
    ("pieces", "speed"),
    [
        (generated(1, 2), -5.0),
        (generated(1, 2, rigid=1), -2.0),
        (["*INITIAL_VELOCITY", card(0), card(0, 0, -3)], -5.0),
        (["*INITIAL_VELOCITY", card(0, 0, 0, -1), card(0, 0, -3)], -3.0),
        (["*SET_PART", card(4), card(1), "*INITIAL_VELOCITY", card(0, 0, 0, 4), card(0, 0, -3)],
         -3.0),
        (["*INITIAL_VELOCITY_RIGID_BODY", card(1, 0, 0, -4)], -4.0),
    ],
)  # fmt: skip
def test_rates_of_a_part_hold_unless_irigid_says_otherwise(
    tmp_path: Path, pieces: list[str], speed: float
) -> None:
    velocity, text = start(tmp_path, pieces, parts=OWN)
    assert velocity == [0.0, 0.0, speed]
    assert ("(part 1 has that of its *PART_INERTIA, IRIGID)" in text) == (speed == -5.0)


def push(kind: int, *more: float) -> list[str]:
    return ["*BOUNDARY_PRESCRIBED_MOTION_RIGID", card(1, 3, kind, 5, 1.0, *more)]


def curve(*points: tuple[float, float], head: str = card(5)) -> list[str]:
    return ["*DEFINE_CURVE", head, *(f"{x:20}{y:20}" for x, y in points)]


RAMP = curve((0.0, 0.0), (4.0, 1.0))
TURNING = ["*INITIAL_VELOCITY_RIGID_BODY", card(1, 0.5, 0.0, -2.0, 0.0, 0.1, 0.0)]


def motion(folder: Path, *pieces: list[str]) -> tuple:
    """The motion of the head form, and the text of its case."""
    case, text = converted(folder, deck(RIGID, FOAM, CONTACT, *pieces, END))
    return case.body[0].motion, text


def test_what_is_accelerated_starts_with_its_velocity(tmp_path: Path) -> None:
    found, text = motion(tmp_path, push(1), RAMP, TURNING)
    assert found.velocity == [0.5, 0.0, -2.0]
    assert "its other ways go on as they start" in text
    assert "(part 1 starts with a spin about y, which is left out)" in text
    _, text = motion(tmp_path, push(0), RAMP, TURNING)
    assert "(part 1 starts with vx, a spin about y, which is left out)" in text


@pytest.mark.parametrize("kind", [0, 2])
def test_a_step_in_a_curve_stays_one(tmp_path: Path, kind: int) -> None:
    found, _ = motion(tmp_path, push(kind), curve((0, 0), (2, 0.5), (2, 1), (4, 1)))
    times, values = np.array(found.table)[:, [0, 3]].T
    assert times.tolist() == [0.0, pytest.approx(2.0, rel=1e-5), 2.0, 4.0]
    assert times[1] < 2.0
    np.testing.assert_allclose(values, [0.0, 0.5, 1.0, 1.0], rtol=1e-5)


def test_times_that_fall_are_turned_round_or_listed(tmp_path: Path) -> None:
    points = (-4.0, 0.0), (-2.0, 7.0), (0.0, 1.0)
    found, text = motion(tmp_path, push(0), curve(*points, head=card(5, 0, -1.0)))
    assert found.table == [[0, 0, 0, 1], [2, 0, 0, 7], [4, 0, 0, 0]]
    assert "Not understood" not in text
    for bad, why in (
        (((0, 1), (3, 2), (2, 3)), "the times of curve 5 fall"),
        (
            (),
            "curve 5 has no points",
        ),
    ):
        found, text = motion(tmp_path, push(0), curve(*bad))
        assert found.kind == "free"
        assert f"(part 1, {why})" in text


@pytest.mark.parametrize(
    ("life", "why"),
    [
        ((0, 1e28, 0.0), ""),
        ((0, 4.0), ""),
        ((0, 2.0), "(part 1, DEATH 2: the motion goes on)"),
        ((0, 0.0, 1.0), "(part 1, BIRTH 1: it moves before, too)"),
    ],
)
def test_a_life_is_listed_where_it_is_shorter_than_the_run(
    tmp_path: Path, life: tuple[float, ...], why: str
) -> None:
    _, text = motion(tmp_path, push(0, *life), RAMP)
    assert why in text
    assert ("Not understood" in text) == bool(why)


@pytest.mark.parametrize(
    ("rub", "sides", "why"),
    [
        ((-1.0, 0.3), (), "(FS -1, friction of parts or by a table)"),
        ((0.2, 0.3, 0.01), (), "(FD 0.3 beside FS 0.2, DC is left out)"),
        ((0.4, 0.3, 0.01, 20.0), (), "(VC 20.0)"),
        ((0.4,), (7,), "(SBOXID 7)"),
        ((0.4, 0.4, 0.0, 0.0, 0.0, 0, 0.0, 3.0), (), "(BT and DT, it lasts all the time)"),
        ((0.4, 0.4, 0.0, 0.0, 0.0, 0, 0.0, 1e20), (), ""),
        ((0.4, 0.3, 0.01), (), ""),
    ],
)
def test_of_a_contact_what_is_left_out_is_listed(
    tmp_path: Path, rub: tuple[float, ...], sides: tuple[int, ...], why: str
) -> None:
    _, text = converted(tmp_path, deck(RIGID, FOAM, contact(2, 1, 3, 3, *sides, rub=rub), END))
    assert why in text
    assert ("Not understood" in text) == bool(why)


def test_what_only_begins_like_a_part_is_listed(tmp_path: Path) -> None:
    more = ["*PARTICLE_BLAST", "1", "*PART_MOVE", card(1, 0.0, 0.0, 5.0), "*PART_PRINT"]
    _, text = start(tmp_path, more)
    assert "*PARTICLE_BLAST, line" in text
    assert "*PART_MOVE, line" in text
    assert "*PART_PRINT" not in text


AMPERSAND = card(7, 0, "&scale")


def test_parameters_that_nothing_needs_are_listed(tmp_path: Path) -> None:
    lost = [
        *curve((0.0, 0.0), (4.0, 1.0), head=AMPERSAND), "*SET_NODE_LIST", card(6), card("&first"),
        "*SET_PART_LIST", card(6), card("&first"), "*PART", "bracket", card(8, 8, "&steel"),
        "*SECTION_SHELL", card(8, 2), card("&t"),
    ]  # fmt: skip
    with pytest.warns(ContigaWarning, match="a parameter without a value"):
        _, text = start(tmp_path, lost)
    for keyword in ("DEFINE_CURVE", "SET_NODE_LIST", "SET_PART_LIST", "PART", "SECTION_SHELL"):
        assert f"*{keyword} (a parameter without a value), line" in text


def test_a_curve_with_parameters_that_a_body_needs_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match=r"\*DEFINE_CURVE: .*found '&scale'.*write the deck out"):
        motion(tmp_path, push(0), curve((0, 0), (4, 1), head=card(5, 0, "&scale")))


def test_a_rigid_part_with_parameters_is_none(tmp_path: Path) -> None:
    unsure = [*OWN[:3], card(0.0, 0.0, 20.5, "&mass"), *OWN[4:]]
    with pytest.raises(FileError, match=r"1 \*PART_INERTIA \(a parameter"), pytest.warns():
        start(tmp_path, parts=unsure)


def test_a_blank_title_is_a_card(tmp_path: Path) -> None:
    titled = ["*DEFINE_CURVE_TITLE", "", *RAMP[1:]]
    sides = ["*SET_PART_LIST_TITLE", "", card(4), card(1)]
    side = contact(2, 4, 3, 2)
    case, _ = converted(tmp_path, deck(RIGID, FOAM, sides, side, push(0), titled, END))
    assert case.body[0].motion.table == [[0, 0, 0, 0], [4, 0, 0, 1]]
    named = [push(0)[0] + "_ID", "", *push(0)[1:]]
    found, _ = motion(tmp_path, named, RAMP)
    assert found.table == [[0, 0, 0, 0], [4, 0, 0, 1]]


@pytest.mark.parametrize("section", [[card(11, 2), card(0.0)], [card(19, 2), card(2.0)]])
def test_shells_without_thickness_are_told(tmp_path: Path, section: list[str]) -> None:
    thick, _ = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END))
    at = PARTS.index("*SECTION_SHELL")
    thin = [*PARTS[: at + 1], *section, *PARTS[at + 3 :]]
    case, text = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END, parts=thin))
    assert case.body[0].mass.total == pytest.approx(thick.body[0].mass.total / 2.0, rel=1e-12)
    assert "at a thickness of 1, as the deck has none: set it" in text
    assert "(part 1, its shells have no thickness: 1 is taken for its mass), line" in text


def test_shells_may_have_a_thickness_of_their_own(tmp_path: Path) -> None:
    lines, text = mesh(), deck(RIGID, FOAM, CONTACT, END)
    thick, _ = converted(tmp_path, text)
    first, last = lines.index("*ELEMENT_SHELL"), lines.index("*ELEMENT_SOLID")
    own = ["*ELEMENT_SHELL_THICKNESS"]
    for shell in lines[first + 1 : last]:
        own += [shell, "".join(f"{4.0:16}" for _ in range(4))]
    case, _ = converted(tmp_path, text.replace("\n".join(lines[first:last]), "\n".join(own)))
    assert case.body[0].mass.total == pytest.approx(2.0 * thick.body[0].mass.total, rel=1e-12)


def test_the_mesh_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reads = []
    read = deck_parts.read_raw
    monkeypatch.setattr(deck_parts, "read_raw", lambda path: reads.append(path) or read(path))
    monkeypatch.setattr("contiga.io.mesh.read_mesh.read_raw", lambda path: pytest.fail("again"))
    converted(tmp_path, deck(RIGID, FOAM, CONTACT, CONTACT, END))
    assert len(reads) == 1


def test_lines_of_included_files_name_the_file(tmp_path: Path) -> None:
    inner = ["*KEYWORD", "*CONTROL_TIMESTEP", card(0.0, 0.9), *RIGID]
    (tmp_path / "stiff.k").write_text("\n".join(inner) + "\n", encoding="utf-8")
    _, text = converted(tmp_path, deck(["*INCLUDE", "stiff.k"], FOAM, CONTACT, END))
    assert "1 *CONTROL_TIMESTEP of stiff.k, line 2" in text
    assert "*MAT_RIGID in line 4 of stiff.k" in text
