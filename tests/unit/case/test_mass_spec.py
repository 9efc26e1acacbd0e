"""The `mass` of a body in a case."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

import contiga as cg
from contiga.case.mass_spec import MassSpec
from contiga.case.problems import case_error
from contiga.case.spec import Spec
from contiga.errors import CaseError, GeometryError, InputError


class Holder(Spec):
    """A table with a mass, as a body's is."""

    mass: MassSpec


def spec(**mass) -> MassSpec:
    return TypeAdapter(Holder).validate_python({"mass": mass}).mass


def message(**mass) -> str:
    data = {"mass": mass}
    with pytest.raises(ValidationError) as caught:
        TypeAdapter(Holder).validate_python(data)
    return str(case_error(caught.value, data, "case.toml"))


def egg() -> cg.Body:
    stretched = np.diag([1.0, 2.0, 3.0, 1.0])
    return (
        cg.Body([cg.shapes.sphere(radius=1.0)], name="egg")
        .transformed(stretched)
        .translated([5.0, 0.0, 0.0])
    )


def tube() -> cg.Body:
    return cg.Body([cg.shapes.cylinder(radius=1.0, height=2.0)], name="tube")


SHAPE = np.diag([13.0, 10.0, 5.0]) / 5.0
"""Of the egg, for a mass of one."""


def test_a_density_takes_the_shape():
    actual = spec(density=2.0).properties(egg())
    assert actual.mass == pytest.approx(2.0 * 8.0 * np.pi, rel=1e-10)
    assert actual.centre == pytest.approx([5.0, 0.0, 0.0], abs=1e-12)
    assert actual.inertia == pytest.approx(actual.mass * SHAPE, rel=1e-10, abs=1e-9)


def test_a_total_scales_what_the_shape_has():
    actual = spec(total=10.0).properties(egg())
    assert actual.mass == 10.0
    assert actual.centre == pytest.approx([5.0, 0.0, 0.0], abs=1e-12)
    assert actual.inertia == pytest.approx(10.0 * SHAPE, rel=1e-10, abs=1e-9)


def test_what_is_given_counts():
    actual = spec(total=3, centre=[1, 2, 3], inertia=[4, 5, 6, 0.1, 0.2, 0.3]).properties(tube())
    assert actual.mass == 3.0
    assert actual.centre.tolist() == [1.0, 2.0, 3.0]
    assert actual.inertia.tolist() == [[4.0, 0.1, 0.3], [0.1, 5.0, 0.2], [0.3, 0.2, 6.0]]


def test_a_closed_body_fills_in_what_is_not_given():
    centred = spec(total=2.0, centre=[4.0, 0.0, 0.0]).properties(egg())
    assert centred.centre.tolist() == [4.0, 0.0, 0.0]
    assert centred.inertia == pytest.approx(2.0 * SHAPE, rel=1e-10, abs=1e-9)
    turned = spec(total=2.0, inertia=[1, 1, 1, 0, 0, 0]).properties(egg())
    assert turned.centre == pytest.approx([5.0, 0.0, 0.0], abs=1e-12)
    assert turned.inertia.tolist() == np.eye(3).tolist()


@pytest.mark.parametrize(
    ("given", "lacks"),
    [
        ({}, "centre"),
        ({"centre": [0, 0, 0]}, "inertia"),
        ({"inertia": [1, 1, 1, 0, 0, 0]}, "centre"),
    ],
)
def test_an_open_body_needs_all_numbers(given, lacks):
    with pytest.raises(CaseError, match=rf"{lacks}: is missing: the body is open.*{lacks} = \["):
        spec(total=1.0, **given).properties(tube())


def test_an_open_body_has_no_density():
    with pytest.raises(GeometryError, match="tube: only a closed body"):
        spec(density=1.0).properties(tube())


def test_an_inward_body_has_no_density():
    with pytest.raises(InputError, match="egg: encloses no volume"):
        spec(density=1.0).properties(egg().flipped())


@pytest.mark.parametrize(
    ("given", "pieces"),
    [
        ({"density": 0.0}, ("case.toml: mass.density: is too small", "> 0")),
        ({"total": -1.0}, ("case.toml: mass.total: is too small", "> 0")),
        ({"total": float("nan")}, ("mass.total: must be finite",)),
        ({"density": 1.0, "total": 1.0}, ("mass: must have exactly one of the keys density or",)),
        ({}, ("mass: must have exactly one of the keys density or total; found 'none'",)),
        ({"totl": 1.0}, ("Did you mean 'total'?",)),
        ({"density": 1.0, "centre": [0, 0, 0]}, ("mass.centre: unknown key", "density")),
        ({"total": 1.0, "centre": [0, 0]}, ("mass.centre: has the wrong length",)),
        ({"total": 1.0, "inertia": [1, 1, 1]}, ("mass.inertia: has the wrong length", "6")),
        (
            {"total": 1.0, "inertia": [1, 1, 3, 0, 0, 0]},
            ("mass.inertia: no body has this inertia", "(1.0, 1.0, 3.0)", "at most 2"),
        ),
        ({"total": 1.0, "inertia": [1, 1, 1, 2, 0, 0]}, ("mass.inertia: the inertia must be pos",)),
        ({"total": 1.0, "inertia": [1, 1, "a", 2, 0, 0]}, ("mass.inertia[2]: must be a number",)),
    ],
    ids=range(12),
)
def test_a_wrong_mass_is_one_message(given, pieces):
    text = message(**given)
    for piece in pieces:
        assert piece in text
    assert "\n" not in text


def test_a_mass_is_described():
    assert spec(density=2.0).describe() == "its volume at a density of 2"
    assert spec(total=3.0).describe() == "3, centre and inertia of its shape"
    assert spec(total=3.0, centre=[0, 0, 0]).describe() == "3, centre given, inertia of its shape"
