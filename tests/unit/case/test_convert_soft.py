"""Parts of a deck that deform in the case, too."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.decks import (
    CONTACT,
    DENSITY,
    END,
    FLIGHT,
    PARTS,
    RIGID,
    card,
    converted,
    deck,
    pad,
    sphere,
)

import contiga as cg
from contiga.errors import MeshError
from contiga.materials import Elastic, Foam, NeoHooke

FIRST = len(sphere()[0]) + 1
LOW = [FIRST + k for k in np.flatnonzero(pad()[0][:, 2] < -9.0).tolist()]
SPC = ["*BOUNDARY_SPC_SET", card(6, 0, 1, 1, 1)]
CURVE = ["*DEFINE_CURVE", card(5)]
CURVE += [f"{x:20.6g}{y:20.6g}" for x, y in ((0, 0), (0.1, 1e-4), (0.6, 2e-4), (0.9, 2e-3))]
ELASTIC = ["*MAT_ELASTIC", card(22, 1e-6, 5e-3, 0.3)]


def held() -> list[str]:
    """The set of the lower nodes of the pad."""
    rows = [LOW[k : k + 8] for k in range(0, len(LOW), 8)]
    return ["*SET_NODE_LIST", card(6), *(card(*row) for row in rows)]


def case_of(folder: Path, *pieces: list[str], parts: list[str] = PARTS) -> tuple[cg.Case, str]:
    return converted(folder, deck(RIGID, CONTACT, FLIGHT, END, *pieces, parts=parts))


@pytest.mark.parametrize(
    ("material", "expected"),
    [
        (ELASTIC, Elastic(young=5e-3, poisson=0.3)),
        (
            ["*MAT_BLATZ-KO_RUBBER", card(22, 1e-6, 1e-3)],
            NeoHooke(young=2e-3 * 1.463, poisson=0.463, volume="nodes"),
        ),
        (
            ["*MAT_MOONEY-RIVLIN_RUBBER_TITLE", "rubber", card(22, 1e-6, 0.49, 4e-4, 1e-4)],
            NeoHooke(young=2e-3 * 1.49, poisson=0.49, volume="nodes"),
        ),
        (
            ["*MAT_057", card(22, 1e-7, 3e-3, 5, "", 0.2), card(7.0)],
            Foam(
                loading=[[0, 0], [0.1, 1e-4], [0.6, 2e-4], [0.9, 2e-3]],
                hysteresis=0.2,
                shape=7.0,
                tension=3e-3,
            ),
        ),
        (
            ["*MAT_LOW_DENSITY_FOAM", card(22, 1e-7, 3e-3, 5)],
            Foam(
                loading=[[0, 0], [0.1, 1e-4], [0.6, 2e-4], [0.9, 2e-3]],
                hysteresis=1.0,
                shape=1.0,
                tension=3e-3,
            ),
        ),
    ],
)
def test_a_held_part_is_made_of_its_material(
    tmp_path: Path, material: list[str], expected: object
) -> None:
    case, text = case_of(tmp_path, material, held(), SPC, CURVE)
    simulation = cg.build(case)
    (part,) = simulation.slaves.values()
    assert isinstance(part.motion, cg.motion.Deforming)
    made = part.motion.material
    assert type(made) is type(expected)
    for key, value in vars(expected).items():
        found = getattr(made, key)
        numbers = isinstance(value, float | np.ndarray)
        assert np.allclose(found, value, rtol=1e-12) if numbers else found == value, key
    assert part.motion.density == (1e-7 if isinstance(expected, Foam) else 1e-6)
    assert f"*{material[0][1:]}" in text
    nodes = simulation.mechanism.nodes["foam pad"]
    low = part.slave.points[~nodes.bare, 2] < -9.0
    np.testing.assert_array_equal(nodes.held.all(axis=1)[~nodes.bare], low)
    assert 0 < low.sum() < len(low)


def test_a_ball_bounces_off_it_with_its_energy(tmp_path: Path) -> None:
    case, _ = case_of(tmp_path, ELASTIC, held(), SPC)
    history = cg.build(case).run().history
    assert history["force"].max() > 0.0
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]


def test_what_nothing_holds_rests(tmp_path: Path) -> None:
    case, text = case_of(tmp_path, ELASTIC)
    assert case.slave[0].motion.kind == "fixed"
    assert "here its points rest" in text


def test_a_curve_that_is_not_there_is_listed_and_the_part_rests(tmp_path: Path) -> None:
    foam = ["*MAT_LOW_DENSITY_FOAM", card(22, 1e-7, 3e-3, 9)]
    case, text = case_of(tmp_path, foam, held(), SPC)
    assert case.slave[0].motion.kind == "fixed"
    assert "there is no curve 9" in text
    assert "*BOUNDARY_SPC_SET (set of nodes 6: of no part that deforms here)" in text


@pytest.mark.parametrize(
    ("ways", "hold"), [((0, 0, 1), ["z"]), ((1, 0, 1), ["x", "z"]), ((1, 1, 1), ["x", "y", "z"])]
)
def test_only_the_ways_that_are_said_are_held(
    tmp_path: Path, ways: tuple[int, ...], hold: list[str]
) -> None:
    case, _ = case_of(tmp_path, ELASTIC, held(), ["*BOUNDARY_SPC_SET_ID", "1", card(6, 0, *ways)])
    assert case.slave[0].motion.fixed[0].hold == hold


def test_axes_of_its_own_are_listed(tmp_path: Path) -> None:
    case, text = case_of(tmp_path, ELASTIC, held(), ["*BOUNDARY_SPC_SET", card(6, 4, 1, 1, 1)])
    assert case.slave[0].motion.kind == "fixed"
    assert "in axes of its own, CID" in text


def test_what_holds_turns_alone_is_listed(tmp_path: Path) -> None:
    case, text = case_of(
        tmp_path, ELASTIC, held(), ["*BOUNDARY_SPC_SET", card(6, 0, 0, 0, 0, 1, 1, 1)]
    )
    assert case.slave[0].motion.kind == "fixed"
    assert "set of nodes 6, turns alone" in text


def test_a_velocity_of_the_part_is_that_of_its_nodes(tmp_path: Path) -> None:
    flight = ["*INITIAL_VELOCITY_GENERATION", card(2, 2, 0.0, 0.0, 0.0, 0.5), ""]
    case, _ = case_of(tmp_path, ELASTIC, held(), SPC, flight)
    assert case.slave[0].motion.velocity == [0.0, 0.0, 0.5]


def test_a_part_in_two_slaves_would_be_there_twice_and_rests(tmp_path: Path) -> None:
    foam, cells = pad()
    other = [f"{30001:8d}{3:8d}" + "".join(f"{node:8d}" for node in cells[0] + FIRST)]
    third = ["*PART", "another", card(3, 12, 22), "*ELEMENT_SOLID", *other]
    sides = ["*SET_PART_LIST", card(8), card(2, 3)]
    both = ["*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", card(8, 1, 2, 3), card(0.1), ""]
    case, text = case_of(tmp_path, ELASTIC, held(), SPC, third, sides, both)
    assert [slave.motion.kind for slave in case.slave] == ["fixed", "fixed"]
    assert "*BOUNDARY_SPC_SET (set of nodes 6" in text
    assert len(foam) > 0


def test_a_set_of_its_nodes_that_is_a_slave_too_keeps_it_at_rest(tmp_path: Path) -> None:
    nodes = ["*CONTACT_NODES_TO_SURFACE", card(6, 1, 4, 3), card(0.1), ""]
    case, _ = case_of(tmp_path, ELASTIC, held(), SPC, nodes)
    assert [slave.motion.kind for slave in case.slave] == ["fixed", "fixed"]


@pytest.mark.parametrize(
    "material",
    [
        ["*MAT_ELASTIC", card(22, 1e-6, 5e-3, 0.5)],
        ["*MAT_ELASTIC", card(22, 0.0, 5e-3, 0.3)],
        ["*MAT_MOONEY-RIVLIN_RUBBER", card(22, 1e-6, 0.49, 0.0, 0.0)],
        ["*MAT_LOW_DENSITY_FOAM", card(22, 1e-7, 3e-3, 6)],
    ],
)
def test_numbers_that_make_no_material_are_listed_and_the_part_rests(
    tmp_path: Path, material: list[str]
) -> None:
    falls = ["*DEFINE_CURVE", card(6)]
    falls += [f"{x:20.6g}{y:20.6g}" for x, y in ((0, 0), (0.1, 1e-4), (0.6, 1e-5))]
    case, text = case_of(tmp_path, material, held(), SPC, falls)
    assert case.slave[0].motion.kind == "fixed"
    assert material[0] in text.partition("Not understood")[2]


def test_nodes_shared_with_a_rigid_part_go_with_it(tmp_path: Path) -> None:
    """A plate of rigid shells on the lower side of the pad."""
    _, cells = pad()
    lines = [
        "".join(f"{n:8d}" for n in (20001 + k, 3, *(cell[[0, 3, 2, 1]] + FIRST)))
        for k, cell in enumerate(cells)
    ]
    plate = ["*PART", "plate", card(3, 11, 23), "*ELEMENT_SHELL", *lines]
    plate += ["*MAT_RIGID", card(23, DENSITY, 210.0, 0.3), ""]
    case, text = case_of(tmp_path, ELASTIC, plate)
    motion = case.slave[0].motion
    assert [(one.set, one.body) for one in motion.attached] == [(3, "plate")]
    assert "nodes shared with *PART 3" in text
    assert {body.name for body in case.body} == {"head form", "plate"}
    simulation = cg.build(case)
    assert not [finding for finding in simulation.check() if finding.rule == "unused"]
    state = simulation.run().state
    plate_low = state.bodies["plate"].pose[:3, 3]
    low = simulation.slaves["foam pad"].slave.points[:, 2] < -9.0
    moved = state.slaves["foam pad"].points - simulation.slaves["foam pad"].slave.points
    assert np.abs(plate_low).max() > 0.0
    np.testing.assert_allclose(moved[low].mean(axis=0), plate_low, atol=1e-3)


def test_more_nodes_of_the_same_rigid_part_go_with_it_as_well(tmp_path: Path) -> None:
    """Of two cells' plate, and a card that names all lower nodes."""
    _, cells = pad()
    lines = [
        "".join(f"{n:8d}" for n in (20001 + k, 3, *(cell[[0, 3, 2, 1]] + FIRST)))
        for k, cell in enumerate(cells[:2])
    ]
    plate = ["*PART", "plate", card(3, 11, 23), "*ELEMENT_SHELL", *lines]
    plate += ["*MAT_RIGID", card(23, DENSITY, 210.0, 0.3), ""]
    extra = ["*CONSTRAINED_EXTRA_NODES_SET", card(3, 6)]
    case, text = case_of(tmp_path, ELASTIC, plate, held(), extra)
    assert [one.set for one in case.slave[0].motion.attached] == [3, "set of nodes 6"]
    (joint,) = cg.build(case).mechanism.nodes["foam pad"].joints
    assert set(LOW) <= {int(row) + 1 for row in joint.rows}
    assert "rests" not in text.partition("Not understood")[2]


