"""Output of runs: histories, fields, outlines, meshes; each file whole or not at all."""
