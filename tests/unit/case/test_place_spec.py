"""`align` and `place` of a case: whatever the order in the file; circles are one message."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.case.build import build
from contiga.case.describe import describe, placed_parts
from contiga.case.schema import parse_case
from contiga.case.toml import resolved_toml
from contiga.errors import CaseError, InputError

HEAD = """
[[body]]
name = "head"
geometry.shape = "sphere"
geometry.radius = 10.0
geometry.place = { on = "pad", direction = [0, 0, -2], gap = 1.5 }
motion = { kind = "translate", table = [[0, 0, 0, 0], [1, 0, 0, -2.5]] }
"""
BLOCK = """
[[body]]
name = "block"
geometry.shape = "torus"
geometry.major = 30
geometry.minor = 4
geometry.align = { centres = ["x", "y"], lows = ["z"] }
"""
PAD = """
[[slave]]
name = "pad"
points.grid = { shape = "plane", width = 20, length = 20, nu = 5, nv = 5 }
points.align = { to = "block", centres = ["x", "y"], lows = ["z"] }
"""
CASE = """
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 1.0, step = 0.5 }
PARTS
[[contact]]
master = "head"
slave = "pad"
law = { kind = "penalty", stiffness = 3.0 }
"""


def text(*parts: str) -> str:
    return CASE.replace("PARTS", "\n".join(parts))


@pytest.mark.parametrize("parts", [(HEAD, BLOCK, PAD), (BLOCK, PAD, HEAD), (PAD, HEAD, BLOCK)])
def test_parts_stand_the_same_in_whatever_order_the_file_has_them(parts: tuple[str, ...]) -> None:
    simulation = build(parse_case(text(*parts)))
    np.testing.assert_allclose(simulation.slaves["pad"].slave.points[:, 2], 0.0, atol=1e-9)
    centre = simulation.bodies["head"].body.bounds().mean(axis=0)
    np.testing.assert_allclose(centre, [0.0, 0.0, 11.5], atol=1e-8)
    order = ["head", "block"] if parts.index(HEAD) < parts.index(BLOCK) else ["block", "head"]
    assert [*simulation.bodies] == order


def test_motions_start_from_where_a_part_is_placed() -> None:
    state = build(parse_case(text(HEAD, BLOCK, PAD))).run().state
    assert state.contacts["head-pad"].penetration.max() == pytest.approx(1.0, abs=1e-8)


def test_the_resolved_copy_places_again() -> None:
    case = parse_case(text(HEAD, BLOCK, PAD))
    again = parse_case(resolved_toml(case))
    assert again == case
    assert build(again).fingerprint() == build(case).fingerprint()


def test_a_check_says_how_and_where_parts_are_placed() -> None:
    case = parse_case(text(HEAD, BLOCK, PAD))
    said = dict(describe(case))
    assert said["body head"].endswith("moved along [0.0, 0.0, -2.0] to a gap of 1.5 from pad")
    assert said["slave pad"].endswith("centres x, y and lows z aligned to block")
    assert (
        dict(placed_parts(build(case)))["body head"]
        == "20 × 20 × 20 mm, from [-10, -10, 1.5] to [10, 10, 21.5]"
    )


TURNED = """
[[body]]
name = "rod"
geometry.shape = "cylinder"
geometry.radius = 1.0
geometry.height = 8.0
motion = { kind = "rotate", axis = "x", table = [[0, 90], [1, 100]] }
[[body]]
name = "plate"
geometry.shape = "plane"
geometry.width = 2.0
geometry.length = 4.0
motion = { kind = "rotate", axis = "x", table = [[0, 90], [1, 100]] }
"""
LIFTED = 'motion = { kind = "translate", table = [[0, 0, 0, 5], [1, 0, 0, 2]] }'


def test_a_check_says_where_parts_stand_at_the_start_of_the_run() -> None:
    higher = HEAD.replace("[[0, 0, 0, 0]", "[[0, 0, 0, 7]")
    said = dict(placed_parts(build(parse_case(text(higher, BLOCK, PAD + LIFTED, TURNED)))))
    assert said["body head"] == "20 × 20 × 20 mm, from [-10, -10, 8.5] to [10, 10, 28.5]"
    assert said["slave pad"] == "20 × 20 × 0 mm, from [-10, -10, 5] to [10, 10, 5]"
    assert said["body rod"].startswith("2 × 8 × 2 mm, from [-1, -4, -1] to [1, 4, 1]")
    # Its free side is turned from z to −y.
    box, side = said["body plate"].split("; ")
    assert box.startswith("2 × ")
    assert "× 4 mm, from [-1, " in box
    assert [float(x) for x in side.split("[")[1][:-1].split(",")] == pytest.approx([0, -1, 0])


WRONG = {
    "circle": (
        BLOCK,
        'align = { centres = ["x", "y"], lows = ["z"] }',
        'place = { on = "head", direction = "z" }',
        "head by pad by block by head",
    ),
    "itself": (HEAD, 'on = "pad"', 'on = "head"', "head by head"),
    "unknown": (
        HEAD,
        'on = "pad"',
        'on = "pat"',
        "body[0].geometry.place.on: no body or slave of this name is defined; found 'pat'",
    ),
    "negative": (HEAD, "gap = 1.5", "gap = -1.5", "body[0].geometry.place.gap: is too small"),
    "zero": (
        HEAD,
        "[0, 0, -2]",
        "[0, 0, 0]",
        "body[0].geometry.place.direction: an axis must not be the zero vector",
    ),
    "key": (HEAD, "gap = 1.5", "gaps = 1.5", "Did you mean 'gap'?"),
    "nothing": (
        PAD,
        ', centres = ["x", "y"], lows = ["z"]',
        "",
        "slave[0].points.align: says nothing to align",
    ),
    "slaves": (
        PAD,
        'align = { to = "block", centres = ["x", "y"], lows = ["z"] }',
        'place = { on = "pad", direction = "z" }',
        "slave[0].points.place.on: a slave cannot be placed on a slave",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_told_in_one_message(name: str) -> None:
    part, old, new, said = WRONG[name]
    assert old in part
    parts = [p.replace(old, new) if p is part else p for p in (HEAD, BLOCK, PAD)]
    with pytest.raises(InputError) as caught:
        parse_case(text(*parts), Path("case.toml"))
    assert said in str(caught.value)
    assert "things are wrong" not in str(caught.value)


def test_a_way_that_leads_past_is_told_with_its_key() -> None:
    away = HEAD.replace("[0, 0, -2]", "[1, 0, 0]").replace(
        "radius = 10.0", "radius = 10.0\ngeometry.centre = [0, 0, 40]"
    )
    with pytest.raises(
        CaseError,
        match=r"body\[0\]\.geometry\.place\.direction: head never has a gap of 1\.5 from pad",
    ):
        build(parse_case(text(away, BLOCK, PAD)))


def test_a_series_of_files_is_not_placed(tmp_path: Path) -> None:
    for k in range(2):
        (tmp_path / f"s_{k}.csv").write_text("0,0,0\n", encoding="utf-8")
    pad = PAD.replace("[[slave]]", '[[slave]]\nmotion = { kind = "series", files = "s_*.csv" }')
    with pytest.raises(CaseError, match="a series of files says where the points are"):
        parse_case(text(HEAD, BLOCK, pad), tmp_path / "case.toml")
