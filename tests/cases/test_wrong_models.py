"""Models that are wrong, each in a way that runs: what is said of them, and that right ones are
told nothing."""

from __future__ import annotations

import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from tests.cases.models import (
    BOX,
    CURVE,
    DROPPED,
    GRID,
    MASS,
    PLANE,
    PRESSED,
    SPHERE,
    case_of,
    face,
    moved,
    on_joint,
    on_spring,
    sphere,
)

import contiga as cg
from contiga.case.schema import parse_case
from contiga.errors import InputError


def wrong(name: str, base: str, rule: str, *words: str, full: bool = False, **swaps: str):
    marks = (pytest.mark.full,) if full else ()
    return pytest.param(base, swaps, rule, words, id=name, marks=marks)


def refused(name: str, base: str, old: str, new: str, *words: str):
    return pytest.param(base, old, new, words, id=name)


SHEET = 'motion = { kind = "deform", density = 1e-3, material = { kind = "elastic", young = 1.0 } }'
BEFORE = [
    wrong("a step too long for elements", PRESSED, "critical", "slave pad: the step of 0.25",
          "Take a step below", fixed=SHEET),
    wrong("masses scaled far up", PRESSED, "scaled", "slave pad: mass scaling gives",
          "Ask for a shorter step", fixed=SHEET.replace("density", "mass_scaling = 1.0, density")),
    wrong("a larger ball", PRESSED, "inside", "of 625 points of pad start inside ball",
          "8 mm deep", 'search = "penetration"', ball=sphere(60.0, 52)),
    wrong("a start inside", PRESSED, "inside", "28 mm deep", ball=sphere(50.0, 22)),
    wrong("a drop from inside", DROPPED, "inside", "12 mm deep", ball=sphere(50.0, 38)),
    wrong("inside a little", PRESSED, "inside", "1 of 625 points", "0.01 mm",
          ball=sphere(50, 49.99)),
    wrong("a ball in metres", PRESSED, "sizes", "980 times less", "m where mm are thought",
          ball=sphere(0.05, 0.052)),
    wrong("a ball in metres stays away", PRESSED, "apart", "never comes closer",
          ball=sphere(0.05, 20)),
    wrong("a pad in metres", PRESSED, "sizes", "pad",
          grid=GRID.replace("120.0", "0.12")),
    wrong("far away", PRESSED, "apart", "never comes closer to ball than 1193 mm", "at t = 5 ms",
          ball=sphere(50.0, 1252)),
    wrong("just short", PRESSED, "apart", "than 0.5 mm", table=moved(-1.5)),
    wrong("the wrong way", PRESSED, "apart", "than 2 mm", "at t = 0 ms", table=moved(9)),
    wrong("beside it", PRESSED, "apart",
          ball='{ shape = "sphere", radius = 50.0, centre = [150, 0, 52] }'),
    wrong("flies the wrong way", DROPPED, "apart", "in free flight",
          velocity="velocity = [0, 0, 3.0]"),
    wrong("flies past", DROPPED, "apart", "in free flight", velocity="velocity = [30.0, 0, -3.0]",
          ball='{ shape = "sphere", radius = 50.0, centre = [70, 0, 58] }'),
    wrong("stops before", DROPPED, "apart", velocity="velocity = [0, 0, -0.05]"),
    wrong("does not move", PRESSED, "still", "neither ball nor pad moves", table=moved(0)),
    wrong("normals point inward", PRESSED, "inward", "flip = true",
          ball=SPHERE.replace(" }", ", flip = true }")),
    wrong("inward, by penetration", PRESSED, "inward", ball=SPHERE.replace(" }", ", flip = true }"),
          law=f'law = {{ kind = "stress", elastic = {CURVE} }}\nsearch = "penetration"'),
    wrong("a face turned away", PRESSED, "behind", "an open face", "flip = true",
          ball=PLANE.replace("0] }", "3], flip = false }")),
    wrong("a cap upside down", PRESSED, "behind",
          ball='{ shape = "plane", width = 200.0, length = 200.0, centre = [0, 0, 1] }'),
    wrong("a small face turned away", PRESSED, "behind", "169 of 625", "up to 5 mm",
          "flip = true in ball", ball=face(60.0, 5)),
    wrong("a face that comes from behind, and back", PRESSED, "behind", "at t = 4.5 ms",
          "flip = true in ball", ball=face(60.0, 30), table=moved(-37)),
    wrong("the same by penetration", PRESSED, "behind", "flip = true in ball",
          ball=face(60.0, 30), table=moved(-37),
          law=f'law = {{ kind = "stress", elastic = {CURVE} }}\nsearch = "penetration"'),
    wrong("a start behind by penetration", PRESSED, "behind", "169 points", "up to 5 mm",
          "come out through it", "flip = true in ball", ball=face(60.0, 5),
          law=f'law = {{ kind = "stress", elastic = {CURVE} }}\nsearch = "penetration"'),
    wrong("a face that falls through", DROPPED, "behind", "flip = true in ball",
          ball=face(60.0, 40)),
    wrong("deeper than the pad", PRESSED, "thickness", "reaches 23 mm", "20 mm thick",
          table=moved(-25)),
    wrong("a thin pad", PRESSED, "thickness", "reaches 7 mm", "2 mm thick",
          thickness="thickness = 2.0"),
    wrong("a thickness in metres", PRESSED, "thickness", "0.02 mm", thickness="thickness = 0.02"),
    wrong("a thickness in micrometres", PRESSED, "thickness", "layer is 2e+04 mm thick",
          thickness="thickness = 20000.0"),
    wrong("beyond the table", PRESSED, "table", "strain reaches 0.35", "ends at 0.2",
          "continued straight on", curve="[[0, 0], [0.1, 0.1], [0.2, 0.2]]"),
    wrong("beyond the table, held",
        PRESSED,
        "table",
        "held at its last value",
        curve='{ points = [[0, 0], [0.1, 0.1], [0.2, 0.2]], extrapolation = "constant" }',
    ),
    wrong("beyond a table of forces", PRESSED, "table", "penetration reaches 7 mm", "at 3 mm",
          law='law = { kind = "force", curve = [[0, 0], [1, 100], [3, 900]] }'),
    wrong("MPa where stresses are GPa", PRESSED, "stress", "0.34 GPa", "stresses are in GPa",
          units='mass = "kg"'),
    wrong("Pa where stresses are MPa", PRESSED, "stress", "MPa",
          curve="[[0, 0], [0.1, 1e5], [0.6, 4e5], [0.9, 2e6]]"),
    wrong("a curve far too soft", PRESSED, "stress", "that soft",
          curve="[[0, 0], [0.1, 1e-8], [0.6, 4e-8], [0.9, 2e-7]]"),
    wrong("a curve of tensions", PRESSED, "curve", "never pushes",
          curve="[[0, 0], [0.1, -0.1], [0.6, -0.4]]"),
    wrong("a curve that falls to nothing", PRESSED, "curve", "falls from 0.3 MPa",
          curve="[[0, 0.3], [0.9, 0]]"),
    wrong("strains in percents of percents", PRESSED, "curve", "ends at a strain of 0.009",
          curve="[[0, 0], [0.001, 0.1], [0.006, 0.4], [0.009, 2.0]]"),
    wrong("kPa where stresses are MPa", PRESSED, "stress", "that soft",
          curve="[[0, 0], [0.1, 1e-4], [0.6, 4e-4], [0.9, 2e-3]]"),
    wrong("a cloud of unit areas", PRESSED, "weights", "stands for 1e+04 mm²",
          grid=BOX, nodal="thickness = 20.0\narea = 10000.0\n"),
    wrong("a cloud with areas in m²", PRESSED, "weights",
          grid=BOX, nodal="thickness = 20.0\narea = 2e-5\n"),
    wrong("one step right in", PRESSED, "step", "in the one step to t = 5", "shorter",
          step="step = 5.0", table="[[0, 0, 0, 0], [5, 0, 0, -14.9], [10, 0, 0, -19]]",
          ball=sphere(50.0, 50.1)),
    wrong("a body nobody touches", PRESSED, "unused", "no contact, spring, joint, load or sensor",
          slave='[[body]]\nname = "wall"\ngeometry = { shape = "plane", width = 1.0, '
          'length = 1.0 }\n[[contact]]'),
    wrong("a slave nobody touches", PRESSED, "unused", "slave dust",
          slave=f'[[slave]]\nname = "dust"\npoints = {BOX}\n[[contact]]'),
    wrong("the same contact twice", PRESSED, "twice", "both push",
          slave=f'[[contact]]\nname = "again"\nmaster = "ball"\nslave = "pad"\n'
          f'law = {{ kind = "stress", elastic = {CURVE} }}\n[[contact]]'),
    wrong("a pad whose nodes are free", PRESSED, "dust", "625 nodes are free masses of their own",
          fixed='motion = { kind = "free" }', nodal="thickness = 20.0\nmass = 0.1\n"),
    wrong("a joint that is open", DROPPED, "joint", "moves 1 free body", "moved by 10 mm",
          last=on_joint("spherical", "[[0, 0, 162], [0, 0, 152]]")),
    wrong("a velocity that a joint does not allow", DROPPED, "joint", "differs by 3 mm/ms",
          last=on_joint("spherical", "[0, 0, 152]")),
    wrong("a mass in kg", DROPPED, "mass", "its mass is 0.001 g",
          mass="mass = { total = 0.001 }"),
    wrong("a mass in mg", DROPPED, "mass", "1e+09 g", mass="mass = { total = 1e9 }"),
    wrong("an inertia in kg m²", DROPPED, "inertia", "g·mm²",
          mass="mass = { total = 1000.0, inertia = [1e-3, 1e-3, 1e-3, 0, 0, 0] }"),
    wrong("an inertia of another body", DROPPED, "inertia",
          mass="mass = { total = 1000.0, inertia = [1e10, 1e10, 1e10, 0, 0, 0] }"),
    wrong("gravity in m/s²", DROPPED, "gravity", "9810 m/s²", "0.009807",
          world="[world]\ngravity = [0, 0, -9.81]\n[time]"),
    wrong("gravity in mm/s²", DROPPED, "gravity", world="[world]\ngravity = [0, 0, -9810]\n[time]"),
    wrong("a velocity in km/h and s", DROPPED, "velocity", "mm/ms",
          velocity="velocity = [0, 0, -300000.0]"),
    wrong("a velocity in mm/s", DROPPED, "velocity", "times the size of the largest part",
          velocity="velocity = [0, 0, -3000.0]"),
    wrong("a sensor in metres away", DROPPED, "far", "sensor middle",
          sensor="at = [0, 0, 52000]\n"),
    wrong("a load far off", DROPPED, "far", "load 0",
          last='[[load]]\nbody = "ball"\nforce = [1.0, 0, 0]\nat = [5000, 0, 0]\n'
          '[[sensor]]\nname = "middle"\nbody = "ball"\n'),
    wrong("a spring far off", DROPPED, "far", "spring ball-ground",
          last='[[spring]]\nbetween = ["ball", "ground"]\nat = [[0, 9000, 0], [0, 0, 0]]\n'
          'curve = 1.0\n[[sensor]]\nname = "middle"\nbody = "ball"\n'),
    wrong("a case in km", PRESSED.replace('"mm"', '"km"'), "sizes", "1.73e+05 m"),
    wrong("friction in percents", PRESSED, "friction", "is 30",
          law=f'law = {{ kind = "stress", elastic = {CURVE} }}\n'
          'friction = { kind = "coulomb", static = 30.0 }'),
    wrong("viscous friction in percents", PRESSED, "friction", "is 40",
          law=f'law = {{ kind = "stress", elastic = {CURVE} }}\n'
          'friction = { kind = "viscous-regularised", coefficient = 40.0, speed = 0.1 }'),
    wrong("damping in percents", PRESSED, "damping", "10 times the critical",
          law='law = { kind = "penalty", stiffness = 10.0, damping_ratio = 10.0 }',
          nodal="thickness = 20.0\nmass = 1.0\n"),
    wrong("a step a thousandth as long", PRESSED.replace("step = 0.25", "step = 5e-5"), "steps",
          "2e+05", "5e-05"),
    wrong("a largest step a thousandth as long",
          DROPPED.replace('step = "auto"', 'step = "auto"\nlargest = 1e-4'), "steps", "2e+05"),
    wrong("times in seconds", PRESSED, "span", "from t = 0 to 0.01 ms", "Give times in ms",
          table="[[0, 0, 0, 0], [0.005, 0, 0, -9], [0.01, 0, 0, 0]]"),
]  # fmt: skip
"""Told before a run."""

