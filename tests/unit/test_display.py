"""Records and objects print as one line that says what is in them, and as a table in a notebook."""

from __future__ import annotations

import re

import numpy as np
import pytest

import contiga as cg
from contiga.display import counted, line_of, table_of

BALL = cg.Body([cg.shapes.sphere(radius=1.0)], name="ball")
PAD = cg.Slave([[0.0, 0.0, 1.2], [0.0, 0.0, 1.5]], area=[1.0, 1.0], name="pad", unit="mm")
CONTACT = cg.Contact(BALL, PAD, law=cg.PenaltyLaw(100.0))
DOWN = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -0.4]])


def shown() -> dict[str, tuple[object, str]]:
    simulation = cg.Simulation(
        bodies={"ball": BALL}, slaves={"pad": (PAD, DOWN)}, contacts=[CONTACT], end=1.0, step=0.5
    )
    result = simulation.run()
    state = result.state
    points = np.array([[0.0, 0.0, 2.0], [0.0, np.nan, 0.0]])
    feet = BALL.project(points)
    hits = BALL.first_hit([[0.0, 0.0, 2.0], [3.0, 0.0, 2.0]], [[0.0, 0.0, 0.5], [3.0, 0.0, 0.5]])
    mesh = BALL.tessellate(0.1)
    return {
        "body": (BALL, "Body('ball', patches 1, trimmed 0)"),
        "mesh": (mesh, f"TriMesh('ball', vertices {len(mesh.vertices)}, triangles \\d+)"),
        "slave": (PAD, "Slave('pad', points 2, active 2, facets 0, unit mm)"),
        "contact": (CONTACT, "Contact(slave pad, master ball, law PenaltyLaw, .*quadrature nodes)"),
        "state": (
            state.contacts["ball-pad"],
            "State(points 2, in contact 1, deepest 0.2, force .*, not proved 0)",
        ),
        "system": (
            state,
            "SystemState(time 1, bodies 1, slaves 1, contacts 1, in contact 1, stored 2)",
        ),
        "simulation": (
            simulation,
            "Simulation(bodies ball, slaves pad, contacts ball-pad, time (0, 1), steps 2)",
        ),
        "result": (
            result,
            "Result(steps 3, end 1, in contact 1, warnings 0, states kept 0, folder none)",
        ),
        "feet": (feet, "Projection(points 2, OK 1, NOT_FINITE 1, certified 1)"),
        "hits": (hits, "Hit(segments 2, OK 1, NO_HIT 1)"),
    }


def test_everything_prints_as_one_line_and_as_a_table() -> None:
    for what, (value, line) in shown().items():
        pattern = line.replace("(", r"\(").replace(")", r"\)").replace(r"\\(", r"\(")
        assert re.fullmatch(pattern, repr(value)), (what, repr(value))
        table = value._repr_html_()  # type: ignore[attr-defined]
        assert table.startswith("<table>")
        assert table.count("<tr>") >= 2


def test_what_a_user_named_is_escaped() -> None:
    assert "<b>" not in table_of("Body", [("a<b>", "c<b>")], "<b>")
    assert line_of("Body", [("x", 0.1 + 0.2)], "it's") == 'Body("it\'s", x 0.3)'


@pytest.mark.parametrize(("counts", "left"), [([0, 2], [("b", 2)]), ([0, 0], [])])
def test_only_what_occurs_is_counted(counts: list[int], left: list[tuple[str, int]]) -> None:
    assert counted(["a", "b"], counts) == left