def test_single_nodes_of_other_parts_stay_listed(tmp_path: Path) -> None:
    single = ["*BOUNDARY_SPC_NODE", *(card(n, 0, 1, 1, 1) for n in (*LOW, 5))]
    case, text = case_of(tmp_path, ELASTIC, single)
    assert case.slave[0].motion.kind == "deform"
    listed = text.partition("Not understood")[2]
    assert "1 *BOUNDARY_SPC_NODE (nodes held in xyz: of no part that deforms here)" in listed


@pytest.mark.parametrize("rows", [[card(999999, 0, 1, 1, 1)], ["       abc         0"]])
def test_a_mesh_does_without_what_holds_it(tmp_path: Path, rows: list[str]) -> None:
    text = deck(RIGID, ["*BOUNDARY_SPC_NODE", *rows])
    (tmp_path / "deck.k").write_text(text, encoding="utf-8")
    assert len(cg.read_mesh(tmp_path / "deck.k", parts=[2])) > 0


@pytest.mark.parametrize("kind", ["SET", "NODE"])
def test_extra_nodes_of_a_rigid_part_go_with_it(tmp_path: Path, kind: str) -> None:
    rows = [card(1, 6)] if kind == "SET" else [card(1, node) for node in LOW]
    extra = [f"*CONSTRAINED_EXTRA_NODES_{kind}", *rows]
    case, text = case_of(tmp_path, ELASTIC, held(), extra)
    name = "set of nodes 6" if kind == "SET" else "nodes with part 1"
    assert [(one.set, one.body) for one in case.slave[0].motion.attached] == [(name, "head form")]
    assert f"*CONSTRAINED_EXTRA_NODES_{kind}, line" in text
    nodes = cg.build(case).mechanism.nodes["foam pad"]
    (joint,) = nodes.joints
    assert len(joint.rows) == len(LOW)


