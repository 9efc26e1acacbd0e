"""CAD files: STEP, IGES, 3DM, G+Smo.

Question: which exact body, or which parts, are in this file? Read `read_cad` and `cad_parts` (what
users call), `formats`, `read_cache` (results on disk), `parts` (labels and selection), `gismo` (the
shortest reader), `assemble` with `loops`, `sew` and `stitch` (faces to a body), `step_iges` and
`rhino`, `unite`.
"""
