"""Triangle meshes: their arrays, their condition, and the search on them.

Question: is this mesh a surface that can be searched, and where is it closest or hit? Read
`trimesh` (the class) and `triangle_arrays`, `topology`, `orientation`, `condition`; the search:
`facet_tables`, `facets`, `facet_surface`, `facet_feet`, `facet_hits`; `moments`, `exchange`.
"""

import contiga.jit  # noqa: F401 (before any kernel: how they are kept)
