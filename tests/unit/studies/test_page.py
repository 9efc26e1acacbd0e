"""The page: all its data, no more than it needs, and a script that runs where node is there."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from contiga.studies.page import page_data, page_of
from contiga.studies.row import DONE, FAILED, Row
from contiga.studies.table import table_of

from .conftest import STUDY, base_in, study_from

MESHES = STUDY.replace("values = [0.5, 0.25]", "values = [0.5, 0.25]\nrefines = true")


def rows_of(count: int) -> list[Row]:
    """Rows of a study of speeds and steps; the third failed."""
    return [
        Row(
            k + 1,
            FAILED if k == 2 else DONE,
            "</script> & <b>" if k == 2 else "",
            {"speed": -1.0 - k // 2, "step": (0.5, 0.25)[k % 2]},
            {
                "max(force)": float("nan") if k == 2 else 10.0 + k / 3.0,
                "at(ball.vz, 2)": 0.1 * k,
                "cg.HIC15": 1.0,
            },
            0.5,
        )
        for k in range(count)
    ]


def data_of(text: str, folder: Path, count: int) -> tuple[dict[str, Any], str]:
    """What the page has, read back from it, and the page."""
    study, rows = study_from(text, folder), rows_of(count)
    names = ("max(force)", "at(ball.vz, 2)", "cg.HIC15")
    table = table_of(rows, study.labels, names)
    page = page_of(study, page_data(study, base_in(folder, *names), table, rows), rows, b"")
    match = re.search(r'id="study-data">(.*?)</script>', page, re.S)
    assert match is not None
    return json.loads(match.group(1)), page


def test_the_page_has_every_row_and_column(folder: Path) -> None:
    data, page = data_of(STUDY, folder, 4)
    columns = {column["name"]: column for column in data["columns"]}
    assert list(columns) == [
        *("case", "speed", "step", "max(force)", "at(ball.vz, 2)", "cg.HIC15", "status", "message")
    ]
    assert columns["max(force)"]["values"] == [10.0, 10.33333, None, 11.0]
    assert columns["status"]["texts"] == ["done", "failed"]
    assert columns["status"]["values"] == [0, 0, 1, 0]
    assert columns["message"]["texts"][1] == "</script> & <b>"
    assert "</script> & <b>" not in page
    assert data["links"][0] == "cases/0001/"
    assert "convergence" not in data


def test_a_report_that_is_there_is_linked(folder: Path) -> None:
    home = folder / "out" / "cases" / "0002"
    home.mkdir(parents=True)
    (home / "report.html").write_text("", encoding="utf-8")
    data, _ = data_of(STUDY, folder, 4)
    assert data["links"] == [f"cases/{k:04d}/" + "report.html" * (k == 2) for k in (1, 2, 3, 4)]


def test_refined_meshes_have_their_convergence(folder: Path) -> None:
    data, page = data_of(MESHES, folder, 4)
    actual = data["convergence"]
    assert (actual["name"], actual["sizes"]) == ("step", [1.0, 0.5])
    lines = actual["lines"]["at(ball.vz, 2)"]
    assert [line["rows"] for line in lines] == [[0, 1], [2, 3]]
    assert 'id="convergence"' in page


def test_ten_thousand_rows_are_a_small_page(folder: Path) -> None:
    text = STUDY.replace("[-1.0, -2.0]", "[-1.0]")
    data, page = data_of(text, folder, 10_000)
    assert data["count"] == 10_000
    with_plotly = len(page.encode())
    _, small = data_of(text, folder, 1)
    assert with_plotly - len(small.encode()) < 1_500_000
    assert page.count("<tr") < 10  # rows are made when they come into sight


DOM = """
const fs = require("fs"), html = fs.readFileSync(0, "utf8"), els = {}, drawn = {};
const m = html.match(/id="study-data">([\\s\\S]*?)<\\/script><script>([\\s\\S]*?)<\\/script>/);
class El {
  constructor() {
    Object.assign(this, { children: [], style: {}, on_: {}, clientHeight: 560, scrollTop: 0 });
  }
  appendChild(c) { this.children.push(c); if (c.selected) this.value = c.value; return c; }
  addEventListener(e, f) { this.on_[e] = f; }
  setAttribute() {}
  on() {}
  set textContent(t) { this.text = t; this.children = []; }
  get textContent() { return this.text; }
}
for (const [, id] of html.matchAll(/ id="([\\w-]+)"/g)) els[id] = new El();
els["study-data"].text = m[1];
global.document = { getElementById: id => els[id], createElement: () => new El() };
const heard = {};
global.window = { requestAnimationFrame: f => f(), addEventListener: (e, f) => heard[e] = f };
const keep = (id, data) => { drawn[id] = data.map(t => t.type); };
global.Plotly = { react: keep, newPlot: keep };
const begun = process.hrtime.bigint();
eval(m[2]);
const said = cell => cell.text || cell.children[0]?.text;
const rows = () => els["rows-body"].children.map(row => row.children.map(said));
const first = rows();
heard.beforeprint();
const printed = rows().length;
heard.afterprint();
const after = rows().length;
const head = () => els["rows-head"].children[3].children[0];
head().on_.click();
const rising = rows();
head().on_.click();
const falling = rows();
els["rows-body"].children[0].on_.click();
els["rows-body"].children[1].on_.click();
console.log(JSON.stringify({ drawn, printed, after, first, rising, falling,
  compare: els.compare.text, ms: Number(process.hrtime.bigint() - begun) / 1e6 }));
"""


@pytest.mark.skipif(shutil.which("node") is None, reason="no node to run scripts")
def test_the_script_draws_sorts_and_compares(folder: Path) -> None:
    _, page = data_of(MESHES, folder, 4)
    _, many = data_of(STUDY, folder, 2_000)
    told, much = (
        json.loads(
            subprocess.run(
                ["node", "-e", DOM], input=text, capture_output=True, text=True, check=True
            ).stdout
        )
        for text in (page, many)
    )
    assert set(told["drawn"]) == {"parallel", "response", "surface", "convergence", "errors"}
    assert told["drawn"]["response"] == ["scattergl"]
    assert [row[0] for row in told["first"]] == ["1", "2", "3", "4"]
    assert [row[3] for row in told["rising"]] == ["10", "10.33333", "11", "–"]
    assert [row[3] for row in told["falling"]] == ["11", "10.33333", "10", "–"]
    assert told["compare"] == "contiga compare cases/0004 cases/0002 -o compare.html"
    assert len(much["first"]) == much["after"] < 60
    assert much["printed"] == 2_000


def test_the_script_names_only_what_the_page_has() -> None:
    script = files("contiga.studies").joinpath("page.js").read_text(encoding="utf-8")
    page = files("contiga.studies").joinpath("page.py").read_text(encoding="utf-8")
    ids = set(re.findall(r'\$\("([\w-]+)"\)', script))
    assert len(ids) > 15
    for name in ids:
        assert f'id="{name}"' in page or name.replace("-", "_") + "=" in page, name
