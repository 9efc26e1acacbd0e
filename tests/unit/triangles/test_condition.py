"""What is said of a mesh as a master."""

from __future__ import annotations

import numpy as np
import pytest

import contiga as cg
from contiga import TriMesh
from contiga.errors import MeshError


def test_a_good_mesh_is_closed_and_has_no_flaw(oracle):
    condition = oracle.box().condition()
    assert condition.closed
    assert condition.volume == pytest.approx(1.0)
    assert condition.rows == [("surface", "closed, volume 1")]
    assert oracle.box().flipped().condition().rows[0][1].endswith("normals inward")


FLAWS = {
    "open": ("open_edges", 3, "open, 3 edges of one triangle"),
    "without area": ("without_area", 1, "1 triangles without area take no part"),
    "twice": ("doubled", 1, "1 triangles given twice count once"),
    "turned": ("turned_edges", 3, "3 edges with triangles that face opposite ways"),
    "crowded": ("crowded_edges", 1, "1 edges of more than two triangles"),
    "back to back": ("back_to_back", 1, "1 pairs of triangles back to back: no master"),
    "loose": ("loose_vertices", 1, "1 nodes of no triangle take no part"),
}


def flawed(box: TriMesh, flaw: str) -> TriMesh:
    """A box with one flaw."""
    points, triangles = box.vertices.tolist(), box.triangles.tolist()
    if flaw == "open":
        triangles.pop(0)
    elif flaw == "without area":
        triangles.append([0, 1, 1])
    elif flaw == "twice":
        triangles.append(np.roll(triangles[4], 1).tolist())
    elif flaw == "turned":
        triangles[4].reverse()
    elif flaw == "back to back":
        triangles.append(triangles[4][::-1])
    else:
        points.append([3.0, 0.1, 0.2])
        if flaw == "crowded":
            triangles.append([*triangles[4][:2], 8])
    return TriMesh(points, triangles, name="crate")


@pytest.mark.parametrize("flaw", FLAWS)
def test_each_flaw_is_counted_and_said(oracle, flaw):
    name, count, text = FLAWS[flaw]
    condition = flawed(oracle.box(), flaw).condition()
    assert getattr(condition, name) == count
    assert any(text in said for _, said in condition.rows)


def test_a_mesh_without_a_surface_is_said_so():
    assert TriMesh([], []).condition().rows == [("surface", "none: no triangle has an area")]
    line = TriMesh([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
    assert not line.condition().closed
    assert "none" in line.condition().rows[0][1]


@pytest.mark.parametrize("flaw", FLAWS)
def test_a_master_is_refused_where_it_has_no_sides_and_served_otherwise(oracle, flaw):
    mesh = flawed(oracle.box(), flaw)
    slave = cg.Slave([[0.1, 0.2, 1.0]], area=[1.0])
    law = cg.PenaltyLaw(1.0)
    said = {"turned": "opposite ways", "back to back": r"crate.*back to back.*first 4 and 12"}
    if flaw in said:
        with pytest.raises(MeshError, match=said[flaw]):
            cg.Contact(mesh, slave, law=law)
        return
    contact = cg.Contact(mesh, slave, law=law)
    state = contact.step(contact.start(slave.points), slave.points - [0, 0, 0.6])
    assert state.max_penetration == pytest.approx(0.1)
