"""Contact of a slave with a master: detect, measure, respond, state.

Question: what force acts on the points of a slave that touch a master, and where did its work go?
Asked step by step with positions (n, 3); answered by a `State`. Read `contact` (the class),
`state`, `checks` (what is refused) and `points` (what carries contact). The search of a step:
`detect`, `settle`, and `nearest` or `followed` for what that leaves; `ways`, `through`, `thick` and
`curved` are cases of it. Then `respond` (forces), and the derivatives: `tangent`,
`friction_tangent`, `control_tangent`.
"""
