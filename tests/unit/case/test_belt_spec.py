"""Belts in a case: routed over its bodies, run, and what is refused of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.unit.simulation.sameness import same_states

import contiga as cg
from contiga.belts import Retractor
from contiga.case.build import belts_of
from contiga.case.columns import columns_of_case
from contiga.case.describe import describe
from contiga.case.schema import parse_case
from contiga.case.toml import resolved_toml
from contiga.case.whole import load_case_to_build
from contiga.errors import InputError, RunError

CASE = """
[units]
length = "mm"
mass = "g"
time = "ms"

[time]
end = 0.5
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
    assert result.history["force_z"].max() > 50.0
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
        cg.build(load_case_to_build(file))
    assert said.lower() in str(told.value).lower()
    assert str(told.value).count("\n") == 0


def test_a_belt_and_a_body_or_a_slave_have_names_of_their_own() -> None:
    with pytest.raises(InputError, match=r"belt\[0\].name: a body and a slave must not"):
        parse_case(case(old='name = "strap"', new='name = "ball"'))
    slave = '[[slave]]\nname = "strap"\npoints = { coordinates = [[0, 0, 500]] }\n\n[[contact]]'
    with pytest.raises(InputError, match=r"belt\[0\].name: a slave has this name"):
        parse_case(case(old="[[contact]]", new=slave))


HELD = """
[units]
length = "mm"
mass = "g"
time = "ms"

[time]
end = 10.0
step = "auto"

[[body]]
name = "sled"
geometry = { shape = "plane", width = 400.0, length = 200.0, centre = [-250, 0, -150] }

[[body]]
name = "ball"
geometry = { shape = "sphere", radius = 100.0 }
mass = { total = 3000.0 }
motion = { kind = "free", velocity = [10, 0, 0], hold = ["y", "z", "rx", "ry", "rz"] }

[[belt]]
name = "strap"
path = { start = [20, 0, 200], end = [20, 0, -200], via = [[150, 0, 0]], over = ["ball"] }
anchors = ["sled", "ground"]
start = { length = 100.0 }
kind = "KIND"
width = 50.0
thickness = 1.2
MATERIAL
density = 1.0e-3
segments = 12
across = 1

[[spring]]
name = "webbing"
between = ["ground", "sled"]
at = [[20, 100, 200], [20, 0, 200]]
curve = 300.0
retractor = { spool = 5.0, lock = { trigger = "hit" } }
limiter = { force = 2000.0 }
pretensioner = { trigger = "hit", pull = [[0, 0], [2, 20]] }

[[slip_ring]]
name = "ring"
between = ["webbing", "strap start"]
friction = 0.2

[[sensor]]
name = "hit"
body = "ball"
trigger = { channel = "vx", below = 9.999 }

[[contact]]
master = "ball"
slave = "strap"
law = { kind = "penalty", stiffness = 20.0 }
friction = { kind = "coulomb", static = 0.2 }
"""
BARS = 'material = { kind = "belt", loading = 1e5 }'
CLOTH = 'material = { kind = "elastic", young = 1667.0, compression = false }'


OTHER = """[[spring]]
name = "strap start"
between = ["ground", "ball"]
at = [[0, 0, 300], [0, 0, 0]]
curve = 1.0
"""


def held(kind: str = "bars", old: str = "", new: str = "") -> str:
    text = HELD.replace("KIND", kind).replace("MATERIAL", BARS if kind == "bars" else CLOTH)
    if kind != "bars":
        text = text.replace("length = 100.0 }", "length = 100.0, curve = 1000.0 }")
    assert old in text
    return text.replace(old, new) if old else text


@pytest.mark.parametrize("kind", ["bars", "ribbon", "membrane"])
def test_a_belt_on_a_retractor_and_a_ring_stops_its_body(kind: str) -> None:
    made = parse_case(held(kind))
    result = cg.build(made).run()
    history = result.history
    assert set(columns_of_case(made)) <= {*history, *(f"ball-strap.{name}" for name in history)}
    assert history["ball.vx"][-1] < 7.0
    assert result.summary["springs"]["webbing"]["locked"] is not None
    assert history["webbing.paid_out"].min() < -1.0
    slips = np.diff(history["ring.slipped"], prepend=0.0) > 1e-6
    ratio = history["strap start.force"][slips] / history["webbing.force"][slips]
    np.testing.assert_allclose(ratio, np.exp(0.2 * history["ring.angle"][slips]), rtol=1e-9)
    came = history["energy.total"][0] + history["energy.external"].max()
    assert np.abs(history["energy.error"]).max() < 1e-3 * came
    # The pull on the last row of nodes is what the belt carries there, but for its inertia.
    force = history["strap start.force"]
    assert force.max() > 1000.0