def test_nodes_that_go_with_a_part_are_not_held_as_well(tmp_path: Path) -> None:
    extra = ["*CONSTRAINED_EXTRA_NODES_SET", card(1, 6)]
    case, text = case_of(tmp_path, ELASTIC, held(), extra, SPC)
    assert case.slave[0].motion.kind == "fixed"
    assert "*BOUNDARY_SPC_SET (set of nodes 6: some go with a rigid part already, so" in text
    assert "*BOUNDARY_SPC_SET (set of nodes 6: of no part" not in text
    assert "*CONSTRAINED_EXTRA_NODES_SET (set of nodes 6: of no part that deforms here)" in text


def test_extra_nodes_of_a_part_that_is_not_rigid_are_listed(tmp_path: Path) -> None:
    extra = ["*CONSTRAINED_EXTRA_NODES_SET", card(2, 6)]
    case, text = case_of(tmp_path, ELASTIC, held(), extra)
    assert case.slave[0].motion.kind == "fixed"
    assert "*CONSTRAINED_EXTRA_NODES_SET (set of nodes 6: of no part that deforms here)" in text


def _layer_below(material: str, cells: int = 36) -> list[str]:
    """A part 3 of solids that hangs on the lower nodes of the pad; its own are new."""
    foam, hexahedra = pad()
    start = FIRST + len(foam)
    low = foam[foam[:, 2] < -9.0] - [0.0, 0.0, 5.0]
    nodes = [f"{start + k:8d}" + "".join(f"{x:16.8f}" for x in p) for k, p in enumerate(low)]
    lines = []
    for k, cell in enumerate(hexahedra[:cells]):
        row = [30001 + k, 3, *(cell[:4] + start), *(cell[:4] + FIRST)]
        lines.append("".join(f"{number:8d}" for number in row))
    part = ["*PART", "layer", card(3, 12, 23), "*NODE", *nodes, "*ELEMENT_SOLID", *lines]
    return [*part, f"*MAT_{material}", card(23, 1e-6, 5e-3, 0.3)]


