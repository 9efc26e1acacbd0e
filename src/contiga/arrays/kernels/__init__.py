"""Kernels, in reading order: what every room counts with. Each stands on those before it.

- fma_nb: the fused multiply-add, written where it is meant: x·y + z rounded once (IEEE 754, 5.4.1)
- query_nb: what searches of splines and of triangles share: blank rows, and the lengths of paths
- rows_nb: rows of tables that are written, and tables that grow
- sort_nb: numbers put in order, rows of a table by one of its columns, and places in what is sorted
- union_nb: sets that are joined, by union and find
- vector_nb: vectors of three numbers in kernels, as tuples
- foot_slopes_nb: rows of derivatives of feet: how they are written, and those of feet on kinks
"""
