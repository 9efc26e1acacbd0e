"""Stamps of sources: of all that is imported, and of nothing else."""

from __future__ import annotations

import pytest

from contiga.jit import stamps
from contiga.jit.stamps import PACKAGE, stamp_at_import, stamp_of


@pytest.fixture
def tiny(tmp_path):
    """A package of three files of which the last imports the first."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    (folder / "between.py").write_text("")
    (folder / "callee.py").write_text("x = 1")
    (folder / "caller.py").write_text("from tiny.callee import x")
    return folder


def test_a_stamp_is_of_the_files_imported_and_of_no_others(tiny):
    before = stamp_of(tiny / "caller.py", tiny)
    (tiny / "between.py").write_text("y = 2")
    assert stamp_of(tiny / "caller.py", tiny) == before
    (tiny / "callee.py").write_text("x = 2")
    assert stamp_of(tiny / "caller.py", tiny) != before


def test_files_that_import_each_other_have_a_stamp(tiny):
    (tiny / "callee.py").write_text("from tiny import caller")
    before = stamp_of(tiny / "caller.py", tiny)
    (tiny / "callee.py").write_text("from tiny import caller\nx = 3")
    assert stamp_of(tiny / "caller.py", tiny) != before


def test_the_package_is_this_one():
    assert (PACKAGE / "jit" / "stamps.py").is_file()


def test_a_stamp_at_import_lasts_until_the_next_import(tiny, monkeypatch):
    monkeypatch.setattr(stamps, "PACKAGES", [PACKAGE, tiny])
    code = compile("def one():\n    return 1\n", str(tiny / "caller.py"), "exec")

    def imported(spec):
        names = {"__spec__": spec}
        exec(code, names)
        return names["one"]

    first, again = imported("first"), imported("again")
    before = stamp_at_import(first)
    assert before == stamp_of(tiny / "caller.py", tiny)
    (tiny / "callee.py").write_text("x = 2")
    assert stamp_at_import(first) == before
    after = stamp_at_import(again)
    assert after == stamp_of(tiny / "caller.py", tiny) != before
    (tiny / "callee.py").write_text("x = 30")
    loose = imported(None)  # of no import: nothing tells which
    assert stamp_at_import(loose) == stamp_of(tiny / "caller.py", tiny) != after
