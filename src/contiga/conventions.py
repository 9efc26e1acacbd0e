"""Signs, frames and units: the one page everything else links to.

Arrays
    float64, C-contiguous, one row a point: ``(n, 3)`` everywhere. Plane problems use z = 0.

Normal, gap, penetration
    The master normal is ``n = S_u × S_v / |S_u × S_v|`` and points to the **free** side, the one
    the slave comes from. ``flipped()`` swaps the sides. A solid from CAD is oriented outward.
    For a slave point ``P`` with foot ``P̂`` the gap is ``g = (P − P̂)·n``, negative when the point
    has gone through, and the penetration is ``λ = max(−g, 0)``.

    ::

            free side          P  (g > 0)
                        n ↑
        ────────────────────┴──── P̂ ────   master surface
            contact side       P  (g < 0, λ = −g)

Force
    A slave node in contact feels ``+F_i n``. The master feels the opposite, acting at ``P̂``; its
    sum is the wrench ``(force, moment about the body's reference point)``.

Frames
    ``p_W`` is a point in world axes, ``n_B`` a normal in body axes and ``X_WB`` the pose of the
    body B in the world W: ``p_W = R_WB @ p_B + t_WB``. A pose is a ``(4, 4)`` homogeneous matrix.
    The search runs in the body frame: slave points are brought to the master, never the other
    way round, so that everything computed about the master is computed once.

Units
    The library is unit-free: any consistent set will do. A case file names its length, mass and
    time units, and files with a unit of their own are converted when they are read.

Words
    *Master* and *slave* are the terms of the field (primary and secondary elsewhere). *Foot* is
    the projection of a slave point, *element* one Bézier piece (knot span) of a patch.
"""
