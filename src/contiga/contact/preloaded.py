"""Load the kernels for the first step of a contact with CAD while the CAD is read."""

from __future__ import annotations

from contiga.elements.kernels.sides_nb import sample
from contiga.geometry.kernels.basis_nb import refinement_rows
from contiga.geometry.kernels.edge_gap_nb import image_gap
from contiga.geometry.kernels.evaluate_nb import curve_range, surface_range
from contiga.geometry.kernels.trim_build_nb import fill_cells, monotone_pieces
from contiga.geometry.kernels.trim_nb import box_states
from contiga.jit.preload import preload
from contiga.search.closest.kernels.nearest_nb import project_global
from contiga.search.hierarchy.kernels.curve_leaves_nb import curve_leaves
from contiga.search.hierarchy.kernels.hierarchy_nb import surface_leaves
from contiga.search.hierarchy.kernels.plates_nb import fill_plates
from contiga.search.hierarchy.kernels.tree_nb import build
from contiga.search.sides.kernels.side_pieces_nb import surface_pieces
from contiga.search.sweep.kernels.hit_nb import last_crossings
from contiga.search.track.kernels.track_nb import track_chunks

KERNELS = (
    *(refinement_rows, curve_range, surface_range, image_gap),
    *(monotone_pieces, fill_cells, box_states, sample),
    *(surface_leaves, curve_leaves, build, fill_plates),
    *(surface_pieces, project_global, last_crossings, track_chunks),
)
"""Kernels in calling order: faces, trims, elements, hierarchy, sides, search."""


def preload_search() -> None:
    """Load `KERNELS` from their cache, which takes as long as reading a small CAD part."""
    preload(KERNELS)
