"""A case from its file to its output folder: `contiga.run`, with its progress bar and Ctrl-C.

Above `case`, which builds the simulation, and `report`, which is written at the end; the command
line calls it as any program does. Read `run_case`, then `progress` and `interrupts`.
"""
