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
    with pytest.raises(UnitError, match="not a known unit"):
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


def test_the_units_looked_up_without_pint_are_what_pint_says():
    for dimension, plain in units._PLAIN.items():
        for name, factor in plain.items():
            for spelling in (name, name.upper()):
                fits = [
                    float(quantity.to(units._BASE[dimension]).magnitude)
                    for quantity in units._readings(spelling)
                    if quantity.check(f"[{dimension}]")
                ]
                assert fits[0] == factor == units.base_factor(spelling, dimension)


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
        (acceleration_factor, "m/s", "a unit of velocity, not of acceleration; found 'm/s'"),
        (velocity_factor, "m/s^2", "a unit of acceleration, not of velocity"),
        (velocity_factor, "g", "a unit of acceleration, not of velocity; .* such as m/s, mm/ms"),
        (acceleration_factor, "mph", "a unit of velocity, not of acceleration"),
        (acceleration_factor, "m/s/ms", "not a unit of acceleration"),
        (acceleration_factor, "", "not a unit of acceleration; found ''"),
        (acceleration_factor, "N", "not a unit of acceleration; found 'N'.*such as g, m/s"),
        (velocity_factor, "kg/s", "not a unit of length; found 'kg'"),
        (velocity_factor, "m/kg", "not a unit of time; found 'kg'"),
    ],
)
def test_other_units_are_no_rates(factor, unit: str, message: str) -> None:
    with pytest.raises(UnitError, match=message):
        factor(unit, "mm", "ms", "a.csv:1")


def test_factors_of_velocity_are_exact_where_numbers_are() -> None:
    assert 36.0 * velocity_factor("km/h", "m", "s") == 10.0
    assert velocity_factor("m/s", "mm", "ms") == 1.0
    assert acceleration_factor("m/s^2", "mm", "ms") == 0.001
