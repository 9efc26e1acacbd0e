"""Parts of fabric in a deck, as membranes of the case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.decks import CONTACT, END, FLIGHT, PARTS, RIGID, card, converted, deck, pad, sphere

import contiga as cg
from contiga.materials import Elastic, Fabric

FIRST = len(sphere()[0]) + 1
EDGE = [FIRST + k for k, p in enumerate(pad()[0]) if p[2] > -1.0 and abs(p[0]) > 14.0]
SHEET = [*PARTS[:-2], "*SECTION_SHELL", card(12, 9), card(0.4, 0.4, 0.4, 0.4)]
SPC = ["*BOUNDARY_SPC_NODE", *(card(node, 0, 1, 1, 1) for node in EDGE)]
WARP = ["*DEFINE_CURVE", card(7), "0.0, 0.0", "0.1, 0.02", "0.3, 0.2"]
SHEAR = ["*DEFINE_CURVE", card(8), "0.0, 0.0", "0.5, 0.01"]


def fabric(
    *,
    weft: float | str = "",
    poisson: float | str = "",
    shear: float | str = "",
    slack: int = 1,
    form: int = 0,
    direction: tuple[float, ...] = (),
    curves: tuple[int, ...] = (),
) -> list[str]:
    """*MAT_FABRIC as its manual lays it out."""
    axes = 2.0 if direction else 0.0
    return [
        "*MAT_FABRIC_TITLE",
        "nylon",
        card(22, 8e-7, 0.3, weft, "", poisson),
        card(shear, "", "", slack),
        card(axes, "", "", "", "", form),
        card("", "", "", *direction),
        card(0.0),
        *([card(*curves)] if curves else []),
    ]


def case_of(folder: Path, *pieces: list[str], parts: list[str] = SHEET) -> tuple[cg.Case, str]:
    """With the upper side of the pad as a sheet of shells."""
    text = deck(RIGID, CONTACT, FLIGHT, END, *pieces, parts=parts)
    start = text.index("*ELEMENT_SOLID")
    end = text.index("*PART", start)
    lines = ["*ELEMENT_SHELL"]
    for k, nodes in enumerate(pad()[1] + FIRST, start=10001):
        lines.append("".join(f"{number:8d}" for number in (k, 2, *nodes[4:])))
    return converted(folder, text[:start] + "\n".join(lines) + "\n" + text[end:])


@pytest.mark.parametrize(
    ("material", "expected"),
    [
        (fabric(poisson=0.2), Elastic(young=0.3, poisson=0.2, compression=False)),
        (fabric(weft=0.3, slack=0), Elastic(young=0.3)),
        (
            fabric(weft=0.2, shear=0.01, direction=(0, 1, 0)),
            Fabric(warp=0.3, weft=0.2, shear=0.01, direction=[0, 1, 0]),
        ),
        (
            fabric(form=14, curves=(7, 0, 8), direction=(1, 0, 0), slack=0),
            Fabric(
                warp=[[0, 0], [0.1, 0.02], [0.3, 0.2]],
                shear=[[0, 0], [0.5, 0.01]],
                direction=[1, 0, 0],
                compression=1.0,
            ),
        ),
    ],
)
def test_a_held_sheet_is_made_of_its_fabric(
    tmp_path: Path, material: list[str], expected: object
) -> None:
    case, text = case_of(tmp_path, material, SPC, WARP, SHEAR)
    simulation = cg.build(case)
    (part,) = simulation.slaves.values()
    assert isinstance(part.motion, cg.motion.Deforming)
    assert part.motion.thickness == 0.4
    assert part.motion.density == 8e-7
    made = part.motion.material
    assert type(made) is type(expected)
    for key, value in vars(expected).items():
        if value is None or isinstance(value, bool):
            assert getattr(made, key) is value, key
        else:
            np.testing.assert_allclose(getattr(made, key), value, rtol=1e-12, err_msg=key)
    assert "*MAT_FABRIC_TITLE" in text
    assert "without bending" not in text
    nodes = simulation.mechanism.nodes["foam pad"]
    edge = np.abs(part.slave.points[~nodes.bare, 0]) > 14.0
    np.testing.assert_array_equal(nodes.held.all(axis=1)[~nodes.bare], edge)


def test_a_ball_falls_into_the_sheet_and_keeps_its_energy(tmp_path: Path) -> None:
    case, _ = case_of(tmp_path, fabric(poisson=0.2), SPC)
    history = cg.build(case).run().history
    assert history["force"].max() > 0.0
    assert np.abs(history["energy.error"]).max() < 1e-3 * history["energy.total"][0]


def test_notes_say_what_it_is_not(tmp_path: Path) -> None:
    curves = fabric(form=4, curves=(7, 7, 8, 9), poisson=0.1, direction=(1, 0, 0))
    _, text = case_of(tmp_path, curves, SPC, WARP, SHEAR)
    assert "warp and weft do not contract each other, it unloads as it loads" in text
    _, text = case_of(tmp_path, ["*MAT_ELASTIC", card(22, 1e-6, 5e-3, 0.3)], SPC)
    assert "its shells are membranes, without bending" in text


@pytest.mark.parametrize(
    ("material", "why"),
    [
        (fabric(weft=0.2, shear=0.01), "AOPT 0, its axes are no vector"),
        (fabric(form=14, curves=(9, 9, 9), direction=(1, 0, 0)), "there is no curve 9"),
        (fabric(form=14, curves=(0, 7, 8)), "FORM 14 with its curves"),
        (fabric(form=-14, curves=(7, 7, 8), direction=(1, 0, 0)), "FORM -14 with its curves"),
        (fabric(form=24), "FORM 24 with its curves"),
        (["*MAT_FABRIC", card(22, 8e-7, 0.0)], "no modulus EA"),
        (fabric(weft=0.2, shear=0.01, direction=(0, 0, 1)), "the warp of element 0 is across"),
    ],
)
def test_fabric_that_is_not_understood_rests(tmp_path: Path, material: list[str], why: str) -> None:
    case, text = case_of(tmp_path, material, SPC, WARP, SHEAR)
    assert case.slave[0].motion.kind == "fixed"
    assert f"{material[0]} ({why}" in text.partition("Not understood")[2]
    assert "*BOUNDARY_SPC_NODE (nodes held in xyz: of no part that deforms here)" in text


@pytest.mark.parametrize(
    ("thickness", "why"),
    [((0.0,) * 4, "no thickness"), ((0.4, 0.5, 0.4, 0.5), "thicknesses from 0.43")],
)
def test_shells_without_one_thickness_rest(
    tmp_path: Path, thickness: tuple[float, ...], why: str
) -> None:
    parts = [*SHEET[:-1], card(*thickness)]
    case, text = case_of(tmp_path, fabric(), SPC, parts=parts)
    assert case.slave[0].motion.kind == "fixed"
    assert f"(its shells have {why}" in text


def test_a_modulus_beside_a_curve_is_kept(tmp_path: Path) -> None:
    material = fabric(form=14, weft=0.1, curves=(7, 0, 8), direction=(1, 0, 0))
    case, _ = case_of(tmp_path, material, SPC, WARP, SHEAR)
    made = case.slave[0].motion.material.instance
    assert made.weft.tolist() == [[0.0, 0.0], [1.0, 0.1]]
