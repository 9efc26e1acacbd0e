"""Draw the picture of the page on studies: ``python docs/draw_study.py [FOLDER]``, many minutes.

It runs the whole study of the bonnet, or what is missing of it, into ``out/bonnet``.
"""

from __future__ import annotations

import runpy
import shutil
import sys
from pathlib import Path

from contiga.studies.folder import MANIFEST, MAP
from contiga.studies.spec import load_study
from contiga.studies.study import run_study

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES, OUT = ROOT / "examples", ROOT / "out" / "bonnet"


def main(folder: Path) -> None:
    """Part, study, picture."""
    part = EXAMPLES / "generated" / "bonnet.step"
    if not part.is_file():
        make = runpy.run_path(str(EXAMPLES / "make_bonnet.py"))
        make["main"](part, make["SPACING"])
    study = load_study(EXAMPLES / "bonnet_study.toml")
    run_study(study, OUT, resume=(OUT / MANIFEST).is_file(), progress=print)
    shutil.copyfile(OUT / MAP, folder / "bonnet.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "images")
