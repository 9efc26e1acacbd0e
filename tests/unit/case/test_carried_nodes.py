"""Nodes of what deforms that a body carries, as a case names them."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.unit.case.test_deform_spec import PLANE, write_case

import contiga as cg
from contiga.case.schema import load_case
from contiga.errors import InputError


def test_a_body_that_carries_nodes_is_of_use_and_must_be_there(tmp_path: Path) -> None:
    base = '[[body]]\nname = "base"\ngeometry = { shape = "plane", centre = [0, 0, -5] }\n[[slave]]'
    text = write_case(tmp_path).read_text().replace("[[slave]]", base)
    text = text.replace(f"fixed = {PLANE}", f"attached = {PLANE[:-1]}, body = 'base' }}")
    (tmp_path / "carried.toml").write_text(text)
    findings = cg.build(load_case(tmp_path / "carried.toml")).check()
    assert "unused" not in {finding.rule for finding in findings}
    (tmp_path / "nobody.toml").write_text(text.replace("body = 'base'", "body = 'bass'"))
    with pytest.raises(InputError, match=r"slave\[0\].motion.attached\[0\].body: .*'bass'.*base"):
        load_case(tmp_path / "nobody.toml")
