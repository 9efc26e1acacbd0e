"""Enumerations: a sentence of advice for each value, numbers that stay."""

from __future__ import annotations

import ast
import pickle
from pathlib import Path

import pytest

import contiga as cg
from contiga import records
from contiga.statuses import Advised

ROOT = Path(__file__).resolve().parents[2]
ENUMERATIONS = (cg.Status, cg.ContactStatus, cg.Feature)


def test_all_enumerations_give_advice() -> None:
    """There are no others in the package but the reasons of steps: users meet these."""
    bases = {
        (node.name, ast.unparse(base))
        for path in (ROOT / "src" / "contiga").rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
        for base in node.bases
        if "Enum" in ast.unparse(base) or ast.unparse(base) == "Advised"
    }
    ours = {(e.__name__, "Advised") for e in ENUMERATIONS}
    assert bases == {("Advised", "IntEnum"), ("Reason", "IntEnum"), *ours}


@pytest.mark.parametrize("member", [m for e in ENUMERATIONS for m in e], ids=repr)
def test_every_value_has_one_sentence(member: Advised) -> None:
    text = member.advice
    assert text[0].isupper()
    assert text.endswith(".")
    assert ". " not in text
    same = [other for other in type(member) if other.advice == text]
    assert same == [member]


def test_values_are_numbers_as_before() -> None:
    assert [int(s) for s in cg.Status] == list(range(9))
    assert [int(s) for s in cg.ContactStatus] == list(range(11))
    assert [int(f) for f in cg.Feature] == [-1, 0, 1, 2]
    assert cg.Status(4) is cg.Status.BRANCH_EVENT
    assert pickle.loads(pickle.dumps(cg.ContactStatus.HELD)) is cg.ContactStatus.HELD
    assert set(records.IN_CONTACT) < set(cg.ContactStatus)
