"""The check of CI that a run compiles each kernel once."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests import one_version


def test_a_kernel_kept_in_two_versions_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert one_version.main([str(tmp_path)]) == 1
    assert "run the demo first" in capsys.readouterr().err
    for name in ("a_nb.f-01.py311.1.nbc", "a_nb.g-02.py311.1.nbc", "a_nb.f-01.py311.nbi"):
        (tmp_path / name).write_bytes(b"")
    assert one_version.main([str(tmp_path)]) == 0
    (tmp_path / "a_nb.f-01.py311.2.nbc").write_bytes(b"")
    assert one_version.main([str(tmp_path)]) == 1
    assert capsys.readouterr().err == "a_nb.f: 2 versions\n"