def test_a_belt_with_devices_that_was_killed_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    def kill(done: int, total: int, touching: int) -> None:
        if done == 200:
            raise KeyboardInterrupt

    simulation = cg.build(parse_case(held("ribbon", "end = 10.0", "end = 5.0")))
    whole = simulation.run()
    with pytest.raises(KeyboardInterrupt):
        simulation.run(tmp_path / "out", progress=kill)
    resumed = simulation.run(tmp_path / "out", resume=True)
    same_states(whole.state, resumed.state)
    np.testing.assert_array_equal(
        whole.history["strap start.force"], resumed.history["strap start.force"]
    )


def test_webbing_that_is_used_up_is_told() -> None:
    pulled = held("bars", "length = 100.0", "length = 1.0")
    with pytest.raises(RunError, match="spring 'strap start' has no webbing left: 1 at the start"):
        cg.build(parse_case(pulled)).run()


def test_what_is_at_the_ends_reads_back_and_is_described() -> None:
    end = 'end = { length = 20.0, curve = 5.0, release = { trigger = "hit" } }\nsegments = 12'
    one = parse_case(
        held("bars", "segments = 12", end).replace('"sled", "ground"', '"sled", "sled"')
    )
    again = parse_case(resolved_toml(one)).belt[0]
    assert again == one.belt[0]
    assert again.end is not None
    assert again.end.instance.release == "hit"
    rows = dict(describe(one))
    assert rows["  start"] == "webbing 100 long"
    assert "released by hit" in rows["  end"]
    assert cg.build(one).springs["strap end"].devices.release == "hit"


def test_a_belt_has_devices_of_its_own() -> None:
    retractor = "length = 100.0, retractor = { spool = 5.0, lock = { rate = 1.0 } } }"
    text = held("bars", "length = 100.0 }", retractor)
    text = text[: text.index("[[slip_ring]]")] + text[text.index("[[sensor]]") :]
    spring = cg.build(parse_case(text)).springs["strap start"]
    assert isinstance(spring.devices.retractor, Retractor)
    assert spring.devices.retractor.rate == 1.0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("length = 100.0", "length = 190.0", "belt[0].start.length: this webbing would lie on"),
        ("end = [20, 0, -200]", "end = [-50, 0, -20]", "belt[0].end: lies 46.1484 inside ball"),
        ('"webbing", "strap start"', '"webbing", "strap end"', "slip_ring[0].between[1]: no sp"),
        ("length = 100.0 }", "length = 100.0, limiter = { force = 9.0 } }",
         "spring 'strap start': has a slip ring at its anchor, and no end left for its devices"),
        ("curve = 300.0\n", "damping = 1.0\n",
         "spring[0].curve: is missing: a device needs webbing"),
        ('lock = { trigger = "hit" }', 'lock = { trigger = "hut" }',
         "spring[0].retractor.lock.trigger: no sensor of this name"),
        ("length = 100.0 }", 'length = 100.0, release = { trigger = "hut" } }',
         "belt[0].start.release.trigger: no sensor of this name"),
        ("[[slip_ring]]", f"{OTHER}\n[[slip_ring]]", "another spring has this name"),
        ('["sled", "ground"]', '["free", "ground"]', "anchors[0]: webbing needs a support"),
        ("start = { length = 100.0 }", "start = { lenght = 100.0 }", "did you mean"),
        ("start = { length = 100.0 }", "retractor = { lock = { rate = 1.0 } }",
         "belt[0].retractor: unknown key"),
    ],
)  # fmt: skip
def test_ends_that_cannot_be_are_told_by_one_message(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    file = tmp_path / "case.toml"
    file.write_text(held("bars", old, new))
    with pytest.raises(InputError) as told:
        cg.build(load_case_to_build(file))
    assert said.lower() in str(told.value).lower()
    assert str(told.value).count("\n") == 0


def test_a_belt_is_laid_where_its_bodies_are_at_the_start(tmp_path: Path) -> None:
    moved = 'motion = { kind = "translate", table = [[0, 30, 0, 0], [1, 30, 0, 0]] }'
    rider = (
        '\n[[body]]\nname = "bell"\ngeometry = { shape = "sphere", radius = 100.0, '
        'centre = [0, 0, -10] }\nmotion = { kind = "attached", body = "ball" }\n'
    )
    file = tmp_path / "case.toml"
    still = belts_of(parse_case(case()))["strap"]
    for over in ("ball", "bell"):
        text = case(old="radius = 100.0 }", new=f"radius = 100.0 }}\n{moved}\n{rider}")
        text = text.replace('over = ["ball"]', f'over = ["{over}"]')
        file.write_text(text)
        (belt,) = belts_of(load_case_to_build(file)).values()
        centre = np.array([30.0, 0.0, 0.0 if over == "ball" else -10.0])
        away = np.linalg.norm(belt.slave.points - centre, axis=1)
        assert 100.0 <= away.min() < 100.01
    assert np.abs(still.slave.points[20] - [200.0, 0.0, 0.0]).max() < 1e-9
