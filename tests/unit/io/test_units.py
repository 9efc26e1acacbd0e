"""Units at the door."""

from __future__ import annotations

import pytest

from contiga.errors import UnitError
from contiga.io import units
from contiga.io.units import (
    acceleration_factor,
    base_factor,
    derived_units,
    length_factor,
    short_name,
    time_factor,
    velocity_factor,
)


@pytest.mark.parametrize(
    ("spelling", "millimetres"),
    [
        ("mm", 1.0),
        ("MM", 1.0),
        ("millimetre", 1.0),
        ("Millimeters", 1.0),
        ("M", 1000.0),
        ("metre", 1000.0),
        ("CM", 10.0),
        ("in", 25.4),
        ("INCH", 25.4),
        ("inches", 25.4),
        ("FT", 304.8),
        ("feet", 304.8),
        ("mile", 1609344.0),
        ("mil", 0.0254),
        ("um", 0.001),
        ("micron", 0.001),
        (" mm ", 1.0),
    ],
)
def test_spellings_of_cad_files_are_understood_to_the_bit(spelling, millimetres):
    assert length_factor(spelling, "mm") == millimetres


def test_masses_and_times():
    assert base_factor("t", "mass") == 1000.0
    assert base_factor("lb", "mass") == pytest.approx(0.45359237, rel=1e-15)
    assert time_factor("ms", "s") == 0.001


def test_factors_there_and_back_are_inverse():
    for unit in ("mm", "in", "ft", "km"):
        there, back = length_factor("m", unit), length_factor(unit, "m")
        assert there * back == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("text", ["", "foo", "3", "mm+", "1/0", "milimetre", None, 5, "()"])
def test_what_is_no_unit_is_refused(text):
    with pytest.raises(UnitError, match="not a known unit of length"):
        length_factor(text, "mm")


def test_a_unit_of_another_dimension_is_named_so():
    with pytest.raises(UnitError, match=r"units\.length: not a unit of length; found 'kg'"):
        base_factor("kg", "length", "units.length")


def test_a_slip_gets_a_suggestion():
    with pytest.raises(UnitError, match="Did you mean 'millimetre'"):
        length_factor("milimetre", "mm")


@pytest.mark.parametrize(
    ("units", "force", "stress"),
    [
        (("m", "kg", "s"), "N", "Pa"),
        (("mm", "t", "s"), "N", "MPa"),
        (("mm", "kg", "ms"), "kN", "GPa"),
        (("mm", "g", "ms"), "N", "MPa"),
        (("in", "lb", "s"), "lb·in/s²", "lb/(in·s²)"),
    ],
)
def test_labels_of_consistent_sets(units, force, stress):
    labels = derived_units(*units)
    assert (labels["force"], labels["stress"]) == (force, stress)
    assert labels["area"] == units[0] + "²"


def test_short_names():
    assert short_name("INCH") == "in"
    assert short_name("millimetre") == "mm"
    assert short_name("mile") == "mile"


def test_the_units_of_the_table_are_what_pint_says() -> None:
    spelt = {"kmh": "km/h", "t": "tonne", "mil": "thou", "inches": "inch", "feet": "foot"}
    spelt |= {"Nm": "N*m", "Nmm": "N*mm", "kNm": "kN*m", "kNmm": "kN*mm", "MNm": "MN*m"}
    spelt |= {"MNmm": "MN*mm", "g": "gram", "G": "g_0", "g0": "g_0", "gn": "g_0", "tonne": "tonne"}
    for quantity, kind in units.QUANTITIES.items():
        for name, size in kind.sizes.items():
            if kind.powers is None or quantity == "ratio":
                continue
            other = "g_0" if (quantity, name) == ("acceleration", "g") else spelt.get(name, name)
            (found,) = {one for one in units._pint_readings(other) if one.powers == kind.powers}
            assert found.value == pytest.approx(size, rel=1e-15)
            assert units.si_size(name, quantity) == size


