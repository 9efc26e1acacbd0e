"""Kernels compiled ahead of a run, or beside it, by other processes that go through exercises."""

EXERCISES = (
    *("run", "flight", "meshes", "balls", "followed", "paths", "sides", "closest", "rubbed"),
    *("crowds", "areas", "pressed", "simulations", "files", "triangles", "shapes"),
)
"""Functions of `contiga.warmup.exercises`. After a whole run come what a run comes to late and what
stands apart from its beginning."""
LAST = "fallbacks"
"""Done by every process once no other is left: it knows the kernels of those that it did."""
BESIDE = EXERCISES[1:]
"""Those of processes beside a run: what it gets to late is there by then."""
