"""Signs, frames and units: the one page everything else links to.

**Arrays** are float64, one row a point: `(n, 3)` everywhere. Plane problems use z = 0; the body is
then a curve given a depth, `Body.from_profile(curve, depth)`.

**Normal, gap, penetration.** The master normal is `n = S_u × S_v / |S_u × S_v|`. It points to the
*free* side, the one the slave comes from; `flipped()` swaps the sides, and a solid from CAD is
oriented outward. A slave point `P` with foot `P̂` has the gap `g = (P − P̂)·n`, negative once it has
gone through, and the penetration `λ = max(−g, 0)`.

```
free side          P  (g > 0)
            n ↑
────────────────────┴──── P̂ ────   master surface
contact side       P  (g < 0, λ = −g)
```

**Force.** A slave node in contact feels `+F_i n`. The master feels the opposite, acting at `P̂`; its
sum is the wrench: force, and moment about the body's reference point.

**Frames.** `p_W` is a point in world axes, `n_B` a normal in body axes, `X_WB` the pose of the body
B in the world W, a `(4, 4)` matrix: `p_W = R_WB p_B + t_WB`. In its place `scipy`'s `Rotation` and
a pair `(R, t)`, of a `Rotation` or a `(3, 3)` matrix and a position, are accepted everywhere;
results have matrices. The search runs in the body's frame: slave points are brought to the master,
so that everything known about the master is built once.

**Units.** The library is unit-free: any consistent set will do. A case file names its length, mass
and time units; files with a unit of their own are converted when they are read, and derived units
follow for labels:

| length, mass, time | force | stress |
|---|---|---|
| mm, g, ms | N | MPa |
| mm, kg, ms | kN | GPa |
| mm, t, s | N | MPa |
| m, kg, s | N | Pa |

**Words.** *Master* (primary) is the rigid surface, *slave* (secondary) the points. A *foot* is the
projection of a slave point. An *element* is one Bézier piece (knot span) of a patch.
"""
