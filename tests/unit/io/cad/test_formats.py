"""The reader of CAD is loaded ahead where a case or a path names CAD, and only there."""

from __future__ import annotations

from pathlib import Path

import pytest

from contiga.io.cad import formats


@pytest.mark.parametrize(
    ("text", "reader"),
    [
        ('geometry = { file = "head.STEP" }', "contiga.io.cad.step_iges:read_step_iges"),
        ("file = 'hull.igs'", "contiga.io.cad.step_iges:read_step_iges"),
        ('"shoe.3dm"', None),  # for which OpenCASCADE is not needed
        ('geometry = { shape = "sphere", radius = 1 }', None),
        ('"teapot.xml"', None),
    ],
)
def test_what_is_loaded_ahead(
    monkeypatch: pytest.MonkeyPatch, text: str, reader: str | None
) -> None:
    asked: list[str] = []
    monkeypatch.setattr(formats, "prepare", asked.append)
    formats.expect_cad(*formats.cad_files_in(text, Path("nowhere")))
    assert asked == ([] if reader is None else [reader])
