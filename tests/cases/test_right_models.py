"""Models that are right: nothing is told of them, before a run or after it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest
from tests.cases.models import (
    BOX,
    CURVE,
    DROPPED,
    GRID,
    PRESSED,
    case_of,
    face,
    moved,
    on_spring,
    sphere,
)
from tests.sample import full

import contiga as cg


def right(name: str, base: str, often: bool = True, **swaps: str):
    return pytest.param(base, swaps, id=name, marks=() if often else (pytest.mark.full,))


def law(text: str) -> str:
    return f"law = {{ {text} }}"


MOVE = 'motion = { kind = "translate", table = [[0, 0, 0, 0], [5, 0, 0, 9], [10, 0, 0, 0]] }'
STRESS = f'kind = "stress", elastic = {CURVE}'

RIGHT = [
    right("as they are", PRESSED),
    right("dropped", DROPPED),
    right("the pad comes", PRESSED, fixed=MOVE, table=moved(0)),
    right("a cylinder", PRESSED,
          ball='{ shape = "cylinder", radius = 50.0, height = 80.0, axis = "x", '
          "centre = [0, 0, 52] }"),
    right("an ellipsoid", PRESSED, ball='{ shape = "ellipsoid", axes = [60.0, 50.0, 40.0], '
          "transform = [{ translate = [0, 0, 42] }] }"),
    right("a torus", PRESSED,
          ball='{ shape = "torus", major = 40.0, minor = 15.0, centre = [0, 0, 17] }'),
    right("a plate, an open face", PRESSED, ball='{ shape = "plane", width = 300.0, '
          'length = 300.0, transform = [{ rotate = { axis = "x", degrees = 180 } }, '
          "{ translate = [0, 0, 2] }] }"),
    right("in metres and kg", PRESSED.replace("120.0", "0.12").replace("20.0", "0.02"),
          units='mass = "kg"', ball=sphere(0.05, 0.052),
          table="[[0, 0, 0, 0], [5, 0, 0, -0.009], [10, 0, 0, 0]]",
          curve="[[0, 0], [0.1, 1e-4], [0.6, 4e-4], [0.9, 2e-3]]"),
    right("by penetration", PRESSED, law=f'{law(STRESS)}\nsearch = "penetration"'),
    right("starts inside, by penetration", PRESSED, ball=sphere(50.0, 48),
          law=f'{law(STRESS)}\nsearch = "penetration"'),
    right("a force over penetration", PRESSED,
          law=law('kind = "force", curve = [[0, 0], [5, 500], [20, 9000]]')),
    right("a penalty", PRESSED, law=law('kind = "penalty", stiffness = 10.0')),
    right("a modulus", PRESSED, curve="2.0"),
    right("damped", DROPPED, law=law(f"{STRESS}, damping = 0.2")),
    right("with friction", PRESSED,
          law=law(STRESS) + '\nfriction = { kind = "coulomb", static = 0.3 }'),
    right("points on facets", PRESSED, grid=GRID.replace("25", "9"),
          law=f"{law(STRESS)}\nquadrature = 6"),
    right("a cloud with its areas", PRESSED, grid=BOX.replace("500", "900"),
          nodal="thickness = 20.0\narea = 11.0\n"),
    right("a hand spring", DROPPED,
          last=on_spring(5.0)),
    right("a face that comes from afar", PRESSED, ball=face(60.0, 30, ", flip = true"),
          table=moved(-37)),
    right("the same by penetration", PRESSED, ball=face(60.0, 30, ", flip = true"),
          table=moved(-37), law=f'{law(STRESS)}\nsearch = "penetration"'),
    right("a face on a spring", DROPPED, often=False, ball=face(40.0, 15, ", flip = true"),
          velocity="velocity = [0, 0, -2.0]", last=on_spring(5.0)),
    right("a tube, open at its ends", PRESSED, ball='{ shape = "cylinder", radius = 10.0, '
          'height = 80.0, axis = "x", centre = [0, 0, 12] }'),
    right("a belt", DROPPED, last=on_spring("{ points = [[0, 0], [10, 3], [90, 40]], "
          'extrapolation = "constant" }')),
    right("gravity", DROPPED, world="[world]\ngravity = [0, 0, -9.81e-3]\n[time]"),
    right("a heavy block", DROPPED, mass="mass = { density = 7.85e-3 }", thick="thickness = 80.0",
          velocity="velocity = [0, 0, -1.0]", end="end = 60.0"),
]  # fmt: skip


@pytest.mark.parametrize(("base", "swaps"), RIGHT)
def test_a_right_model_is_told_nothing(base: str, swaps: dict[str, str]) -> None:
    simulation = case_of(base, swaps)
    assert simulation.check() == ()
    result = simulation.run()
    assert result.summary["warnings"] == []
    assert result.history["n_contact"].max() > 0


FOLDER = Path(__file__).parents[2] / "examples"
EXAMPLES = [path.stem for path in sorted(FOLDER.glob("0[2-9]*.toml"))]
RIGID = ("02_two_regions", "03_two_parts", "04_sled")


@pytest.mark.parametrize("name", [*RIGID, *full(*(n for n in EXAMPLES if n not in RIGID))])
def test_examples_are_told_nothing(name: str) -> None:
    path = FOLDER / f"{name}.toml"
    for file, maker in re.findall(r'"(generated/(\w+)\.\w+)"', path.read_text()):
        if not (FOLDER / file).exists():
            make = [sys.executable, str(FOLDER / f"make_{maker}.py"), str(FOLDER / file)]
            subprocess.run(make, check=True)
    assert cg.build(cg.load_case(path)).run().summary["warnings"] == []
