"""Contact of a slave with a master: search, areas, forces, state.

Question: which forces act on the points of a slave that touch a master, and how is their work
stored or lost? The input of a step are positions (n, 3), the answer is a `State`. Read `contact`
(the class), `state`, `checks` (errors of the input) and `points` (points of contact). The search of
a step: `detect`, `settle`, then `nearest` or `followed` for the remaining points; `deep_paths`,
`through`, `thick` and `curved` are special cases. Then `respond` (forces), and the derivatives:
`tangent`, `friction_tangent`, `control_tangent`.
"""
