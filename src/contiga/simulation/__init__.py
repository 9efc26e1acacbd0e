"""Simulate a model step by step, and write and resume runs.

Question: how does a model move from its start to its end? The input are bodies, slaves and
contacts, the answer is a `Result`. Read `simulation` (the class), `parts` and `model` (its parts),
`system_state`, `step` (one step), `step_size` and `critical` (its length), `run` (all steps),
`recorder`, `history` and `checkpoint` (output), `result` and `summary`. Elements of a model have
files of their own, such as `joints`, `springs`, `gas`, `sensor` with `sensors` and
`sensor_criteria`.
"""
