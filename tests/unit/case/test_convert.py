"""Keyword decks as cases: what is understood comes out as the deck says it, the rest is listed."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from tests.decks import (
    CONTACT,
    DENSITY,
    END,
    FLIGHT,
    FOAM,
    FULL,
    PARTS,
    RADIUS,
    RIGID,
    THICKNESS,
    UNITS,
    card,
    converted,
    deck,
)

import contiga as cg
from contiga.case.convert import convert, parse_units
from contiga.errors import FileError, InputError, MeshError, UnitError


def test_a_rigid_part_flies_onto_a_pad(tmp_path: Path) -> None:
    case, text = converted(tmp_path, FULL)
    assert (case.title, case.time.end, case.time.step) == ("Head onto foam", 4.0, "auto")
    (body,), (slave,), (contact,) = case.body, case.slave, case.contact
    assert (body.name, slave.name) == ("head form", "foam pad")
    assert (contact.master, contact.slave) == ("head form", "foam pad")
    assert body.motion.velocity == [0.0, 0.0, -2.0]
    assert body.motion.hold == ["rx", "ry", "rz"]
    friction = contact.friction
    assert (friction.static, friction.dynamic, friction.decay) == (0.4, 0.3, 0.01)
    # Bulk modulus 0.003 / 3, a tenth of it over facets of 5: two a square, halves of its area.
    facets = cg.read_mesh(tmp_path / "deck.k", parts=[2])
    assert contact.law.stiffness == pytest.approx(1e-4 / np.sqrt(2.0 * mean_area(facets)), rel=1e-5)
    assert "Not understood" not in text
    simulation = cg.build(case)
    assert simulation.bodies["head form"].body.closed


def mean_area(slave: cg.Slave) -> float:
    corners = slave.points[slave.facets]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(0.5 * np.linalg.norm(cross, axis=1).mean())


def test_shells_weigh_what_a_shell_weighs(tmp_path: Path) -> None:
    case, _ = converted(tmp_path, FULL)
    mass = case.body[0].mass
    mesh = cg.read_master(tmp_path / "deck.k", parts=[1])
    assert mass.total == pytest.approx(mesh.area() * THICKNESS * DENSITY, rel=1e-12)
    assert mass.total == pytest.approx(4.0 * np.pi * RADIUS**2 * THICKNESS * DENSITY, rel=0.02)
    np.testing.assert_allclose(mass.centre, [0.0, 0.0, RADIUS + 0.5], atol=1e-9)
    # A thin sphere: 2/3 m R²; facets lie a little inside.
    expected = 2.0 / 3.0 * mass.total * RADIUS**2
    np.testing.assert_allclose(mass.inertia[:3], expected, rtol=0.03)
    np.testing.assert_allclose(mass.inertia[3:], 0.0, atol=1e-9 * expected)


def test_a_run_of_it_is_stopped_by_the_pad(tmp_path: Path) -> None:
    text = FULL.replace(card(22, 1e-7, 0.003, 5), card(22, 1e-7, 3.0, 5))
    case, _ = converted(tmp_path, text)
    result = cg.run(case)
    speed = result.history["head form.vz"]
    assert speed[0] == -2.0
    assert speed[-1] > 1.5, "what is elastic gives the speed back"
    assert result.summary["energy"]["relative"] < 0.01


INERTIA = [
    "*PART_INERTIA", "head", card(1, 11, 21), card(0.0, 0.0, 20.5, 4.5, 0, 0),
    card(800.0, 0.0, 1.0, 900.0, 0.0, 950.0), card(0.0, 0.0, -3.0, 0.0, 0.01, 0.0),
    *PARTS[3:],
]  # fmt: skip


def test_inertia_and_velocity_of_a_part_are_taken(tmp_path: Path) -> None:
    loose = [RIGID[0], RIGID[1], card(0, 0, 0), ""]
    case, _ = converted(tmp_path, deck(loose, FOAM, CONTACT, END, parts=INERTIA))
    mass, motion = case.body[0].mass, case.body[0].motion
    assert (mass.total, mass.centre) == (4.5, [0.0, 0.0, 20.5])
    assert mass.inertia == [800.0, 900.0, 950.0, 0.0, 0.0, 1.0]
    assert (motion.velocity, motion.spin, motion.hold) == ([0.0, 0.0, -3.0], [0.0, 0.01, 0.0], [])


PUSH = [
    "*BOUNDARY_PRESCRIBED_MOTION_RIGID", card(1, 3, 2, 9, -2.0), card(1, 1, 2, 8),
    "*DEFINE_CURVE", card(9), f"{0.0:20}{0.0:20}", f"{4.0:20}{1.5:20}",
    "*DEFINE_CURVE", "8, 0, 1.0, 0.5", "0.0, 0.0", "2.0, 1.0",
]  # fmt: skip


@pytest.mark.parametrize(("kind", "name"), [(0, "velocity"), (1, "acceleration"), (2, "translate")])
def test_prescribed_ways_go_into_one_table(tmp_path: Path, kind: int, name: str) -> None:
    push = [
        PUSH[0], card(1, 3, kind, 9, -2.0), card(1, 1, kind, 8), *PUSH[3:],
    ]  # fmt: skip
    case, text = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END, push))
    motion = case.body[0].motion
    assert motion.kind == name
    # Both curves at the times of both: SFO 0.5 of one, SF −2 of the other, held to the end.
    assert motion.table == [[0, 0, 0, 0], [2, 0.5, 0, -1.5], [4, 0.5, 0, -3.0]]
    assert case.body[0].mass is None
    assert "other ways stand still" in text


def test_motions_without_their_curve_or_of_two_kinds_are_listed(tmp_path: Path) -> None:
    lost = [*PUSH[:3], card(1, 2, 0, 8), card(1, 2, 2, 77), *PUSH[3:]]
    case, text = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END, lost))
    assert case.body[0].motion.table == [[0, 0, 0, 0], [2, 0.5, 0, -1.5], [4, 0.5, 0, -3.0]]
    assert "(part 1, there is no curve 77), line" in text
    assert "(part 1, VAD 0 beside VAD 2), line" in text


def test_a_case_elsewhere_finds_its_deck(tmp_path: Path) -> None:
    (tmp_path / "cases").mkdir()
    (tmp_path / "deck.k").write_text(FULL, encoding="utf-8")
    actual = convert(tmp_path / "deck.k", UNITS, tmp_path / "cases")
    assert 'mesh = "../deck.k"' in actual.text


def test_gravity_acts_against_the_acceleration_of_the_base(tmp_path: Path) -> None:
    gravity = ["*LOAD_BODY_Z", card(7, 9.81e-3), "*DEFINE_CURVE", "7", "0,1", "100,1"]
    case, _ = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END, gravity))
    assert case.world.gravity == [0.0, 0.0, -9.81e-3]
    case, text = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END, [*gravity[:-1], "100,2"]))
    assert case.world.gravity == [0.0, 0.0, 0.0]
    assert "*LOAD_BODY_Z (its curve is not constant), line" in text


def test_sets_of_parts_and_nodes_are_sides(tmp_path: Path) -> None:
    sets = [
        "*SET_PART_LIST_TITLE", "rigid ones", card(4), card(1, 0),
        "*SET_NODE_LIST_GENERATE", card(6), card(350, 355, 360, 361),
    ]  # fmt: skip
    contact = ["*CONTACT_NODES_TO_SURFACE", card(6, 4, 4, 2), "", ""]
    case, _ = converted(tmp_path, deck(RIGID, FOAM, sets, contact, END))
    assert case.contact[0].friction is None
    assert case.slave[0].points.parts == ["set of nodes 6"]
    slave = cg.build(case).slaves["set of nodes 6"].slave
    assert slave.active.sum() == 8


def test_two_rigid_parts_meet_with_the_points_of_one(tmp_path: Path) -> None:
    stiff = ["*MAT_RIGID", card(22, 1e-6, 10.0, 0.3), "", ""]
    for contact, pairs in (
        (CONTACT, [("head form", "foam pad points")]),
        (["*CONTACT_AUTOMATIC_SINGLE_SURFACE", card(0, 0, 2, 0), "", ""],
         [("head form", "foam pad points")]),
    ):  # fmt: skip
        case, _ = converted(tmp_path, deck(RIGID, stiff, contact, END))
        assert [(c.master, c.slave) for c in case.contact] == pairs
        assert case.slave[0].motion.body == "foam pad"
        assert case.body[1].mass.density == 1e-6
        cg.build(case)


def test_the_rigid_side_is_the_master(tmp_path: Path) -> None:
    turned = [*CONTACT[:2], card(1, 2, 3, 3), *CONTACT[3:]]
    case, text = converted(tmp_path, deck(RIGID, FOAM, turned, END))
    assert case.contact[0].master == "head form"
    assert "its sides are swapped" in text


def test_parameters_have_their_values(tmp_path: Path) -> None:
    """Wherever they stand: the end was said to be missing, and velocities were left out."""
    named = [
        "*PARAMETER", "R tEnd    4.0       Rspeed    -2.0      I part    1",
        "*PARAMETER_EXPRESSION", "R half    &speed/2.0", "I foam    part + 1",
        "*CONTROL_TERMINATION", card("&tend"),
        "*INITIAL_VELOCITY_GENERATION", card("&part", 2, 0.0, "&half", "-&half", "&Speed"), "",
        "*LOAD_BODY_Z", card(7, "&g"), "*DEFINE_CURVE", "7", "0,&one", "100,&one",
        "*PARAMETER_LOCAL", "R g, 9.81-3, R one, 1",
    ]  # fmt: skip
    parts = [line.replace(card(2, 12, 22), card("&foam", 12, 22)) for line in PARTS]
    case, text = converted(tmp_path, deck(RIGID, FOAM, CONTACT, named, parts=parts))
    assert case.time.end == 4.0
    assert case.body[0].motion.velocity == [-1.0, 1.0, -2.0]
    assert case.world.gravity == [0.0, 0.0, -9.81e-3]
    assert case.slave[0].name == "foam pad"
    assert "Not understood" not in text


def test_what_is_not_understood_is_listed_with_its_lines(tmp_path: Path) -> None:
    other = [
        "*CONTROL_TIMESTEP", card(0.0, 0.9), "*PARAMETER_TYPE", "R speed   -2.0",
        "*INITIAL_VELOCITY_RIGID_BODY", card(1, 0.0, 0.0, "&speed"),
        "*CONTROL_TIMESTEP", card(0.0, 0.8), "*MAT_VISCOELASTIC", card(23),
        "*BOUNDARY_PRESCRIBED_MOTION_RIGID", card(1, 5, 0, 9),
    ]  # fmt: skip
    text = deck(RIGID, FOAM, CONTACT, END, other)
    case, written = converted(tmp_path, text)
    actual = convert(tmp_path / "deck.k", UNITS, tmp_path).unknown
    lines = text.splitlines()
    assert {name.split(" ")[0] for name in actual} == {
        "*CONTROL_TIMESTEP", "*PARAMETER_TYPE", "*INITIAL_VELOCITY_RIGID_BODY", "*MAT_VISCOELASTIC",
        "*BOUNDARY_PRESCRIBED_MOTION_RIGID",
    }  # fmt: skip
    for name, at in actual.items():
        assert all(lines[line - 1] == name.split(" ")[0] for line in at)
        assert name in written
    assert len(actual["*CONTROL_TIMESTEP"]) == 2
    assert case.body[0].motion.velocity == [0.0, 0.0, 0.0]


def test_the_long_format_says_the_same(tmp_path: Path) -> None:
    def wide(pieces: list[str]) -> list[str]:
        return [
            "".join(f"{line[i : i + 10]:>20}" for i in range(0, len(line), 10))
            if line.startswith(" ") and re.search(r"\d", line)
            else line
            for line in pieces
        ]  # fmt: skip

    short, _ = converted(tmp_path, FULL)
    plus = [[p[0] + "+", *wide(p[1:])] for p in (RIGID, CONTACT, FLIGHT, END)]
    plus[1][1] = CONTACT[1]
    long, _ = converted(tmp_path, deck(plus[0], FOAM, *plus[1:]))
    assert long.body[0].motion == short.body[0].motion
    assert long.contact[0].friction == short.contact[0].friction
    assert long.time.end == short.time.end


@pytest.mark.parametrize(
    ("text", "kind", "message"),
    [
        (deck(RIGID, FOAM, END), FileError, r"no contact with a rigid part.*no \*CONTACT"),
        (deck(FOAM, CONTACT, END), FileError, r"1 \*CONTACT_.*\(no rigid part on either side"),
        ("hello\n", FileError, "not an LS-DYNA keyword deck"),
        (FULL.replace("AUTOMATIC_SURFACE", "TIED_SURFACE"), FileError, r"1 \*CONTACT_TIED"),
        (FULL.replace(card(4.0), card("late")), MeshError, r"\*CONTROL_TERMINATION.*not a number"),
    ],
)
def test_decks_that_are_no_case_are_told(
    tmp_path: Path, text: str, kind: type, message: str
) -> None:
    with pytest.raises(kind, match=message):
        converted(tmp_path, text)


def test_wrong_units_are_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--units: must be three units; found 'mm,kg'"):
        parse_units("mm,kg")
    with pytest.raises(UnitError, match="--units: not a unit of mass"):
        convert(tmp_path / "deck.k", ("mm", "s", "ms"), tmp_path)
    with pytest.raises(FileError, match="cannot be read"):
        convert(tmp_path / "deck.k", UNITS, tmp_path)
