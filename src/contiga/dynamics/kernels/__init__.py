"""Kernels, in reading order: what moves bodies. Each stands on those before it.

- rigid_body_nb: free rigid bodies, one step of a leapfrog: half a kick, a drift, half a kick
- nodes_nb: nodes of masses, one step of the same
- closed_skin_nb: the volume that facets close
- joints_nb: joints between them, positions and velocities (RATTLE)
- gases_nb: heat capacities, enthalpies and entropies of gases and of their mixtures
- gas_nb: a step of gas in chambers, through openings and from inflators
- stiffness_nb: how stiff contacts hold a body, and the fastest of its vibrations
"""
