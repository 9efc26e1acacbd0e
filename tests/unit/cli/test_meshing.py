"""How many triangles a mesh will have is told before minutes go by."""

from __future__ import annotations

import pytest
from tests.scenes import box

import contiga as cg
from contiga.cli.meshing import LARGE_COUNT, MAX_TRIANGLES, foretell
from contiga.errors import InputError

BALL = cg.Body([cg.shapes.sphere(radius=1.0)])


def triangles(body: cg.Body, tol: float) -> int:
    return len(body.tessellate(tol).triangles)


def test_a_tolerance_that_is_far_too_fine_is_told_and_one_beyond_all_is_refused(
    capsys: pytest.CaptureFixture[str],
) -> None:
    each = triangles(BALL, 1e-4) * 1e-4
    foretell(BALL, 2.0 * each / LARGE_COUNT)
    assert capsys.readouterr().err == ""
    foretell(BALL, 0.5 * each / LARGE_COUNT)
    said = capsys.readouterr().err
    count, tol = (float(said.split(word)[1].split()[0]) for word in ("about ", "--tol "))
    assert count == pytest.approx(2.0 * LARGE_COUNT, rel=0.2)
    assert tol == pytest.approx(each / LARGE_COUNT, rel=0.3)
    with pytest.raises(InputError, match=r"--tol: about .*allowed: about .* 4e\+07 triangles"):
        foretell(BALL, 0.3 * each / MAX_TRIANGLES)


def test_flat_faces_have_as_few_at_any_tolerance(capsys: pytest.CaptureFixture[str]) -> None:
    foretell(box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0)), 1e-12)
    assert capsys.readouterr().err == ""
