"""Masses, inertia and stiffness of converted decks, against closed forms."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.decks import (
    CONTACT,
    DENSITY,
    END,
    FOAM,
    PARTS,
    RIGID,
    THICKNESS,
    UNITS,
    box,
    card,
    converted,
    deck,
)

import contiga as cg
from contiga.case.convert import convert
from contiga.case.schema import Case, parse_case
from contiga.errors import MeshError

SIDE = 20.0
OWN = DENSITY * SIDE**3
"""Mass of the head, a cube about (0, 0, 11)."""
HEAD = ["*PART", "head", card(1, 1, 1)]
PAD = ["*PART", "pad", card(2, 3, 2), "*SECTION_SOLID", card(3, 1)]
STIFF = ["*MAT_RIGID", card(1, DENSITY, 210.0, 0.3), card(0), ""]
SOFT = ["*MAT_ELASTIC", card(2, 1e-6, 0.01, 0.3)]
TOUCH = ["*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", card(2, 1, 3, 3), card(0.2), card(1)]
CUBES = [*box(1, 1, 1, 1.0, 21.0), *box(11, 2, 2, -20.0, 0.0)]
HELD = ["*SET_NODE_LIST", card(9), card(11, 12, 13, 14), "*BOUNDARY_SPC_SET", card(9, 0, 1, 1, 1)]


def cubes(folder: Path, *pieces: list[str], head: list[str] = HEAD) -> tuple[Case, list[str]]:
    """The case of a rigid cube over a soft one, and what is listed."""
    lines = ["*KEYWORD", *head, *PAD, *STIFF, *SOFT, *CUBES, *END]
    lines += [line for piece in pieces for line in piece]
    if not any(line.startswith("*CONTACT") for line in lines):
        lines += TOUCH
    (folder / "deck.k").write_text("\n".join([*lines, "*END", ""]), encoding="utf-8")
    result = convert(folder / "deck.k", UNITS, folder)
    return parse_case(result.text, folder / "case.toml"), list(result.unknown)


def lumped(*rows: tuple[int, float], option: str = "") -> list[str]:
    return [f"*ELEMENT_MASS{option}", *(f"{k:8d}{n:8d}{m:16}" for k, (n, m) in enumerate(rows, 1))]


def with_points(places: Any, masses: Any) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre and tensor of the cube with masses at points, by the parallel axes."""
    places = np.vstack([[0.0, 0.0, 11.0], places])
    weights = np.array([OWN, *masses])
    centre = weights @ places / weights.sum()
    tensor = OWN * SIDE**2 / 6.0 * np.eye(3)
    for p, m in zip(places - centre, weights, strict=True):
        tensor += m * (p @ p * np.eye(3) - np.outer(p, p))
    return float(weights.sum()), centre, tensor


