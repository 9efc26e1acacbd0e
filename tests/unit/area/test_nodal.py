"""Constant nodal areas."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga.area.method import AreaInput, AreaMethod
from contiga.errors import InputError
from contiga.records import empty_projection

PLANE = cg.Body([cg.shapes.plane()])


def _measure(method: cg.NodalArea, rows: list[int], slave_area: np.ndarray | None = None):
    points = np.zeros((5, 3))
    index = np.array(rows, dtype=np.int32)
    return method.measure(AreaInput(PLANE, index, points, empty_projection(len(rows)), slave_area))


def test_it_is_an_area_method() -> None:
    assert isinstance(cg.NodalArea(), AreaMethod)


def test_one_number_is_the_area_of_every_point() -> None:
    areas = _measure(cg.NodalArea(0.1), [4, 1])
    assert areas.area.tolist() == [0.1, 0.1]
    assert areas.clusters.tolist() == [0, 0]


def test_an_array_follows_the_rows_in_contact() -> None:
    areas = _measure(cg.NodalArea([0.0, 1.0, 2.0, 3.0, 4.0]), [4, 1])
    assert areas.area.tolist() == [4.0, 1.0]


def test_the_slaves_own_areas_are_taken_if_none_is_given() -> None:
    assert _measure(cg.NodalArea(), [2], np.arange(5.0)).area.tolist() == [2.0]


def test_no_contact_has_no_areas() -> None:
    areas = _measure(cg.NodalArea(0.1), [])
    assert areas.area.shape == areas.clusters.shape == (0,)


def test_the_values_are_copied() -> None:
    values = np.ones(5)
    method = cg.NodalArea(values)
    values[:] = 7.0
    assert _measure(method, [0]).area.tolist() == [1.0]


@pytest.mark.parametrize(
    "value", [-1.0, np.nan, np.inf, [1.0, -1e-300], [[1.0]], "large", [1, "x"]]
)
def test_impossible_areas_are_refused(value: object) -> None:
    with pytest.raises(InputError) as error:
        cg.NodalArea(value)  # type: ignore[arg-type]
    assert error.value.where == "area"


def test_areas_that_do_not_fit_the_slave_are_refused_by_the_contact() -> None:
    cloud = cg.Slave(np.zeros((3, 3)))
    with pytest.raises(InputError, match="one entry a point") as error:
        cg.Contact(PLANE, cloud, law=cg.PenaltyLaw(1.0), area=cg.NodalArea([1.0, 2.0]))
    assert (error.value.found, error.value.allowed) == ((2,), "(3,)")


def test_a_bare_cloud_needs_an_area() -> None:
    with pytest.raises(InputError, match="no facets to take areas from"):
        cg.Contact(PLANE, cg.Slave(np.zeros((3, 3))), law=cg.PenaltyLaw(1.0))
