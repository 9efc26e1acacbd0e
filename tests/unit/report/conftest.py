"""An output folder as a run leaves it: a ball pressed down into a square sheet."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from contiga.io.out.history import write_history
from contiga.io.out.vtkhdf import FieldsWriter
from contiga.io.out.vtkhdf_layout import Part
from contiga.records import ContactStatus
from contiga.report.peak import Outline

RADIUS = 10.0
DEPTHS = (-1.0, 1.0, 3.0, 2.0, -1.0)
"""How far the ball has gone through the plane z = 0 at each recorded time."""


def ball(n: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """A sphere of `RADIUS` round the origin: points (k, 3), triangles (m, 3) outward."""
    theta, phi = np.meshgrid(
        np.linspace(0.0, 2 * np.pi, 2 * n, endpoint=False), np.linspace(0, np.pi, n), indexing="ij"
    )
    points = RADIUS * np.stack(
        [np.sin(phi) * np.cos(theta), np.sin(phi) * np.sin(theta), np.cos(phi)], axis=-1
    )
    ids = np.arange(2 * n * n).reshape(2 * n, n)
    a, b = ids[:, :-1], np.roll(ids, -1, axis=0)[:, :-1]
    c, d = np.roll(ids, -1, axis=0)[:, 1:], ids[:, 1:]
    triangles = np.stack([np.stack([a, c, b], -1), np.stack([a, d, c], -1)], axis=2)
    return points.reshape(-1, 3), triangles.reshape(-1, 3)


def sheet(n: int = 13) -> tuple[np.ndarray, np.ndarray]:
    """A square of side 24 in z = 0: points (n², 3), triangles (m, 3)."""
    x = np.linspace(-12.0, 12.0, n)
    points = np.stack([*np.meshgrid(x, x, indexing="ij"), np.zeros((n, n))], axis=-1)
    ids = np.arange(n * n).reshape(n, n)
    a, b, c, d = ids[:-1, :-1], ids[1:, :-1], ids[1:, 1:], ids[:-1, 1:]
    triangles = np.stack([np.stack([a, b, c], -1), np.stack([a, c, d], -1)], axis=2)
    return points.reshape(-1, 3), triangles.reshape(-1, 3)


def penetration_of(points: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray]:
    """Penetration (n,) and outward normal (n, 3) of points in a ball `depth` through z = 0."""
    away = points - np.array([0.0, 0.0, RADIUS - depth])
    distance = np.linalg.norm(away, axis=1)
    return np.maximum(RADIUS - distance, 0.0), away / distance[:, None]


def mises_of(points: np.ndarray, step: int) -> np.ndarray:
    """A made-up stress (n,) of the points of the sheet, that of most of which touches nothing."""
    return 0.25 * step + 0.5 * np.abs(points[:, 0])


def write_fields(path: Path, *, cloud: bool = False, deforms: bool = False) -> None:
    """Fields of the ball at `DEPTHS`, the sheet with facets or as a bare `cloud`, or stressed."""
    body, faces = ball()
    slave, facets = sheet()
    parts = [
        Part("ball", "body", len(body), faces),
        Part("sheet", "slave", len(slave), None if cloud else facets),
    ]
    with FieldsWriter(path, parts) as writer:
        for step, depth in enumerate(DEPTHS):
            inside, normal = penetration_of(slave, depth)
            touching = inside > 0.0
            status = np.where(touching, ContactStatus.OLD, ContactStatus.FREE)
            normal = np.where(touching[:, None], normal, 0.0)
            writer.append(
                float(step),
                np.vstack([body + np.array([0.0, 0.0, RADIUS - depth]), slave]),
                {
                    "contact_status": np.r_[np.full(len(body), -1), status].astype(np.int32),
                    "penetration": np.r_[np.zeros(len(body)), inside],
                    "normal": np.vstack([np.zeros((len(body), 3)), normal]),
                    **(
                        {"von_mises": np.r_[np.full(len(body), np.nan), mises_of(slave, step)]}
                        if deforms
                        else {}
                    ),
                },
            )


def outlined() -> tuple[Outline, ...]:
    """Two made-up regions: circles in the sheet on either side of the middle."""
    angle = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
    return tuple(
        Outline(np.stack([x + 2 * np.cos(angle), 2 * np.sin(angle), 0 * angle], axis=1), cluster, 0)
        for cluster, x in enumerate((-2.5, 2.5))
    )


def write_folder(folder: Path, *, fields: bool = True, cloud: bool = False) -> Path:
    """All files of a run but the report."""
    folder.mkdir(exist_ok=True)
    force = np.array([0.0, 20.0, 90.0, 50.0, 0.0])
    history = {name: np.zeros(5) for name in ("force_x", "force_y", "moment_x", "n_clusters")}
    history |= {
        "time": np.arange(5.0),
        "n_contact": np.array([0.0, 12.0, 45.0, 32.0, 0.0]),
        "max_penetration": np.maximum(DEPTHS, 0.0),
        "force": force,
        "force_z": -force,
        "area": force / 2.0,
        "wall_time": np.full(5, 0.01),
    }
    write_history(folder / "history.csv", history)
    summary = {
        "title": "A ball & a <sheet>",
        "version": "0.1.0",
        "units": {"length": "mm", "mass": "g", "time": "ms"},
        "timings": {"import": 0.5, "build": 0.5, "compile": 6.0, "search": 2.0, "total": 10.0},
        "steps": 5,
        "n_points": 169,
        "n_elements": 8,
        "threads": 2,
        "statuses": {"press": {"FREE": 169, "OLD": 0}},
        "inputs": {
            "ball": {"kind": "body", "patches": 1, "size": 34.64},
            "sheet": {"kind": "slave", "points": 169},
        },
        "warnings": [],
    }
    (folder / "summary.json").write_text(json.dumps(summary), encoding="utf-8")
    (folder / "case.toml").write_text('title = "A ball & a <sheet>"\n', encoding="utf-8")
    if fields:
        write_fields(folder / "fields.vtkhdf", cloud=cloud)
    return folder


@pytest.fixture
def run_folder(tmp_path: Path) -> Path:
    """The output folder of the ball and the sheet."""
    return write_folder(tmp_path / "out")
