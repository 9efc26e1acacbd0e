"""Contact area of the points that touch.

Question: over what area does each point touch? Read `method` (the protocol of an area method),
`nodal` (constants), `facet` with `cuts` (facets cut where contact ends), `cloud` with `feet`,
`hull` with `cluster` and `polygon` (the thesis), `regions` and `outline`, `profile` (plane
problems).
"""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
