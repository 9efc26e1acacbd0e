"""Find probable mistakes in a model, before its run and after it.

Question: what in this model, or this run, is probably a mistake? Each answer is a `Finding`. Read
`finding`, `scene` (positions at any time), `model_checks` (all checks before a run), then any file
`…_checks`; `run_checks` and `matter_ran` check a run afterwards.
"""