REFUSED = [
    refused("an end before the start", PRESSED, "end = 10.0", "end = -10.0", "time"),
    refused("a step of nothing", PRESSED, "step = 0.25", "step = 0", "time.step: is too small"),
    refused("a unit of time for a length", PRESSED, '"mm"', '"ms"', "units.length"),
    refused("a number as text", PRESSED, "50.0", '"50"', "radius: must be a number"),
    refused("a negative radius", PRESSED, "50.0", "-50.0", "body[0].geometry"),
    refused("a shape that is none", PRESSED, '"sphere"', '"shpere"', "Did you mean 'sphere'?"),
    refused("a point of two numbers", PRESSED, "[0, 0, 52]", "[0, 52]", "centre"),
    refused("a motion that is none", PRESSED, '"translate"', '"move"', "motion.kind: unknown kind"),
    refused("a table that goes back", PRESSED, "[5, 0, 0, -9]", "[12, 0, 0, -9]", "motion"),
    refused("a master that is none", PRESSED, 'master = "ball"', 'master = "bal"',
            "contact[0].master: no body", "Did you mean 'ball'?"),
    refused("a slave as master", PRESSED, 'master = "ball"', 'master = "pad"',
            "'pad' is a slave"),
    refused("no thickness", PRESSED, "thickness = 20.0", "", "contact[0].law"),
    refused("a thickness of nothing", PRESSED, "thickness = 20.0", "thickness = 0",
            "slave[0].thickness: is too small"),
    refused("a grid of one", PRESSED, "nu = 25", "nu = 1", "nu"),
    refused("a curve of one number a point", PRESSED, "[0.1, 0.1]", "[0.1]", "elastic"),
    refused("a curve that goes back", PRESSED, "[0.1, 0.1]", "[0.7, 0.1]", "contact[0].law"),
    refused("a free body without mass", DROPPED, MASS, "", "body[0].mass: is missing"),
    refused("an inertia that no body has", DROPPED, "1e6, 1e6, 1e6", "1e6, 1e6, 9e6",
            "body[0].mass"),
    refused("a sensor on nothing", DROPPED, 'body = "ball"', 'body = "bowl"', "sensor[0].body"),
    refused("a criterion that is none", DROPPED, "at = [0, 0, 52]\n",
            'at = [0, 0, 52]\ncriteria = ["HIC"]\n', "sensor[0]", "'HIC15'"),
    refused("spin left out for BrIC", DROPPED, "at = [0, 0, 52]\n",
            'at = [0, 0, 52]\ncriteria = ["BrIC"]\n', 'Add "spin" to its measures'),
]  # fmt: skip
"""Told instead of a run."""

