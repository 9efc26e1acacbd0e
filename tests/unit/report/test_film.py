"""Films of a run: what their frames show, and what cannot be filmed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from contiga.errors import FileError, InputError, MissingPackageError, OutputError
from contiga.io.out.vtkhdf import FieldsWriter, Part
from contiga.report import film
from contiga.report.film import write_film

from .conftest import write_folder


def frames_of(path: Path) -> list[np.ndarray]:
    with Image.open(path) as picture:
        frames = []
        for k in range(picture.n_frames):  # type: ignore[attr-defined]
            picture.seek(k)
            frames.append(np.asarray(picture.convert("RGB")))
        return frames


def highest_blue(frame: np.ndarray) -> int:
    """The first row of the ball, which is bluer than the sheet, under the title."""
    ball = frame[..., 2].astype(int) > frame[..., 0].astype(int) + 8
    return int(np.flatnonzero(ball[60:, :700].sum(axis=1) > 10)[0])


def test_the_ball_of_a_gif_comes_down_and_goes_up_again(run_folder: Path, tmp_path: Path) -> None:
    shown: list[tuple[int, int]] = []
    path = write_film(
        run_folder,
        tmp_path / "film.gif",
        seconds=0.42,
        show=lambda done, total, _: shown.append((done, total)),
    )
    frames = frames_of(path)
    assert len(frames) == 5
    assert shown == [(k, 5) for k in range(1, 6)]
    assert frames[0].shape == (832, 880, 3)
    tops = [highest_blue(frame) for frame in frames]
    assert tops[0] < tops[1] < tops[2] > tops[3] > tops[4]
    # the numbers of the colour bar are the same before contact and in it
    ink = [frame[200:690, 800:].max(axis=2) < 120 for frame in frames]
    assert ink[0].sum() > 100
    assert (ink[0] != ink[2]).sum() < 0.05 * ink[0].sum()


def test_frames_show_times_equally_far_apart() -> None:
    times = np.array([0.0, 0.1, 0.2, 0.3, 1.0])
    assert film._nearest_steps(times, 6).tolist() == [0, 2, 3, 3, 4, 4]


def test_an_mp4_has_the_frames_of_its_length(run_folder: Path, tmp_path: Path) -> None:
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = write_film(run_folder, tmp_path / "film.mp4", seconds=0.2)
    reader = imageio_ffmpeg.read_frames(str(path))
    assert next(reader)["size"] == (880, 832)
    assert len(list(reader)) == 5


def test_an_encoder_that_fails_leaves_no_file(
    run_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(path: str, *_: object, **__: object) -> Iterator[None]:
        yield
        Path(path).write_bytes(b"half")
        raise OSError("no such codec\nand a long log")

    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", SimpleNamespace(write_frames=failing))
    (tmp_path / "film").mkdir()
    with pytest.raises(OutputError, match=r"encoded: no such codec\. .*\.gif"):
        write_film(run_folder, tmp_path / "film" / "film.mp4", seconds=0.1)
    assert list((tmp_path / "film").iterdir()) == []


def test_without_an_encoder_the_message_says_what_to_install(
    run_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingPackageError, match=r"\.gif needs no encoder.*contiga\[film\]"):
        write_film(run_folder, tmp_path / "film.mp4")
    assert not (tmp_path / "film.mp4").exists()


def test_what_cannot_be_filmed_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    path = tmp_path / "film.gif"
    bare = write_folder(tmp_path / "bare", fields=False)
    with pytest.raises(InputError, match=r"two recorded steps.*found 0.*vtkhdf"):
        write_film(bare, path)
    single = write_folder(tmp_path / "single", fields=False)
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    part = Part("ball", "body", 3, np.array([[0, 1, 2]]))
    status = np.full(3, -1, np.int32)
    with FieldsWriter(single / "fields.vtkhdf", [part]) as writer:
        data = {"contact_status": status, "penetration": np.zeros(3), "normal": np.zeros((3, 3))}
        writer.append(0.0, corners, data)
    with pytest.raises(InputError, match=r"two recorded steps.*found 1"):
        write_film(single, path)
    with pytest.raises(FileError, match=r"\.mp4 or a \.gif.*found '\.avi'"):
        write_film(bare, tmp_path / "film.avi")
    for seconds in (0.0, 601.0, float("nan")):
        with pytest.raises(InputError, match=r"length in seconds"):
            write_film(bare, path, seconds=seconds)
    with pytest.raises(FileError):
        write_film(tmp_path / "nowhere", path)
    assert not path.exists()
