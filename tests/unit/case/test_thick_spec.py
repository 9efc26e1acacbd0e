"""`shell_thickness` of a contact: what a case makes of it, and what is refused."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from tests.scenes import square_sheet
from tests.unit.case.test_deform_spec import PER_AREA, write_case

import contiga as cg
from contiga.case.schema import load_case
from contiga.errors import InputError

MEMBRANE = """
units = { length = "mm", mass = "g", time = "ms" }
time = { end = 0.05, step = 0.01 }
[[body]]
name = "table"
geometry = { shape = "plane", width = 10.0, length = 10.0 }
[[slave]]
name = "sheet"
points = { file = "sheet.vtu" }
[slave.motion]
kind = "deform"
density = 1e-3
thickness = 0.2
material = { kind = "elastic", young = 2.0 }
[[contact]]
master = "table"
slave = "sheet"
search = "penetration"
shell_thickness = THICK
law = { kind = "penalty", stiffness = 1.0, per_area = true }
"""


@pytest.mark.parametrize(
    ("counts", "depth"), [("true", 0.01), ("0.2", 0.01), ("0.22", 0.02), ("false", 0.0)]
)
@pytest.mark.parametrize("own", ["", "thickness = 2.0"])
def test_a_sheet_touches_half_its_thickness_off(
    tmp_path: Path, own: str, counts: str, depth: float
) -> None:
    """The thickness is that of its membranes, whatever is said of the slave for its laws."""
    points, quads = square_sheet(2.0, 3)
    meshio.Mesh(np.add(points, [0.0, 0.0, 0.09]), [("quad", quads)]).write(tmp_path / "sheet.vtu")
    text = MEMBRANE.replace("THICK", counts).replace("[slave.motion]", f"{own}\n[slave.motion]")
    (tmp_path / "case.toml").write_text(text)
    state = cg.build(load_case(tmp_path / "case.toml")).start()
    (contact,) = state.contacts.values()
    assert contact.max_penetration == pytest.approx(depth, abs=1e-12)
    assert contact.total_force[2] == pytest.approx(4.0 * depth, rel=1e-9)


@pytest.mark.parametrize("thickness", ["0", "-1.0", "inf", '"front"', "[1.0]", "1" + 400 * "0"])
def test_a_thickness_that_is_none_is_told(tmp_path: Path, thickness: str) -> None:
    law = PER_AREA + f"\nshell_thickness = {thickness}"
    with pytest.raises(InputError, match=r"contact\[0\].shell_thickness: must be a thickness"):
        load_case(write_case(tmp_path, law=law))


def test_the_thickness_of_a_membrane_is_not_that_of_a_layer(tmp_path: Path) -> None:
    points, quads = square_sheet(2.0, 3)
    meshio.Mesh(points, [("quad", quads)]).write(tmp_path / "sheet.vtu")
    law = 'law = { kind = "stress", elastic = 1.0 }'
    text = MEMBRANE.replace("THICK", "true").partition("law = ")[0] + law
    (tmp_path / "case.toml").write_text(text)
    with pytest.raises(InputError, match="nodal thickness"):
        cg.build(load_case(tmp_path / "case.toml"))


def test_a_slave_of_solids_has_no_thickness_to_count(tmp_path: Path) -> None:
    law = PER_AREA + "\nshell_thickness = true"
    with pytest.raises(InputError, match="the thickness of 'block' is not known"):
        cg.build(load_case(write_case(tmp_path, law=law)))