AFTER = [
    wrong("tunnelling through a thin plate", PRESSED, "through", "points leave ball from up to",
          full=True,
          ball='{ shape = "ellipsoid", axes = [12.0, 12.0, 3.0], centre = [0, 0, 5] }',
          table=moved(-19),
          grid=GRID.replace("120.0", "30.0")),
    wrong("one long step", DROPPED, "step", "in the one step to t = 8 ms", "22 mm deeper",
          auto="step = 8.0\nallow_unstable = true"),
    wrong("stopped before the peak", DROPPED, "unfinished", "when the run ends", end="end = 6.0"),
    wrong("stopped on the way back", DROPPED, "unfinished", "when the run ends", end="end = 9.0",
          full=True),
    wrong("a drop through the pad", DROPPED, "thickness", "4 mm thick", thick="thickness = 4.0"),
    wrong("a drop beyond the table", DROPPED, "table", curve="[[0, 0], [0.1, 0.1], [0.3, 0.2]]",
          thick="thickness = 40.0"),
    wrong("a spring beyond its table", DROPPED, "table", "spring ball-ground: the elongation",
          "its curve ends at 8 mm", "continued straight on", full=True,
          last=on_spring("[[0, 0], [5, 30], [8, 90]]")),
    wrong("a belt without slack", DROPPED, "table", "its curve begins at 0 mm", "is to be slack",
          velocity="velocity = [0, 0, 3.0]", last=on_spring("[[0, 0], [10, 300], [90, 900]]")),
    wrong("damping that does it all", DROPPED, "damping", "% of the work",
          law=f'law = {{ kind = "stress", elastic = {CURVE}, damping = 20.0 }}'),
    wrong("a mesh too coarse", PRESSED, "coarse", "nodes are in contact", "quadrature",
          grid=GRID.replace("25", "5")),
    wrong("a spring pulls it back", DROPPED, "apart", "in the whole run",
          full=True, last=on_spring(5000)),
    wrong("a face on a spring, turned away", DROPPED, "behind", "passed it without contact",
          "flip = true in ball", ball=face(60.0, 30), velocity="velocity = [0, 0, -5.0]",
          last=on_spring(5)),
    wrong("a face that a spring pulls from behind", DROPPED, "behind", "and meet it",
          "flip = true in ball", ball=face(60.0, 30), velocity="velocity = [0, 0, -5.0]",
          full=True, last=on_spring(20), thick="thickness = 80.0"),
    wrong("both sides of a shell",
        PRESSED,
        "layers",
        "both sides of pad",
        grid='{ grid = { shape = "cylinder", radius = 3.0, height = 40.0, axis = "x", nu = 31, '
        "nv = 21 }, transform = [{ translate = [0, 0, -2] }] }",
        table=moved(-14.5),
    ),
]  # fmt: skip
"""Told after it."""


