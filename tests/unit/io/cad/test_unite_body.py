"""Closed pieces of bodies made in Python, 3DM and G+Smo that touch or overlap are united."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from tests.stress import fields, unions
from tests.unit.search.borders.test_meetings import APART, MOVED, UNIT, ball, box, cavity, rod

import contiga as cg
from contiga.errors import ContigaWarning, FileError, GeometryError
from contiga.io.cad.unite_body import unite_pieces

UNITED = {
    "boxes face to face": (box(*UNIT) + box((1, 0.2, 0), (2, 0.7, 1)), 1.5),
    "the same twice": (box(*UNIT) + box(*UNIT), 1.0),
    "a pin without play": (
        rod(3.0, 0, 2) + cavity(rod(1.0, 0.5, 1.5)) + rod(1.0, 0.7, 1.3),
        math.pi * (18.0 - 0.4),
    ),
}


SPLINES = [("a pin without play", 1.0)]


@pytest.mark.parametrize(
    ("name", "factor"), [*SPLINES, ("boxes face to face", 1e-7), ("the same twice", 1e5)]
)
def test_a_union_has_the_volume_of_its_closed_form(name: str, factor: float) -> None:
    patches, volume = UNITED[name]
    body = cg.Body(patches, name="two.5").scaled(factor)
    if name not in dict(SPLINES):
        body = body.transformed(_small(MOVED, factor))
    assert not body.closed
    both = cg.unite(body.with_reference_point([1.0, 2.0, 3.0]))
    assert (both.closed, both.name) == (True, "two.5")
    assert both.reference_point.tolist() == [1.0, 2.0, 3.0]
    assert both.volume() == pytest.approx(volume * factor**3, rel=1e-7)


def _small(matrix: np.ndarray, factor: float) -> np.ndarray:
    moved = matrix.copy()
    moved[:3, 3] *= factor
    return moved


@pytest.mark.parametrize("name", ["bricks", "pin in its hole"])
def test_bodies_that_share_walls_have_the_inside_of_any(name: str) -> None:
    from tests.stress.solids import written

    pieces = unions.RECIPES[name]()
    bodies = [cg.read_cad(written(f"{name} {k}", p.shape)) for k, p in enumerate(pieces)]
    body = cg.unite(*bodies)
    least = fields.union(*(piece.field for piece in pieces))
    low, high = body.bounds()
    p = np.random.default_rng(3).uniform(low - 1.0, high + 1.0, (2000, 3))
    assert body.closed
    assert ((least(p) < 0.0) == body.contains(p)).all()
    assert np.abs(least(body.project(p).point)).max() <= 1e-8 * body.size


@pytest.mark.parametrize("name", APART)
def test_pieces_that_are_apart_stay_as_they_are(name: str) -> None:
    body = cg.Body(APART[name])
    both = cg.unite(body)
    assert both.closed
    assert all(a is b for a, b in zip(body.patches, both.patches, strict=True))


def test_what_cannot_be_united_is_left_and_told() -> None:
    leaves = cg.Body(ball(2.0) + cavity(ball(1.0, 1.5, 0.0, 0.0)))
    assert not cg.unite(leaves).closed
    with pytest.raises(GeometryError, match="nothing to unite"):
        cg.unite()
    metre = cg.Body(ball(1.0), unit="m")
    with pytest.raises(GeometryError, match=r"one length unit; found .'None', 'm'"):
        cg.unite(metre, leaves)


def test_a_union_that_fails_is_said_with_patches_and_place(monkeypatch) -> None:
    from contiga.io.cad import unite

    monkeypatch.setattr(unite._Union, "holds", lambda self: False)
    two = cg.Body(box(*UNIT) + box((1, 0.2, 0), (2, 0.7, 1)), name="two")
    with pytest.warns(ContigaWarning, match=r"no sound union .* patches 0 to 5 and patches 6 to"):
        assert len(cg.unite(two).patches) == 12


def test_it_is_told_which_patch_each_is_a_part_of() -> None:
    far = box((9, 9, 9), (10, 10, 10))
    body = cg.Body(far + box(*UNIT) + box((1, 0.2, 0), (2, 0.7, 1)))
    actual = unite_pieces(body, body.pieces, None, "here")
    assert actual.met == [[tuple(range(6, 12)), tuple(range(12, 18))]]
    # The second box's lower end in x is gone.
    assert set(actual.origin) == set(range(18)) - {12}
    assert actual.origin == sorted(actual.origin)
    for patch, k in zip(actual.body.patches, actual.origin, strict=True):
        low, high = body.patches[k].bounds()
        assert (patch.bounds()[0] >= low - 1e-9).all()
        assert (patch.bounds()[1] <= high + 1e-9).all()
    with pytest.raises(FileError, match=r"here: .*touch or overlap"):
        unite_pieces(body, body.pieces, "refuse", "here")


def _gismo(path: Path, surfaces: list[cg.NurbsSurface]) -> Path:
    def element(s: cg.NurbsSurface) -> str:
        knots = "".join(
            f'<Basis type="BSplineBasis"><KnotVector degree="{p}">'
            f"{' '.join(map(repr, map(float, U)))}</KnotVector></Basis>"
            for p, U in zip(s.degrees, s.knots, strict=True)
        )
        net = s.control_points.transpose(1, 0, 2).reshape(-1, 3)
        rows = "\n".join(" ".join(map(repr, map(float, row))) for row in net)
        return (
            f'<Geometry type="TensorBSpline2"><Basis type="TensorBSplineBasis2">{knots}</Basis>'
            f'<coefs geoDim="3">{rows}</coefs></Geometry>'
        )

    path.write_text(f'<?xml version="1.0"?><xml>{"".join(map(element, surfaces))}</xml>')
    return path


def test_patches_of_a_gismo_file_are_united_too(tmp_path: Path) -> None:
    path = _gismo(tmp_path / "two.xml", box(*UNIT) + box((0.5, 0.5, 0.5), (2, 2, 2)))
    with pytest.warns(ContigaWarning, match=r"made one: patches 0 to 5 and patches 6 to 11 at"):
        body = cg.read_cad(path)
    assert body.closed
    assert body.volume() == pytest.approx(1.0 + 1.5**3 - 0.125)
    with pytest.warns(ContigaWarning, match="kept as they are"):
        assert not cg.read_cad(path, solids="separate").closed