def assert_is(mass: Any, expected: tuple[float, np.ndarray, np.ndarray]) -> None:
    total, centre, tensor = expected
    assert mass.total == pytest.approx(total, rel=1e-12)
    np.testing.assert_allclose(mass.centre, centre, atol=1e-12 * SIDE)
    entries = [tensor[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    np.testing.assert_allclose(mass.inertia, entries, atol=1e-12 * np.abs(tensor).max())


def test_lumped_masses_are_of_the_rigid_part_whose_nodes_they_stand_on(tmp_path: Path) -> None:
    case, told = cubes(tmp_path, lumped((1, 4.5), (8, 0.25), (1, 0.5)))
    places = [[-10.0, -10.0, 1.0], [10.0, 10.0, 21.0]]
    assert_is(case.body[0].mass, with_points(places, [5.0, 0.25]))
    assert told == []


def test_nodes_of_a_set_share_a_mass(tmp_path: Path) -> None:
    nodes = ["*SET_NODE_LIST", card(7), card(1, 2, 3, 4)]
    case, told = cubes(tmp_path, nodes, lumped((7, 2.0), option="_NODE_SET"))
    places = [(x, y, 1.0) for y in (-10.0, 10.0) for x in (-10.0, 10.0)]
    assert_is(case.body[0].mass, with_points(places, [0.5] * 4))
    assert told == []


@pytest.mark.parametrize("kind", ["NODE", "SET"])
def test_masses_on_extra_nodes_count_as_well(tmp_path: Path, kind: str) -> None:
    node = ["*NODE", f"{99:8d}{0.0:16}{30.0:16}{50.0:16}", "*SET_NODE_LIST", card(7), card(99)]
    extra = [f"*CONSTRAINED_EXTRA_NODES_{kind}", card(1, 99 if kind == "NODE" else 7)]
    case, told = cubes(tmp_path, node, extra, lumped((99, 1.5)))
    assert_is(case.body[0].mass, with_points([[0.0, 30.0, 50.0]], [1.5]))
    assert told == []


INERTIA = [
    "*PART_INERTIA", "head", card(1, 1, 1), card(0, 0, 11, 4.5, 0, 0),
    card(100.0, 5.0, -7.0, 200.0, 3.0, 250.0), card(0, 0, -2.0),
]  # fmt: skip
TENSOR = np.array([[100.0, 5.0, -7.0], [5.0, 200.0, 3.0], [-7.0, 3.0, 250.0]])


def test_part_inertia_stands_alone(tmp_path: Path) -> None:
    case, told = cubes(tmp_path, lumped((1, 4.5)), head=INERTIA)
    assert_is(case.body[0].mass, (4.5, np.array([0.0, 0.0, 11.0]), TENSOR))
    assert told == []


def test_masses_on_nodes_of_what_rests_are_listed(tmp_path: Path) -> None:
    case, told = cubes(tmp_path, lumped((1, 4.5), (12, 1.0), (15, 1.0)))
    assert case.body[0].mass.total == pytest.approx(OWN + 4.5, rel=1e-12)
    why = "2 nodes of nothing that moves here, first 12: their masses are left out"
    assert told == [f"*ELEMENT_MASS ({why})"]


def weights(case: Case) -> tuple[float, np.ndarray]:
    """Mass of the free body, and of each of the nodes of the pad that are not the body's."""
    mechanism = cg.build(case).mechanism
    nodes = mechanism.nodes["pad"]
    apart = ~nodes.bare
    for joint in nodes.joints:
        apart[joint.rows] = False
    return float(mechanism.fixed[0, 0]), np.where(apart, nodes.mass, 0.0)


def test_masses_on_nodes_of_a_part_that_deforms_are_those_of_the_deck(tmp_path: Path) -> None:
    nodes = ["*SET_NODE_LIST", card(7), card(15, 16)]
    masses = lumped((1, 4.5), (18, 1.0), (15, 0.5), (18, 0.25))
    case, told = cubes(tmp_path, HELD, nodes, masses, lumped((7, 0.5), option="_NODE_SET"))
    assert told == []
    (table,) = case.slave[0].motion.masses
    assert dict(zip(table.nodes, table.mass, strict=True)) == {15: 0.75, 16: 0.25, 18: 1.25}
    body, nodal = weights(case)
    assert body + nodal.sum() == pytest.approx((DENSITY + 1e-6) * SIDE**3 + 6.75, rel=1e-12)
    own = 1e-6 * SIDE**3 / 8.0
    np.testing.assert_allclose(nodal[8:], own + np.array([0, 0, 0, 0, 0.75, 0.25, 0, 1.25]))


def test_a_mass_on_a_node_that_a_rigid_part_shares_counts_once(tmp_path: Path) -> None:
    extra = ["*CONSTRAINED_EXTRA_NODES_NODE", card(1, 18)]
    case, told = cubes(tmp_path, HELD, extra, lumped((18, 1.0), (15, 0.5)))
    assert told == []
    (table,) = case.slave[0].motion.masses
    assert (table.nodes, table.mass) == ([15], [0.5])
    assert case.body[0].mass.total == pytest.approx(OWN + 1.0, rel=1e-12)
    body, nodal = weights(case)
    assert body + nodal.sum() == pytest.approx((DENSITY + 1e-6) * SIDE**3 + 1.5, rel=1e-12)


@pytest.mark.parametrize(
    ("row", "total"),
    [(f"{1:8d}{1.25:16}", OWN + 1.25), (f"{1:8d}{9.0:16}{4.0:16}", 4.0)],
)
def test_the_mass_of_a_part_is_added_over_its_volume(
    tmp_path: Path, row: str, total: float
) -> None:
    case, told = cubes(tmp_path, ["*ELEMENT_MASS_PART", row])
    inertia = total * SIDE**2 / 6.0 * np.eye(3)
    assert_is(case.body[0].mass, (total, np.array([0.0, 0.0, 11.0]), inertia))
    assert told == []


def test_a_part_that_deforms_is_as_heavy_as_its_cards_say(tmp_path: Path) -> None:
    added = ["*ELEMENT_MASS_PART", f"{2:8d}{0.25:16}"]
    case, told = cubes(tmp_path, HELD, added)
    assert case.slave[0].motion.density == pytest.approx(1e-6 + 0.25 / SIDE**3, rel=1e-9)
    assert told == []


def test_the_mass_of_a_part_that_rests_is_listed(tmp_path: Path) -> None:
    _, told = cubes(tmp_path, ["*ELEMENT_MASS_PART", f"{2:8d}{0.25:16}"])
    assert told == ["*ELEMENT_MASS_PART (ADDMASS 0.25)"]


def test_shells_carry_the_mass_over_their_area_that_their_section_adds(tmp_path: Path) -> None:
    extra = 3e-5
    heavy = [*PARTS]
    heavy[heavy.index("*SECTION_SHELL") + 2] = card(*(THICKNESS,) * 4, 0, extra)
    plain, _ = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END))
    case, text = converted(tmp_path, deck(RIGID, FOAM, CONTACT, END, parts=heavy))
    share = (THICKNESS * DENSITY + extra) / (THICKNESS * DENSITY)
    mass, before = case.body[0].mass, plain.body[0].mass
    assert mass.total == pytest.approx(share * before.total, rel=1e-12)
    assert mass.centre == pytest.approx(before.centre, abs=1e-9)
    np.testing.assert_allclose(mass.inertia[:3], share * np.array(before.inertia[:3]), rtol=1e-12)
    assert "MAREA" not in text


