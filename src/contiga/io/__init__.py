"""Files: each format reads into or writes from plain records.

Question: what does this file hold, in the units asked for? Read `worker` and `limits` (readers run
in a process of their own), `units`, `naming`, `sheet` and `curves` (tables of text), `channels`
(columns of a run); then the rooms `mesh`, `cad` and `out`.
"""
