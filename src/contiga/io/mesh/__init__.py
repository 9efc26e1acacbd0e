"""Files of meshes and clouds, and series of them.

Question: which points, cells and groups are in this file? Read `read_mesh` (what users call), `raw`
(what a reader returns), `polygon_files` and `cloud_files` (the shortest readers), `meshio_files`,
then `lsdyna`, `abaqus` and `nastran` with the files named after them; `layers`, `read_master`,
`series`.
"""
