"""Chambers of gas in a case: units, names, and a run of one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.errors import InputError
from contiga.gas import Mixture
from contiga.report.run_folder import read_run

CASE = """
[units]
length = "mm"
mass = "g"
time = "ms"

[time]
end = 1.0
step = "auto"

[[slave]]
name = "bag"
points = { file = "bag.stl" }

[slave.motion]
kind = "deform"
material = { kind = "elastic", young = 5.0, poisson = 0.3 }
density = 1e-3
thickness = 0.5

[[gas]]
name = "airbag"
slave = "bag"
inflator = [{ mass_rate = [[0, 0.1], [1, 0.1]], temperature = 500.0 }]
vent = [{ area = 10.0, coefficient = 0.7, opens_at = 0.002 }]
leak = 1e-5
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    ball = cg.Body([cg.shapes.sphere(radius=30.0)]).tessellate(2.0)
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners)
        + "endloop\nendfacet\n"
        for corners in ball.vertices[ball.triangles].tolist()
    )
    (tmp_path / "bag.stl").write_text(f"solid bag\n{facets}endsolid bag\n")
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


def test_air_and_the_atmosphere_are_in_the_units_of_the_case(file: Path) -> None:
    chamber = cg.build(cg.load_case(file)).gas["airbag"]
    around = chamber.surroundings
    assert around.pressure == pytest.approx(0.101325, rel=1e-12)  # MPa
    assert around.gas.constant == pytest.approx(287.05, rel=1e-12)  # mm²/ms²
    assert chamber.vents[0].opens_at == 0.002
    metres = CASE.replace('"mm"', '"m"').replace('"g"', '"kg"').replace('"ms"', '"s"')
    file.write_text(metres)
    around = cg.load_case(file).gas[0].chamber(("m", "kg", "s"), list).surroundings
    assert around.pressure == 101_325.0
    assert around.gas.constant == 287.05


def test_a_case_blows_up_its_bag_and_the_report_shows_it(file: Path, tmp_path: Path) -> None:
    case = cg.load_case(file)
    result = cg.run(case, tmp_path / "out")
    history = result.history
    assert history["airbag.pressure"][-1] > 0.103
    assert history["airbag.mass"][-1] > history["airbag.mass"][0]
    assert abs(result.state.energy.error) < 1e-3 * history["energy.external"][-1]
    run = read_run(tmp_path / "out")
    assert set(run.gas) == {"airbag"}
    assert "airbag" not in run.contacts
    from contiga.case.columns import columns_of_case

    assert set(columns_of_case(case)) <= set(history)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "<h2>Gas</h2>" in page
    assert "In slave" in page


