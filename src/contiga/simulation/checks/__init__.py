"""Find what the author of a model most likely did not mean, before a run and after it.

Question: what in this model, or this run, is probably a mistake? Answered by a `Finding` each. Read
`finding`, `scene` (where all stands at any time), `model_checks` (all checks before a run), then
any file `…_checks`; `run_checks` and `matter_ran` look at a run afterwards.
"""
