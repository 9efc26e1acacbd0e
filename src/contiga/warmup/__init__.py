"""Kernels compiled ahead of a run, or beside it, by several processes.

Which kernels there are, of what types their arguments are and which kernels each is built of says a
list that the package brings along (`listing`). A `Plan` hands out those whose parts are there, a
`CompilePool` of processes compiles them, and a run that needs one takes part until it has it.
"""
