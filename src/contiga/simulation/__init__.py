"""Runs: what is simulated, step by step, with what is written and resumed.

Question: how does a model move from its start to its end? Asked with bodies, slaves and contacts;
answered by a `Result`. Read `simulation` (the class), `parts` and `model` (what it is made of),
`system_state`, `step` (one step), `step_size` and `critical` (its length), `run` (all steps),
`recorder`, `history` and `checkpoint` (what is kept), `result` and `summary`. What may be in a
model has files of its own, such as `joints`, `springs`, `gas`, `sensor` with `sensors` and
`sensor_criteria`.
"""
