"""Kernels that all rooms share, in reading order: each depends on the ones before it only.

- fma_nb: the explicit fused multiply-add: x·y + z rounded once (IEEE 754, 5.4.1)
- query_nb: blank rows and lengths of paths, for searches of splines and of triangles
- rows_nb: writing rows of tables, and tables that grow
- sort_nb: sorting numbers, or rows of a table by a column, and counting in sorted arrays
- union_nb: union and find
- vector_nb: vectors of three numbers in kernels, as tuples
- foot_slopes_nb: writing rows of derivatives of feet, in general and on kinks
"""
