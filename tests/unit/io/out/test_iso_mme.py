"""ISO-MME files: what is written, read back line by line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contiga.errors import InputError, OutputError
from contiga.io.out.iso_mme import MmeChannel, write_mme

VALUES = np.array([0.0, 1.0 / 3.0, -2.5e-300])


def channel(code: str = "11HEAD0000H3ACXA", **changes: object) -> MmeChannel:
    made = MmeChannel(code, "Head\nacceleration", "m/(s*s)", -0.01, 1e-4, VALUES, "1000")
    return made._replace(**changes)  # type: ignore[arg-type]


def head_of(path: Path) -> tuple[dict[str, str], list[str]]:
    """Names and values of the head, and the other lines."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = [line.split(":", 1) for line in lines if ":" in line]
    assert all(len(name) == 28 for name, _ in head)
    return {name.strip(): value for name, value in head}, [x for x in lines if ":" not in x]


def test_a_test_is_a_folder_of_channels(tmp_path: Path) -> None:
    other = "1?CHST0000H3DSXC"
    out = write_mme(tmp_path, "T-17", [channel(), channel(other)], title="Sled  run", comment="c")
    assert out == tmp_path / "T-17"
    files = {path.relative_to(out).as_posix() for path in out.rglob("*.*")}
    wanted = {"T-17.mme", "Channel/T-17.chn", "Channel/T-17.001", "Channel/T-17.002"}
    assert files == wanted
    about, _ = head_of(out / "T-17.mme")
    assert (about["Data format edition number"], about["Title"]) == ("1.6", "Sled run")
    listed, _ = head_of(out / "Channel" / "T-17.chn")
    assert listed["Number of channels"] == "2"
    assert listed["Name of channel 002"] == f"{other} / Head acceleration"
    head, numbers = head_of(out / "Channel" / "T-17.001")
    assert head["Channel code"] == "11HEAD0000H3ACXA"
    assert (head["Dimension"], head["Direction"], head["Unit"]) == ("AC", "X", "m/(s*s)")
    assert (float(head["Time of first sample"]), float(head["Sampling interval"])) == (-0.01, 1e-4)
    assert head["Number of samples"] == "3"
    np.testing.assert_array_equal([float(line) for line in numbers], VALUES)


@pytest.mark.parametrize(
    ("test", "channels", "message"),
    [
        ("a/b", [channel()], "test: is not a test name"),
        ("", [channel()], "test: is not a test name"),
        ("t", [], "channels: must be some channels"),
        ("t", [channel(), channel()], "code: is there twice, of .* and of "),
        ("t", [channel("11head0000H3ACXA")], "code: is not a channel code"),
        ("t", [channel("11HEAD")], "code: is not a channel code"),
    ],
)
def test_what_cannot_be_written_is_refused(tmp_path, test, channels, message: str) -> None:
    with pytest.raises(InputError, match=message):
        write_mme(tmp_path, test, channels, title="")
    assert not list(tmp_path.iterdir())


def test_a_folder_of_that_name_stays_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "t").mkdir()
    (tmp_path / "t" / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="cannot be made"):
        write_mme(tmp_path, "t", [channel()], title="")
    assert [path.name for path in (tmp_path / "t").iterdir()] == ["mine.txt"]


def test_a_test_that_is_there_stays(tmp_path: Path) -> None:
    write_mme(tmp_path, "t", [channel()], title="first")
    with pytest.raises(OutputError, match="cannot be made"):
        write_mme(tmp_path, "t", [channel()], title="second")
    assert head_of(tmp_path / "t" / "t.mme")[0]["Title"] == "first"
