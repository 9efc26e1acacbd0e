"""Pages in a browser: Debian's Chromium without a window, led by playwright, where both are."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

WIDTHS = (500, 800, 1400)
SCHEMES = ("light", "dark")
LEAST_CONTRAST = 4.5
"""Least contrast of text by WCAG 2, level AA."""
_NAMES = ("chromium", "chromium-browser", "google-chrome")
# Where there is no screen and no graphics card, nor a user that a sandbox could be made for.
_OPTIONS = ["--no-sandbox", "--enable-unsafe-swiftshader", "--use-gl=angle"]


@contextmanager
def browser() -> Iterator[Any]:
    """One that opens pages; a test without is skipped."""
    playwright = pytest.importorskip("playwright.sync_api")
    program = next(filter(None, map(shutil.which, _NAMES)), None)
    if program is None:
        pytest.skip("there is no Chromium")
    with playwright.sync_playwright() as led:
        opened = led.chromium.launch(executable_path=program, args=_OPTIONS)
        yield opened
        opened.close()


def opened(on: Any, path: Path, width: int, scheme: str = "light") -> tuple[Any, list[str]]:
    """A page in a window of a width, and what is wrong with it: lines that are added to."""
    page = on.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)
    wrong = list[str]()
    page.on("console", lambda said: said.type == "error" and wrong.append(said.text))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(path.resolve().as_uri())
    page.wait_for_load_state("load")
    return page, wrong


def too_wide(page: Any) -> list[str]:
    """What is wider than the window, but for what stands in something to be scrolled."""
    script = """() => {
      const limit = document.documentElement.clientWidth, found = [];
      if (document.documentElement.scrollWidth > limit) found.push("the page");
      for (const one of document.querySelectorAll("main *")) {
        let held = false;
        for (let up = one.parentElement; up; up = up.parentElement) {
          held = held || ["auto", "scroll", "hidden"].includes(getComputedStyle(up).overflowX);
        }
        if (!held && one.getBoundingClientRect().right > limit + 0.5) {
          found.push(one.tagName + "." + one.className);
        }
      }
      return found;
    }"""
    return list(page.evaluate(script))


def outside_on_paper(page: Any, folder: Path, **paper: Any) -> list[str]:
    """What of a page, printed as PDF, is wider than the card it stands in, or than the paper."""
    page.evaluate("""() => {
      const paper = matchMedia("print");
      window.printed = null;
      paper.addEventListener("change", () => {
        if (!paper.matches) return;
        const found = [], main = document.querySelector("main");
        const limit = main.getBoundingClientRect().right + 0.5;
        for (const one of document.querySelectorAll("main *")) {
          if (one.closest("svg") !== one && one.closest("svg")) continue;
          const box = one.getBoundingClientRect(), card = one.closest(".frame");
          const inner = card ? card.getBoundingClientRect().right + 0.5 : limit;
          if (box.width > 0 && box.right > Math.min(inner, limit)) {
            found.push(one.tagName + "." + (one.className.baseVal ?? one.className));
          }
        }
        window.printed = found;
      });
    }""")
    page.pdf(path=folder / "page.pdf", **paper)
    return list(page.evaluate("window.printed"))


def faint(page: Any) -> list[str]:
    """Texts of a page whose contrast with what is behind them is too small, and what it is.

    Behind a text are the backgrounds of the elements it stands in, down to an opaque one. Texts of
    the axes of 3D views are not elements: their colours are those of the layout.
    """
    script = """(least) => {
      const looked = { willReadFrequently: true };
      const canvas = document.createElement("canvas").getContext("2d", looked);
      const channels = (colour) => {
        canvas.clearRect(0, 0, 1, 1);
        canvas.fillStyle = colour;
        canvas.fillRect(0, 0, 1, 1);
        return Array.from(canvas.getImageData(0, 0, 1, 1).data, (one) => one / 255);
      };
      const over = (above, below) => [0, 1, 2].map(
        (k) => above[3] * above[k] + (1 - above[3]) * below[k]).concat([1]);
      const luminance = (colour) => {
        const [r, g, b] = colour.slice(0, 3).map(
          (c) => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
        return 0.2126 * r + 0.7152 * g + 0.0722 * b;
      };
      const found = [];
      const compare = (text, ink, paper) => {
        const [a, b] = [luminance(over(ink, paper)), luminance(paper)];
        const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
        if (contrast < least) found.push(`${text.trim().slice(0, 40)}: ${contrast.toFixed(2)}`);
      };
      const behind = (element) => {
        const layers = [];
        for (let up = element; up; up = up.parentElement) {
          const style = getComputedStyle(up);
          const box = up.matches(".legend, .annotation-text-g") && up.querySelector(".bg");
          for (const colour of [box && getComputedStyle(box).fill, style.backgroundColor]) {
            if (colour && colour !== "none") layers.push(channels(colour));
          }
          if (layers.length && layers[layers.length - 1][3] === 1) break;
        }
        return layers.reverse().reduce((paper, layer) => over(layer, paper), [1, 1, 1, 1]);
      };
      const main = document.querySelector("main");
      const walker = document.createTreeWalker(main, NodeFilter.SHOW_TEXT);
      while (walker.nextNode()) {
        const text = walker.currentNode.data, element = walker.currentNode.parentElement;
        const box = element.getBoundingClientRect();
        if (!text.trim() || !box.width || !element.checkVisibility()) continue;
        if (element.closest("script, style, option")) continue;
        const style = getComputedStyle(element), drawn = element.closest("svg");
        const ink = channels(drawn ? style.fill : style.color);
        for (let up = element; up; up = up.parentElement) ink[3] *= getComputedStyle(up).opacity;
        if (ink[3]) compare(text, ink, behind(element));
      }
      for (const plot of document.querySelectorAll(".js-plotly-plot")) {
        const { scene, paper_bgcolor } = plot._fullLayout;
        if (!scene) continue;
        for (const axis of [scene.xaxis, scene.yaxis, scene.zaxis]) {
          for (const font of [axis.tickfont, axis.title.font]) {
            compare("axis of " + plot.id, channels(font.color), channels(paper_bgcolor));
          }
        }
      }
      return found;
    }"""
    return list(page.evaluate(script, LEAST_CONTRAST))
