"""Studies: many cases from one base case, run on a cluster engine, gathered in one table.

A study file lists the variables (`spec`), from which the cases follow (`cases`), and the quantities
that are collected from each (`quantities`). An engine (`engines`) runs them, each in a folder of
its own (`one_case`); the folder of the study (`folder`) holds their rows, from which the table and
the page are made.
"""
