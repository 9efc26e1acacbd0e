"""Output of runs: histories, fields, outlines, meshes; each file whole or not at all.

Question: how does a run reach the disk so that no file is ever half written? Read `files` (whole or
not at all), `lock`, `history`, `hdf5`, `vtkhdf_layout` and `vtkhdf` (fields), `outlines`,
`write_mesh`, `iso_mme`; `stored` reads what has been written.
"""
