"""Belts in a case: routed over its bodies, run, and what is refused of them."""

from __future__ import annotations

from pathlib import Path

import pytest

import contiga as cg
from contiga.case.columns import columns_of_case
from contiga.case.schema import parse_case
from contiga.case.toml import resolved_toml
from contiga.case.whole import load_whole
from contiga.errors import InputError

CASE = """
[units]
length = "mm"
mass = "g"
time = "ms"

[time]
end = 0.2
step = "auto"

[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 100.0 }

[[belt]]
name = "strap"
path = { start = [-200, 0, 0], end = [200, 0, 0], via = [[0, 0, 150]], over = ["ball"] }
kind = "KIND"
width = 50.0
thickness = 1.2
material = { kind = "elastic", young = 200.0, poisson = 0.3, compression = false }
density = 1.0e-3
shortening = 0.01
segments = 20

[[contact]]
master = "ball"
slave = "strap"
law = { kind = "penalty", stiffness = 10.0 }
friction = { kind = "coulomb", static = 0.3 }
"""


def case(kind: str = "bars", old: str = "", new: str = "") -> str:
    assert old in CASE
    return CASE.replace("KIND", kind).replace(old, new) if old else CASE.replace("KIND", kind)


@pytest.mark.parametrize("kind", ["bars", "ribbon"])
def test_a_belt_is_laid_and_presses_on_its_body(kind: str) -> None:
    simulation = cg.build(parse_case(case(kind)))
    (name,) = simulation.slaves
    assert name == "strap"
    result = simulation.run()
    assert result.history["force_z"][-1] > 0.0
    assert result.history["energy.strain"][0] > 0.0


def test_the_case_reads_back_as_the_same() -> None:
    one = parse_case(case("ribbon"))
    assert parse_case(resolved_toml(one)).belt == one.belt


def test_a_belt_has_the_columns_of_what_deforms() -> None:
    made = parse_case(case())
    history = cg.build(made).run().history
    energies = {name for name in columns_of_case(made) if name.startswith("energy.")}
    assert {"energy.strain", "energy.hourglass"} <= energies <= set(history)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("width = 50.0", "width = 0.0", "belt[0].width"),
        ('over = ["ball"]', "over = []", "belt[0].path.over"),
        (', over = ["ball"]', "", "belt[0].path.over: is missing"),
        ('over = ["ball"]', 'over = ["bell"]', "belt[0].path.over[0]: no body"),
        ("end = [200, 0, 0]", "end = [-200, 0, 0]", "belt[0].end: a path ends in another point"),
        ("[[0, 0, 150]]", "[[0, 0, 50]]", "belt[0].via[0]: lies 50 inside ball"),
        ("start = [-200, 0, 0]", "start = [-20, 0, 0]", "belt[0].start: lies 80 inside ball"),
        ("segments = 20", 'anchors = ["ground", "bell"]', "belt[0].anchors[1]: no body"),
        ("segments = 20", "shortening = 1.0", "belt[0].shortening"),
        ("segments = 20", "segment = 20", "did you mean"),
        ('kind = "elastic", young = 200.0, poisson = 0.3, compression = false',
         'kind = "fabric", warp = 1.0, shear = 0.1, direction = [1, 0, 0]', "belt[0]"),
    ],
)  # fmt: skip
def test_a_wrong_belt_is_told_with_its_key(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = case("bars", old, new)
    if new == "shortening = 1.0":
        text = text.replace("shortening = 0.01\n", "")
    file = tmp_path / "case.toml"
    file.write_text(text)
    with pytest.raises(InputError) as told:
        cg.build(load_whole(file))
    assert said.lower() in str(told.value).lower()
    assert str(told.value).count("\n") == 0


def test_a_belt_and_a_body_or_a_slave_have_names_of_their_own() -> None:
    with pytest.raises(InputError, match=r"belt\[0\].name: a body and a slave must not"):
        parse_case(case(old='name = "strap"', new='name = "ball"'))
    slave = '[[slave]]\nname = "strap"\npoints = { coordinates = [[0, 0, 500]] }\n\n[[contact]]'
    with pytest.raises(InputError, match=r"belt\[0\].name: a slave has this name"):
        parse_case(case(old="[[contact]]", new=slave))
