"""Pages in a browser: Debian's Chromium without a window, led by playwright, where both are."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

WIDTHS = (500, 1400)
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


def opened(on: Any, path: Path, width: int) -> tuple[Any, list[str]]:
    """A page in a window of a width, and what is wrong with it: lines that are added to."""
    page, wrong = on.new_page(viewport={"width": width, "height": 900}), list[str]()
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