@pytest.mark.parametrize(
    ("unit", "size", "powers"),
    [
        ("N/mm^2", 1e6, (-1, 1, -2, 0)),
        ("kg / (m * s**2)", 1.0, (-1, 1, -2, 0)),
        ("rad/ms", 1e3, (0, 0, -1, 1)),
        ("N·mm", 1e-3, (2, 1, -2, 0)),
        ("mm³", 1e-9, (3, 0, 0, 0)),
        ("1/s", 1.0, (0, 0, -1, 0)),
        ("s^-1", 1.0, (0, 0, -1, 0)),
        ("m/s/(s)", 1.0, (1, 0, -2, 0)),
    ],
)
def test_products_are_read_without_pint(unit: str, size: float, powers: tuple[int, ...]) -> None:
    found = units._product_of(unit)
    assert found is not None
    assert found.value == pytest.approx(size, rel=1e-14)
    assert found.powers == powers
    (other,) = units._pint_readings(unit.replace("·", "*"))[:1]
    assert other.value == pytest.approx(size, rel=1e-14)
    assert other.powers == powers


@pytest.mark.parametrize(
    "unit", ["m*", "(m", "m)", "/s", "m//s", "2*m", "m^", "m s", "^2", "", "q"]
)
def test_what_is_no_product_of_the_table_is_none(unit: str) -> None:
    assert units._product_of(unit) is None


def test_an_angle_counts_and_may_be_left_out_of_a_spin() -> None:
    assert units.si_size("1/s", "spin") == units.si_size("rad/s", "spin") == 1.0
    for unit, quantity in (("rad/s", "rate"), ("deg", "ratio"), ("1", "angle")):
        with pytest.raises(UnitError, match="not a unit of"):
            units.si_size(unit, quantity)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("unit", "si"),
    [
        ("g", 9.80665),
        (" G ", 9.80665),
        ("m/s^2", 1.0),
        ("m/s²", 1.0),
        ("m/s2", 1.0),
        ("m / s**2", 1.0),
        ("m/(s^2)", 1.0),
        ("m/s/s", 1.0),
        ("mm/ms^2", 1000.0),
        ("mm/s^2", 0.001),
        ("in/s^2", 0.0254),
        ("km/h/h", 1000.0 / 3600.0**2),
        ("km/h/s", 1.0 / 3.6),
    ],
)
def test_units_of_acceleration(unit: str, si: float) -> None:
    assert acceleration_factor(unit, "m", "s") == pytest.approx(si, rel=1e-14)
    assert acceleration_factor(unit, "mm", "ms") == pytest.approx(si / 1000.0, rel=1e-14)


@pytest.mark.parametrize(
    ("unit", "si"),
    [("m/s", 1.0), ("mm/ms", 1.0), ("km/h", 1 / 3.6), ("kph", 1 / 3.6), ("mph", 0.44704)],
)
def test_units_of_velocity(unit: str, si: float) -> None:
    assert velocity_factor(unit, "m", "s") == pytest.approx(si, rel=1e-14)
    assert velocity_factor(unit, "mm", "s") == pytest.approx(si * 1000.0, rel=1e-14)


@pytest.mark.parametrize(
    ("factor", "unit", "message"),
    [
        (
            acceleration_factor,
            "m/s",
            "not a unit of acceleration; found 'm/s'.*It is a unit of velocity",
        ),
        (velocity_factor, "m/s^2", "not a unit of velocity; .*It is a unit of acceleration"),
        (
            velocity_factor,
            "g",
            "not a unit of velocity; .* such as m/s, mm/ms.*It is a unit of mass",
        ),
        (acceleration_factor, "mph", "not a unit of acceleration; .*It is a unit of velocity"),
        (acceleration_factor, "", "not a known unit of acceleration; found ''"),
        (
            acceleration_factor,
            "N",
            "not a unit of acceleration; found 'N'.*such as g, m/s.*unit of force",
        ),
        (velocity_factor, "kg/s", r"not a unit of velocity; found 'kg/s'"),
        (velocity_factor, "m/kg", "not a unit of velocity; found 'm/kg'"),
    ],
)
def test_other_units_are_no_rates(factor, unit: str, message: str) -> None:
    with pytest.raises(UnitError, match=message):
        factor(unit, "mm", "ms", "a.csv:1")


def test_factors_of_velocity_are_exact_where_numbers_are() -> None:
    assert 36.0 * velocity_factor("km/h", "m", "s") == 10.0
    assert velocity_factor("m/s", "mm", "ms") == 1.0
    assert acceleration_factor("m/s^2", "mm", "ms") == 0.001
