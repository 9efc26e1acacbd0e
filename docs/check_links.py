"""Check that links of the pages lead somewhere and all are in the site: ``docs/check_links.py``."""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TOP = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
PAGES = [*TOP, *sorted((ROOT / "docs").glob("*.md"))]
LINK = re.compile(r"!?\[[^\]]*\]\(([^)#\s]+)(?:#[^)]*)?\)")
LISTED = re.compile(r"^   ([\w-]+)$", re.M)
SHOWN_BY_INDEX = {"README", "index"}
WRITTEN_BY_SPHINX = {"genindex", "modindex", "py-modindex", "search", "searchindex", "objects"}
"""Names of its own files, which come last and stand in place of a page that is called so."""


def broken_links() -> list[str]:
    """One line for each link to a file that is not there."""
    return [
        f"{page.relative_to(ROOT)}: {target}"
        for page in PAGES
        for target in LINK.findall(page.read_text(encoding="utf-8"))
        if "://" not in target and not (page.parent / target).exists()
    ]


def lost_pages(folder: Path = ROOT / "docs") -> list[str]:
    """One line for each page that the site would not have: in no list, or overwritten."""
    listed = set(LISTED.findall((folder / "index.rst").read_text(encoding="utf-8")))
    files = sorted(file for file in folder.iterdir() if file.suffix in (".md", ".rst"))
    pages = [file for file in files if file.stem not in SHOWN_BY_INDEX]
    unlisted = [f"{page.name}: not in index.rst" for page in pages if page.stem not in listed]
    taken = [page for page in pages if page.stem.lower() in WRITTEN_BY_SPHINX]
    return unlisted + [f"{page.name}: Sphinx writes a file of this name" for page in taken]


if __name__ == "__main__":
    broken = broken_links() + lost_pages()
    print("\n".join(broken) or f"{len(PAGES)} pages, all in the site, all links lead somewhere")
    sys.exit(bool(broken))
