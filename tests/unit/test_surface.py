"""What users rely on does not change in silence: names, signatures and their line in CHANGELOG."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MADE = runpy.run_path(str(ROOT / "docs" / "make_surface.py"))
RECORD = """\
  1 Body(patches, *, name='body')
  0 Body.area(rtol=1e-09)
  0 Body.size
  0 Spring(curve)
  0 Spring.curve
"""
CHANGES = """# Changes

## 0.2.0, not released yet

- `Body` is new, and `cg.Body(patches)` makes one. Area and size are words of sentences.

## 0.1.0

- `Body.area` was there already.
"""
NOW = {name: signature for name, (signature, _) in MADE["read"](RECORD).items()}


def test_what_changes_of_the_public_surface_has_a_line_in_the_change_log() -> None:
    now, record = MADE["surface"](), MADE["RECORD"].read_text(encoding="utf-8")
    changes = MADE["CHANGES"].read_text(encoding="utf-8")
    assert len(now) > 500
    assert MADE["unsaid"](now, record, changes) == [], (
        "what users rely on has changed: say so in CHANGELOG.md, the name in `backticks`"
    )


def test_what_has_not_changed_asks_for_nothing() -> None:
    assert MADE["mentions"]("contiga.Body", CHANGES) == 1
    assert MADE["unsaid"](NOW, RECORD, CHANGES) == []


@pytest.mark.parametrize(
    ("change", "line", "unsaid"),
    [
        ({"Body": "(patches, *, name='part')"}, "", ["Body"]),
        ({"Body": "(patches, *, name='part')"}, "- `Body(name=…)` is another.", []),
        ({"Body.area": "(rtol=1e-06)"}, "- The area is less exact.", ["Body.area"]),
        ({"Body.area": "(rtol=1e-06)"}, "- `Body.area` is less exact.", []),
        ({"Body.ray": "(origins)"}, "- Rays.", ["Body.ray"]),
        ({"Body.ray": "(origins)"}, "- Bodies have `ray`.", []),
        ({"Gas": "(volume)", "Gas.volume": ""}, "", ["Gas"]),
        ({"Gas": "(volume)", "Gas.volume": ""}, "- `cg.Gas`: a bag.", []),
        ({"Body.size": None}, "- `Body.area` is new.", ["Body.size"]),
        ({"Spring": None, "Spring.curve": None}, "- No `Spring` any more.", []),
    ],
)
def test_a_change_asks_for_a_line_that_is_new_since_the_record(
    change: dict[str, str | None], line: str, unsaid: list[str]
) -> None:
    now = {n: s for n, s in (NOW | change).items() if s is not None}
    changes = CHANGES.replace("\n## 0.1.0", f"{line}\n\n## 0.1.0")
    assert MADE["unsaid"](now, RECORD, changes) == unsaid


def test_signatures_are_spelt_as_they_are_called() -> None:
    now = MADE["surface"]()
    assert now["Body.track"] == "(points, start)"
    assert now["Body.project"] == "(points, *, start=None, mode='global', out=None)"
    assert now["TriMesh.from_meshio"] == "(mesh, *, name='mesh', **options)"
    assert now["Result.plot"] == "(*, x=None, y=None, columns=None, path=None)"
    assert now["Feature"].endswith("FACE:0, EDGE:1, VERTEX:2")
    assert "shapes.sphere" in now
    assert "TriMesh.with_reference_point" in now
    assert not [name for name in now if "._" in name or ".." in name]