def test_mixtures_of_the_case_have_heat_capacities_and_vents_a_place(file: Path) -> None:
    mixture = (
        "gas = [{ share = 0.8, constant = 296.8, c_p = [[300, 1040], [2000, 1280]] }, "
        "{ share = 0.2, constant = 208.1, gamma = 1.667 }]"
    )
    text = CASE.replace("temperature = 500.0", f"temperature = 500.0, {mixture}")
    text = text.replace("opens_at = 0.002", "on = { box = [[-20, -20, 20], [20, 20, 31]] }")
    file.write_text(text.replace("leak = 1e-5", "leak = [[0, 0], [0.1, 1e-3]]"))
    chamber = cg.build(cg.load_case(file)).gas["airbag"]
    gas = chamber.inflators[0].gas
    assert isinstance(gas, Mixture)
    assert [share for _, share in gas.parts] == [0.8, 0.2]
    assert gas.parts[0][0].heat_capacity(1150.0) == pytest.approx(1160.0, rel=1e-12)
    assert chamber.vents[0].on == {"box": [[-20, -20, 20], [20, 20, 31]]}
    assert np.interp(0.05, chamber.leak.x, chamber.leak.y) == pytest.approx(5e-4)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("leak = 1e-5", "leak = -1.0", "leak: must not be below zero"),
        ("leak = 1e-5", "leak = [[1, 0], [0, 1]]", "leak: the values of p go back or repeat"),
        ("leak = 1e-5", "gas = [{ constant = 287.05, gamma = 1.4 }]", "share"),
        ("leak = 1e-5", "gas = { constant = 287.05 }", "exactly one of the keys gamma, c_p"),
        (
            "leak = 1e-5",
            "gas = { constant = 287.05, c_p = [[300, 200]] }",
            "above the gas constant",
        ),
        (
            "leak = 1e-5",
            "gas = { constant = 287.05, c_p = [900, 0.1] }",
            "between two temperatures",
        ),
        ("opens_at = 0.002", "on = {}", "says nowhere"),
        ("opens_at = 0.002", "on = { box = [[-1, -1, 29.9], [1, 1, 31]] }", "on no fabric"),
        ("leak = 1e-5", '[[gas]]\nname = "b"\nslave = "bag"', "fills these facets already"),
        ('slave = "bag"\n', 'slave = "bags"\n', "no slave of this name"),
        ("area = 10.0", 'area = "big"', "must be a number, or rows"),
        ("leak = 1e-5", 'gas = "helium"', "must be a gas"),
        ("leak = 1e-5", "leaks = 1e-5", "unknown key"),
        ("opens_at = 0.002", 'to = "other"', "leads to no other chamber"),
        ('name = "airbag"', 'name = "ambient"', "stands for the surroundings"),
        ("[[0, 0.1]", "[[0, nan]", r"inflator\[0\].mass_rate\[0\]\[1\]: must be finite"),
        ("[[0, 0.1]", "[[2, 0.1]", r"inflator\[0\].mass_rate: the times go back or repeat"),
        ("[[0, 0.1]", "[[0, -0.1]", r"inflator\[0\].mass_rate: must not be below zero"),
        ("= 500.0", "= 0.0", r"inflator\[0\].temperature: must be above zero; found 0.0"),
        ("= 500.0", "= nan", r"inflator\[0\].temperature: must be finite"),
        ("leak = 1e-5", "temperature = -3.0", "temperature: is too small"),
        (
            "= 500.0",
            "= 500.0, gas = { constant = nan, gamma = 1.4 }",
            "gas.constant: must be finite",
        ),
    ],
)
def test_a_wrong_key_or_value_is_told(file: Path, old: str, new: str, said: str) -> None:
    file.write_text(CASE.replace(old, new))
    with pytest.raises(InputError, match=said) as told:
        cg.build(cg.load_case(file))
    assert "things are wrong" not in str(told.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("= 500.0", "= 20.0", "the temperature of inflator[0] is 20 K"),
        ("leak = 1e-5", "temperature = 20.0", "the temperature around it is 20 K"),
        (
            "= 500.0",
            "= 500.0, gas = { constant = 287050.0, gamma = 1.4 }",
            "sound in the gas of inflator[0] would go at 1.09e+04 m/s",
        ),
    ],
)
def test_a_gas_in_another_unit_is_found(file: Path, old: str, new: str, said: str) -> None:
    assert not [one for one in cg.build(cg.load_case(file)).check() if one.rule == "gas"]
    file.write_text(CASE.replace(old, new))
    (found,) = (one for one in cg.build(cg.load_case(file)).check() if one.rule == "gas")
    assert said in str(found)


def grown(file: Path, factor: float) -> None:
    """A mesh with the bag's nodes and facets, of another size."""
    bag = cg.read_mesh(file.parent / "bag.stl")
    cg.write_mesh(file.parent / "grown.stl", cg.TriMesh(factor * bag.points, bag.facets))


@pytest.mark.parametrize(
    "reference", ['{ file = "grown.stl" }', "{ scale = 0.8 }", "{ scale = [0.8, 0.8, 0.8] }"]
)
def test_a_bag_is_strained_against_its_reference(file: Path, reference: str) -> None:
    """Stretched evenly by 1.25: S = E/(1−ν) · E₁₁ and 2 E₁₁ = 1.25² − 1 in both directions."""
    grown(file, 0.8)
    file.write_text(CASE.replace("thickness = 0.5", f"thickness = 0.5\nreference = {reference}"))
    simulation = cg.build(cg.load_case(file))
    strain = 0.5 * (1.25**2 - 1.0)
    slave = simulation.slaves["bag"].slave
    area = 0.64 * simulation.chambers.skins["airbag"].closed(slave.points).areas.sum()
    wanted = area * 0.5 * 5.0 / (1.0 - 0.3) * strain**2
    assert simulation.start().energy.strain == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize(
    ("reference", "said"),
    [
        ("{ scale = 0.0 }", "reference.scale"),
        ("{ scale = [1, 1] }", "reference.scale"),
        ("{ }", "exactly one of the keys file, scale"),
        ('{ file = "grown.stl", scale = 1.0 }', "exactly one of the keys file, scale"),
        ('{ file = "none.stl" }', "none.stl"),
        ('{ file = "half.stl" }', "must have the nodes of the slave"),
        ('{ file = "turned.stl" }', "must have the elements of the slave"),
    ],
)
def test_a_reference_of_another_shape_is_told(file: Path, reference: str, said: str) -> None:
    grown(file, 0.8)
    bag = cg.read_mesh(file.parent / "bag.stl")
    few = np.unique(bag.facets[:9])
    half = np.searchsorted(few, bag.facets[np.isin(bag.facets, few).all(axis=1)])
    cg.write_mesh(file.parent / "half.stl", cg.TriMesh(bag.points[few], half))
    turned = bag.facets.copy()
    turned[5] = turned[5, ::-1]
    cg.write_mesh(file.parent / "turned.stl", cg.TriMesh(bag.points, turned))
    file.write_text(CASE.replace("thickness = 0.5", f"thickness = 0.5\nreference = {reference}"))
    with pytest.raises(InputError, match=said):
        cg.build(cg.load_case(file))
