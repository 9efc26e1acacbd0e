"""Laws: from penetration and area to force.

Question: what force belongs to this penetration, rate and area, or to this sliding? Arrays only,
one row a point. Read `law` (the protocol), `normal` (the simplest laws), `stress`, `force` with
`deepest` and `share`, `combined` with `stress_path` (two sides that deform), `by_face`; `friction`
stands alone.
"""