@pytest.mark.parametrize("touches", [True, False])
def test_parts_that_are_joined_and_not_of_one_slave_rest(tmp_path: Path, touches: bool) -> None:
    other = ["*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", card(3, 1, 3, 3), card(0.1), ""]
    pieces = [_layer_below("ELASTIC"), held(), SPC, *([other] if touches else [])]
    case, text = case_of(tmp_path, ELASTIC, *pieces)
    assert {slave.motion.kind for slave in case.slave} == {"fixed"}
    assert "part 3 shares nodes with it and is not of its slave" in text


def test_parts_that_are_joined_deform_as_one_slave(tmp_path: Path) -> None:
    sides = ["*SET_PART_LIST", card(8), card(2, 3)]
    both = ["*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", card(8, 1, 2, 3), card(0.1), ""]
    pieces = [_layer_below("ELASTIC"), held(), SPC, sides, both]
    text = deck(RIGID, FLIGHT, END, ELASTIC, *pieces)
    case, _ = converted(tmp_path, text)
    (slave,) = case.slave
    assert [part.set for part in slave.motion.parts] == [2, 3]
    cg.build(case).start()


def test_what_a_case_would_refuse_rests_and_is_listed(tmp_path: Path) -> None:
    """Two rigid plates that share a node of the pad with each other."""
    _, cells = pad()
    plates = []
    for k, cell in enumerate(cells[:2]):
        row = "".join(f"{n:8d}" for n in (20001 + k, 3 + k, *(cell[[0, 3, 2, 1]] + FIRST)))
        plates += ["*PART", f"plate {k}", card(3 + k, 11, 23), "*ELEMENT_SHELL", row]
    plates += ["*MAT_RIGID", card(23, DENSITY, 210.0, 0.3), ""]
    case, text = case_of(tmp_path, ELASTIC, plates)
    assert case.slave[0].motion.kind == "fixed"
    listed = text.partition("Not understood")[2]
    assert "is held, driven or attached already, so the slave rests" in listed


def test_a_rigid_part_without_mass_that_carries_nodes_is_told(tmp_path: Path) -> None:
    _, cells = pad()
    row = "".join(f"{n:8d}" for n in (20001, 3, *(cells[0][[0, 3, 2, 1]] + FIRST)))
    plate = ["*PART", "plate", card(3, 11, 23), "*ELEMENT_SHELL", row]
    plate += ["*MAT_RIGID", card(23, 0.0, 210.0, 0.3), ""]
    with pytest.raises(MeshError, match=r"part 3: is free to move and has no mass.*MAT_RIGID"):
        case_of(tmp_path, ELASTIC, plate)
