"""The case file: TOML to a checked Case to a Simulation.

Question: what simulation does this file describe, and what is wrong with it? Read `schema` (the
tables) and `spec` (their base), the `…_spec` file of a table, `problems` and `whole` (messages),
`build` and `contact_build` (to a simulation), `include` (files in files), `convert` (from LS-DYNA
decks).
"""

from contiga.extras import require

require("a case file", "pydantic")
