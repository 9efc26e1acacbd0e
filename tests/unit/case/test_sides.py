"""Who gives way in a contact: laws of contacts, and layers of bodies and their faces."""

from __future__ import annotations

import re

import numpy as np
import pytest

import contiga as cg
from contiga.case.schema import parse_case
from contiga.case.toml import resolved_toml
from contiga.errors import CaseError
from contiga.laws.by_face import FaceLaws
from contiga.laws.combined import CombinedLaw

STRESS = '{ kind = "stress", elastic = 4, thickness = 10 }'
SOFT = '{ kind = "stress", elastic = 1, thickness = 20 }'
FORCE = '{ kind = "force", curve = 2 }'
CASE = """
units = {{ length = "mm", mass = "g", time = "ms" }}
time = {{ end = 1.0, step = 1.0 }}
output = {{ formats = [], report = false }}
[[body]]
name = "bonnet"
geometry = {{ shape = "plane", width = 50, length = 50, transform = [{{ translate = [0, 0, 1] }}] }}
{bonnet}
[[body]]
name = "head"
geometry = {{ shape = "sphere", radius = 10, centre = [0, 0, 11.5] }}
motion = {{ kind = "translate", table = [[0, 0, 0, 0], [1, 0, 0, -1.5]] }}
{head}
[[slave]]
name = "skin"
points = {{ body = "head", tolerance = 0.2 }}
[[contact]]
master = "bonnet"
slave = "skin"
{contact}
"""


def case_of(*, bonnet: str = "", head: str = "", contact: str = "") -> cg.Case:
    return parse_case(CASE.format(bonnet=bonnet, head=head, contact=contact))


LAYER, SKIN = f"layer = {SOFT}", f"layer = {STRESS}"


@pytest.mark.parametrize(
    ("bonnet", "head", "contact", "kind", "law", "master_law"),
    [
        ("", "", f"law = {STRESS}", "slave", cg.StressLaw, None),
        ("", SKIN, "", "slave", cg.StressLaw, None),
        (LAYER, "", "", "master", cg.StressLaw, None),
        (LAYER, SKIN, "", "combined", cg.StressLaw, cg.StressLaw),
        (LAYER, "", f"law = {STRESS}", "combined", cg.StressLaw, cg.StressLaw),
        (LAYER, SKIN, 'type = "slave"', "slave", cg.StressLaw, None),
        (LAYER, SKIN, 'type = "master"', "master", cg.StressLaw, None),
        (LAYER, "", f'type = "slave"\nlaw = {FORCE}', "slave", cg.ForceLaw, None),
        (f"layer = {FORCE}", f"layer = {FORCE}", "", "combined", cg.ForceLaw, cg.ForceLaw),
        (f"{LAYER}\nface_layer = [{{ faces = [1], law = {STRESS} }}]", SKIN, "", "combined",
         cg.StressLaw, FaceLaws),
    ],
)  # fmt: skip
def test_what_gives_way_is_what_has_a_law(bonnet, head, contact, kind, law, master_law) -> None:
    case = case_of(bonnet=bonnet, head=head, contact=contact)
    sides = case.sides(case.contact[0])
    assert (sides.type, type(sides.law)) == (kind, law)
    assert isinstance(sides.master_law, type(None) if master_law is None else master_law)
    again = parse_case(resolved_toml(case))
    assert again.sides(again.contact[0]).type == kind


def test_both_sides_dent_in_series() -> None:
    """A head of foam on a bonnet of foam: what one of half their stiffness would feel."""
    case = case_of(bonnet=LAYER, head=SKIN)
    assert isinstance(cg.build(case).contacts[0].contact.law, CombinedLaw)
    # t/E of the sides: 20/1 and 10/4.
    one = '{ kind = "stress", elastic = 1, thickness = 22.5 }'
    both, alone = (cg.run(c).history["force"][-1] for c in (case, case_of(contact=f"law = {one}")))
    assert both > 0.0
    assert both == pytest.approx(alone, rel=1e-12)


def test_the_face_under_a_point_gives_way_by_its_own_layer() -> None:
    faces = f"layer = {SOFT}\nface_layer = [{{ faces = [1], law = {STRESS} }}]"
    forces = [
        cg.run(case_of(bonnet=text)).history["force"][-1]
        for text in (faces, f"layer = {STRESS}", f"layer = {SOFT}")
    ]
    np.testing.assert_allclose(forces, forces[0] * np.array([1.0, 1.0, 1.0 / 8.0]), rtol=1e-12)


@pytest.mark.parametrize(
    ("bonnet", "head", "contact", "message"),
    [
        ("", "", "", "contact[0].law: is missing; allowed: a law, or a body"),
        ("", SKIN, 'type = "master"', "contact[0].law: is missing"),
        ("", SKIN, 'type = "combined"', "contact[0].master_law: is missing"),
        (LAYER, "", f"law = {FORCE}", "contact[0].law: combined contact balances the stresses"),
        ("layer = { kind = 'stress', elastic = 1 }", "", "", "body[0].layer.thickness: is missing"),
        (f"face_layer = [{{ faces = [1], law = {SOFT} }}]", "", "", "body[0].layer: is missing"),
        ("", f"{SKIN}\nface_layer = [{{ faces = [1], law = {SOFT} }}]", "",
         "contact[0].law: is missing: only the master's side tells faces"),
        (f"{LAYER}\nface_layer = [{{ faces = [0], law = {SOFT} }}]", "", "",
         "body[0].face_layer[0].faces[0]: is too small"),
        (f"{LAYER}\nface_layer = [{{ faces = [1, 1], law = {SOFT} }}]", "", "", "two laws"),
    ],
)  # fmt: skip
def test_sides_that_cannot_be_are_refused(bonnet, head, contact, message: str) -> None:
    with pytest.raises(CaseError, match=re.escape(message)):
        case_of(bonnet=bonnet, head=head, contact=contact)


def test_a_face_that_is_not_there_is_refused_when_the_case_is_built() -> None:
    case = case_of(bonnet=f"{LAYER}\nface_layer = [{{ faces = [2], law = {SOFT} }}]")
    with pytest.raises(CaseError, match=r"contact\[0\].*no such face"):
        cg.build(case)
