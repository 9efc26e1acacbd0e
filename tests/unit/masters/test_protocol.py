"""What is asked of a master: both kinds answer, and nothing above asks which kind it is."""

from __future__ import annotations

import ast
from pathlib import Path

import numpy as np
import pytest

import contiga as cg
from contiga.arrays.digest import Digest
from contiga.errors import InputError
from contiga.masters.protocol import Master, is_master

SOURCE = Path(cg.__file__).parent
KINDS = {"Body", "TriMesh", "Faces", "ExactSurface", "FacetedSurface"}


def plate() -> cg.Body:
    return cg.Body([cg.shapes.plane(width=2.0, length=3.0)], name="plate")


@pytest.fixture(params=["exact", "triangles"])
def master(request: pytest.FixtureRequest) -> Master:
    exact = plate()
    return exact if request.param == "exact" else exact.tessellate(0.1)


def digest_of(master: Master) -> str:
    digest = Digest()
    master.digest(digest)
    return digest.hexdigest()


def test_both_kinds_are_masters_and_other_things_are_not(master: Master) -> None:
    assert is_master(master)
    assert not is_master(cg.shapes.plane())
    assert not is_master("ball")


def test_what_is_no_master_is_told_without_working_anything_out() -> None:
    slave = cg.Slave([[0.0, 0.0, 1.0]], area=[1.0])
    with pytest.raises(InputError, match=r"must be a Body or a TriMesh.*NurbsSurface"):
        cg.Contact(cg.shapes.plane(), slave, law=cg.PenaltyLaw(1.0))  # type: ignore[arg-type]


def test_both_kinds_answer_alike(master: Master) -> None:
    assert master.name == "plate"
    assert master.size == pytest.approx(np.sqrt(13.0))
    assert not master.closed
    assert not master.surface.closed
    assert master.flaws == []
    master.check()
    np.testing.assert_allclose(master.bounds(), [[-1.0, -1.5, 0.0], [1.0, 1.5, 0.0]])
    np.testing.assert_allclose(master.project([[0.2, 0.3, 0.5]]).point, [[0.2, 0.3, 0.0]])
    assert master.contains([[0.2, 0.3, -0.5], [0.2, 0.3, 0.5]]).tolist() == [True, False]
    hit = master.first_hit([[0.2, 0.3, 1.0]], [[0.2, 0.3, -1.0]])
    assert hit.fraction[0] == pytest.approx(0.5)
    assert hit.patch[0] < master.n_pieces
    assert {"kind", "elements", "closed", "size"} <= set(master.facts())
    assert master.condition_rows()[-1][1].startswith("open")


def test_memory_grows_with_what_the_search_has_built() -> None:
    ball = cg.Body([cg.shapes.sphere(radius=1.0)])
    meshes = [ball.tessellate(tol).surface for tol in (0.1, 0.01)]
    finer = meshes[1].n_elements / meshes[0].n_elements
    assert finer > 5.0
    assert meshes[1].nbytes / meshes[0].nbytes == pytest.approx(finer, rel=0.2)
    # a triangle has 18 numbers and 8 links at least
    assert meshes[1].nbytes > meshes[1].n_elements * (18 * 8 + 8 * 4)
    assert ball.surface.nbytes > 1000 * ball.surface.n_elements


def test_only_exact_geometry_has_faces() -> None:
    exact = plate()
    assert exact.faces is exact
    assert exact.tessellate(0.1).faces is None


def test_the_digest_tells_masters_apart(master: Master) -> None:
    assert digest_of(master) == digest_of(master.with_reference_point([0.0, 0.0, 0.0]))
    assert digest_of(master) != digest_of(master.with_reference_point([0.0, 0.0, 1.0]))


def test_nothing_asks_what_kind_of_master_it_has() -> None:
    roots = (SOURCE, SOURCE.with_name("contiga_validation"))
    asked = [
        f"{path.name}: {ast.unparse(node)}"
        for root in roots
        for path in sorted(root.rglob("*.py"))
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "isinstance"
        if KINDS & {name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name)}
    ]
    assert asked == []
