"""Kernels compiled ahead of a run, or beside it, by several processes.

A list in the package (`listing`) has the kernels, the types of their arguments and the kernels that
each calls. A `Plan` hands out kernels whose parts are compiled, a `CompilePool` of processes
compiles them, and a run that needs a kernel takes part until it has it.
"""