@pytest.mark.parametrize(("base", "swaps", "rule", "words"), BEFORE)
def test_a_wrong_model_is_told_before_it_runs(base, swaps, rule, words) -> None:
    findings = case_of(base, swaps).check()
    texts = [str(finding) for finding in findings if finding.rule == rule]
    assert texts, [finding.rule for finding in findings]
    for word in words:
        assert any(word in text for text in texts), texts


@pytest.mark.parametrize(("base", "old", "new", "words"), REFUSED)
def test_what_cannot_run_is_refused_in_one_message(base, old, new, words) -> None:
    assert old in base
    at = base.rindex(old) if old.startswith("body") else base.index(old)
    with pytest.raises(InputError) as caught:
        cg.build(parse_case(base[:at] + new + base[at + len(old) :]))
    assert "things are wrong" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize(("base", "swaps", "rule", "words"), AFTER)
def test_a_run_tells_what_is_wrong_with_its_model(base, swaps, rule, words) -> None:
    simulation = case_of(base, swaps)
    assert rule not in [finding.rule for finding in simulation.check()]
    summary = simulation.run().summary
    texts = [str(cg.Finding(**f)) for f in summary["findings"] if f["rule"] == rule]
    assert texts, [finding["rule"] for finding in summary["findings"]]
    assert set(texts) <= set(summary["warnings"])
    for word in words:
        assert any(word in text for text in texts), texts


