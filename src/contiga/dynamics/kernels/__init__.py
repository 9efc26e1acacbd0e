"""Kernels of motion, in reading order. Each uses those before it.

- rigid_body_nb: free rigid bodies, one step of a leapfrog: half a kick, a drift, half a kick
- nodes_nb: nodes with masses, one step of the same
- closed_skin_nb: the volume that facets enclose
- joints_nb: joints between bodies, positions and velocities (RATTLE)
- gases_nb: heat capacities, enthalpies and entropies of gases and of their mixtures
- gas_nb: a step of gas in chambers, through openings and from inflators
- stiffness_nb: the stiffness of contacts of a body, and its fastest vibration
"""
