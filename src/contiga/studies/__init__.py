"""Studies: many cases from one base case, run on a cluster engine, gathered in one table.

A study file says what varies (`spec`), which cases follow of it (`cases`) and what is kept of each
(`quantities`). One engine or another (`engines`) runs them, each in a folder of its own
(`one_case`); the folder of the study (`folder`) holds their rows, of which the table and the page
are made.
"""
