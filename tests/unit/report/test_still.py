"""The still picture: its size, its labels and bars, and its halves."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from PIL import Image

from contiga.io.out.vtkhdf import read_fields
from contiga.report import still
from contiga.report.coloured import ColouredField
from contiga.report.peak import Peak, at_frame
from contiga.report.run_folder import Units
from contiga.report.still import draw_still, halves

from .conftest import outlined, write_fields

UNITS = Units("mm", "g", "ms", "mm²", "N", "N·mm", "MPa")


def peak_at(tmp_path: Path, frame: int) -> Peak:
    write_fields(tmp_path / "fields.vtkhdf", cloud=False)
    return at_frame(read_fields(tmp_path / "fields.vtkhdf"), frame)


def test_picture_is_a_png_of_its_size(tmp_path: Path) -> None:
    path = tmp_path / "peak.png"
    draw_still(peak_at(tmp_path, 2), path, UNITS)
    head = path.read_bytes()[:24]
    assert head[:8] == b"\x89PNG\r\n\x1a\n"
    assert (int.from_bytes(head[16:20]), int.from_bytes(head[20:24])) == (1640, 840)


def test_picture_with_outlines_and_labels_is_written(tmp_path: Path) -> None:
    peak = peak_at(tmp_path, 2)
    draw_still(peak._replace(outlines=outlined()), tmp_path / "lines.png", UNITS)
    draw_still(peak, tmp_path / "bare.png", UNITS)
    assert (tmp_path / "lines.png").read_bytes() != (tmp_path / "bare.png").read_bytes()


def test_a_picture_of_two_views_comes_apart_between_them(tmp_path: Path) -> None:
    draw_still(peak_at(tmp_path, 2), tmp_path / "p.png", UNITS)
    whole = imread(tmp_path / "p.png")
    left, right = (imread(BytesIO(part)) for part in halves((tmp_path / "p.png").read_bytes()))
    assert np.array_equal(np.concatenate([left, right], axis=1), whole)
    # Nothing is cut: beside the seam all is white.
    assert left[:, -1:, :3].min() == right[:, :1, :3].min() == 1.0


def test_the_letters_are_there_where_matplotlib_keeps_them_elsewhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    still._font.cache_clear()
    at_once = still._font(15)
    monkeypatch.setattr(still, "find_spec", lambda name: None)
    still._font.cache_clear()
    assert still._font(15).getbbox("N/mm² µs ß") == at_once.getbbox("N/mm² µs ß")
    still._font.cache_clear()


@pytest.mark.parametrize("cut", [False, True])
def test_a_bar_has_the_colours_of_the_scale_from_its_top_down(cut: bool) -> None:
    picture = Image.new("RGB", (200, 840), "white")
    still.put_bar(picture, ColouredField("Pressure", "MPa", np.zeros(1), 2.5, cut), 20)
    column = np.asarray(picture)[:, 29].astype(int)
    coloured = np.flatnonzero((column != 255).any(axis=1))
    bar = column[235:672]
    lightness = bar.sum(axis=1)
    assert (np.diff(lightness) >= 0).all(), "from dark to light, downwards"
    assert tuple(bar[0]) == (74, 15, 87)
    assert tuple(bar[-1]) == (255, 233, 168)
    assert ((coloured > 216) & (coloured < 235)).any() == cut


@pytest.mark.parametrize("top", [2.5e-7, 0.0125, 2.5, 98765.0])
def test_a_bar_and_its_words_end_in_the_picture(top: float) -> None:
    picture = Image.new("RGB", (1640, 840), "white")
    field = ColouredField("Penetration", "mm", np.zeros(1), top, cut=False)
    still.put_bar(picture, field, 1540)
    assert (np.asarray(picture)[:, 1637:] == 255).all()
    assert (np.asarray(picture)[:, 1600:1637] < 255).any(), "its unit, or its numbers"