def test_a_velocity_that_nothing_has_is_refused() -> None:
    simulation = case_of(DROPPED, {"velocity": "velocity = [0, 0, -3.0e6]"})
    with pytest.raises(InputError, match=r"body ball: it would start at 3e\+06 m/s; found '3e"):
        simulation.check()


def test_what_is_pressed_in_from_the_start_is_not_taken_for_turned_away() -> None:
    law = f'law = {{ kind = "stress", elastic = {CURVE} }}\nsearch = "penetration"'
    right = PLANE.replace("0] }", "-1], flip = true }")
    assert [one.rule for one in case_of(PRESSED, {"ball": right, "law": law}).check()] == []


@pytest.mark.parametrize(("turn", "told"), [(0.0, False), (180.0, True)])
def test_a_solid_touched_from_within_is_told(tmp_path: Path, turn: float, told: bool) -> None:
    """A block of one brick, its upper side chosen, under a ball that comes down or up."""
    block = tmp_path / "block.vtu"
    corners = np.array(
        [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float
    )
    meshio.write(block, meshio.Mesh(corners, [("hexahedron", np.arange(8)[None])]))
    top = cg.read_mesh(block).selected(side=([0, 0, 1], 30.0))
    ball = cg.Body([cg.shapes.sphere(radius=2.0, centre=(0.5, 0.5, 3.1))])
    way = -0.5
    if turn:
        ball, way = cg.Body([cg.shapes.sphere(radius=2.0, centre=(0.5, 0.5, -1.1))]), 0.5
    move = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, way]])
    simulation = cg.Simulation(
        bodies={"ball": (ball, move)},
        slaves={"top": top},
        contacts=[cg.Contact(ball, top, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step=0.1,
    )
    assert ("side" in [finding.rule for finding in simulation.check()]) == told


def test_a_slave_without_active_points_is_told() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    pad = cg.Slave([[0, 0, 1.1], [0.1, 0, 1.1]], area=[0.01, 0.01], active=[False, False])
    contact = cg.Contact(ball, pad, law=cg.PenaltyLaw(1.0))
    down = cg.motion.Translate([[0, 0, 0, 0], [1, 0, 0, -0.2]])
    simulation = cg.Simulation(
        bodies={"ball": ball}, slaves={"pad": (pad, down)}, contacts=[contact], end=1.0, step=0.1
    )
    (finding,) = simulation.check()
    assert (finding.rule, finding.where) == ("inactive", "slave pad")
    assert "none of its 2 points takes part" in finding.text


def test_strict_refuses_a_wrong_model_before_its_first_step(tmp_path: Path) -> None:
    simulation = case_of(PRESSED, {"table": moved(-1.5)})
    with pytest.raises(cg.errors.InputError, match=r"contact ball-pad: pad never comes closer"):
        simulation.run(tmp_path / "out", strict=True)
    assert not (tmp_path / "out").exists()


def test_every_rule_of_the_page_has_a_wrong_model_here() -> None:
    page = (Path(__file__).parents[2] / "docs" / "checks.md").read_text(encoding="utf-8")
    told = {
        (rule, when)
        for rule, whens in re.findall(r"^\| `(\w+)` \| ([a-z, ]+) \|", page, re.M)
        for when in whens.split(", ")
    }
    tried = {(case.values[2], "before") for case in BEFORE}
    tried |= {("inactive", "before"), ("side", "before"), ("file", "before"), ("lone", "before")}
    tried |= {(case.values[2], "after") for case in AFTER} | {("jump", "after")}
    of_matter = "density", "modulus", "rates", "locking", "torn", "held", "coarse", "open", "gas"
    tried |= {(rule, "before") for rule in of_matter} | {("hourglass", "after"), ("deep", "after")}
    assert told == tried


@pytest.mark.parametrize("what", ["load", "spring", "sensor"])
def test_a_place_a_million_sizes_away_is_refused_before_the_run(what: str) -> None:
    """Its lever turned the body so fast that the steps never came to an end."""
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    far = [0.0, 1e12, 0.0]
    given: dict[str, object] = {
        "load": {"loads": [cg.Load("ball", force=[1.0, 0.0, 0.0], at=far)]},
        "spring": {"springs": {"s": cg.Spring(["ball", "ground"], at=[far, [0, 0, 0]], curve=1.0)}},
        "sensor": {"sensors": [cg.Sensor("cg", "ball", at=far)]},
    }[what]
    mass = cg.motion.Free(mass=1.0, inertia=np.eye(3), centre=[0, 0, 0])
    point = cg.Slave([[0.0, 0.0, 2.0]], area=[1.0])
    simulation = cg.Simulation(
        bodies={"ball": (ball, mass)},
        slaves={"point": point},
        contacts=[cg.Contact(ball, point, law=cg.PenaltyLaw(1.0))],
        end=1.0,
        step="auto",
        **given,  # type: ignore[arg-type]
    )
    for refused in (simulation.check, simulation.run):
        with pytest.raises(
            cg.errors.InputError, match=r"times its size away from it; found '\[0, 1e"
        ):
            refused()