def test_a_membrane_carries_it_too(tmp_path: Path) -> None:
    shells = ["*ELEMENT_SHELL", "".join(f"{k:8d}" for k in (9, 4, 15, 16, 18, 17))]
    sheet = [
        "*PART",
        "sheet",
        card(4, 8, 2),
        "*SECTION_SHELL",
        card(8, 2),
        card(0.5, 0, 0, 0, 0, 4e-7),
    ]
    onto = [TOUCH[0], card(4, 1, 3, 3), *TOUCH[2:]]
    edge = ["*SET_NODE_LIST", card(9), card(15, 16), "*BOUNDARY_SPC_SET", card(9, 0, 1, 1, 1)]
    lines = ["*KEYWORD", *HEAD, *sheet, *STIFF, *SOFT, *box(1, 1, 1, 1.0, 21.0), *onto, *END]
    lines += [*box(11, 2, 2, -20.0, 0.0)[:9], *shells, *edge, "*END", ""]
    (tmp_path / "deck.k").write_text("\n".join(lines), encoding="utf-8")
    result = convert(tmp_path / "deck.k", UNITS, tmp_path)
    case = parse_case(result.text, tmp_path / "case.toml")
    assert case.slave[0].motion.density == pytest.approx(1e-6 + 4e-7 / 0.5, rel=1e-12)
    simulation = cg.build(case)
    nodes = simulation.mechanism.nodes["sheet"]
    weight = nodes.mass[~nodes.bare].sum()
    assert weight == pytest.approx(SIDE**2 * (0.5 * 1e-6 + 4e-7), rel=1e-9)
    assert result.unknown == {}


def local(*axes: object) -> list[str]:
    """The inertia in axes of its own."""
    return [*INERTIA[:3], card(0, 0, 11, 4.5, 1, 0), *INERTIA[4:], card(*axes)]


TURN = Rotation.from_rotvec([0.4, -1.1, 0.7])
ALONG, PLANE, _ = TURN.as_matrix().T


def as_text(vector: np.ndarray) -> list[str]:
    return [f"{v:.7f}" for v in vector]


ORIGIN = np.array([1.0, 2.0, 3.0])
VECTOR = card(5, *as_text(ALONG), *as_text(PLANE + 0.5 * ALONG))
AXES = [card(5, *ORIGIN, *as_text(ORIGIN + ALONG)), card(*as_text(ORIGIN + 3.0 * PLANE))]
SYSTEMS = {
    "vector": ["*DEFINE_COORDINATE_VECTOR", VECTOR],
    "system": ["*DEFINE_COORDINATE_SYSTEM_TITLE", "own", *AXES],
}


