"""Case files that cannot be read as one, and several faults in one file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.case.schema import load_case
from contiga.errors import CaseError, FileError

from .conftest import GOOD


def test_a_mark_in_front_of_the_text_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert load_case(path).title == "Cloud pressed into a plate"


def test_a_missing_case_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"none\.toml: no such file") as caught:
        load_case(tmp_path / "none.toml")
    assert caught.value.exit_code == 2


def test_a_folder_or_a_binary_file_is_no_case(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be read"):
        load_case(tmp_path)
    (tmp_path / "a.toml").write_bytes(np.arange(255, dtype=np.uint8).tobytes())
    with pytest.raises(FileError, match="not UTF-8"):
        load_case(tmp_path / "a.toml")


def test_everything_wrong_is_told_at_once(tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    text = GOOD.replace("step = 1.0", "step = 0").replace('"force"', '"forse"')
    path.write_text(text.replace('"mm"', '"xy"'), encoding="utf-8")
    with pytest.raises(CaseError, match="3 things are wrong") as caught:
        load_case(path)
    lines = str(caught.value).splitlines()
    assert [line.split(":")[0].strip() for line in lines[1:]] == [
        "units.length",
        "time.step",
        "contact[0].law.kind",
    ]


@pytest.mark.parametrize("key", ["belt", "load", "spring"])
def test_a_number_in_place_of_tables_is_refused(key: str, tmp_path: Path) -> None:
    path = tmp_path / "case.toml"
    path.write_text(f"{key} = 1.5\n{GOOD}", encoding="utf-8")
    with pytest.raises(CaseError, match=rf"case\.toml: {key}: must be a list; found 1\.5"):
        load_case(path)
