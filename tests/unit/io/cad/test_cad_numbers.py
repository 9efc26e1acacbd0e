"""Numbers that are none end in a message with line and entity, and at once."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import pytest

import contiga as cg
from contiga.errors import FileError
from contiga.io.cad.cad_numbers import check_numbers


@pytest.mark.parametrize("number", ["NAN", "-nan", "-nan(ind)", "INF", "1.E999", "1.#QNAN"])
def test_a_step_point_without_numbers_is_refused(
    number: str, solids: ModuleType, tmp_path: Path
) -> None:
    path = solids.write(solids.rounded_box(), tmp_path / "part.step")
    text = path.read_text()
    start = text.index("CARTESIAN_POINT('',(") + len("CARTESIAN_POINT('',(")
    path.write_text(text[:start] + number + text[text.index(",", start) :])
    line = text.count("\n", 0, start) + 1
    with pytest.raises(FileError, match=rf"line {line}, #\d+ CARTESIAN_POINT: a number is not fin"):
        cg.read_cad(path)


def test_names_may_look_like_numbers_that_are_none(tmp_path: Path) -> None:
    path = tmp_path / "part.step"
    path.write_text(
        "ISO-10303-21;\n#1=PRODUCT('(nan,1.E999)','INF',(1.E+2,0.));\n#2=INF(1.E-400);\n"
    )
    check_numbers(path)


def test_apostrophes_of_comments_hide_nothing(tmp_path: Path) -> None:
    path = tmp_path / "part.step"
    head = "ISO-10303-21;\n#1=PRODUCT('it''s; (nan,/* ','');\n/* it's nan,\n(nan) */"
    path.write_text(f"{head}#2=DIRECTION('',(0.,0.,1.));\n")
    check_numbers(path)
    path.write_text(f"{head}#2=DIRECTION('',(0.,NAN,1.));\n")
    with pytest.raises(FileError, match="line 4, #2 DIRECTION: a number is not finite"):
        check_numbers(path)


def test_an_iges_parameter_that_is_none_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "part.igs"
    rows = [("3Hnan,", "S", 1), ("124,1.,0.,NAN,0.;", "P", 2)]
    path.write_text("".join(f"{text:<64}{'       7'}{kind}{k:>7}\n" for text, kind, k in rows))
    with pytest.raises(FileError, match=r"line 2, directory entry 7: a number is not finite.*NAN"):
        check_numbers(path)