@pytest.mark.parametrize(
    ("head", "system"),
    [
        (local(*as_text(2.0 * ALONG), *as_text(PLANE - 0.3 * ALONG)), []),
        *((local(0, 0, 0, 0, 0, 0, 5), system) for system in SYSTEMS.values()),
    ],
)
def test_a_tensor_in_axes_of_its_own_is_turned(
    tmp_path: Path, head: list[str], system: list[str]
) -> None:
    case, told = cubes(tmp_path, system, head=head)
    turned = TURN.as_matrix() @ TENSOR @ TURN.as_matrix().T
    inertia = case.body[0].mass.inertia
    expected = [turned[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    np.testing.assert_allclose(inertia, expected, atol=1e-4)
    assert told == []


@pytest.mark.parametrize("head", [local(0, 0, 0, 0, 0, 0, 5), local(1, 0, 0, 2, 0, 0)])
def test_axes_that_are_not_understood_are_listed(tmp_path: Path, head: list[str]) -> None:
    case, told = cubes(tmp_path, head=head)
    assert case.body[0].mass.inertia[:3] == [100.0, 200.0, 250.0]
    assert told == [
        "*PART_INERTIA (part 1: its own axes are not understood, those of the world are taken)"
    ]


CURVE = ["*DEFINE_CURVE", card(7), f"{0:20}{0:20}", f"{1:20}{2:20}"]


@pytest.mark.parametrize(
    ("given", "again", "told"),
    [
        (SOFT, ["*MAT_ELASTIC", card(2, 1e-6, 0.02, 0.3)], "MAT_ELASTIC: material 2 is given"),
        (SOFT, ["*MAT_RIGID", *SOFT[1:], card(0), ""], "MAT_RIGID: material 2 is given"),
        (CURVE, [*CURVE[:3], f"{1:20}{3:20}"], "DEFINE_CURVE: curve 7 is given"),
    ],
)
def test_a_number_that_is_given_twice_not_alike_is_refused(
    tmp_path: Path, given: list[str], again: list[str], told: str
) -> None:
    _, listed = cubes(tmp_path, [] if given is SOFT else given, given)
    assert listed == []
    with pytest.raises(
        MeshError, match=rf"deck\.k, line \d+: \*{told} twice, otherwise in line"
    ) as e:
        cubes(tmp_path, given, again)
    lines = (tmp_path / "deck.k").read_text().splitlines()
    first, second = (lines[int(n) - 1] for n in re.findall(r"line (\d+)", str(e.value))[::-1])
    assert (first, second) == (given[1], again[1])


BULK = 0.01 / (3.0 * (1.0 - 2.0 * 0.3))


@pytest.mark.parametrize(
    ("sides", "third", "scale", "left"),
    [
        (card(2, 1, 3, 3), card(3.0), 3.0, []),
        (card(2, 1, 3, 3), card(3.0, 5.0), 3.0, ["SFM 5.0"]),
        (card(1, 2, 3, 3), card(3.0, 5.0), 5.0, ["SFS 3.0"]),
        (card(9, 1, 4, 3), card(3.0), 3.0, []),
        (card(1, 9, 3, 4), card(3.0, 5.0), 5.0, ["SFS 3.0"]),
    ],
)
def test_the_stiffness_is_of_the_part_that_the_points_belong_to(
    tmp_path: Path, sides: str, third: str, scale: float, left: list[str]
) -> None:
    nodes = ["*SET_NODE_LIST", card(9), card(15, 16, 17, 18)]
    case, told = cubes(tmp_path, nodes, [TOUCH[0], sides, card(0.2), third])
    # Two triangles a side, so that the root of twice their area is the side.
    assert case.contact[0].law.stiffness == pytest.approx(0.1 * scale * BULK / SIDE, rel=1e-5)
    assert told == [f"{TOUCH[0]} ({what})" for what in left]


@pytest.mark.parametrize("factor", [0.0, 1.0, 0.5, 2.0])
def test_fsf_scales_friction(tmp_path: Path, factor: float) -> None:
    third = card(1, 1, 0, 0, 1, 1, factor)
    case, told = cubes(tmp_path, [*TOUCH[:2], card(0.4, 0.3, 0.01), third])
    friction, scale = case.contact[0].friction, factor or 1.0
    assert (friction.static, friction.dynamic, friction.decay) == (0.4 * scale, 0.3 * scale, 0.01)
    assert told == []
