"""Arrays as kernels take them, numbers of statuses, sums of a fixed order, threads and memory.

Question: how do all rooms pass arrays to kernels, with the same bits on every machine? Read
`layout` (checks of arguments), `codes` (all numbers of statuses), `threads`, `workspace`, `ordered`
(linear algebra), `queries` and `query_checks` (searches), `piecewise`, `disk_cache` and `digest`.
"""
