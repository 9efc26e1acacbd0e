"""Arrays as kernels take them, numbers of statuses, sums of one order, threads and memory.

Question: how does everything else hand arrays to kernels, with the same bits on every machine? Read
`layout` (checks at the door), `codes` (all numbers of statuses), `threads`, `workspace`, `ordered`
(linear algebra), `queries` and `query_checks` (searches), `piecewise`, `disk_cache` and `digest`.
"""
