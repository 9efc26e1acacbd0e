"""Numbers as a person reads them, and pages that read offline."""

from __future__ import annotations

import pytest

from contiga.report.style import INK, LINES, MUTED, SCALE, colour_map, inverted, number, page


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0"),
        (3.0, "3"),
        (1853.2, "1\N{NARROW NO-BREAK SPACE}853"),
        (12.345678, "12.35"),
        (0.012, "0.012"),
        (-7.5, "-7.5"),
        (100.0, "100"),
        (9.9999, "10"),
        (0.00012345, "1.234e-04"),
        (2.5e12, "2.500e+12"),
        (float("nan"), "–"),
    ],
)
def test_number_is_short_and_right(value: float, text: str) -> None:
    assert number(value) == text


def test_a_page_is_whole_and_its_title_is_text() -> None:
    text = page("a < b", "<p>said</p>", css="p { margin: 0; }", script="let x = 1;")
    assert text.startswith("<!doctype html>")
    assert text.endswith("<p>said</p>\n</main></body></html>\n")
    assert "<title>a &lt; b</title>" in text
    assert text.index("p { margin: 0; }</style>") < text.index("<script>let x = 1;</script>")
    assert "<script>" not in page("bare", "")
    assert "http" not in page("bare", "")


def test_colours_grow_darker_all_the_way() -> None:
    light = colour_map()([0.0, 0.25, 0.5, 0.75, 1.0])[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert (light[1:] < light[:-1]).all()
    assert len(set(SCALE)) == len(SCALE)


@pytest.mark.parametrize("colour", [INK, MUTED, *LINES, "#ffffff"])
def test_a_colour_inverted_twice_is_itself_and_keeps_its_hue(colour: str) -> None:
    first, back = (bytes.fromhex(one[1:]) for one in (colour, inverted(colour)))
    assert inverted(inverted(colour)) == colour
    assert max(first) - min(first) == max(back) - min(back)
    assert sum(map(max, (first, back))) + sum(map(min, (first, back))) == 560


def test_a_page_is_dark_on_dark_screens_alone() -> None:
    text = page("bare", "")
    light, dark = text.split("@media screen and (prefers-color-scheme: dark)")
    assert f"--ink: {INK};" in light
    assert f"--ink: {inverted(INK)};" in dark
