"""Units of history columns."""

from __future__ import annotations

import pytest

from contiga.io.column_units import column_units


@pytest.mark.parametrize(
    ("column", "unit"),
    [
        ("n_contact", ""),
        ("time", "ms"),
        ("pad.wall_time", "s"),
        ("pad.moment_x", "N·mm"),
        ("pad.area", "mm²"),
        ("pad.max_pressure", "MPa"),
        ("pad.work", "mJ"),
        ("pad.energy_error", "mJ"),
        ("head.qw", ""),
        ("head.wx", "rad/ms"),
        ("head.vx", "mm/ms"),
        ("head_cg.filtered_a", "mm/ms²"),
        ("head_cg.x", "mm"),
        ("head_cg.f", "N"),
        ("head_cg.mz", "N·mm"),
        ("energy.friction", "mJ"),
    ],
)
def test_a_column_has_its_unit(column: str, unit: str) -> None:
    assert column_units([column], ("mm", "g", "ms")) == {column: unit}


def test_without_units_there_are_none() -> None:
    assert column_units(["time"], ("", "", "")) == {}
